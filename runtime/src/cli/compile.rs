//! `oslcl compile`: OSL files to OpenCL C and reflection.
//!
//! In: OSL or `.oso` files. Out: NAME.cl, which a driver builds as it stands, and NAME.json, the whole artifact. Several files
//! are compiled at a time; what is said about each stays together, in the order of the files.

use super::args::CompileArgs;
use super::sources::{self, Folders};
use super::{Error, params, report, terminal};
use oslcl_compiler::{Artifact, Failure, Master, Options};
use oslcl_runtime::assemble;
use oslcl_runtime::files::{self, Output};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::textures;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// What came of a file: its index, the line to print, the findings.
type Told = (usize, Result<String, Error>, String);

/// Compiles each file, as many at a time as there are cores; fails when one has errors. The outputs of a file that fails stay
/// as they were.
pub fn run(args: &CompileArgs) -> Result<(), Error> {
    if args.files.len() > 1 && !args.param.is_empty() {
        return Err(Error::Usage("--param goes with one file only".to_owned()));
    }
    let mut bases: HashMap<PathBuf, &Path> = HashMap::new();
    for path in &args.files {
        if let Some(other) = bases.insert(base(path, args), path) {
            return Err(Error::Usage(format!(
                "`{}` and `{}` would be written to the same files",
                other.display(),
                path.display()
            )));
        }
    }
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(args.files.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(path) = args.files.get(index) else { break };
                    let mut said = String::new();
                    let done = compile(path, args, &mut said);
                    if sender.send((index, done, said)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        tell(receiver, args.files.len())
    })
}

/// Prints what is said about each file, in order. The first wrong usage ends it.
fn tell(receiver: mpsc::Receiver<Told>, count: usize) -> Result<(), Error> {
    let mut result = Ok(());
    let mut waiting: Vec<Option<(Result<String, Error>, String)>> = (0..count).map(|_| None).collect();
    let mut at = 0;
    for (index, done, said) in receiver {
        waiting[index] = Some((done, said));
        while let Some((done, said)) = waiting.get_mut(at).and_then(Option::take) {
            at += 1;
            terminal::say(&said);
            match done {
                Ok(text) => terminal::print(&text)?,
                Err(Error::Reported) => result = Err(Error::Reported),
                Err(Error::Usage(message)) => return Err(Error::Usage(message)),
                Err(error) => {
                    terminal::say_error(error);
                    result = Err(Error::Reported);
                }
            }
        }
    }
    result
}

/// Where the outputs go, without their endings.
fn base(path: &Path, args: &CompileArgs) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default();
    match &args.output {
        Some(folder) => folder.join(stem),
        None => path.with_file_name(stem),
    }
}

/// `base` with an ending; what stands behind an earlier dot stays.
fn with_ending(base: &Path, ending: &str) -> PathBuf {
    let mut name = base.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}

/// Compiles a file; the line that says what was written. Findings are added to `said`.
fn compile(path: &Path, args: &CompileArgs, said: &mut String) -> Result<String, Error> {
    let source = sources::read(path)?;
    let options = sources::options(&source, &args.source);
    let folders = Folders::new(&args.source);
    let master = Master::new(&source.text, &options, &folders).map_err(|f| failed(&f, &folders, said))?;
    said.push_str(&report::rendered(master.sources(), master.warnings()));
    let library = Arc::new(textures::Library::default());
    let bindings = params::bindings(&args.param, master.info())?;
    let options = Options { bindings, textures: Some(library.access()), ..options };
    let output = master.instance(&options).map_err(|f| failed(&f, &folders, said))?;
    // Those of the front half come first and were said.
    let later = &output.warnings[master.warnings().len().min(output.warnings.len())..];
    said.push_str(&report::rendered(&output.sources, later));
    let artifact = output.artifact;
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|e| files::Error { path: folder.clone(), cause: e.into() })?;
    }
    let base = base(path, args);
    let (code, json) = (with_ending(&base, ".cl"), with_ending(&base, ".json"));
    let text = standalone(&artifact).map_err(|e| Error::Shade(e.into()))?;
    files::replace(&[
        Output { path: code.clone(), bytes: text.into_bytes() },
        Output { path: json.clone(), bytes: artifact.to_json().into_bytes() },
    ])?;
    Ok(format!("{}: {} {}\n", path.display(), code.display(), json.display()))
}

fn failed(failure: &Failure, folders: &Folders, said: &mut String) -> Error {
    said.push_str(&report::rendered(&failure.sources, &failure.diagnostics));
    for refused in folders.refused() {
        said.push_str(&format!("  note: {refused}\n"));
    }
    Error::Reported
}

/// The code with every header in place, and how to build it.
fn standalone(artifact: &Artifact) -> Result<String, assemble::Error> {
    let mut head = format!(
        "// {} {}: function {}. The interface stands at `typedef struct ... ShadeResult` below.\n// Build options: {}, or for \
         64-bit floats: {}\n",
        artifact.kind,
        artifact.name,
        artifact.entry,
        Precision::Standard.build_options(),
        Precision::Reference.build_options()
    );
    for name in textures::macros(&artifact.textures) {
        let _ = writeln!(head, "#define {name}");
    }
    for lobe in &artifact.lobes {
        let _ = writeln!(head, "#define HAS_LOBE_{}", lobe.to_uppercase());
    }
    if !artifact.sites.is_empty() {
        head.push_str("#define HAS_MESSAGES\n");
    }
    assemble::assemble(&format!("{}.cl", artifact.entry), &(head + &artifact.code))
}
