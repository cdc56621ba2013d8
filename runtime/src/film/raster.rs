//! Rasters: values of any number of channels in memory; EXR, TIFF and PNG on disk.
//!
//! In: numbers per pixel, or a file. Out: files that are replaced as a whole or not at all, or numbers. Integer formats hold
//! 0 to 1 as 0 to their largest value; nothing is converted between colour spaces. It must not know scenes or devices.

use super::Error;
use crate::files;
use crate::textures;
use std::io::Cursor;
use std::path::Path;

/// Numbers on a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Numbers per pixel.
    pub channels: usize,
    /// `width * height * channels` numbers, row by row from the top left, a pixel's together.
    pub data: Vec<f32>,
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 8-bit integers.
    U8,
    /// 16-bit floats; TIFF files get 32-bit ones instead.
    Half,
    /// 32-bit floats.
    Float,
    /// 32-bit integers; EXR files get floats instead.
    Int,
}

/// Writes a raster by the file's extension: .exr (float or half), .tif, .tiff or .png (8 bits, as they are; colours divided by alpha).
pub fn write(path: &Path, raster: &Raster, depth: Depth) -> Result<(), Error> {
    Ok(files::replace(&[encode(path, raster, depth)?])?)
}

/// What [`write()`] writes, for those who replace several files at once.
pub fn encode(path: &Path, raster: &Raster, depth: Depth) -> Result<files::Output, Error> {
    let Raster { width, height, channels, .. } = *raster;
    let wanted = width.checked_mul(height).and_then(|n| n.checked_mul(channels));
    if raster.data.is_empty() || wanted != Some(raster.data.len()) {
        return Err(Error::Size { path: path.to_path_buf(), width, height, count: raster.data.len() });
    }
    let encoded = match extension(path).as_str() {
        "exr" => encode_exr(raster, depth),
        "tif" | "tiff" => encode_tiff(raster, depth),
        "png" => encode_png(raster),
        _ => return Err(Error::UnknownExtension { path: path.to_path_buf(), known: ".exr, .tif or .png" }),
    };
    let bytes = encoded.map_err(|cause| Error::Encoding { path: path.to_path_buf(), cause })?;
    Ok(files::Output { path: path.to_path_buf(), bytes })
}

/// Reads the first picture of a file of any format that textures can have; its name does not matter. An EXR's channels are
/// sorted R, G, B, A, others by name. Colours are associated: multiplied by alpha where the file keeps them apart.
pub fn read(path: &Path) -> Result<Raster, Error> {
    let unreadable = |cause: String| Error::Unreadable { path: path.to_path_buf(), cause };
    let picture = textures::read(path).map_err(unreadable)?;
    let part = picture.subimages.first().and_then(|sub| Some((sub.channels, sub.levels.first()?)));
    let Some((channels, level)) = part else { return Err(unreadable("it has no pixels".to_owned())) };
    let (width, height) = (level.width as usize, level.height as usize);
    let data = (0..width * height * channels).map(|i| level.texels.get(i) as f32).collect();
    Ok(Raster { width, height, channels, data })
}

fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// 0 to 1 as 0 to 255, rounded; NaN is 0.
fn byte(value: f32) -> u8 {
    (255.0 * value.clamp(0.0, 1.0) + 0.5) as u8
}

/// Names of channels in EXR files, by their number and place.
fn channel_name(channels: usize, index: usize) -> String {
    match (channels, index) {
        (1, _) => "Y".to_owned(),
        (3 | 4, i) => ["R", "G", "B", "A"][i].to_owned(),
        // Sorted by name they stay in their order.
        (_, i) => format!("channel{i:05}"),
    }
}

