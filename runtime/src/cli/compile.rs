//! `oslcl compile`: OSL files to OpenCL C, SPIR-V, reflection and the like.
//!
//! In: OSL or `.oso` files. Out: the files that `--emit` asks for ([`emit`]). Several files
//! are compiled at a time; what is said about each stays together, in the order of the files.

use super::args::{CompileArgs, EmitArg};
use super::sources::{self, Folders};
use super::{Error, emit, params, report, terminal};
use oslcl_compiler::{Failure, Master, Options};
use oslcl_runtime::device::Device;
use oslcl_runtime::files::{self, Output};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::textures;
use std::collections::HashMap;
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
    let needs_device = args.emit.contains(&EmitArg::Binary);
    let device = needs_device.then(|| Device::open(args.device.as_deref())).transpose()?;
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(args.files.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next, device) = (sender.clone(), &next, &device);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(path) = args.files.get(index) else { break };
                    let mut said = String::new();
                    let done = compile(path, args, device.as_ref(), &mut said);
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
fn compile(path: &Path, args: &CompileArgs, device: Option<&Device>, said: &mut String) -> Result<String, Error> {
    let precision = Precision::from(args.precision);
    let source = sources::read(path)?;
    let options = sources::options(&source, &args.source)?;
    let folders = Folders::new(&args.source);
    let master = Master::new(&source.text, &options, &folders).map_err(|f| failed(&f, &folders, said))?;
    said.push_str(&report::rendered(master.sources(), master.warnings()));
    let library = Arc::new(textures::Library::default());
    let bindings = params::bindings(&args.param, master.info())?;
    let spirv = args.emit.iter().any(|e| matches!(e, EmitArg::Spirv | EmitArg::Bitcode));
    let options = Options { bindings, textures: Some(library.access()), spirv, ..options };
    let output = master.instance(&options).map_err(|f| failed(&f, &folders, said))?;
    // Those of the front half come first and were said.
    let later = &output.warnings[master.warnings().len().min(output.warnings.len())..];
    said.push_str(&report::rendered(&output.sources, later));
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|e| files::Error { path: folder.clone(), cause: e.into() })?;
    }
    let base = base(path, args);
    let mut outputs = Vec::new();
    for kind in emit::KINDS.into_iter().filter(|k| args.emit.contains(k)) {
        let job = emit::Job { master: &master, options: &options, artifact: &output.artifact, precision, device };
        let files = job.write(kind).map_err(|e| match e {
            emit::Error::Compile(failure) => failed(&failure, &folders, said),
            emit::Error::Other(error) => error,
        })?;
        outputs.extend(files.into_iter().map(|(ending, bytes)| Output { path: with_ending(&base, ending), bytes }));
    }
    files::replace(&outputs)?;
    let names: Vec<String> = outputs.iter().map(|o| o.path.display().to_string()).collect();
    Ok(format!("{}: {}\n", path.display(), names.join(" ")))
}

fn failed(failure: &Failure, folders: &Folders, said: &mut String) -> Error {
    said.push_str(&report::rendered(&failure.sources, &failure.diagnostics));
    for refused in folders.refused() {
        said.push_str(&format!("  note: {refused}\n"));
    }
    Error::Reported
}
