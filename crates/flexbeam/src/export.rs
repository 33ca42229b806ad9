//! `flexbeam export`: a file of ours in a form that other tools read.
//!
//! Enters: any file that can be exported, a form. Leaves: that form, and one answer. Deliberately absent: the forms
//! themselves, which `flexbeam-files` owns.

mod recording;

use flexbeam_files::{Error, Fault, RUN_SCHEMA, Tried, schema_of};

use crate::{Failure, cli};

/// `flexbeam export`.
pub fn run(arguments: &cli::Export) -> Result<(), Failure> {
    match schema_of(&arguments.file)?.as_deref() {
        None | Some(RUN_SCHEMA) => recording::export(arguments),
        Some(other) => {
            let fault = Fault::Schema { found: other.into(), needed: RUN_SCHEMA };
            Err(Error::new(Tried::Read, &arguments.file, fault).into())
        }
    }
}
