//! A texture file in memory: subimages, their levels of detail, and what the file says about itself.
//!
//! In: the readers of this folder fill it. Out: texels as numbers. It must not know file formats.

use exr::prelude::f16;
use oslcl_compiler::textures::Info;

/// Texels in the format that the file has; wider ones are floats.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 0 to 255 as 0 to 1.
    U8(Vec<u8>),
    /// 0 to 65535 as 0 to 1.
    U16(Vec<u16>),
    /// 16-bit floats.
    F16(Vec<f16>),
    /// 32-bit floats.
    F32(Vec<f32>),
}

impl Texels {
    /// How many numbers there are.
    pub fn count(&self) -> usize {
        match self {
            Texels::U8(v) => v.len(),
            Texels::U16(v) => v.len(),
            Texels::F16(v) => v.len(),
            Texels::F32(v) => v.len(),
        }
    }

    /// One number; 0 where there is none.
    pub fn get(&self, i: usize) -> f64 {
        match self {
            Texels::U8(v) => v.get(i).map_or(0.0, |x| f64::from(*x) / 255.0),
            Texels::U16(v) => v.get(i).map_or(0.0, |x| f64::from(*x) / 65535.0),
            Texels::F16(v) => v.get(i).map_or(0.0, |x| f64::from(x.to_f32())),
            Texels::F32(v) => v.get(i).map_or(0.0, |x| f64::from(*x)),
        }
    }

    /// Bytes of a number.
    pub fn width(&self) -> usize {
        match self {
            Texels::U8(_) => 1,
            Texels::U16(_) | Texels::F16(_) => 2,
            Texels::F32(_) => 4,
        }
    }

    /// Numbers in this format.
    pub fn like(&self, numbers: impl Iterator<Item = f64>) -> Texels {
        let whole = |x: f64, most: f64| (x.clamp(0.0, 1.0) * most).round();
        match self {
            Texels::U8(_) => Texels::U8(numbers.map(|x| whole(x, 255.0) as u8).collect()),
            Texels::U16(_) => Texels::U16(numbers.map(|x| whole(x, 65535.0) as u16).collect()),
            Texels::F16(_) => Texels::F16(numbers.map(f16::from_f64).collect()),
            Texels::F32(_) => Texels::F32(numbers.map(|x| x as f32).collect()),
        }
    }
}

/// A level of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// Row by row from the top left, the channels of a texel together.
    pub texels: Texels,
}

/// Side of the tiles that files without tiles count as having: what OSL's reference implementation sets.
const AUTOTILE: u32 = 64;

/// A part of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Subimage {
    /// Its name, or "".
    pub name: String,
    /// Numbers per texel, at least 1.
    pub channels: usize,
    /// Which of them is alpha.
    pub alpha: Option<usize>,
    /// Where the texels lie in the full picture: column and row of the first.
    pub origin: [i32; 2],
    /// The full picture: first column and row, columns, rows (at least 1).
    pub full: [i32; 4],
    /// Levels of detail, the finest first; at least one, each half of the one before.
    pub levels: Vec<Level>,
    /// Texels across and down of a tile; `None`: the file has rows. Those count as tiles of `AUTOTILE`, as in the reference.
    pub tile: Option<[u32; 2]>,
    /// What else the file says, by name.
    pub facts: Vec<(String, Info)>,
    /// Levels behind the first are ours, not the file's.
    pub completed: bool,
}

/// A file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// `tiff`, `openexr`, `png` ...
    pub format: &'static str,
    /// At least one.
    pub subimages: Vec<Subimage>,
}

impl Subimage {
    /// A picture without a past: one level, its own full picture.
    pub fn new(channels: usize, alpha: Option<usize>, level: Level) -> Subimage {
        let full = [0, 0, level.width as i32, level.height as i32];
        Subimage {
            name: String::new(),
            channels,
            alpha,
            origin: [0, 0],
            full,
            levels: vec![level],
            tile: None,
            facts: Vec::new(),
            completed: false,
        }
    }

    /// What the file says under a name.
    pub fn fact(&self, name: &str) -> Option<&Info> {
        self.facts.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, info)| info)
    }

    /// As [`Subimage::fact`], if it is a text.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.fact(name) {
            Some(Info::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// Whether it is made for `environment()`.
    pub fn is_environment(&self) -> bool {
        self.text("textureformat") == Some("LatLong Environment")
    }

    /// Whether y is up in an environment, as it is where the file says nothing else.
    pub fn y_is_up(&self) -> bool {
        !self.is_environment() || self.text("oiio:updirection") != Some("z")
    }

    /// Whether the outermost texels lie on the border itself.
    pub fn has_border(&self) -> bool {
        self.is_environment() && matches!(self.fact("oiio:sampleborder"), Some(Info::Ints(v)) if v.first() != Some(&0))
    }

    /// The file's wrap modes, as places in [`oslcl_compiler::textures::WRAPS`]; black where it says nothing.
    pub fn wraps(&self) -> [u32; 2] {
        let text = self.text("wrapmodes").unwrap_or("black");
        let (s, t) = text.split_once(',').unwrap_or((text, text));
        [s, t].map(|name| {
            let known = &oslcl_compiler::textures::WRAPS;
            // What no file can mean is black.
            known.iter().position(|k| *k == name.trim()).filter(|code| *code > 0).unwrap_or(1) as u32
        })
    }

    /// From coordinates of the full picture to those of the texels: factors and offsets along s and t.
    pub fn placement(&self) -> [f32; 4] {
        let size = [self.levels[0].width as f32, self.levels[0].height as f32];
        let [x, y, width, height] = self.full;
        [
            width as f32 / size[0],
            (x - self.origin[0]) as f32 / size[0],
            height as f32 / size[1],
            (y - self.origin[1]) as f32 / size[1],
        ]
    }

    /// Whether a level is one tile, so that environments fade to one colour at its poles.
    pub fn is_one_tile(&self, level: usize) -> bool {
        let l = &self.levels[level];
        let [w, h] = self.tile.unwrap_or([AUTOTILE; 2]);
        l.width <= w && l.height <= h
    }

    /// Mean of a row of a level, as a 32-bit float.
    pub fn row_mean(&self, level: usize, row: u32) -> Vec<f64> {
        let l = &self.levels[level];
        let start = row as usize * l.width as usize * self.channels;
        let mean = |c: usize| {
            let numbers = (0..l.width as usize).map(|i| l.texels.get(start + i * self.channels + c));
            f64::from((numbers.sum::<f64>() / f64::from(l.width)) as f32)
        };
        (0..self.channels).map(mean).collect()
    }

    /// The mean colour that the file tells, or its level of one texel; `None` when it has neither.
    pub fn average(&self) -> Option<Vec<f64>> {
        if let Some(Info::Floats(v)) = self.fact("oiio:AverageColor")
            && v.len() >= self.channels
        {
            return Some(v[..self.channels].to_vec());
        }
        let last = self.levels.last()?;
        if self.completed && self.origin != [0, 0] {
            // The reference looks for the one texel where the part of the picture begins, and finds black.
            return Some(vec![0.0; self.channels]);
        }
        (last.width == 1 && last.height == 1).then(|| (0..self.channels).map(|c| last.texels.get(c)).collect())
    }

    /// The colour of all texels, if the file tells that they have one.
    pub fn constant(&self) -> Option<Vec<f64>> {
        match self.fact("oiio:ConstantColor") {
            Some(Info::Floats(v)) if v.len() >= self.channels => Some(v[..self.channels].to_vec()),
            _ => None,
        }
    }
}
