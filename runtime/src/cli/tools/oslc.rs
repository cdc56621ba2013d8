//! `oslc`: the compiler, with the options of the reference implementation's.
//!
//! In: the command line. Out: `.oso` files, dependency files; findings on standard error, each as `FILE:LINE: error: ...`
//! first; "Compiled" and "FAILED" on standard output.

use super::super::args::SourceArgs;
use super::super::sources::{self, Folders};
use super::super::{Error, terminal};
use super::options::{self, Item, Spec, Takes, spec};
use oslcl_compiler::diag::{self, Diagnostic};
use oslcl_compiler::source::FileId;
use oslcl_compiler::{Failure, Options, OsoOptions, SourceMap, preprocessed, to_oso};
use oslcl_runtime::files::{self, Output};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const TABLE: &[Spec] = &[
    spec(&["help", "h"], Takes::Nothing, "Print this help"),
    spec(&["version"], Takes::Nothing, "Print the version"),
    spec(&["o"], Takes::Joined, "FILE: the output file [default: SHADERNAME.oso]"),
    spec(&["v"], Takes::Nothing, "Verbose mode: also warnings that only this compiler has"),
    spec(&["q"], Takes::Nothing, "Quiet mode: do not say what was compiled"),
    spec(&["I"], Takes::Joined, "DIR: look here for #include files"),
    spec(&["D"], Takes::Joined, "NAME[=VALUE]: define a preprocessor symbol"),
    spec(&["U"], Takes::Joined, "NAME: leave a preprocessor symbol undefined"),
    spec(&["O0", "O1", "O2", "O"], Takes::Nothing, "Accepted: the code is optimised when it is run"),
    spec(&["d"], Takes::Nothing, "Accepted for the reference's debug mode"),
    spec(&["E"], Takes::Nothing, "Only preprocess, to standard output"),
    spec(&["Werror"], Takes::Nothing, "Treat warnings as errors"),
    spec(&["W"], Takes::Rest, ""),
    spec(&["embed-source"], Takes::Nothing, "Put the preprocessed source into the .oso file"),
    spec(&["buffer"], Takes::Nothing, "Accepted: compilation is always from memory"),
    spec(&["MD", "write-dependencies"], Takes::Nothing, "Also write a file of the headers used"),
    spec(&["MMD", "write-user-dependencies"], Takes::Nothing, "As -MD, without the compiler's own"),
    spec(&["M", "dependencies"], Takes::Nothing, "As -MD, to standard output"),
    spec(&["MM", "user-dependencies"], Takes::Nothing, "As -MMD, to standard output"),
    spec(&["MF"], Takes::Joined, "FILE: name of the file of headers [default: that of the source with .d]"),
    spec(&["MT"], Takes::Joined, "TARGET: what depends on the headers"),
];

/// Warnings without a counterpart in the reference's compiler. Scripts that read its output, and builds with `-Werror`, must not
/// meet them; `oslcl check` and `-v` say them.
const OURS: &[&str] = &["W2002", "W2008", "W2009", "W2011"];

/// Where a list of headers goes.
enum Dependencies {
    No,
    Print,
    Write,
}

