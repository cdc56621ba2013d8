//! Rasters: values of any number of channels in memory; EXR, TIFF and PNG on disk.
//!
//! In: numbers per pixel, or a file. Out: files that are replaced as a whole or not at all, or numbers. Integer formats hold
//! 0 to 1 as 0 to their largest value; nothing is converted between colour spaces. It must not know scenes or devices.

use super::Error;
use crate::files;
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

/// Writes a raster by the file's extension: .exr (float or half), .tif, .tiff or .png (8 bits, as they are).
pub fn write(path: &Path, raster: &Raster, depth: Depth) -> Result<(), Error> {
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
    Ok(files::replace(&[files::Output { path: path.to_path_buf(), bytes }])?)
}

/// Reads the first picture of a file, whatever its channels: an EXR's are sorted R, G, B, A, others by name.
pub fn read(path: &Path) -> Result<Raster, Error> {
    let unreadable = |cause: String| Error::Unreadable { path: path.to_path_buf(), cause };
    let bytes = std::fs::read(path).map_err(|cause| unreadable(cause.to_string()))?;
    let decoded = match extension(path).as_str() {
        "exr" => decode_exr(bytes),
        "tif" | "tiff" | "tx" => decode_tiff(bytes),
        "png" => decode_png(&bytes),
        _ => return Err(Error::UnknownExtension { path: path.to_path_buf(), known: ".exr, .tif or .png" }),
    };
    decoded.map_err(unreadable)
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

fn decode_exr(bytes: Vec<u8>) -> Result<Raster, String> {
    use exr::prelude::*;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|cause| cause.to_string())?;
    let layer = image.layer_data;
    let mut list: Vec<&AnyChannel<FlatSamples>> = layer.channel_data.list.iter().collect();
    let rank = |c: &AnyChannel<FlatSamples>| {
        let name = c.name.to_string();
        ["R", "G", "B", "A"].iter().position(|n| *n == name).map_or((4, name), |i| (i, String::new()))
    };
    list.sort_by_key(|c| rank(c));
    let (width, height, channels) = (layer.size.width(), layer.size.height(), list.len());
    let mut data = vec![0.0; width * height * channels];
    for (c, channel) in list.iter().enumerate() {
        if channel.sampling != Vec2(1, 1) {
            return Err(format!("channel {} is subsampled", channel.name));
        }
        for (i, value) in channel.sample_data.values_as_f32().enumerate() {
            data[i * channels + c] = value;
        }
    }
    Ok(Raster { width, height, channels, data })
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

fn decode_tiff(bytes: Vec<u8>) -> Result<Raster, String> {
    use tiff::ColorType;
    use tiff::decoder::{Decoder, DecodingResult};
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(|cause| cause.to_string())?;
    let (width, height) = decoder.dimensions().map_err(|cause| cause.to_string())?;
    let color = decoder.colortype().map_err(|cause| cause.to_string())?;
    let channels = match color {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        ColorType::Multiband { num_samples, .. } => usize::from(num_samples),
        other => return Err(format!("pixels of kind {other:?} are not supported yet")),
    };
    fn scaled<T: Copy + Into<f64>>(values: Vec<T>, largest: f64) -> Vec<f32> {
        values.into_iter().map(|v| (v.into() / largest) as f32).collect()
    }
    let data = match decoder.read_image().map_err(|cause| cause.to_string())? {
        DecodingResult::U8(v) => scaled(v, f64::from(u8::MAX)),
        DecodingResult::U16(v) => scaled(v, f64::from(u16::MAX)),
        DecodingResult::U32(v) => scaled(v, f64::from(u32::MAX)),
        DecodingResult::I32(v) => scaled(v, f64::from(i32::MAX)),
        DecodingResult::F16(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::F32(v) => v,
        DecodingResult::F64(v) => scaled(v, 1.0),
        _ => return Err("samples of this integer type are not supported yet".to_owned()),
    };
    let raster = Raster { width: width as usize, height: height as usize, channels, data };
    if raster.data.len() != raster.width * raster.height * channels {
        return Err("planar files of several channels are not supported yet".to_owned());
    }
    Ok(raster)
}

fn encode_png(raster: &Raster) -> Result<Vec<u8>, String> {
    use image::{ExtendedColorType, ImageEncoder};
    let color = match raster.channels {
        1 => ExtendedColorType::L8,
        3 => ExtendedColorType::Rgb8,
        4 => ExtendedColorType::Rgba8,
        n => return Err(format!("PNG files have 1, 3 or 4 channels, not {n}")),
    };
    let samples: Vec<u8> = raster.data.iter().map(|v| byte(*v)).collect();
    let side = |n: usize| u32::try_from(n).map_err(|_| format!("{n} pixels are too many"));
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&samples, side(raster.width)?, side(raster.height)?, color)
        .map_err(|cause| cause.to_string())?;
    Ok(bytes)
}

fn decode_png(bytes: &[u8]) -> Result<Raster, String> {
    let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Png).map_err(|e| e.to_string())?;
    let (width, height, channels) = (image.width() as usize, image.height() as usize, image.color().channel_count());
    let data = match channels {
        1 => image.into_luma16().into_raw().iter().map(|v| f32::from(*v) / f32::from(u16::MAX)).collect(),
        3 => image.into_rgb32f().into_raw(),
        _ => image.into_rgba32f().into_raw(),
    };
    let channels = if channels == 2 { 4 } else { usize::from(channels) };
    Ok(Raster { width, height, channels, data })
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
                ("a.png", Depth::U8, 2e-3),
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
