//! Texture files: found, read once, looked up on the host, packed for devices.
//!
//! In: names as shaders write them, folders to search. Out: answers for the compiler ([`Textures`]), one device buffer
//! ([`Packed`]), words about what is missing. It must not know scenes, plans or devices.

mod info;
mod mip;
mod pack;
mod picture;
mod read;
mod read_exr;
mod read_tiff;
mod sample;
mod udim;

pub use pack::{Error, Packed, macros, pack};
pub use picture::{Level, Picture, Subimage, Texels};
pub use read::read;

use crate::points;
use oslcl_compiler::points::PointClouds;
use oslcl_compiler::textures::{Info, InfoType, Lookup, Texel, TextureAccess, Textures};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// How files are found and read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Folders that relative names are looked for in, in order; then they are taken as they are.
    pub search: Vec<PathBuf>,
    /// Make the levels of detail that files lack, as the reference's tools do (`automip`).
    pub automip: bool,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { search: Vec::new(), automip: true }
    }
}

/// What a name stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A file.
    File(Picture),
    /// Nothing that can be read; why.
    Missing(String),
    /// A set of tiles (UDIM).
    Tiles {
        /// Tiles across, at least 1.
        columns: u32,
        /// Tiles down, at least 1.
        rows: u32,
        /// The names of their files, row by row; `None` where there is none.
        files: Vec<Option<String>>,
    },
}

/// Texture files by name, each read once.
#[derive(Debug, Default)]
pub struct Library {
    settings: Settings,
    entries: Mutex<HashMap<String, Arc<Entry>>>,
    points: points::Library,
}

impl Library {
    /// An empty library.
    pub fn new(settings: Settings) -> Library {
        let points = points::Library::new(settings.search.clone());
        Library { settings, entries: Mutex::default(), points }
    }

    /// The point clouds in the same folders.
    pub fn points(&self) -> &points::Library {
        &self.points
    }

    /// For [`oslcl_compiler::Options::textures`].
    pub fn access(self: &Arc<Library>) -> TextureAccess {
        TextureAccess(self.clone())
    }

    /// What a name stands for; read when it is first asked for.
    pub fn entry(&self, name: &str) -> Arc<Entry> {
        let known =
            |library: &Library| library.entries.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned();
        if let Some(entry) = known(self) {
            return entry;
        }
        // Outside of the lock: two threads may read the same file, which costs time only.
        let entry = Arc::new(self.load(name));
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.entry(name.to_owned()).or_insert(entry).clone()
    }

    fn load(&self, name: &str) -> Entry {
        let _span = tracing::debug_span!("texture", name).entered();
        if let Some(entry) = udim::find(name, &self.settings.search) {
            return entry;
        }
        let Some(path) = self.find(name) else { return Entry::Missing(not_found(name)) };
        match read::read(&path) {
            Ok(mut picture) => {
                if self.settings.automip {
                    picture.subimages.iter_mut().filter(|s| s.levels.len() == 1).for_each(mip::complete);
                }
                Entry::File(picture)
            }
            Err(cause) => Entry::Missing(format!("Could not open file: {name}: {cause}")),
        }
    }

    fn find(&self, name: &str) -> Option<PathBuf> {
        if name.is_empty() {
            return None;
        }
        let path = Path::new(name);
        let folders = self.settings.search.iter().map(|folder| folder.join(path));
        folders.chain([path.to_path_buf()]).find(|p| p.is_file())
    }

    /// The picture behind a name, or behind the tile that coordinates lie in, which become those of the tile.
    fn picture_at(&self, name: &str, st: &mut [f64; 2]) -> Result<Arc<Entry>, String> {
        let entry = self.entry(name);
        match &*entry {
            Entry::File(_) => Ok(entry),
            Entry::Missing(message) => Err(message.clone()),
            Entry::Tiles { columns, rows, files } => {
                let place = st.map(|c| c.max(0.0) as u32);
                *st = st.map(|c| c - c.floor());
                let [u, v] = place;
                let file = if u < *columns && v < *rows { files[(v * columns + u) as usize].as_ref() } else { None };
                match file.map(|f| self.entry(f)) {
                    Some(tile) if matches!(&*tile, Entry::File(_)) => Ok(tile),
                    _ => Err(no_tile(name)),
                }
            }
        }
    }

    /// Words about a name that stands for nothing that can be read; `None` when all is well.
    pub fn complaint(&self, name: &str) -> Option<String> {
        match &*self.entry(name) {
            Entry::File(_) => None,
            Entry::Missing(message) => Some(message.clone()),
            Entry::Tiles { files, .. } => files.iter().flatten().find_map(|f| self.complaint(f)),
        }
    }
}

/// The message of a name that no file has, in the words that the reference's users know.
fn not_found(name: &str) -> String {
    const ENDINGS: [&str; 13] =
        ["tx", "tif", "tiff", "exr", "env", "png", "jpg", "jpeg", "hdr", "tga", "bmp", "rgbe", "tpic"];
    let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if ENDINGS.contains(&ending.as_str()) {
        format!("Could not open file: {name}: No such file or directory")
    } else {
        format!(
            "Image \"{name}\" does not exist. Also, it is not the name of an image format that OpenImageIO recognizes."
        )
    }
}

fn no_tile(name: &str) -> String {
    format!("\"{name}\" has no tile there")
}

/// The message for a part that a file does not have.
fn no_subimage(part: &str, name: &str) -> String {
    format!("Unknown subimage \"{part}\" in texture \"{name}\"")
}

/// The part of a picture that a lookup asks for.
fn part<'a>(picture: &'a Picture, number: i32, name: &str) -> Option<&'a Subimage> {
    if name.is_empty() {
        return picture.subimages.get(usize::try_from(number).ok()?);
    }
    picture.subimages.iter().find(|s| s.name == name)
}

impl Textures for Library {
    fn clouds(&self) -> Option<&dyn PointClouds> {
        Some(&self.points)
    }

    fn tiles(&self, file: &str) -> Option<(u32, u32)> {
        match &*self.entry(file) {
            Entry::Tiles { columns, rows, .. } => Some((*columns, *rows)),
            _ => None,
        }
    }

    fn info(&self, file: &str, tile: Option<(u32, u32)>, name: &str, ty: InfoType, count: usize) -> Option<Info> {
        info::info(self, file, tile, name, ty, count)
    }

    fn lookup(&self, lookup: &Lookup<'_>) -> Texel {
        sample::lookup(self, lookup)
    }

    fn error(&self, file: &str, mut st: [f64; 2], subimage: i32, subimage_name: &str) -> String {
        match self.picture_at(file, &mut st) {
            Err(message) => message,
            Ok(entry) => match &*entry {
                Entry::File(picture) if part(picture, subimage, subimage_name).is_none() => no_subimage("", file),
                _ => String::new(),
            },
        }
    }
}
