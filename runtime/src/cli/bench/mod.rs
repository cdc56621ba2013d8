//! `oslcl bench`: reports that anyone can make again, one file a subject.

mod accuracy;
mod effects;
mod page;
mod startup;

use super::Error;
use super::args::BenchCommand;

/// Makes the report asked for.
pub fn run(command: &BenchCommand) -> Result<(), Error> {
    match command {
        BenchCommand::Accuracy(args) => accuracy::run(args),
        BenchCommand::Startup(args) => startup::run(args),
        BenchCommand::Effects(args) => effects::run(args),
    }
}
