//! OSL to `.oso` and back means the same; what is no `.oso` is an error with a place.

mod common;

use common::{Beside, corpus, name, shaders, text};
use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Failure, Master, Options, Oso, OsoOptions, to_oso};
use std::path::Path;

fn options(name: &str) -> Options {
    Options { file_name: name.to_owned(), ..Options::default() }
}

fn oso(name: &str, text: &str) -> Result<Oso, Failure> {
    to_oso(text, &options(name), &OsoOptions::default(), &Beside(corpus()))
}

/// A few points where every global has a value of its own.
fn points() -> Vec<Globals> {
    (0..4)
        .map(|k| {
            let x = 0.21 + 0.37 * f64::from(k);
            Globals {
                p: [x, 0.3 - x, 1.5 * x],
                i: [0.1, -0.7 * x, -0.6],
                n: [0.0, 0.6, 0.8],
                ng: [0.6, 0.0, 0.8],
                u: 0.25 * f64::from(k),
                v: 0.9 - 0.2 * f64::from(k),
                dpdu: [1.0, 0.2, x],
                dpdv: [0.0, 1.1, -x],
                time: 0.5 * x,
                dtime: 0.1,
                ..Globals::default()
            }
        })
        .collect()
}

/// The values of all outputs and of `Ci`.
fn values(master: &Master) -> Result<Vec<f64>, Failure> {
    let outputs = master.info().params.iter().filter(|p| p.output && p.fields.is_empty());
    let number = |ty: &str| !ty.starts_with("string") && !ty.starts_with("closure");
    let mut names: Vec<String> = outputs.filter(|p| number(&p.ty)).map(|p| p.name.clone()).collect();
    names.push("Ci".to_owned());
    let points = master.evaluate_all(&Options::default(), &names, &points())?;
    Ok(points.into_iter().flatten().flat_map(|(_, v)| v).collect())
}

fn first_line(failure: &Failure) -> String {
    failure.to_string().lines().next().unwrap_or_default().to_owned()
}

/// What differs between a shader and its way through `.oso`; `None` when nothing does.
fn differs(name: &str, source: &str) -> Option<String> {
    let direct = Master::new(source, &options(name), &Beside(corpus()));
    let written = match oso(name, source) {
        Ok(written) => written,
        Err(_) if direct.is_err() => return None,
        Err(failure) => return Some(format!("not written: {}", first_line(&failure))),
    };
    let through = Master::from_oso(&written.text, &options("through.oso"));
    let (direct, through) = match (direct, through) {
        (Ok(a), Ok(b)) => (a, b),
        // What is not supported is so both ways.
        (Err(_), Err(_)) => return None,
        (Ok(_), Err(failure)) => return Some(format!("not read: {}\n{}", first_line(&failure), written.text)),
        (Err(failure), Ok(_)) => return Some(format!("read, but as OSL: {}", first_line(&failure))),
    };
    let mut ours = through.info().clone();
    ours.params.iter_mut().for_each(|p| p.resolved = direct.info().params[0].resolved);
    let mut theirs = direct.info().clone();
    theirs.params.iter_mut().for_each(|p| p.resolved = direct.info().params[0].resolved);
    if ours != theirs {
        return Some(format!("the reflection differs:\n{ours:#?}\n{theirs:#?}"));
    }
    match (values(&direct), values(&through)) {
        (Ok(a), Ok(b)) => {
            let near = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan() || (a - b).abs() <= 1e-9 * a.abs().max(1.0);
            let bad = a.iter().zip(&b).position(|(a, b)| !near(*a, *b));
            let bad = if a.len() == b.len() { bad? } else { 0 };
            Some(format!("value {bad}: {:?} and {:?}\n{}", a.get(bad), b.get(bad), written.text))
        }
        (Err(_), Err(_)) => None,
        (Ok(_), Err(failure)) => Some(format!("fails only through .oso: {failure}\n{}", written.text)),
        (Err(failure), Ok(_)) => Some(format!("fails only directly: {failure}")),
    }
}

fn check_folder(folder: &Path) -> usize {
    let mut failures = Vec::new();
    let files = shaders(folder);
    for path in &files {
        if let Some(what) = differs(&name(path), &text(path)) {
            failures.push(format!("{}: {what}", name(path)));
        }
    }
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), files.len(), failures.join("\n\n"));
    files.len()
}

#[test]
fn the_corpus_means_the_same_through_oso() {
    let mut count = check_folder(&corpus());
    for folder in ["run", "builtins", "errors"] {
        let folder = corpus().join(folder);
        if folder.is_dir() {
            count += check_folder(&folder);
        }
    }
    assert!(count > 50, "only {count} shaders were found");
}

#[test]
fn shipped_materials_mean_the_same_through_oso() {
    assert!(check_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl")) > 5);
}
