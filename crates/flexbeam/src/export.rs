//! `flexbeam export`: a file of ours in a form that other tools read.
//!
//! Enters: any file that can be exported, a form. Leaves: that form, and one answer. Deliberately absent: the forms
//! themselves, which `flexbeam-files` and `flexbeam-codegen` own.

mod recording;
mod single;
mod source;

use flexbeam_files::{Error, Fault, RUN_SCHEMA, Tried, schema_of};

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
        cli::Form::Csv | cli::Form::Mat => match schema_of(&arguments.file)?.as_deref() {
            None | Some(RUN_SCHEMA) => recording::export(arguments),
            Some(other) => {
                let fault = Fault::Schema { found: other.into(), needed: RUN_SCHEMA };
                Err(Error::new(Tried::Read, &arguments.file, fault).into())
            }
        },
    }
}

/// The first option that would do nothing.
fn idle(arguments: &cli::Export) -> Option<Idle> {
    let (form, of_controller) = match arguments.form {
        cli::Form::C => ("c", true),
        cli::Form::Rust => ("rust", true),
        cli::Form::Csv => ("csv", false),
        cli::Form::Mat => ("mat", false),
    };
    let given = if of_controller {
        vec![("--columns", !arguments.columns.is_empty()), ("--period", arguments.period.is_some())]
    } else {
        let named = arguments.name != cli::DEFAULT_NAME;
        let (precision, unverified) = (arguments.precision.is_some(), arguments.unverified.is_some());
        vec![("--precision", precision), ("--name", named), ("--unverified", unverified)]
    };
    let needed = if of_controller { "--as csv or mat" } else { "--as c or rust" };
    given.into_iter().find(|(_, given)| *given).map(|(option, _)| Idle { option, form, needed })
}
