//! Point clouds in one buffer of 32-bit words, as kernels/osl/points.h reads them.
//!
//! In: a library, names. Out: words, and the strings among the attributes.

use super::{Cloud, Data, Library};
use oslcl_compiler::strings::string_id;

/// Words for the device.
#[derive(Debug, Default)]
pub struct Packed {
    /// The buffer.
    pub words: Vec<u32>,
    /// Strings that shaders may print.
    pub strings: Vec<String>,
}

/// What can't be packed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Offsets have 32 bits.
    #[error("point cloud `{name}`: with it, the point clouds have more than 2^32 numbers")]
    TooLarge {
        /// The cloud that is too much.
        name: String,
    },
}

/// Packs the clouds of these names, each once; those that can't be read are left out.
pub fn pack<'a>(library: &Library, names: impl IntoIterator<Item = &'a str>) -> Result<Packed, Error> {
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_unstable();
    names.dedup();
    let clouds: Vec<_> = names.iter().map(|name| (*name, library.cloud(name))).collect();
    let there: Vec<(&str, &Cloud)> =
        clouds.iter().filter_map(|(name, cloud)| Some((*name, (**cloud).as_ref().ok()?))).collect();
    let mut packed = Packed { words: vec![there.len() as u32], strings: Vec::new() };
    packed.words.resize(1 + 2 * there.len(), 0);
    for (i, (name, cloud)) in there.into_iter().enumerate() {
        let at = packed.words.len();
        packed.words[1 + 2 * i] = string_id(name);
        packed.words[2 + 2 * i] = at as u32;
        packed.add(cloud);
        if packed.words.len() as u64 > u64::from(u32::MAX) {
            return Err(Error::TooLarge { name: name.to_owned() });
        }
    }
    Ok(packed)
}

impl Packed {
    /// Words CLOUD_*, four words per attribute, then all numbers.
    fn add(&mut self, cloud: &Cloud) {
        let at = self.words.len();
        let grid = &cloud.grid;
        let has_position = cloud.attributes.iter().any(|a| a.name == "position");
        let attributes = cloud.attributes.len() + usize::from(!has_position);
        let head = 12 + 4 * attributes;
        let starts = at + head;
        let points = starts + grid.starts.len();
        let positions = points + grid.points.len();
        self.words.push(cloud.positions.len() as u32);
        self.words.extend(grid.cells);
        self.words.extend(grid.origin.map(f32::to_bits));
        self.words.extend([grid.scale.to_bits(), starts as u32, points as u32, positions as u32, attributes as u32]);
        let first = self.words.len();
        self.words.resize(at + head, 0);
        self.words.extend(&grid.starts);
        self.words.extend(&grid.points);
        self.words.extend(cloud.positions.iter().flatten().map(|x| x.to_bits()));
        let mut rows = Vec::with_capacity(attributes);
        for attribute in &cloud.attributes {
            let offset = self.words.len() as u32;
            let (ty, count) = match &attribute.data {
                Data::Ints(n, all) => {
                    self.words.extend(all.iter().map(|i| *i as u32));
                    (0, *n)
                }
                Data::Floats(n, all) => {
                    self.words.extend(all.iter().map(|x| x.to_bits()));
                    (1, *n)
                }
                Data::Triples(all) => {
                    self.words.extend(all.iter().flatten().map(|x| x.to_bits()));
                    (2, 3)
                }
                Data::Texts(all) => {
                    self.words.extend(all.iter().map(|s| string_id(s)));
                    self.strings.extend(all.iter().cloned());
                    (3, 1)
                }
            };
            rows.push([string_id(&attribute.name), ty, count as u32, offset]);
        }
        if !has_position {
            rows.push([string_id("position"), 2, 3, positions as u32]);
        }
        self.words[first..at + head].copy_from_slice(rows.as_flattened());
        self.strings.sort_unstable();
        self.strings.dedup();
    }
}