fn encode_exr(raster: &Raster, depth: Depth) -> Result<Vec<u8>, String> {
    use exr::prelude::*;
    let channel = |index: usize| {
        let values = raster.data.iter().skip(index).step_by(raster.channels);
        let samples = match depth {
            Depth::Half => FlatSamples::F16(values.map(|v| f16::from_f32(*v)).collect()),
            Depth::U8 | Depth::Float | Depth::Int => FlatSamples::F32(values.copied().collect()),
        };
        AnyChannel::new(channel_name(raster.channels, index).as_str(), samples)
    };
    let channels = AnyChannels::sort((0..raster.channels).map(channel).collect());
    let encoding = Encoding { line_order: LineOrder::Increasing, ..Encoding::SMALL_FAST_LOSSLESS };
    let layer = Layer::new((raster.width, raster.height), LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|cause| cause.to_string())?;
    Ok(bytes.into_inner())
}

fn encode_tiff(raster: &Raster, depth: Depth) -> Result<Vec<u8>, String> {
    use tiff::encoder::{Compression, TiffEncoder, colortype};
    let side = |n: usize| u32::try_from(n).map_err(|_| format!("{n} pixels are too many"));
    let (w, h) = (side(raster.width)?, side(raster.height)?);
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).map_err(|cause| cause.to_string())?;
    let mut encoder = encoder.with_compression(Compression::Deflate(Default::default()));
    let written = if depth == Depth::U8 {
        let samples: Vec<u8> = raster.data.iter().map(|v| byte(*v)).collect();
        match raster.channels {
            1 => encoder.write_image::<colortype::Gray8>(w, h, &samples),
            3 => encoder.write_image::<colortype::RGB8>(w, h, &samples),
            4 => encoder.write_image::<colortype::RGBA8>(w, h, &samples),
            n => return Err(format!("TIFF files of {n} channels are not supported yet: use .exr")),
        }
    } else if depth == Depth::Int {
        let largest = f64::from(i32::MAX);
        let samples: Vec<i32> = raster.data.iter().map(|v| (f64::from(*v) * largest).round() as i32).collect();
        match raster.channels {
            1 => encoder.write_image::<colortype::GrayI32>(w, h, &samples),
            n => return Err(format!("TIFF files of {n} channels of integers are not supported yet: use .exr")),
        }
    } else {
        match raster.channels {
            1 => encoder.write_image::<colortype::Gray32Float>(w, h, &raster.data),
            3 => encoder.write_image::<colortype::RGB32Float>(w, h, &raster.data),
            4 => encoder.write_image::<colortype::RGBA32Float>(w, h, &raster.data),
            n => return Err(format!("TIFF files of {n} channels are not supported yet: use .exr")),
        }
    };
    written.map_err(|cause| cause.to_string())?;
    Ok(bytes.into_inner())
}

fn encode_png(raster: &Raster) -> Result<Vec<u8>, String> {
    use image::{ExtendedColorType, ImageEncoder};
    let color = match raster.channels {
        1 => ExtendedColorType::L8,
        3 => ExtendedColorType::Rgb8,
        4 => ExtendedColorType::Rgba8,
        n => return Err(format!("PNG files have 1, 3 or 4 channels, not {n}")),
    };
    // PNG files keep colours and alpha apart.
    let apart = |pixel: &[f32]| match *pixel {
        [r, g, b, a] if a > 0.0 => vec![byte(r / a), byte(g / a), byte(b / a), byte(a)],
        _ => pixel.iter().map(|v| byte(*v)).collect(),
    };
    let samples: Vec<u8> = raster.data.chunks(raster.channels).flat_map(apart).collect();
    let side = |n: usize| u32::try_from(n).map_err(|_| format!("{n} pixels are too many"));
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&samples, side(raster.width)?, side(raster.height)?, color)
        .map_err(|cause| cause.to_string())?;
    Ok(bytes)
}

/// Limits of [`differences`], in the sense of the tools that compare pictures pixel by pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// A value differs when it is off by more than this ...
    pub fail: f64,
    /// ... and by more than this part of the mean of both.
    pub relative: f64,
    /// Pixels that may differ, in percent.
    pub percent: f64,
    /// Pixels that may differ besides.
    pub allowed: usize,
    /// No value may be off by more than this.
    pub hard: f64,
}

