//! What the compiler and the interpreter ask about texture files. The crate does no IO, so a trait answers.
//!
//! In: names of files as shaders write them. Out: facts for `gettextureinfo`, and filtered lookups. Whoever implements
//! [`Textures`] finds and reads the files.

use std::fmt;
use std::sync::Arc;

/// Wrap modes by name; their place is their code in [`Lookup::wraps`] and in the kernels.
pub const WRAPS: [&str; 7] =
    ["default", "black", "clamp", "periodic", "mirror", "periodic_pow2", "periodic_sharedborder"];

/// Interpolations by name; their place is their code in [`Lookup::interp`] and in the kernels.
pub const INTERPS: [&str; 4] = ["smartcubic", "cubic", "linear", "closest"];

/// Bits of a lookup's mode: 3 for each wrap (s, t, r), 2 for the interpolation, 1 for whether a colour stands in for a
/// missing file, 1 for whether the shader asks for the message.
pub const MODE_T: i32 = 1 << 3;
/// As [`MODE_T`], of the third axis.
pub const MODE_R: i32 = 1 << 6;
/// As [`MODE_T`], of the interpolation.
pub const MODE_INTERP: i32 = 1 << 9;
/// As [`MODE_T`], of the colour for a missing file.
pub const MODE_MISSING: i32 = 1 << 11;
/// Set where the shader asks for the message of a missing file, so that nobody else needs to say it.
pub const MODE_QUIET: i32 = 1 << 12;

/// How a file is looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// `texture()`.
    Texture,
    /// `texture3d()`.
    Volume,
    /// `environment()`.
    Environment,
}

/// One lookup. What an option means is OSL's specification ch. 7, "Texture".
#[derive(Clone, Debug, PartialEq)]
pub struct Lookup<'a> {
    /// How.
    pub kind: Kind,
    /// The file's name as the shader has it.
    pub file: &'a str,
    /// s, t, or a position, or a direction.
    pub at: [f64; 3],
    /// Its change from one pixel to the next.
    pub dx: [f64; 3],
    /// Its change from one line of pixels to the next.
    pub dy: [f64; 3],
    /// Of s, t, r: places in [`WRAPS`].
    pub wraps: [i32; 3],
    /// Place in [`INTERPS`].
    pub interp: i32,
    /// The channel that the result starts with.
    pub first_channel: i32,
    /// Channels of the result, 1 or 3.
    pub channels: u32,
    /// The part of the file, when `subimage_name` is empty.
    pub subimage: i32,
    /// The part of the file.
    pub subimage_name: &'a str,
    /// Factors of the filter's size along s and t.
    pub width: [f64; 2],
    /// Sizes added to the filter's, along s and t.
    pub blur: [f64; 2],
    /// Stands for channels that the file lacks.
    pub fill: f64,
    /// Stands for a file that is missing.
    pub missing: Option<[f64; 3]>,
}

/// What a lookup finds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// The channels.
    pub value: [f64; 3],
    /// Their derivatives by s, t and r; zero for environments.
    pub by: [[f64; 3]; 3],
}

/// The type that an answer of `gettextureinfo` must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum InfoType {
    /// int
    Int,
    /// float, triples, matrices
    Float,
    /// string
    Text,
}

/// An answer of `gettextureinfo`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Info {
    /// Whole numbers.
    Ints(Vec<i32>),
    /// Numbers.
    Floats(Vec<f64>),
    /// One string.
    Text(String),
}

/// Answers questions about texture files.
pub trait Textures: Send + Sync {
    /// Columns and rows of tiles, when the name stands for a set of them (UDIM).
    fn tiles(&self, file: &str) -> Option<(u32, u32)>;
    /// A fact about a file, or about one tile (column, row) of a set, with this type and number of values; `None` when it is
    /// not known.
    fn info(&self, file: &str, tile: Option<(u32, u32)>, name: &str, ty: InfoType, count: usize) -> Option<Info>;
    /// A filtered lookup, in f64.
    fn lookup(&self, lookup: &Lookup<'_>) -> Texel;
    /// The message for a lookup that finds no such file or part; `""` when it does.
    fn error(&self, file: &str, st: [f64; 2], subimage: i32, subimage_name: &str) -> String;
    /// Who knows point clouds, which are files of the same kind of folders.
    fn clouds(&self) -> Option<&dyn crate::points::PointClouds> {
        None
    }
}

/// Shared [`Textures`], to be put into options.
#[derive(Clone)]
pub struct TextureAccess(pub Arc<dyn Textures>);

impl fmt::Debug for TextureAccess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TextureAccess")
    }
}

impl PartialEq for TextureAccess {
    fn eq(&self, other: &TextureAccess) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
