//! OSL sources: files, shipped materials, includes, macros.
//!
//! In: paths and names from the command line. Out: texts, and the compiler's [`Options`] and [`Includes`] for them. It must
//! not know what is done with them.

use super::args::SourceArgs;
use oslcl_compiler::{Includes, Options, suggest};
use oslcl_runtime::{scene, shader_file};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Why there is no source.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system does not give it.
    #[error("cannot read `{}`: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// It is no text.
    #[error("`{}` is not UTF-8 text: line {line} has a byte that cannot stand there", path.display())]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// Line of the first wrong byte, from 1.
        line: usize,
    },
    /// Neither a file nor a material.
    #[error("no file and no shipped material is called `{name}`{help}")]
    Unknown {
        /// As given.
        name: String,
        /// The materials to choose from.
        help: String,
    },
}

/// The text of a shader and the name that diagnostics give it.
pub struct Source {
    /// Path, or `NAME.osl` of a shipped material.
    pub name: String,
    /// The text.
    pub text: String,
}

/// Reads an OSL or `.oso` file.
pub fn read(path: &Path) -> Result<Source, Error> {
    let bytes = std::fs::read(path).map_err(|cause| Error::Read { path: path.to_owned(), cause })?;
    let text = decode(bytes).map_err(|line| Error::NotUtf8 { path: path.to_owned(), line })?;
    Ok(Source { name: path.to_string_lossy().into_owned(), text })
}

/// Reads an OSL or `.oso` file, or takes the shipped material of that name.
pub fn read_or_shipped(path: &Path) -> Result<Source, Error> {
    let name = path.to_string_lossy();
    // What looks like a path is one.
    if path.exists() || path.extension().is_some() || path.components().count() != 1 {
        return read(path);
    }
    if scene::shipped(&name).is_none()
        && let Some(file) = shader_file::find(&name, &[PathBuf::new()])
    {
        return read(&file);
    }
    match scene::shipped(&name) {
        Some(text) => Ok(Source { name: format!("{name}.osl"), text: text.to_owned() }),
        None => {
            let help = match suggest::closest(&name, scene::names()) {
                Some(near) => format!("\n  help: did you mean `{near}`?"),
                None => format!("\n  help: the materials: {}", scene::names().collect::<Vec<_>>().join(", ")),
            };
            Err(Error::Unknown { name: name.into_owned(), help })
        }
    }
}

/// Bytes as text without a byte order mark; else the line of the first byte that is none.
fn decode(bytes: Vec<u8>) -> Result<String, usize> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text)),
        Err(e) => {
            let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
            Err(1 + good.iter().filter(|b| **b == b'\n').count())
        }
    }
}

/// The compiler's options for a source.
pub fn options(source: &Source, args: &SourceArgs) -> Options {
    let define = |text: &String| match text.split_once('=') {
        Some((name, value)) => (name.to_owned(), value.to_owned()),
        None => (text.clone(), "1".to_owned()),
    };
    Options { file_name: source.name.clone(), defines: args.define.iter().map(define).collect(), ..Options::default() }
}

/// Includes from the file system: `"path"` beside the including file, then both forms in the `-I` folders in order.
pub struct Folders {
    folders: Vec<PathBuf>,
    /// Files that are there but could not be taken, for the messages.
    refused: Mutex<Vec<Error>>,
}

impl Folders {
    /// The `-I` folders.
    pub fn new(args: &SourceArgs) -> Folders {
        Folders { folders: args.include.clone(), refused: Mutex::default() }
    }

    /// What was found but not taken, so that "not found" is not all that is said.
    pub fn refused(&self) -> Vec<Error> {
        std::mem::take(&mut self.refused.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn take(&self, path: PathBuf) -> Option<(String, Arc<str>)> {
        if !path.is_file() {
            return None;
        }
        match read(&path) {
            Ok(source) => Some((source.name, Arc::from(source.text))),
            Err(error) => {
                self.refused.lock().unwrap_or_else(PoisonError::into_inner).push(error);
                None
            }
        }
    }
}

impl Includes for Folders {
    fn read(&self, path: &str, from: Option<&str>, system: bool) -> Option<(String, Arc<str>)> {
        let beside = from.filter(|_| !system).map(|f| Path::new(f).parent().unwrap_or(Path::new("")).to_owned());
        beside.iter().chain(&self.folders).find_map(|folder| self.take(folder.join(path)))
    }
}
