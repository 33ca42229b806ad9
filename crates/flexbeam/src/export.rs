//! `flexbeam export`: a file of ours in a form that other tools read.
//!
//! Enters: any file that can be exported, a form. Leaves: that form, and one answer. Deliberately absent: the forms
//! themselves, which `flexbeam-files` and `flexbeam-codegen` own.

mod compiler;
mod recording;
mod single;
mod source;
mod unit;

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
        cli::Form::Fmu => unit::export(arguments),
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
    use cli::Form::{C, Csv, Fmu, Mat, Rust};
    let (recording, source, controller) = (&[Csv, Mat][..], &[C, Rust][..], &[C, Rust, Fmu][..]);
    let options = [
        ("--columns", !arguments.columns.is_empty(), recording, "--as csv or mat"),
        ("--period", arguments.period.is_some(), recording, "--as csv or mat"),
        ("--precision", arguments.precision.is_some(), source, "--as c or rust"),
        ("--name", arguments.name != cli::DEFAULT_NAME, controller, "--as c, rust or fmu"),
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
    };
    let idle = options.into_iter().find(|(_, given, forms, _)| *given && !forms.contains(&arguments.form));
    idle.map(|(option, _, _, needed)| Idle { option, form, needed })
}
