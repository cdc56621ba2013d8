//! `oslcl check`: errors and warnings of OSL files, and whether packages are whole; writes nothing.

use super::args::CheckArgs;
use super::sources::{self, Folders};
use super::{Error, package, report, terminal};
use std::path::Path;

/// Checks each file; fails when one has errors.
pub fn run(args: &CheckArgs) -> Result<(), Error> {
    let mut result = Ok(());
    for path in &args.files {
        match check(path, args) {
            Ok(()) => terminal::print(&format!("{}: ok\n", path.display()))?,
            Err(Error::Reported) => result = Err(Error::Reported),
            Err(error) => {
                terminal::say_error(error);
                result = Err(Error::Reported);
            }
        }
    }
    result
}

fn check(path: &Path, args: &CheckArgs) -> Result<(), Error> {
    if let Some((file, name)) = package::named(path) {
        return package::check(&file, name.as_deref());
    }
    let source = sources::read(path)?;
    let options = sources::options(&source, &args.source)?;
    let master = report::master(&source.text, &options, &Folders::new(&args.source))?;
    // Some findings need values: a loop of closures, say, must have an end that is known.
    report::instance(&master, &options)?;
    Ok(())
}
