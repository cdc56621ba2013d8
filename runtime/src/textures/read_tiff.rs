//! Reads TIFF files, tiled ones with levels of detail (as `maketx` writes them) among them.
//!
//! In: bytes. Out: a [`Picture`]. A directory of reduced resolution, or of half the size of the one before it in a file that
//! says it is a texture, is a level of that one; any other is a subimage.

use super::picture::{Level, Picture, Subimage, Texels};
use super::read::{MAX_BYTES, associate};
use oslcl_compiler::textures::Info;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// Most directories that are looked at.
const MAX_DIRECTORIES: usize = 4096;

/// Pixar's texture tags, and PhotoShop's kin that TIFF readers know by number.
const FULL_WIDTH: u16 = 33300;
const FULL_HEIGHT: u16 = 33301;
const TEXTURE_FORMAT: u16 = 33302;
const WRAP_MODES: u16 = 33303;
const FOV_COT: u16 = 33304;
const WORLD_TO_SCREEN: u16 = 33305;
const WORLD_TO_CAMERA: u16 = 33306;

/// Texts that are facts, by tag.
const TEXTS: [(u16, &str); 10] = [
    (269, "DocumentName"),
    (270, "ImageDescription"),
    (271, "Make"),
    (272, "Model"),
    (305, "Software"),
    (306, "DateTime"),
    (315, "Artist"),
    (316, "HostComputer"),
    (33432, "Copyright"),
    (285, "PageName"),
];

type Reader = Decoder<Cursor<Vec<u8>>>;

/// Decodes a file.
pub fn decode(bytes: Vec<u8>) -> Result<Picture, String> {
    let wrong = |cause: tiff::TiffError| cause.to_string();
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES;
    limits.intermediate_buffer_size = MAX_BYTES;
    limits.ifd_value_size = 64 << 20;
    let mut reader = Decoder::new(Cursor::new(bytes)).map_err(wrong)?.with_limits(limits);
    let mut subimages: Vec<Subimage> = Vec::new();
    for _ in 0..MAX_DIRECTORIES {
        let reduced = number(&mut reader, 254).is_some_and(|bits| bits & 1 != 0);
        let sub = subimage(&mut reader)?;
        match subimages.last_mut() {
            Some(last) if is_level_of(last, &sub, reduced) => last.levels.extend(sub.levels),
            _ => subimages.push(sub),
        }
        if !reader.more_images() {
            return Ok(Picture { format: "tiff", subimages });
        }
        reader.next_image().map_err(wrong)?;
    }
    Err(format!("it has more than {MAX_DIRECTORIES} parts"))
}

fn is_level_of(last: &Subimage, next: &Subimage, reduced: bool) -> bool {
    let (Some(fine), Some(coarse)) = (last.levels.last(), next.levels.first()) else { return false };
    let half = |a: u32, b: u32| b == (a / 2).max(1) || b == a.div_ceil(2);
    let smaller = half(fine.width, coarse.width) && half(fine.height, coarse.height);
    let same = last.channels == next.channels
        && std::mem::discriminant(&fine.texels) == std::mem::discriminant(&coarse.texels);
    same && smaller && (reduced || last.fact("textureformat").is_some())
}

fn number(reader: &mut Reader, tag: u16) -> Option<u32> {
    reader.find_tag_unsigned::<u32>(Tag::from_u16_exhaustive(tag)).ok().flatten()
}

fn text(reader: &mut Reader, tag: u16) -> Option<String> {
    let text = reader.get_tag_ascii_string(Tag::from_u16_exhaustive(tag)).ok()?;
    Some(text.trim_end_matches('\0').to_owned()).filter(|t| !t.is_empty())
}

fn float(reader: &mut Reader, tag: Tag) -> Option<f64> {
    reader.find_tag(tag).ok().flatten().and_then(|v| match v {
        tiff::decoder::ifd::Value::Rational(a, b) if b != 0 => Some(f64::from(a) / f64::from(b)),
        other => other.into_f64().ok(),
    })
}

fn parts<T: Into<f64>>(values: Vec<T>, largest: f64) -> Vec<f32> {
    values.into_iter().map(|v| (v.into() / largest).max(-1.0) as f32).collect()
}