/// What [`differences`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Differences {
    /// Pixels with a value beyond [`Limits::fail`].
    pub pixels: usize,
    /// The largest difference; infinite where only one is a number.
    pub largest: f64,
    /// Mean of the differences.
    pub mean: f64,
    /// Whether all limits hold.
    pub within: bool,
}

/// Compares value by value with the reference `b`; `None` for different shapes.
pub fn differences(a: &Raster, b: &Raster, limits: &Limits) -> Option<Differences> {
    if (a.width, a.height) != (b.width, b.height) || a.channels != b.channels {
        return None;
    }
    let mut found = Differences::default();
    let mut sum = 0.0;
    for (p, q) in a.data.chunks(a.channels.max(1)).zip(b.data.chunks(b.channels.max(1))) {
        let mut differs = false;
        for (x, y) in p.iter().map(|v| f64::from(*v)).zip(q.iter().map(|v| f64::from(*v))) {
            // Equal infinities and a NaN on both sides agree.
            let off = if x == y || (x.is_nan() && y.is_nan()) { 0.0 } else { (x - y).abs() };
            let off = if off.is_nan() { f64::INFINITY } else { off };
            found.largest = found.largest.max(off);
            sum += off;
            let tolerated = off <= limits.relative * 0.5 * (x.abs() + y.abs());
            differs |= off > limits.fail && !tolerated;
        }
        found.pixels += usize::from(differs);
    }
    found.mean = sum / a.data.len().max(1) as f64;
    let may = limits.percent / 100.0 * (a.width * a.height) as f64;
    let few = found.pixels <= limits.allowed || found.pixels as f64 <= may;
    found.within = few && found.largest <= limits.hard;
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(channels: usize) -> Raster {
        let data = (0..5 * 4 * channels).map(|i| i as f32 / (20 * channels) as f32).collect();
        Raster { width: 5, height: 4, channels, data }
    }

    #[test]
    fn files_hold_what_was_written() {
        let folder = std::env::temp_dir().join(format!("oslcl-raster-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        for channels in [1, 3, 4] {
            let raster = ramp(channels);
            for (name, depth, error) in [
                ("a.exr", Depth::Float, 0.0),
                ("a.exr", Depth::Half, 5e-4),
                ("a.tif", Depth::Float, 0.0),
                ("a.tif", Depth::U8, 2e-3),
                // Colour, alpha and, when read, their product are rounded, each by half of 1/255.
                ("a.png", Depth::U8, if channels == 4 { 6e-3 } else { 2e-3 }),
            ] {
                let path = folder.join(name);
                write(&path, &raster, depth).expect("written");
                let back = read(&path).expect("read");
                let limits = Limits { fail: error, relative: 0.0, percent: 0.0, allowed: 0, hard: error };
                let found = differences(&back, &raster, &limits).expect("the same shape");
                assert!(found.within, "{name} {depth:?} {channels}: {found:?}");
            }
        }
        let many = ramp(16);
        write(&folder.join("m.exr"), &many, Depth::Float).expect("written");
        assert_eq!(read(&folder.join("m.exr")).expect("read"), many);
        assert!(matches!(write(&folder.join("m.tif"), &many, Depth::Float), Err(Error::Encoding { .. })));
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn limits_are_those_of_pixels() {
        let a = ramp(1);
        let mut b = a.clone();
        b.data[3] += 0.02;
        b.data[4] = f32::NAN;
        let loose = Limits { fail: 0.01, relative: 0.0, percent: 10.0, allowed: 0, hard: f64::INFINITY };
        let found = differences(&a, &b, &loose).expect("the same shape");
        assert_eq!((found.pixels, found.within), (2, true));
        assert!(!differences(&a, &b, &Limits { percent: 5.0, ..loose }).expect("the same shape").within);
        assert!(differences(&a, &b, &Limits { percent: 5.0, allowed: 2, ..loose }).expect("the same shape").within);
        assert!(!differences(&a, &b, &Limits { hard: 0.01, ..loose }).expect("the same shape").within);
        assert_eq!(differences(&a, &ramp(3), &loose), None);
    }
}
