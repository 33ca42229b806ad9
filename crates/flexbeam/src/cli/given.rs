//! Arguments that know which of them stand on the command line: what stands there wins over a project, a default does not.

use std::collections::BTreeSet;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches, Id};

/// A command's arguments, and which of them were given.
#[derive(Clone, Debug)]
pub struct Given<A> {
    /// All of them, defaults filled in.
    pub arguments: A,
    stated: BTreeSet<Id>,
}

impl<A> Given<A> {
    /// Whether the option stands on the command line, by the name of its field.
    pub fn states(&self, field: &str) -> bool {
        self.stated.contains(field)
    }
}

impl<A: Args> Args for Given<A> {
    fn augment_args(command: Command) -> Command {
        A::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        A::augment_args_for_update(command)
    }
}

impl<A: FromArgMatches> FromArgMatches for Given<A> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Given<A>, Error> {
        Ok(Given { arguments: A::from_arg_matches(matches)?, stated: stated(matches) })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        self.stated.extend(stated(matches));
        self.arguments.update_from_arg_matches(matches)
    }
}

fn stated(matches: &ArgMatches) -> BTreeSet<Id> {
    let stated = |id: &&Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
    matches.ids().filter(stated).cloned().collect()
}