fn subimage(reader: &mut Reader) -> Result<Subimage, String> {
    let wrong = |cause: tiff::TiffError| cause.to_string();
    let (width, height) = reader.dimensions().map_err(wrong)?;
    let channels = number(reader, 277).unwrap_or(1) as usize;
    let texels = match reader.read_image().map_err(wrong)? {
        DecodingResult::U8(v) => Texels::U8(v),
        DecodingResult::U16(v) => Texels::U16(v),
        DecodingResult::F16(v) => Texels::F16(v),
        DecodingResult::F32(v) => Texels::F32(v),
        DecodingResult::F64(v) => Texels::F32(v.into_iter().map(|x| x as f32).collect()),
        DecodingResult::U32(v) => {
            Texels::F32(v.into_iter().map(|x| (f64::from(x) / f64::from(u32::MAX)) as f32).collect())
        }
        // Signed integers are parts of the largest one.
        DecodingResult::I8(v) => Texels::F32(parts(v, f64::from(i8::MAX))),
        DecodingResult::I16(v) => Texels::F32(parts(v, f64::from(i16::MAX))),
        DecodingResult::I32(v) => Texels::F32(parts(v, f64::from(i32::MAX))),
        _ => return Err("its pixels are neither integers of 32 bits nor floats".to_owned()),
    };
    let wanted = (width as usize).checked_mul(height as usize).and_then(|n| n.checked_mul(channels));
    if channels == 0 || width == 0 || height == 0 || wanted != Some(texels.count()) {
        return Err(format!("it has {} numbers for {width} x {height} pixels of {channels}", texels.count()));
    }
    let extra = reader.find_tag_unsigned_vec::<u32>(Tag::ExtraSamples).ok().flatten().unwrap_or_default();
    let place = |kind: u32| extra.iter().position(|e| *e == kind).map(|i| channels - extra.len().min(channels) + i);
    let separate = place(2);
    // A fourth channel that the file says nothing of is taken as alpha, as the usual readers do.
    let alpha = place(1).or(separate).or((channels == 4 && extra.is_empty()).then_some(3)).filter(|a| *a < channels);
    let mut sub = Subimage::new(channels, alpha, Level { width, height, texels });
    if let (Some(alpha), true) = (separate.filter(|a| *a < channels), separate == alpha) {
        associate(&mut sub.levels[0].texels, channels, alpha);
    }
    if let (Some(w), Some(h)) = (number(reader, 322), number(reader, 323)) {
        sub.tile = Some([w, h]);
    }
    place_of(reader, &mut sub);
    sub.facts = facts(reader);
    Ok(sub)
}

/// Where the texels lie in the full picture.
fn place_of(reader: &mut Reader, sub: &mut Subimage) {
    let position = |reader: &mut Reader, tag: u16, resolution: Tag| {
        let at = float(reader, Tag::from_u16_exhaustive(tag))?;
        let per_unit = float(reader, resolution).unwrap_or(1.0);
        Some((at * per_unit).round() as i32)
    };
    sub.origin =
        [position(reader, 286, Tag::XResolution).unwrap_or(0), position(reader, 287, Tag::YResolution).unwrap_or(0)];
    let side = |reader: &mut Reader, tag: u16| number(reader, tag).filter(|n| *n > 0 && *n < 1 << 24);
    if let (Some(width), Some(height)) = (side(reader, FULL_WIDTH), side(reader, FULL_HEIGHT)) {
        sub.full = [0, 0, width as i32, height as i32];
    } else {
        sub.full[..2].copy_from_slice(&sub.origin);
    }
}

fn facts(reader: &mut Reader) -> Vec<(String, Info)> {
    let mut out = Vec::new();
    for (tag, name) in TEXTS {
        if let Some(text) = text(reader, tag) {
            if name == "ImageDescription" {
                described(&text, &mut out);
            }
            out.push((name.to_owned(), Info::Text(text)));
        }
    }
    for (tag, name) in [(TEXTURE_FORMAT, "textureformat"), (WRAP_MODES, "wrapmodes")] {
        out.extend(text(reader, tag).map(|text| (name.to_owned(), Info::Text(text))));
    }
    for (tag, name) in [(WORLD_TO_SCREEN, "worldtoscreen"), (WORLD_TO_CAMERA, "worldtocamera")] {
        if let Ok(m) = reader.get_tag_f32_vec(Tag::from_u16_exhaustive(tag))
            && m.len() == 16
        {
            out.push((name.to_owned(), Info::Floats(m.into_iter().map(f64::from).collect())));
        }
    }
    if let Ok(x) = reader.get_tag_f32(Tag::from_u16_exhaustive(FOV_COT)) {
        out.push(("fovcot".to_owned(), Info::Floats(vec![f64::from(x)])));
    }
    if let Some(n) = number(reader, 274) {
        out.push(("Orientation".to_owned(), Info::Ints(vec![n as i32])));
    }
    for (tag, name) in [(Tag::XResolution, "XResolution"), (Tag::YResolution, "YResolution")] {
        out.extend(float(reader, tag).map(|x| (name.to_owned(), Info::Floats(vec![x]))));
    }
    out
}

/// `oiio:NAME=VALUE` and the like that image descriptions hold.
fn described(text: &str, out: &mut Vec<(String, Info)>) {
    for word in text.split_whitespace() {
        let Some((name, value)) = word.split_once('=').filter(|(name, _)| name.starts_with("oiio:")) else { continue };
        let numbers: Option<Vec<f64>> = value.split(',').map(|x| x.parse().ok()).collect();
        let info = match (name, numbers) {
            ("oiio:AverageColor" | "oiio:ConstantColor", Some(v)) => Info::Floats(v),
            ("oiio:sampleborder", Some(v)) => Info::Ints(v.iter().map(|x| *x as i32).collect()),
            _ => Info::Text(value.to_owned()),
        };
        out.push((name.to_owned(), info));
    }
}
