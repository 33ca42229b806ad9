//! `flexbeam export`: a file of ours in a form that other tools read.
//!
//! Enters: any file that can be exported, a form. Leaves: that form, and one answer. Deliberately absent: the forms
//! themselves, which `flexbeam-files` and `flexbeam-codegen` own.

mod compiler;
mod recording;
mod single;
mod source;
mod system;
mod unit;

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
        cli::Form::Fmu => unit::export(arguments),
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

fn table_options(arguments: &cli::Export) -> [(&'static str, bool); 3] {
    [
        ("--columns", !arguments.columns.is_empty()),
        ("--period", arguments.period.is_some()),
        ("--resample", arguments.resample.is_some()),
    ]
}

/// The first option that would do nothing.
fn idle(arguments: &cli::Export) -> Option<Idle> {
    use cli::Form::{C, Csv, Fmu, Json, Mat, Rust};
    let (recording, source, controller) = (&[Csv, Mat][..], &[C, Rust][..], &[C, Rust, Fmu][..]);
    let of_tables = table_options(arguments).map(|(option, given)| (option, given, recording, "--as csv or mat"));
    let of_controllers = [
        ("--precision", arguments.precision.is_some(), source, "--as c or rust"),
        ("--name", arguments.name.is_some(), controller, "--as c, rust or fmu"),
        ("--unverified", arguments.unverified.is_some(), controller, "--as c, rust or fmu"),
        ("--fmi", arguments.fmi.is_some(), &[Fmu], "--as fmu"),
        ("--sources-only", arguments.sources_only, &[Fmu], "--as fmu"),
    ];
    let form = match arguments.form {
        C => "c",
        Rust => "rust",
        Fmu => "fmu",
        Csv => "csv",
        Mat => "mat",
        Json => "json",
    };
    let idle = of_tables
        .into_iter()
        .chain(of_controllers)
        .find(|(_, given, forms, _)| *given && !forms.contains(&arguments.form));
    idle.map(|(option, _, _, needed)| Idle { option, form, needed })
}
