//! `flexbeam export`: a file of ours in a form that other tools read.
//!
//! Enters: any file that can be exported, a form. Leaves: that form, and one answer. Deliberately absent: the forms
//! themselves, which `flexbeam-files` and `flexbeam-codegen` own.

mod recording;
mod single;
mod source;
mod system;

use flexbeam_files::{Controller, Document, Error, Fault, Model, RUN_SCHEMA, Tried, schema_of};

use crate::{Failure, cli};

/// An option that says nothing about the form.
#[derive(Debug, thiserror::Error)]
#[error("found {option} with --as {form}, needed it with {needed} alone\nhint: leave {option} out")]
struct Idle {
    option: &'static str,
    form: &'static str,
    needed: &'static str,
}

/// `flexbeam export`.
pub fn run(arguments: &cli::Export) -> Result<(), Failure> {
    idle(arguments).map_or(Ok(()), |idle| Err(Failure::while_trying("export")(idle)))?;
    match arguments.form {
        cli::Form::C | cli::Form::Rust => source::export(arguments),
        cli::Form::Csv | cli::Form::Mat | cli::Form::Json => data(arguments, schema_of(&arguments.file)?.as_deref()),
    }
}

/// A recording, a model or a controller, by its schema.
fn data(arguments: &cli::Export, schema: Option<&str>) -> Result<(), Failure> {
    let refused = |fault| Err(Error::new(Tried::Read, &arguments.file, fault).into());
    match (arguments.form, schema) {
        (cli::Form::Csv | cli::Form::Mat, None | Some(RUN_SCHEMA)) => recording::export(arguments),
        (cli::Form::Mat | cli::Form::Json, Some(schema @ (Model::SCHEMA | Controller::SCHEMA))) => {
            of_tables_only(arguments).map_err(Failure::while_trying("export"))?;
            system::export(arguments, schema)
        }
        (cli::Form::Csv, Some(found)) => refused(Fault::Schema { found: found.into(), needed: RUN_SCHEMA }),
        (_, Some(found)) => refused(Fault::Schema { found: found.into(), needed: SYSTEMS }),
        (_, None) => refused(Fault::NoSchema { needed: SYSTEMS }),
    }
}

/// What `--as json` takes, and `--as mat` beside recordings.
const SYSTEMS: &str = "flexbeam.model/1 or flexbeam.controller/1";

/// Errors: an option that only a recording in a table answers.
fn of_tables_only(arguments: &cli::Export) -> Result<(), Idle> {
    let needed = "the table of a recording";
    match table_options(arguments).into_iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Idle { option, form: "mat", needed }),
        None => Ok(()),
    }
}

fn table_options(arguments: &cli::Export) -> Vec<(&'static str, bool)> {
    vec![("--columns", !arguments.columns.is_empty()), ("--period", arguments.period.is_some())]
}

/// The first option that would do nothing.
fn idle(arguments: &cli::Export) -> Option<Idle> {
    let (form, of_source, of_tables) = match arguments.form {
        cli::Form::C => ("c", true, false),
        cli::Form::Rust => ("rust", true, false),
        cli::Form::Csv => ("csv", false, true),
        cli::Form::Mat => ("mat", false, true),
        cli::Form::Json => ("json", false, false),
    };
    let given = |options: Vec<(&'static str, bool)>| options.into_iter().find(|(_, given)| *given);
    let of_table = given(table_options(arguments)).filter(|_| !of_tables);
    let of_text = given(source_options(arguments)).filter(|_| !of_source);
    let idle = |needed: &'static str| move |(option, _)| Idle { option, form, needed };
    of_table.map(idle("--as csv or mat")).or(of_text.map(idle("--as c or rust")))
}

fn source_options(arguments: &cli::Export) -> Vec<(&'static str, bool)> {
    let named = arguments.name != cli::DEFAULT_NAME;
    let (precision, unverified) = (arguments.precision.is_some(), arguments.unverified.is_some());
    vec![("--precision", precision), ("--name", named), ("--unverified", unverified)]
}
