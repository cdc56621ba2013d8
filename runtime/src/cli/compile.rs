//! `oslcl compile`: OSL files to OpenCL C, SPIR-V, reflection and the like, or to a package of them.
//!
//! In: OSL or `.oso` files. Out: the files that `--emit` asks for ([`emit`]), or a package ([`super::package`]). Several files
//! are compiled at a time; what is said about each stays together, in the order of the files.

use super::args::{CompileArgs, EmitArg};
use super::sources::{self, Folders};
use super::{Error, emit, package, params, report, terminal};
use clap::ValueEnum;
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

/// What came of a file: its index, the result, the findings.
type Told<T> = (usize, Result<T, Error>, String);

/// Compiles each file, as many at a time as there are cores; fails when one has errors. The outputs of a file that fails stay
/// as they were.
pub fn run(args: &CompileArgs) -> Result<(), Error> {
    if let Some(path) = args.output.as_deref().filter(|p| package::named(p).is_some()) {
        return package::pack(args, path);
    }
    if let Some((file, shader)) = args.files.iter().find_map(|f| package::named(f)) {
        return match args.files.as_slice() {
            [_] => package::unpack(args, &file, shader.as_deref()),
            _ => Err(Error::Usage(format!("`{}` is taken apart alone, not beside other files", file.display()))),
        };
    }
    if !args.interactive.is_empty() {
        return Err(Error::Usage("--interactive goes with a package: -o NAME.oslpak".to_owned()));
    }
    if args.files.len() > 1 && !args.param.is_empty() {
        return Err(Error::Usage("--param goes with one file only".to_owned()));
    }
    check_named(args)?;
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
    let needs_device = args.emits(EmitArg::Binary);
    let device = needs_device.then(|| Device::open(args.device.as_deref())).transpose()?;
    let work = |index: usize, said: &mut String| compile(&args.files[index], args, device.as_ref(), said);
    each(args.files.len(), work, &mut |_, line| terminal::print(&line))
}

/// Does the work for each of `count` files, as many at a time as there are cores; what is said about them and what is done with
/// the results comes in their order. Fails when one fails.
pub(super) fn each<T: Send>(
    count: usize,
    work: impl Fn(usize, &mut String) -> Result<T, Error> + Sync,
    deliver: &mut dyn FnMut(usize, T) -> Result<(), Error>,
) -> Result<(), Error> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(count);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let mut said = String::new();
                    let done = work(index, &mut said);
                    if sender.send((index, done, said)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        tell(receiver, count, deliver)
    })
}

/// Prints what is said about each file, in order, and delivers its result. The first wrong usage ends it.
fn tell<T>(
    receiver: mpsc::Receiver<Told<T>>,
    count: usize,
    deliver: &mut dyn FnMut(usize, T) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut result = Ok(());
    let mut waiting: Vec<Option<(Result<T, Error>, String)>> = (0..count).map(|_| None).collect();
    let mut at = 0;
    for (index, done, said) in receiver {
        waiting[index] = Some((done, said));
        while let Some((done, said)) = waiting.get_mut(at).and_then(Option::take) {
            at += 1;
            terminal::say(&said);
            match done {
                Ok(done) => deliver(at - 1, done)?,
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

/// The form that the output is named after, where it is a file (x.cl) and no folder.
fn named_form(output: &Path) -> Option<EmitArg> {
    let ending = output.extension()?.to_str()?;
    if output.is_dir() {
        return None;
    }
    emit::KINDS.into_iter().find(|k| emit::ending(*k) == ending)
}

/// An output that is named as a file has one source, and is among what is written.
fn check_named(args: &CompileArgs) -> Result<(), Error> {
    let Some((output, form)) = args.output.as_deref().and_then(|o| Some((o, named_form(o)?))) else { return Ok(()) };
    if args.files.len() > 1 {
        return Err(Error::Usage(format!(
            "`{}` is one file: with several sources, -o names a folder",
            output.display()
        )));
    }
    if !args.emits(form) {
        let name = form.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
        return Err(Error::Usage(format!("`{}` is not among what is written: add --emit {name}", output.display())));
    }
    Ok(())
}

/// Where the outputs go, without their endings.
fn base(path: &Path, args: &CompileArgs) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default();
    match args.output.as_deref() {
        Some(file) if named_form(file).is_some() => file.with_extension(""),
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
    let spirv = args.emits(EmitArg::Spirv) || args.emits(EmitArg::Bitcode);
    let options = Options { bindings, textures: Some(library.access()), spirv, ..options };
    let output = master.instance(&options).map_err(|f| failed(&f, &folders, said))?;
    // Those of the front half come first and were said.
    let later = &output.warnings[master.warnings().len().min(output.warnings.len())..];
    said.push_str(&report::rendered(&output.sources, later));
    let base = base(path, args);
    if let (Some(_), Some(folder)) = (&args.output, base.parent()) {
        std::fs::create_dir_all(folder).map_err(|e| files::Error { path: folder.to_owned(), cause: e.into() })?;
    }
    let mut outputs = Vec::new();
    for kind in emit::KINDS.into_iter().filter(|k| args.emits(*k)) {
        let job =
            emit::Job { from: emit::From::Source(&master, &options), artifact: &output.artifact, precision, device };
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

/// Says why a file does not compile.
pub(super) fn failed(failure: &Failure, folders: &Folders, said: &mut String) -> Error {
    said.push_str(&report::rendered(&failure.sources, &failure.diagnostics));
    for refused in folders.refused() {
        said.push_str(&format!("  note: {refused}\n"));
    }
    Error::Reported
}
