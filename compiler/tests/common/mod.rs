//! What the tests of the compiler share: the files of tests/corpus, and the compiler's stages one by one.
//!
//! In: paths below tests/corpus. Out: the results of each stage. It must not know what is expected of them.

#![allow(dead_code)] // Each test file uses its own part.

use oslcl_compiler::ir::Shader;
use oslcl_compiler::preprocess::{self, Preprocessed};
use oslcl_compiler::source::SourceMap;
use oslcl_compiler::{Diagnostic, Includes, ast, check, lower, parse, passes};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The folder tests/corpus.
pub fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/corpus")
}

/// The `.osl` files of a folder, sorted.
pub fn shaders(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of shaders").flatten();
    let mut out: Vec<PathBuf> =
        entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "osl")).collect();
    out.sort();
    out
}

/// A file's text.
pub fn text(path: &Path) -> String {
    std::fs::read_to_string(path).expect("a readable shader")
}

/// The name to show for a file: without its folders.
pub fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Headers beside the shaders of a folder, and those that ship; `stdosl.h` always as shipped.
pub struct Beside(pub PathBuf);

impl Includes for Beside {
    fn read(&self, path: &str, _from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl");
        let folders = if path == "stdosl.h" { vec![shipped] } else { vec![self.0.clone(), shipped] };
        let text = folders.iter().find_map(|folder| std::fs::read_to_string(folder.join(path)).ok())?;
        Some((path.to_owned(), text.into()))
    }
}

/// The text after the preprocessor.
pub fn preprocessed(name: &str, text: &str) -> Result<Preprocessed, Vec<Diagnostic>> {
    let mut sources = SourceMap::default();
    preprocess::preprocess(name, text, &preprocess::Options::default(), &Beside(corpus()), &mut sources)
}

/// The syntax tree.
pub fn tree(name: &str, text: &str) -> Result<ast::File, Vec<Diagnostic>> {
    parse::parse(&preprocessed(name, text)?)
}

/// The IR after lowering.
pub fn lowered(name: &str, text: &str) -> Result<Shader, Vec<Diagnostic>> {
    lower::lower(&check::check(&tree(name, text)?)?)
}

/// The IR after all passes, for a grid of all outputs or, without outputs, as a material.
pub fn optimised(name: &str, text: &str) -> Result<Shader, Vec<Diagnostic>> {
    let mut shader = lowered(name, text)?;
    let outputs: Vec<String> = shader.params.iter().filter(|p| p.output).map(|p| p.name.clone()).collect();
    passes::optimise(&mut shader, &[], &outputs)?;
    Ok(shader)
}
