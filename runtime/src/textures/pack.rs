//! Lays texture files out in one device buffer, as kernels/osl/texture_data.h reads it.
//!
//! In: the names that shaders can ask for. Out: words; the macros that say which kinds of samples are in use.

use super::{Entry, Library, Picture, Subimage, Texels, no_subimage, no_tile};
use oslcl_compiler::TextureUse;
use oslcl_compiler::strings::string_id;
use std::collections::{BTreeMap, HashMap};

/// Words of a subimage's descriptor, and of a level's (kernels/osl/texture_data.h).
const SUB_WORDS: usize = 12;
const LEVEL_WORDS: usize = 4;

/// Kinds of nodes.
const NONE: u32 = 0;
const FILE: u32 = 1;
const TILES: u32 = 2;

/// Textures that can't be packed.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum Error {
    /// More than 32-bit offsets reach.
    #[error(
        "the textures take {bytes} bytes, but at most 16 GiB can be used; the largest is `{file}` with {largest} bytes"
    )]
    TooLarge {
        /// All together.
        bytes: u64,
        /// The largest.
        file: String,
        /// Its size.
        largest: u64,
    },
    /// Two names have the same id.
    #[error("the texture names `{first}` and `{second}` have the same id on the device: rename one of them")]
    SameId {
        /// One.
        first: String,
        /// The other.
        second: String,
    },
}

/// Textures for a device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packed {
    /// The buffer.
    pub words: Vec<u32>,
    /// Strings that lookups can give back, to be known where ids are read.
    pub messages: Vec<String>,
    /// The largest file's name and bytes.
    pub largest: Option<(String, u64)>,
}

/// The macros of a program that looks textures up, as the plan's effects name them.
pub fn macros(uses: &[TextureUse]) -> Vec<String> {
    let has = |names: &[&str]| uses.iter().any(|u| u.interps.iter().any(|i| names.contains(i)));
    let all = [
        ("HAS_TEXTURES", !uses.is_empty()),
        ("HAS_TEXTURE_CUBIC", has(&["cubic", "smartcubic"])),
        ("HAS_TEXTURE_CLOSEST", has(&["closest"])),
    ];
    all.into_iter().filter(|(_, on)| *on).map(|(name, _)| name.to_owned()).collect()
}

/// Packs the named files, each once.
pub fn pack<'a>(library: &Library, names: impl IntoIterator<Item = &'a str>) -> Result<Packed, Error> {
    let mut by_id: BTreeMap<u32, &str> = BTreeMap::new();
    for name in names {
        if let Some(other) = by_id.insert(string_id(name), name).filter(|other| *other != name) {
            return Err(Error::SameId { first: other.to_owned(), second: name.to_owned() });
        }
    }
    let mut packer = Packer { library, out: Packed::default(), nodes: HashMap::new(), bytes: 0 };
    packer.out.words.push(by_id.len() as u32);
    let table = packer.out.words.len();
    packer.out.words.resize(table + 2 * by_id.len(), 0);
    for (i, (id, name)) in by_id.iter().enumerate() {
        let node = packer.node(name)?;
        packer.out.words[table + 2 * i] = *id;
        packer.out.words[table + 2 * i + 1] = node;
    }
    Ok(packer.out)
}

struct Packer<'a> {
    library: &'a Library,
    out: Packed,
    nodes: HashMap<String, u32>,
    bytes: u64,
}

