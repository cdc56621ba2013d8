//! Shader groups as text, with the shaders that they name.
//!
//! In: a group's text, folders. Out: the compiler's [`Group`]. It must not know scenes.

use crate::shader_file;
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::{Failure, Group, Includes, Master, Options, ParseError, TextError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The ending of files that hold a group's text.
pub const EXTENSION: &str = "oslgroup";

/// A group to read.
pub struct Request<'a> {
    /// Its name.
    pub name: &'a str,
    /// OSL's text of a group.
    pub text: &'a str,
    /// The file of the text, for messages. Shaders that no folder has are looked for beside it.
    pub path: &'a Path,
    /// Folders of shaders, in order.
    pub folders: &'a [PathBuf],
    /// How the shaders are compiled.
    pub options: &'a Options,
    /// Other files of theirs.
    pub includes: &'a (dyn Includes + Sync),
}

/// Reads a group. Its shaders are files in the folders or beside the text, with or without `.osl`, or shipped ones.
pub fn read(request: &Request<'_>) -> Result<Group, Failure> {
    let told = |d: Diagnostic| Failure { diagnostics: vec![d], sources: Arc::default() };
    let beside = request.path.parent().unwrap_or(Path::new(""));
    let folders: Vec<PathBuf> = request.folders.iter().cloned().chain([beside.to_path_buf()]).collect();
    let mut find = |name: &str| {
        let found = shader_file::find(name, &folders);
        let file = found.unwrap_or_else(|| beside.join(format!("{name}.osl")));
        let source = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(cause) => match crate::scene::shipped(name) {
                Some(text) => text.to_owned(),
                None => {
                    let message =
                        format!("shader `{name}` is no shipped one, nor is it at {}: {cause}", file.display());
                    return Err(told(TextError { line: 1, column: 1, message, help: None }.diagnostic()));
                }
            },
        };
        let options = Options { file_name: file.to_string_lossy().into_owned(), ..request.options.clone() };
        Master::new(&source, &options, request.includes).map(Arc::new)
    };
    Group::parse(request.name, request.text, &mut find).map_err(|e| match e {
        ParseError::Text(e) => {
            let place = format!("{}:{}:{}", request.path.display(), e.line, e.column);
            let d = Diagnostic::global("E4017", format!("{place}: shader group: {}", e.message));
            told(match e.help {
                Some(help) => d.help(help),
                None => d,
            })
        }
        ParseError::Shader { cause, .. } => cause,
    })
}

/// The full name, `layer.param`, of a parameter; without a layer's name it is one of the last.
pub fn full_name<'a>(name: &str, layers: impl Iterator<Item = &'a str>) -> String {
    let named = name.split_once('.').map(|(layer, _)| layer);
    let mut last = "";
    for layer in layers {
        if named == Some(layer) {
            return name.to_owned();
        }
        last = layer;
    }
    format!("{last}.{name}")
}
