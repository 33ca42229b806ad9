//! The roof: the command line and the paper from end to end. Glue only.
//!
//! Enters: arguments and files. Leaves: files, figures, one JSON object or a table, an exit status.
//! Deliberately absent: mathematics.

pub mod cli;
mod controller_file;
mod design;
mod export;
mod failure;
mod identify;
mod law;
mod nominal;
mod output;
mod poles;
mod record;
mod reproduce;
mod response;
mod rig_file;
mod rig_test;
mod show;
mod simulate;
mod verify;

pub use failure::Failure;

/// Runs one command.
pub fn run(cli: cli::Cli) -> Result<(), Failure> {
    match cli.command {
        cli::Command::Reproduce(arguments) => reproduce::run(&arguments),
        cli::Command::Record(arguments) => record::run(&arguments),
        cli::Command::Identify(arguments) => identify::run(&arguments),
        cli::Command::Design(arguments) => design::run(&arguments),
        cli::Command::Verify(arguments) => verify::run(&arguments),
        cli::Command::Simulate(arguments) => simulate::run(&arguments),
        cli::Command::Rig { command: cli::Rig::Test(arguments) } => rig_test::run(&arguments),
        cli::Command::Export(arguments) => export::run(&arguments),
        cli::Command::Show(arguments) => show::run(&arguments),
    }
}
