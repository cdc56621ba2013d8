//! Point clouds: found, read once, searched on the host, packed for devices.
//!
//! In: names as shaders write them, folders to search. Out: answers for the interpreter ([`PointClouds`]), one device buffer
//! ([`Packed`]), words about what is missing. It must not know scenes, plans or devices.

mod grid;
mod pack;
mod read;
mod write;

pub use grid::Grid;
pub use pack::{Error, Packed, pack};
pub use read::read;
pub use write::{Error as WriteError, write};

use oslcl_compiler::points::{PointClouds, Values};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The numbers of an attribute, those of a point together.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Whole numbers, so many a point.
    Ints(usize, Vec<i32>),
    /// Numbers, so many a point.
    Floats(usize, Vec<f32>),
    /// Triples.
    Triples(Vec<[f32; 3]>),
    /// Strings.
    Texts(Vec<String>),
}

/// A named attribute of all points.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Its name.
    pub name: String,
    /// Its values.
    pub data: Data,
}

/// A point cloud.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// Where the points are, all finite.
    pub positions: Vec<[f32; 3]>,
    /// What else is known of them.
    pub attributes: Vec<Attribute>,
    /// For searches.
    pub grid: Grid,
}

impl Cloud {
    /// A cloud of these points.
    pub fn new(positions: Vec<[f32; 3]>, attributes: Vec<Attribute>) -> Cloud {
        Cloud { grid: Grid::new(&positions), positions, attributes }
    }

    fn values(&self, point: i32, attribute: &str) -> Option<Values> {
        let i = usize::try_from(point).ok().filter(|i| *i < self.positions.len())?;
        let wide = |t: [f32; 3]| Values::Triple(t.map(f64::from));
        let Some(found) = self.attributes.iter().find(|a| a.name == attribute) else {
            return (attribute == "position").then(|| wide(self.positions[i]));
        };
        Some(match &found.data {
            Data::Ints(n, all) => Values::Ints(all[n * i..n * (i + 1)].to_vec()),
            Data::Floats(n, all) => Values::Floats(all[n * i..n * (i + 1)].iter().map(|x| f64::from(*x)).collect()),
            Data::Triples(all) => wide(all[i]),
            Data::Texts(all) => Values::Text(all[i].clone()),
        })
    }
}

/// Point clouds by name, each read once.
#[derive(Debug, Default)]
pub struct Library {
    search: Vec<PathBuf>,
    clouds: Mutex<HashMap<String, Arc<Result<Cloud, String>>>>,
}

impl Library {
    /// An empty library. `search`: folders that relative names are looked for in, in order; then they are taken as they are.
    pub fn new(search: Vec<PathBuf>) -> Library {
        Library { search, clouds: Mutex::default() }
    }

    /// What a name stands for, read when it is first asked for; or why it can't be.
    pub fn cloud(&self, name: &str) -> Arc<Result<Cloud, String>> {
        let mut clouds = self.clouds.lock().unwrap_or_else(PoisonError::into_inner);
        let load = || Arc::new(self.load(name));
        clouds.entry(name.to_owned()).or_insert_with(load).clone()
    }

    fn load(&self, name: &str) -> Result<Cloud, String> {
        let _span = tracing::debug_span!("point cloud", name).entered();
        let path = Path::new(name);
        let folders = self.search.iter().map(|folder| folder.join(path));
        let found = folders.chain([path.to_path_buf()]).find(|p| p.is_file());
        let found = found.ok_or_else(|| "there is no such file".to_owned())?;
        read(&found)
    }

    /// What is wrong with clouds that a shader of this name asks for.
    pub fn complaints<'a>(&'a self, names: &'a [String], shader: &'a str) -> impl Iterator<Item = String> + 'a {
        names.iter().filter_map(move |name| match &*self.cloud(name) {
            Err(cause) => Some(format!("point cloud `{name}` of shader `{shader}` counts as empty: {cause}")),
            Ok(_) => None,
        })
    }
}

impl PointClouds for Library {
    fn search(&self, file: &str, center: [f64; 3], radius: f64, most: usize) -> Vec<(i32, f64)> {
        match &*self.cloud(file) {
            Ok(cloud) if !file.is_empty() => cloud.grid.nearest(&cloud.positions, center, radius, most),
            _ => Vec::new(),
        }
    }

    fn get(&self, file: &str, point: i32, attribute: &str) -> Option<Values> {
        self.cloud(file).as_ref().as_ref().ok()?.values(point, attribute)
    }
}
