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
mod new;
mod nominal;
mod on_rig;
mod output;
mod poles;
mod port;
mod project;
mod record;
mod reproduce;
mod response;
mod rig_file;
mod rig_test;
mod run;
mod serve_rig;
mod show;
mod simulate;
mod tell;
mod verify;

pub use failure::Failure;

/// Runs one command.
pub fn run(cli: cli::Cli) -> Result<(), Failure> {
    match cli.command {
        cli::Command::Reproduce(arguments) => reproduce::run(&arguments),
        cli::Command::New(arguments) => new::run(&arguments),
        cli::Command::Record(arguments) => record::run(&arguments),
        cli::Command::Identify(arguments) => identify::run(&arguments),
        cli::Command::Design(arguments) => design::run(&arguments),
        cli::Command::Verify(arguments) => verify::run(&arguments),
        cli::Command::Simulate(arguments) => simulate::run(&arguments),
        cli::Command::Run(arguments) => run::run(&arguments),
        cli::Command::Tell(arguments) => tell::run(&arguments),
        cli::Command::Rig(cli::Rig { command: Some(cli::Experiment::Test(arguments)), .. }) => {
            rig_test::run(&arguments)
        }
        cli::Command::Rig(cli::Rig { command: None, serve }) => serve_rig::run(&serve),
        cli::Command::Export(arguments) => export::run(&arguments),
        cli::Command::Show(arguments) => show::run(&arguments),
    }
}
