//! The command line.

use std::process::ExitCode;

use clap::Parser;
use flexbeam::cli::Cli;

fn main() -> ExitCode {
    match flexbeam::run(Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("flexbeam: {failure}");
            failure.exit_code()
        }
    }
}
