//! `oslc`: the compiler, with the options of the reference implementation's.
//!
//! In: the command line. Out: `.oso` files; findings on standard error, each as `FILE:LINE: error: ...` first.

use super::super::args::SourceArgs;
use super::super::sources::{self, Folders};
use super::super::{Error, terminal};
use super::options::{self, Spec, Takes, spec};
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::{Options, SourceMap, check_only};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const TABLE: &[Spec] = &[
    spec(&["help", "h"], Takes::Nothing, "Print this help"),
    spec(&["version"], Takes::Nothing, "Print the version"),
    spec(&["o"], Takes::Joined, "FILE: the output file"),
    spec(&["v"], Takes::Nothing, "Verbose mode"),
    spec(&["q"], Takes::Nothing, "Quiet mode"),
    spec(&["I"], Takes::Joined, "DIR: look here for #include files"),
    spec(&["D"], Takes::Joined, "NAME[=VALUE]: define a preprocessor symbol"),
    spec(&["U"], Takes::Joined, "NAME: leave a preprocessor symbol undefined"),
    spec(&["O", "O0", "O1", "O2"], Takes::Nothing, "Accepted: the code is optimised when it is run"),
    spec(&["d"], Takes::Nothing, "Accepted for the reference's debug mode"),
    spec(&["Werror"], Takes::Nothing, "Treat warnings as errors"),
    spec(&["W"], Takes::Rest, ""),
];

/// What the command line asks for.
struct Job {
    files: Vec<PathBuf>,
    options: Options,
    include: Vec<PathBuf>,
    warnings_are_errors: bool,
}

/// Runs the tool.
pub fn run(args: &[String]) -> Result<ExitCode, Error> {
    let items = options::read(args, TABLE).map_err(|e| Error::Usage(format!("oslc: {e}")))?;
    let has = |name: &str| items.iter().any(|i| i.name == name);
    if has("version") {
        terminal::print(concat!("oslc (oslcl ", env!("CARGO_PKG_VERSION"), ")\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let usage =
        || format!("oslc -- Open Shading Language compiler\nUsage:  oslc [options] file...\n{}", options::help(TABLE));
    if args.is_empty() || has("help") {
        terminal::print(&usage())?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut job =
        Job { files: Vec::new(), options: Options::default(), include: Vec::new(), warnings_are_errors: has("Werror") };
    for item in &items {
        let value = item.value();
        match item.name {
            "" => job.files.push(value.into()),
            "I" => job.include.push(value.into()),
            "D" => {
                let (name, text) = value.split_once('=').unwrap_or((value, "1"));
                job.options.defines.push((name.to_owned(), text.to_owned()));
            }
            "U" => job.options.undefines.push(value.to_owned()),
            _ => {}
        }
    }
    if job.files.is_empty() {
        terminal::print(&format!("ERROR: Missing shader path\n\n{}", usage()))?;
        return Ok(ExitCode::FAILURE);
    }
    let mut code = ExitCode::SUCCESS;
    for file in &job.files {
        if !compile(file, &job)? {
            terminal::print(&format!("FAILED {}\n", file.display()))?;
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

/// Compiles one file; false when it has errors, which were said.
fn compile(path: &Path, job: &Job) -> Result<bool, Error> {
    let source = match sources::read(path) {
        Ok(source) => source,
        Err(error) => {
            terminal::say(&format!("error: {error}\n"));
            return Ok(false);
        }
    };
    let options = Options { file_name: source.name.clone(), ..job.options.clone() };
    // As in the reference, the file's own folder also serves `#include <x>`.
    let mut include = vec![path.parent().unwrap_or(Path::new("")).to_owned()];
    include.extend(job.include.iter().cloned());
    let folders = Folders::new(&SourceArgs { include, define: Vec::new(), closures: Vec::new() });
    match check_only(&source.text, &options, &folders) {
        Ok((warnings, sources)) => {
            say(&sources, &warnings, job.warnings_are_errors);
            if job.warnings_are_errors && !warnings.is_empty() {
                return Ok(false);
            }
            terminal::say("error: .oso files cannot be written by this version of oslcl yet\n");
            Ok(false)
        }
        Err(failure) => {
            say(&failure.sources, &failure.diagnostics, job.warnings_are_errors);
            Ok(false)
        }
    }
}

/// Says findings in the form `FILE:LINE: error: message`.
fn say(sources: &SourceMap, findings: &[Diagnostic], warnings_are_errors: bool) {
    for d in findings {
        let word = if d.is_error() || warnings_are_errors { "error" } else { "warning" };
        let mut text = match d.labels.first().map(|l| sources.locate(l.span)) {
            Some(at) => format!("{}:{}: {word}: {} [{}]\n", at.file, at.line, d.message, d.code),
            None => format!("{word}: {} [{}]\n", d.message, d.code),
        };
        for label in d.labels.iter().skip(1) {
            let at = sources.locate(label.span);
            text += &format!("  note: {}:{}: {}\n", at.file, at.line, label.text);
        }
        if let Some(help) = &d.help {
            text += &format!("  help: {help}\n");
        }
        terminal::say(&text);
    }
}