/// What the command line asks for.
struct Job {
    files: Vec<PathBuf>,
    options: Options,
    include: Vec<PathBuf>,
    output: Option<PathBuf>,
    oso: OsoOptions,
    warnings_are_errors: bool,
    verbose: bool,
    quiet: bool,
    preprocess_only: bool,
    dependencies: Dependencies,
    dependency_file: Option<PathBuf>,
    dependency_target: Option<String>,
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
    let job = job(&items, args);
    if job.files.is_empty() {
        terminal::print(&format!("ERROR: Missing shader path\n\n{}", usage()))?;
        return Ok(ExitCode::FAILURE);
    }
    if job.files.len() > 1 && (job.output.is_some() || job.dependency_file.is_some()) {
        return Err(Error::Usage("oslc: -o and -MF go with one file only".to_owned()));
    }
    let mut code = ExitCode::SUCCESS;
    for file in &job.files {
        match one(file, &job) {
            Ok(()) => {}
            Err(Error::Reported) => {
                terminal::print(&format!("FAILED {}\n", file.display()))?;
                code = ExitCode::FAILURE;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(code)
}

fn job(items: &[Item], args: &[String]) -> Job {
    let has = |name: &str| items.iter().any(|i| i.name == name);
    let mut job = Job {
        files: Vec::new(),
        options: Options::default(),
        include: Vec::new(),
        output: None,
        oso: OsoOptions { command_line: String::new(), embed_source: has("embed-source") },
        warnings_are_errors: has("Werror"),
        verbose: has("v"),
        quiet: ["q", "E", "M", "MM"].into_iter().any(has),
        preprocess_only: has("E"),
        dependencies: match () {
            _ if has("M") || has("MM") => Dependencies::Print,
            _ if has("MD") || has("MMD") => Dependencies::Write,
            _ => Dependencies::No,
        },
        dependency_file: None,
        dependency_target: None,
    };
    for item in items {
        let value = item.value();
        match item.name {
            "" => job.files.push(value.into()),
            "I" => job.include.push(value.into()),
            "D" => {
                let (name, text) = value.split_once('=').unwrap_or((value, "1"));
                job.options.defines.push((name.to_owned(), text.to_owned()));
            }
            "U" => job.options.undefines.push(value.to_owned()),
            "o" => job.output = Some(value.into()),
            "MF" => job.dependency_file = Some(value.into()),
            "MT" => job.dependency_target = Some(value.to_owned()),
            _ => {}
        }
    }
    let is_file = |a: &&String| !job.files.iter().any(|f| f.to_str() == Some(a.as_str()));
    job.oso.command_line = args.iter().filter(is_file).cloned().collect::<Vec<_>>().join(" ");
    job
}

/// Compiles one file; `Reported` when it has errors.
fn one(path: &Path, job: &Job) -> Result<(), Error> {
    let refuse = |error: &dyn std::fmt::Display| {
        terminal::say(&format!("error: {error}\n"));
        Error::Reported
    };
    let source = sources::read(path).map_err(|e| refuse(&e))?;
    let options = Options { file_name: source.name.clone(), ..job.options.clone() };
    // As in the reference, the file's own folder also serves `#include <x>`.
    let mut include = vec![path.parent().unwrap_or(Path::new("")).to_owned()];
    include.extend(job.include.iter().cloned());
    let folders = Folders::new(&SourceArgs { include, define: Vec::new(), closures: Vec::new() });
    if job.preprocess_only && matches!(job.dependencies, Dependencies::No) {
        let (text, _) = preprocessed(&source.text, &options, &folders).map_err(|f| failed(&f, &folders))?;
        return terminal::print(&text);
    }
    let oso = match to_oso(&source.text, &options, &job.oso, &folders) {
        Ok(oso) => oso,
        Err(failure) => {
            // The headers are known all the same, and a build tool wants them.
            dependencies(path, &failure.sources, job)?;
            return Err(failed(&failure, &folders));
        }
    };
    let warnings: Vec<Diagnostic> =
        oso.warnings.iter().filter(|d| job.verbose || !OURS.contains(&d.code)).cloned().collect();
    say(&oso.sources, &warnings, job.warnings_are_errors);
    dependencies(path, &oso.sources, job)?;
    if job.warnings_are_errors && !warnings.is_empty() {
        return Err(Error::Reported);
    }
    let to = job.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.oso", oso.name)));
    write(&to, oso.text).map_err(|e| refuse(&e))?;
    if !job.quiet {
        terminal::print(&format!("Compiled {} -> {}\n", path.display(), to.display()))?;
    }
    Ok(())
}

fn write(path: &Path, text: String) -> Result<(), files::Error> {
    files::replace(&[Output { path: path.to_owned(), bytes: text.into_bytes() }])
}

/// Writes the list of headers, if it is asked for.
fn dependencies(path: &Path, sources: &SourceMap, job: &Job) -> Result<(), Error> {
    let to = match job.dependencies {
        Dependencies::No => return Ok(()),
        Dependencies::Write => Some(job.dependency_file.clone().unwrap_or_else(|| path.with_extension("d"))),
        Dependencies::Print => job.dependency_file.clone(),
    };
    let target = match (&job.dependency_target, &job.output) {
        (Some(target), _) => target.clone(),
        (None, Some(output)) => output.display().to_string(),
        (None, None) => path.with_extension("oso").display().to_string(),
    };
    let mut text = format!("{target}: {}", path.display());
    let mut told = vec![path.to_string_lossy().into_owned()];
    // Names in angles are the compiler's own headers, which lie in no file.
    for name in sources.names().filter(|n| !n.starts_with('<')) {
        if !told.iter().any(|t| t == name) {
            told.push(name.to_owned());
            text += &format!(" \\\n  {name}");
        }
    }
    text.push('\n');
    match to {
        None => terminal::print(&text),
        Some(file) => Ok(write(&file, text)?),
    }
}

fn failed(failure: &Failure, folders: &Folders) -> Error {
    say(&failure.sources, &failure.diagnostics, false);
    for refused in folders.refused() {
        terminal::say(&format!("  note: {refused}\n"));
    }
    Error::Reported
}

/// Says findings: `FILE:LINE: error: message` as other compilers do, then the line and what else there is to say.
fn say(sources: &SourceMap, findings: &[Diagnostic], warnings_are_errors: bool) {
    for d in findings {
        let word = if d.is_error() || warnings_are_errors { "error" } else { "warning" };
        let place = match d.labels.first() {
            Some(label) => {
                let at = sources.locate(label.span);
                format!("{}:{}: ", at.file, at.line)
            }
            None if !sources.is_empty() => format!("{}:0: ", sources.file(FileId(0)).name),
            None => String::new(),
        };
        // Below the first line, the plain form has all the rest.
        let plain = diag::render_plain(sources, std::slice::from_ref(d));
        let rest = plain.split_once('\n').map_or("", |(_, rest)| rest);
        terminal::say(&format!("{place}{word}: {} [{}]\n{rest}", d.message, d.code));
    }
}
