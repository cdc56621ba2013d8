//! Compiles collections of shaders and builds them on the first device; writes a report of what does not and why.
//!
//! In: `corpora [-I DIR]... [--report FILE] [--no-build] NAME=DIR...`. Out: the report (standard output without `--report`).
//! A collection's own folders with headers are searched too, and its `stdosl.h` is read behind ours. tests/corpora/run.py
//! finds the collections and calls it.

use oslcl_compiler::{Entry, Failure, Includes, Master, Options, Output, batch};
use oslcl_runtime::assemble::assemble;
use oslcl_runtime::device::{Device, Program};
use oslcl_runtime::textures;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Build options: single precision, as renders use it.
const BUILD: &str = "-cl-std=CL1.2 -cl-single-precision-constant";

/// Functions per program.
const GROUP: usize = 16;

/// Files named with a cause.
const NAMED: usize = 3;

/// Header folders of a collection.
struct Folders(Vec<PathBuf>);

impl Includes for Folders {
    fn read(&self, path: &str, from: Option<&str>, system: bool) -> Option<(String, Arc<str>)> {
        let beside = from.filter(|_| !system).and_then(|f| Path::new(f).parent().map(Path::to_owned));
        beside.iter().chain(&self.0).map(|f| f.join(path)).find_map(|p| {
            let text = fs::read(&p).ok()?;
            Some((p.display().to_string(), String::from_utf8_lossy(&text).into()))
        })
    }
}

/// What became of a file.
enum Fate {
    Built,
    /// It needs files that are not there, or holds no shader.
    Incomplete(String),
    /// The reference compiler refuses it too (tests/corpora/invalid.txt).
    Invalid(String),
    /// The compiler refuses it.
    Refused(String),
    /// The device refuses its code.
    NotBuilt(String),
}

struct Code {
    file: usize,
    entry: String,
    code: String,
    /// Macros of the headers that it needs.
    macros: Vec<String>,
}

fn walk(folder: &Path, shaders: &mut Vec<PathBuf>, headers: &mut BTreeSet<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|e| e.path()) {
        match path.extension().and_then(|e| e.to_str()) {
            _ if path.is_dir() => walk(&path, shaders, headers),
            Some("osl") => shaders.push(path),
            Some("h") => {
                headers.insert(folder.to_owned());
                // `#include <Name/header.h>` starts one folder higher.
                headers.extend(folder.parent().map(Path::to_owned));
            }
            _ => {}
        }
    }
}

/// A shader as a material and, where it has outputs that are no closures or strings, as a grid function of them.
fn compile(path: &Path, includes: &Folders, file: usize) -> Result<Vec<Code>, Failure> {
    let bytes = fs::read(path).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let options = Options {
        file_name: path.display().to_string(),
        textures: Some(Arc::new(textures::Library::new(textures::Settings::default())).access()),
        ..Options::default()
    };
    let master = Master::new(text, &options, includes)?;
    let code = |Output { artifact, .. }: Output| {
        let mut macros: Vec<String> = artifact.lobes.iter().map(|l| format!("HAS_LOBE_{}", l.to_uppercase())).collect();
        macros.extend(textures::macros(&artifact.textures).into_iter().map(|m| m.to_string()));
        if !artifact.sites.is_empty() {
            macros.push("HAS_MESSAGES".into());
        }
        Code { file, entry: artifact.entry, code: artifact.code, macros }
    };
    let mut out = vec![code(master.instance(&options)?)];
    let numeric = |ty: &str| !ty.starts_with("closure") && !ty.starts_with("string");
    let mut outputs: Vec<String> = Vec::new();
    for p in master.info().params.iter().filter(|p| p.output && numeric(&p.ty)) {
        if p.fields.is_empty() {
            outputs.push(p.name.clone());
        }
        outputs.extend(p.fields.iter().filter(|f| numeric(&f.ty)).map(|f| format!("{}.{}", p.name, f.name)));
    }
    if !outputs.is_empty() {
        out.push(code(master.instance(&Options { entry: Entry::Grid(outputs), ..options })?));
    }
    Ok(out)
}

