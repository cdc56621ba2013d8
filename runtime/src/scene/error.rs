//! What can be wrong with a scene: the file, the line where known, and the cause.
//!
//! In: made by the readers and checks of this folder. Out: printed as they are. It must not know how anything is read.

use std::fmt;
use std::path::PathBuf;

/// A place in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file; `<scene>` for a scene that a program built.
    pub file: PathBuf,
    /// Line from 1; 0: unknown.
    pub line: usize,
    /// Column from 1, in characters.
    pub column: usize,
}

impl Location {
    /// The place of scenes that come from no file.
    pub fn built() -> Location {
        Location { file: PathBuf::from("<scene>"), line: 0, column: 0 }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => write!(out, "{}", self.file.display()),
            _ => write!(out, "{}:{}:{}", self.file.display(), self.line, self.column),
        }
    }
}

/// A place in a mesh file: `FILE` or `FILE:LINE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFile {
    /// The file, or the name of a mesh that a program built.
    pub path: PathBuf,
    /// Line from 1, where known.
    pub line: Option<usize>,
}

impl fmt::Display for MeshFile {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            None => write!(out, "{}", self.path.display()),
            Some(line) => write!(out, "{}:{line}", self.path.display()),
        }
    }
}

/// Why a scene can't be had. `help` is empty or starts on a new line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A file that the scene names can't be read.
    #[error("{at}: cannot read the {what} `{}`: {cause}", path.display())]
    UnreadablePart {
        /// Where it is named.
        at: Location,
        /// What it should be: `mesh`, `model`, `shader`.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// A file can't be read.
    #[error("{}: cannot read this {what}: {cause}", path.display())]
    Unreadable {
        /// What it should be: `scene`, `material library`.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// Not TOML.
    #[error("{at}: not valid TOML: {cause}")]
    Syntax {
        /// Where.
        at: Location,
        /// What the parser said.
        cause: String,
    },
    /// Not XML.
    #[error("{at}: not valid XML: {cause}")]
    Xml {
        /// Where.
        at: Location,
        /// What the parser said.
        cause: String,
    },
    /// A key that must be there isn't.
    #[error("{at}: `{table}` needs the key `{key}`")]
    MissingKey {
        /// Where the table begins.
        at: Location,
        /// The table.
        table: String,
        /// What is missing.
        key: String,
    },
    /// A key that means nothing here.
    #[error("{at}: unknown key `{key}` in `{table}`{help}")]
    UnknownKey {
        /// Where.
        at: Location,
        /// The key.
        key: String,
        /// The table.
        table: String,
        /// A better name, or the names known.
        help: String,
    },
    /// A value of another type than the key takes.
    #[error("{at}: `{key}` must be {expected}, not {found}")]
    WrongType {
        /// Where.
        at: Location,
        /// The key, with its table.
        key: String,
        /// What it takes.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// A value out of its range.
    #[error("{at}: `{key}` must be {expected}, not {found}")]
    OutOfRange {
        /// Where.
        at: Location,
        /// The key, with its table.
        key: String,
        /// The range.
        expected: String,
        /// The value.
        found: String,
    },
    /// Keys that exclude each other, or of which one is needed.
    #[error("{at}: {cause}")]
    Conflict {
        /// Where.
        at: Location,
        /// Which keys, and what to do.
        cause: String,
    },
    /// A name for two things.
    #[error("{at}: there are two {what} named `{name}`")]
    Duplicate {
        /// Where the second stands.
        at: Location,
        /// `meshes`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A name that stands for nothing.
    #[error("{at}: there is no {what} named `{name}`{help}")]
    UnknownName {
        /// Where.
        at: Location,
        /// `material`, `mesh`, `shipped shader`, `shape`.
        what: &'static str,
        /// The name.
        name: String,
        /// A better name, or the names known.
        help: String,
    },
    /// A mesh without a material, to be placed.
    #[error("{at}: `{mesh}` has no material\n  help: give the mesh or the instance a `material`")]
    NoMaterial {
        /// Where.
        at: Location,
        /// The mesh.
        mesh: String,
    },
    /// A camera that looks nowhere.
    #[error("{at}: the camera can't look: {cause}")]
    Camera {
        /// Where.
        at: Location,
        /// Why.
        cause: &'static str,
    },
    /// A transform that flattens space.
    #[error("{at}: the transform of `{object}` is singular: it flattens the object, and has no inverse")]
    Singular {
        /// Where.
        at: Location,
        /// The mesh or instance.
        object: String,
    },
    /// A mesh file of an unknown kind.
    #[error("{at}: `{}` is neither .ply nor .obj", path.display())]
    UnknownFormat {
        /// Where.
        at: Location,
        /// The file.
        path: PathBuf,
    },
    /// A mesh file that breaks its format.
    #[error("{at}: malformed {format}: {cause}")]
    Malformed {
        /// Where.
        at: MeshFile,
        /// `PLY`, `OBJ`, `MTL`.
        format: &'static str,
        /// What is wrong.
        cause: String,
    },
    /// A mesh file that ends too early.
    #[error("{at}: the file is truncated: {cause}")]
    Truncated {
        /// Where.
        at: MeshFile,
        /// What was expected.
        cause: String,
    },
    /// A vertex with a NaN or an infinity.
    #[error("{at}: vertex {vertex} is not finite: ({}, {}, {})", value[0], value[1], value[2])]
    NotFinite {
        /// Which mesh.
        at: MeshFile,
        /// Vertex, from 0.
        vertex: usize,
        /// Its position.
        value: [f32; 3],
    },
    /// A face with a vertex that isn't there.
    #[error("{at}: face {face} uses {what} {index}, but there are {count}, from {first}")]
    IndexOutOfRange {
        /// Which mesh.
        at: MeshFile,
        /// Face, from 0.
        face: usize,
        /// `vertex`, `normal`, `texture coordinate`.
        what: &'static str,
        /// The index as written.
        index: i64,
        /// How many there are.
        count: usize,
        /// The first index of the format.
        first: usize,
    },
    /// A mesh with nothing to see.
    #[error("{at}: the mesh has no triangles")]
    NoTriangles {
        /// Which mesh.
        at: MeshFile,
    },
    /// Lists per vertex of another length than the positions.
    #[error("{at}: {count} {what} for {vertices} vertices")]
    LengthMismatch {
        /// Which mesh.
        at: MeshFile,
        /// `normals` or `texture coordinates`.
        what: &'static str,
        /// How many.
        count: usize,
        /// Vertices.
        vertices: usize,
    },
    /// More vertices than 32 bits can number.
    #[error("{at}: {count} vertices or triangles are more than 2^32 - 1")]
    TooLarge {
        /// Which mesh.
        at: MeshFile,
        /// How many.
        count: usize,
    },
    /// A handle of a scene that a program built points nowhere.
    #[error("<scene>: {object} refers to {what} {index}, but there are {count}")]
    BadHandle {
        /// Who refers.
        object: String,
        /// `mesh` or `material`.
        what: &'static str,
        /// The index.
        index: u32,
        /// How many there are.
        count: usize,
    },
}

/// A help line for a name that is not among `known`: the closest one, or all.
pub(super) fn suggest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let closest = known.iter().map(|k| (distance(name, k), *k)).min();
    match closest {
        None => String::new(),
        Some((edits, best)) if edits <= 1 + name.len() / 4 => format!("\n  help: did you mean `{best}`?"),
        Some(_) => format!("\n  help: known here: {}", known.join(", ")),
    }
}

/// Levenshtein's distance: insertions, deletions and replacements from `a` to `b`, in characters, ignoring case.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
