//! `oslinfo`: a shader's parameters, defaults and metadata, as the reference implementation's tool prints them.
//!
//! In: the command line. Out: text on standard output; a shader that cannot be had is a line there, as in the reference.

use super::super::{Error, terminal};
use super::options::{self, Spec, Takes, spec};
use std::process::ExitCode;

const TABLE: &[Spec] = &[
    spec(&["v"], Takes::Nothing, "Verbose output"),
    spec(&["runstats"], Takes::Nothing, "Benchmark the time to load each shader"),
    spec(&["p"], Takes::Values(1), "SEARCHPATH: folders to look for shaders in, with `:` between"),
    spec(&["param"], Takes::Values(1), "NAME: tell about this parameter only"),
    spec(&["json"], Takes::Nothing, "Print JSON for other tools"),
    spec(&["help", "h"], Takes::Nothing, "Print this help"),
    spec(&["version"], Takes::Nothing, "Print the version"),
];

/// Runs the tool.
pub fn run(args: &[String]) -> Result<ExitCode, Error> {
    let items = options::read(args, TABLE).map_err(|e| Error::Usage(format!("oslinfo: {e}")))?;
    if items.iter().any(|i| i.name == "version") {
        terminal::print(concat!("oslinfo (oslcl ", env!("CARGO_PKG_VERSION"), ")\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    if items.iter().any(|i| i.name == "help") || !items.iter().any(|i| i.name.is_empty()) {
        let head = "oslinfo -- list the parameters of OSL shaders\nUsage:  oslinfo [options] file0 [file1 ...]\n";
        terminal::print(&format!("{head}{}", options::help(TABLE)))?;
        return Ok(ExitCode::SUCCESS);
    }
    Err(Error::Usage("oslinfo: queries are not built into this version of oslcl yet".to_owned()))
}