/// Files held for invalid, and why.
const INVALID: &str = include_str!("../../corpora/invalid.txt");

/// Why a file is held for invalid.
fn invalid(path: &Path) -> Option<&'static str> {
    let lines = INVALID.lines().filter(|l| !l.starts_with('#'));
    lines.filter_map(|l| l.split_once(": ")).find(|(end, _)| path.ends_with(end)).map(|(_, why)| why)
}

/// The cause of a failure, the same for files that fail alike.
fn cause(failure: &Failure) -> Fate {
    let Some(d) = failure.diagnostics.iter().find(|d| d.is_error()) else { return Fate::Refused("no finding".into()) };
    let words = format!("{}: {}", d.code, d.message);
    match d.code {
        "E0001" | "E2013" => Fate::Incomplete(words),
        _ => Fate::Refused(words),
    }
}

fn build(device: &Device, group: &[Code]) -> Result<(), String> {
    let macros: BTreeSet<&String> = group.iter().flat_map(|c| &c.macros).collect();
    let mut text = String::from("#define HAS_DERIVATIVES\n");
    text.extend(macros.iter().map(|m| format!("#define {m}\n")));
    for one in group {
        text.push_str(&one.code);
        text.push('\n');
    }
    let text = assemble("corpus.cl", &text).map_err(|e| e.to_string())?;
    Program::build(device, "corpus", &text, BUILD).map(|_| ()).map_err(|e| e.to_string())
}

/// Codes in groups whose functions have different names.
fn groups(codes: Vec<Code>) -> Vec<Vec<Code>> {
    let mut out: Vec<Vec<Code>> = Vec::new();
    for code in codes {
        let start = out.len().saturating_sub(4);
        let fits = |g: &Vec<Code>| g.len() < GROUP && g.iter().all(|c| c.entry != code.entry);
        match out[start..].iter_mut().find(|g| fits(g)) {
            Some(group) => group.push(code),
            None => out.push(vec![code]),
        }
    }
    out
}

/// The line of a device's log that tells most.
fn first_error(log: &str) -> String {
    let line = log.lines().find(|l| l.contains("error:")).or_else(|| log.lines().next()).unwrap_or("no log");
    line.split("error:").last().unwrap_or(line).trim().to_owned()
}

fn collection(folder: &Path, more: &[PathBuf], device: Option<&Device>) -> (Vec<PathBuf>, Vec<Fate>) {
    let (mut shaders, mut headers) = (Vec::new(), BTreeSet::new());
    walk(folder, &mut shaders, &mut headers);
    shaders.sort();
    let includes = Folders(headers.into_iter().chain(more.iter().cloned()).collect());
    let mut fates: Vec<Fate> = shaders.iter().map(|_| Fate::Built).collect();
    let mut codes = Vec::new();
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let work = || {
        batch(|| {
            let mut done = Vec::new();
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(path) = shaders.get(i) else { return done };
                done.push((i, compile(path, &includes, i)));
            }
        })
    };
    let compiled: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads.into_iter().map(|t| t.join().unwrap_or_else(|p| std::panic::resume_unwind(p))).collect()
    });
    for (i, result) in compiled.into_iter().flat_map(|done| done.unwrap_or_else(|e| panic!("{e}"))) {
        match result {
            Ok(more) => codes.extend(more),
            Err(failure) => {
                fates[i] = match invalid(&shaders[i]) {
                    Some(why) => Fate::Invalid(why.to_owned()),
                    None => cause(&failure),
                };
            }
        }
    }
    let Some(device) = device else { return (shaders, fates) };
    let groups = groups(codes);
    let next = AtomicUsize::new(0);
    let work = || {
        let mut found = Vec::new();
        while let Some(group) = groups.get(next.fetch_add(1, Ordering::Relaxed)) {
            if build(device, group).is_ok() {
                continue;
            }
            for one in group {
                if let Err(log) = build(device, std::slice::from_ref(one)) {
                    found.push((one.file, first_error(&log)));
                }
            }
        }
        found
    };
    let found: Vec<(usize, String)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|t| t.join().unwrap_or_else(|p| std::panic::resume_unwind(p))).collect()
    });
    for (file, log) in found {
        fates[file] = Fate::NotBuilt(log);
    }
    (shaders, fates)
}

