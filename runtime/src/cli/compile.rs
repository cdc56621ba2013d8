//! `oslcl compile`: OSL files to OpenCL C and reflection.
//!
//! In: OSL files. Out: NAME.cl, which a driver builds as it stands, and NAME.json, the whole artifact.

use super::args::CompileArgs;
use super::sources::{self, Folders};
use super::{Error, params, report, terminal};
use oslcl_compiler::{Artifact, Options};
use oslcl_runtime::assemble;
use oslcl_runtime::files::{self, Output};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::textures;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Compiles each file; fails when one has errors. The outputs of a file that fails stay as they were.
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
    let mut result = Ok(());
    for done in compile_all(args)? {
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
    result
}

/// Compiles the files, as many at a time as there are processors; the results are in the order of the files.
fn compile_all(args: &CompileArgs) -> Result<Vec<Result<String, Error>>, Error> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(args.files.len());
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        while let Some((at, path)) = {
            let at = next.fetch_add(1, Ordering::Relaxed);
            args.files.get(at).map(|path| (at, path))
        } {
            done.push((at, compile(path, args)));
        }
        done
    };
    let mut all = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(|| oslcl_compiler::batch(work))).collect();
        let mut all = Vec::with_capacity(args.files.len());
        for thread in threads {
            // A panic in there is a defect of ours: it goes on here, with its own message.
            let done = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            all.extend(done.map_err(|failure| report::report(&failure))?);
        }
        Ok::<_, Error>(all)
    })?;
    all.sort_by_key(|(at, _)| *at);
    Ok(all.into_iter().map(|(_, result)| result).collect())
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

fn compile(path: &Path, args: &CompileArgs) -> Result<String, Error> {
    let source = sources::read(path)?;
    let options = sources::options(&source, &args.source);
    let master = report::master(&source.text, &options, &Folders::new(&args.source))?;
    let options = Options { bindings: params::bindings(&args.param, master.info())?, ..options };
    let artifact = report::instance(&master, &options)?.artifact;
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
