// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which arguments the user gave, whatever their values.

use clap::error::Error;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};

/// The arguments of a command, with the names of those that were given.
pub struct Given<A> {
    pub arguments: A,
    /// As they are typed, without dashes: `bc-quality`; of positional ones `table`.
    pub names: Vec<String>,
}

impl<A: Args> FromArgMatches for Given<A> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let all = A::augment_args(Command::new(""));
        let given = all
            .get_arguments()
            .filter(|argument| matches.value_source(argument.get_id().as_str()) == Some(ValueSource::CommandLine));
        let names = given.map(|a| a.get_long().unwrap_or(a.get_id().as_str()).to_string()).collect();
        Ok(Given { arguments: A::from_arg_matches(matches)?, names })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Given::from_arg_matches(matches)?;
        Ok(())
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