fn main() {
    let mut args = std::env::args().skip(1);
    let (mut more, mut report, mut collections) = (Vec::new(), None, Vec::new());
    let mut device = Some(Device::open(Some("0")));
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "-I" => more.extend(args.next().map(PathBuf::from)),
            "--report" => report = args.next(),
            "--no-build" => device = None,
            _ => match arg.split_once('=') {
                Some((name, folder)) => collections.push((name.to_owned(), PathBuf::from(folder))),
                None => return eprintln!("corpora: `{arg}` is neither an option nor NAME=DIR"),
            },
        }
    }
    let device = match device {
        Some(Err(e)) => return eprintln!("corpora: no device: {e}"),
        other => other.and_then(Result::ok),
    };
    let mut out = String::from(
        "# Public collections of shaders\n\nWritten by tests/corpora/run.py: each shader is compiled to OpenCL C, as a material and as a \
         function of its outputs, and built on a device.\nIncomplete files include headers that are not in the collection, or hold no \
         shader; they do not count in the last column, \
         nor do invalid ones, which tests/corpora/invalid.txt lists with the reason why the\nreference compiler refuses them too. Every \
         other file that ours refuses counts as a failure.\n\n| collection | files | incomplete | invalid | refused | do not build | built | of those that \
         count |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    let mut causes = String::new();
    let mut total = [0usize; 5];
    for (name, folder) in &collections {
        let (shaders, fates) = collection(folder, &more, device.as_ref());
        let mut count = [0usize; 5];
        let mut by_cause: BTreeMap<(&str, &str), Vec<String>> = BTreeMap::new();
        for (path, fate) in shaders.iter().zip(&fates) {
            let (kind, words) = match fate {
                Fate::Built => (3, None),
                Fate::Incomplete(w) => (0, Some(("incomplete", w))),
                Fate::Invalid(w) => (4, Some(("invalid", w))),
                Fate::Refused(w) => (1, Some(("refused", w))),
                Fate::NotBuilt(w) => (2, Some(("does not build", w))),
            };
            count[kind] += 1;
            if let Some((what, words)) = words {
                let file = path.strip_prefix(folder).unwrap_or(path).display().to_string();
                by_cause.entry((what, words)).or_default().push(file);
            }
        }
        row(&mut out, name, &count);
        (0..5).for_each(|i| total[i] += count[i]);
        let mut list: Vec<_> = by_cause.into_iter().collect();
        list.sort_by_key(|(_, files)| std::cmp::Reverse(files.len()));
        if !list.is_empty() {
            let _ = writeln!(causes, "\n## {name}\n\n| files | what | cause | such as |\n|--:|---|---|---|");
        }
        for ((what, words), files) in list {
            let words = words.replace('|', "\\|");
            let named: Vec<&str> = files.iter().take(NAMED).map(String::as_str).collect();
            let _ = writeln!(causes, "| {} | {what} | {words} | {} |", files.len(), named.join(", "));
        }
    }
    row(&mut out, "all", &total);
    let out = out + &causes;
    match report {
        None => print!("{out}"),
        Some(path) => {
            if let Err(e) = fs::write(&path, out) {
                eprintln!("corpora: cannot write `{path}`: {e}");
            }
        }
    }
}

fn row(out: &mut String, name: &str, count: &[usize; 5]) {
    let [incomplete, refused, not_built, built, invalid] = *count;
    let counts = refused + not_built + built;
    let part = if counts == 0 { "-".to_owned() } else { format!("{:.1} %", 100.0 * built as f64 / counts as f64) };
    let all = incomplete + invalid + counts;
    let _ = writeln!(out, "| {name} | {all} | {incomplete} | {invalid} | {refused} | {not_built} | {built} | {part} |");
}