impl Packer<'_> {
    fn message(&mut self, text: String) -> u32 {
        let id = string_id(&text);
        self.out.messages.push(text);
        id
    }

    /// The offset of a name's node.
    fn node(&mut self, name: &str) -> Result<u32, Error> {
        if let Some(node) = self.nodes.get(name) {
            return Ok(*node);
        }
        let node = match &*self.library.entry(name) {
            Entry::Missing(message) => {
                let id = self.message(message.clone());
                self.push(&[NONE, id])
            }
            Entry::File(picture) => self.file(name, picture)?,
            Entry::Tiles { columns, rows, files } => {
                let mut words = vec![TILES, *columns, *rows];
                for file in files {
                    let tile = match file {
                        Some(file) if self.library.complaint(file).is_none() => self.node(file)?,
                        _ => 0,
                    };
                    words.push(tile);
                }
                words.push(self.message(no_tile(name)));
                self.push(&words)
            }
        };
        self.nodes.insert(name.to_owned(), node);
        Ok(node)
    }

    /// Adds words; the offset of the first.
    fn push(&mut self, words: &[u32]) -> u32 {
        let at = self.out.words.len() as u32;
        self.out.words.extend_from_slice(words);
        at
    }

    fn file(&mut self, name: &str, picture: &Picture) -> Result<u32, Error> {
        let size: u64 = picture.subimages.iter().map(size_of_texels).sum();
        self.bytes += size;
        if self.out.largest.as_ref().is_none_or(|(_, largest)| size > *largest) {
            self.out.largest = Some((name.to_owned(), size));
        }
        // Before anything is copied. Descriptors are small: a part of 1 GiB is kept for them.
        if self.bytes > 15 << 30 {
            let (file, largest) = self.out.largest.clone().unwrap_or_default();
            return Err(Error::TooLarge { bytes: self.bytes, file, largest });
        }
        let mut words = vec![FILE, picture.subimages.len() as u32];
        for sub in &picture.subimages {
            let offset = self.subimage(sub);
            words.push(offset);
        }
        words.push(self.message(no_subimage("", name)));
        Ok(self.push(&words))
    }

    fn subimage(&mut self, sub: &Subimage) -> u32 {
        let [sscale, soffset, tscale, toffset] = sub.placement().map(f32::to_bits);
        let [swrap, twrap] = sub.wraps();
        let format = match &sub.levels[0].texels {
            Texels::U8(_) => 0,
            Texels::U16(_) => 1,
            Texels::F16(_) => 2,
            Texels::F32(_) => 3,
        };
        let flags = u32::from(sub.y_is_up()) | u32::from(sub.has_border()) << 1;
        let full = sub.full[2].max(sub.full[3]).max(1) as u32;
        let head: [u32; SUB_WORDS] = [
            string_id(&sub.name),
            sub.channels as u32,
            format,
            swrap,
            twrap,
            flags,
            sub.levels.len() as u32,
            sscale,
            soffset,
            tscale,
            toffset,
            full,
        ];
        let at = self.push(&head);
        let table = self.out.words.len();
        self.out.words.resize(table + LEVEL_WORDS * sub.levels.len(), 0);
        for (i, level) in sub.levels.iter().enumerate() {
            let texels = self.out.words.len() as u32;
            self.texels(&level.texels);
            let poles = if sub.is_one_tile(i) { self.poles(sub, i) } else { 0 };
            self.out.words[table + LEVEL_WORDS * i..][..LEVEL_WORDS].copy_from_slice(&[
                level.width,
                level.height,
                texels,
                poles,
            ]);
        }
        at
    }

    fn poles(&mut self, sub: &Subimage, level: usize) -> u32 {
        let last = sub.levels[level].height - 1;
        let colors: Vec<u32> =
            [0, last].iter().flat_map(|row| sub.row_mean(level, *row)).map(|x| (x as f32).to_bits()).collect();
        self.push(&colors)
    }

    /// Words of texels, little end first within a word, as the kernels' narrower pointers read them on all devices there are.
    fn texels(&mut self, texels: &Texels) {
        let words = &mut self.out.words;
        match texels {
            Texels::U8(v) => words.extend(v.chunks(4).map(|c| {
                let mut bytes = [0; 4];
                bytes[..c.len()].copy_from_slice(c);
                u32::from_le_bytes(bytes)
            })),
            Texels::U16(v) => words.extend(v.chunks(2).map(|c| pair(c[0], c.get(1).copied().unwrap_or(0)))),
            Texels::F16(v) => {
                words.extend(v.chunks(2).map(|c| pair(c[0].to_bits(), c.get(1).map_or(0, |x| x.to_bits()))))
            }
            Texels::F32(v) => words.extend(v.iter().map(|x| x.to_bits())),
        }
    }
}

fn pair(low: u16, high: u16) -> u32 {
    u32::from(low) | u32::from(high) << 16
}

fn size_of_texels(sub: &Subimage) -> u64 {
    sub.levels.iter().map(|l| l.texels.count() as u64 * l.texels.width() as u64).sum()
}
