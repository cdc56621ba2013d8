//! Pictures: linear RGB radiance in memory, EXR and PNG on disk.
//!
//! In: pixels. Out: files that are replaced as a whole or not at all. It must not know scenes, devices or how pixels came.

pub mod compare;
pub mod flip;
pub mod raster;

use crate::files;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// A picture: linear Rec.709 radiance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// `width * height` pixels, row by row from the top left.
    pub pixels: Vec<[f32; 3]>,
    /// How much of each pixel is not cut out, 0..=1, in the same order; empty when nothing is.
    pub alpha: Vec<f32>,
    /// Names and values that EXR files carry along, such as samples and seed.
    pub attributes: Vec<(String, String)>,
}

/// Why a picture can't be written or read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file's name doesn't tell its format.
    #[error("{}: a picture's name must end in {known}", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// The extensions that it may have.
        known: &'static str,
    },
    /// The file's folder is not there.
    #[error("{}: there is no folder {}", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The file's name is that of a folder.
    #[error("{}: this is a folder", path.display())]
    IsFolder {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: cannot write: {cause}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The file can't be read.
    #[error("{}: cannot read: {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system or the decoder said.
        cause: String,
    },
    /// The encoder refused.
    #[error("{}: cannot encode: {cause}", path.display())]
    Encoding {
        /// The file.
        path: PathBuf,
        /// What the encoder said.
        cause: String,
    },
    /// A picture of no pixels, or with a list of another length than its size says.
    #[error("{}: {width} x {height} pixels, but a list of {count}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
        /// Pixels in the list.
        count: usize,
    },
}

impl From<files::Error> for Error {
    fn from(error: files::Error) -> Error {
        let path = error.path;
        match error.cause {
            files::Cause::IsFolder => Error::IsFolder { path },
            files::Cause::NoFolder(folder) => Error::NoFolder { path, folder },
            files::Cause::System(cause) => Error::Unwritable { path, cause },
        }
    }
}

#[derive(Clone, Copy)]
enum Format {
    Exr,
    Png,
}

/// Whether a picture could be written to `path`: extension, folder, and the right to write there. Call it before
/// rendering. It leaves nothing behind.
pub fn check_output(path: &Path) -> Result<(), Error> {
    format(path)?;
    Ok(files::probe(path)?)
}

/// Writes a picture, as EXR (32-bit float, linear) or PNG (8 bits, sRGB) by the file's extension. `exposure` in stops
/// brightens PNG only. A file that was there before stays whole until the new one is complete.
pub fn write(path: &Path, picture: &Picture, exposure: f32) -> Result<(), Error> {
    let format = format(path)?;
    let Picture { width, height, .. } = *picture;
    let count = picture.pixels.len();
    let alpha_fits = picture.alpha.is_empty() || picture.alpha.len() == count;
    if count == 0 || width.checked_mul(height) != Some(count) || !alpha_fits {
        return Err(Error::Size { path: path.to_path_buf(), width, height, count });
    }
    let encoded = match format {
        Format::Exr => encode_exr(picture),
        Format::Png => encode_png(picture, exposure),
    };
    let bytes = encoded.map_err(|cause| Error::Encoding { path: path.to_path_buf(), cause })?;
    Ok(files::replace(&[files::Output { path: path.to_path_buf(), bytes }])?)
}

/// Reads the channels R, G and B (float or half) of an EXR file's first layer that has them.
pub fn read_exr(path: &Path) -> Result<Picture, Error> {
    use exr::prelude::*;
    let unreadable = |cause: String| self::Error::Unreadable { path: path.to_path_buf(), cause };
    let bytes = std::fs::read(path).map_err(|cause| unreadable(cause.to_string()))?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Picture {
                width: size.width(),
                height: size.height(),
                pixels: vec![[0.0; 3]; size.area()],
                alpha: Vec::new(),
                attributes: Vec::new(),
            },
            |picture: &mut Picture, at, (r, g, b): (f32, f32, f32)| {
                picture.pixels[at.y() * picture.width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|cause| unreadable(cause.to_string()))?;
    let mut picture = image.layer_data.channel_data.pixels;
    for (name, value) in &image.layer_data.attributes.other {
        if let AttributeValue::Text(text) = value {
            picture.attributes.push((name.to_string(), text.to_string()));
        }
    }
    picture.attributes.sort();
    Ok(picture)
}

fn format(path: &Path) -> Result<Format, Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    match extension.to_ascii_lowercase().as_str() {
        "exr" => Ok(Format::Exr),
        "png" => Ok(Format::Png),
        _ => Err(Error::UnknownExtension { path: path.to_path_buf(), known: ".exr or .png" }),
    }
}

fn encode_exr(picture: &Picture) -> Result<Vec<u8>, String> {
    use exr::prelude::*;
    let mut attributes = LayerAttributes::default();
    for (name, value) in &picture.attributes {
        let text = |s: &str| Text::new_or_none(s).ok_or_else(|| format!("`{s}` is not Latin-1 text"));
        attributes.other.insert(text(name)?, AttributeValue::Text(text(value)?));
    }
    let size = (picture.width, picture.height);
    let place = |at: Vec2<usize>| at.y() * picture.width + at.x();
    // Threads compress; in another order than the picture's they would write another file each time.
    let encoding = Encoding { line_order: LineOrder::Increasing, ..Encoding::SMALL_FAST_LOSSLESS };
    let mut bytes = Cursor::new(Vec::new());
    let written = if picture.alpha.is_empty() {
        let channels = SpecificChannels::rgb(|at: Vec2<usize>| <(f32, f32, f32)>::from(picture.pixels[place(at)]));
        Image::from_layer(Layer::new(size, attributes, encoding, channels)).write().to_buffered(&mut bytes)
    } else {
        let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
            let [r, g, b] = picture.pixels[place(at)];
            (r, g, b, picture.alpha[place(at)])
        });
        Image::from_layer(Layer::new(size, attributes, encoding, channels)).write().to_buffered(&mut bytes)
    };
    written.map_err(|cause| cause.to_string())?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Puts the attributes of a header in the order of their names: the encoder keeps ours in a hash map, and the same picture
/// should be the same file. Lengths and places of all else stay.
fn sort_attributes(exr: &mut [u8]) {
    // Behind the magic number and the version; the list ends with an empty name.
    const START: usize = 8;
    let mut found = Vec::new();
    let mut at = START;
    while exr.get(at).is_some_and(|byte| *byte != 0) {
        match attribute_length(&exr[at..]) {
            Some(length) => found.push(exr[at..at + length].to_vec()),
            None => return,
        }
        at += found.last().map_or(0, Vec::len);
    }
    found.sort();
    exr[START..at].copy_from_slice(&found.concat());
}

/// Bytes of the attribute that `rest` begins with: name, type, length, value. `None` if it is longer than `rest`.
fn attribute_length(rest: &[u8]) -> Option<usize> {
    let name = rest.iter().position(|byte| *byte == 0)? + 1;
    let kind = rest[name..].iter().position(|byte| *byte == 0)? + 1;
    let value = rest.get(name + kind..name + kind + 4)?;
    let length = u32::from_le_bytes(value.try_into().ok()?) as usize;
    let whole = (name + kind + 4).checked_add(length)?;
    (whole <= rest.len()).then_some(whole)
}

fn encode_png(picture: &Picture, exposure: f32) -> Result<Vec<u8>, String> {
    use image::ImageEncoder;
    let gain = exposure.exp2();
    let (samples, color) = if picture.alpha.is_empty() {
        let samples: Vec<u8> = picture.pixels.iter().flatten().map(|radiance| srgb(radiance * gain)).collect();
        (samples, image::ExtendedColorType::Rgb8)
    } else {
        // Radiance is what is seen, alpha included; PNG wants it before that.
        let pixel = |([r, g, b], a): (&[f32; 3], &f32)| {
            let full = |x: f32| srgb(x * gain / a.max(1e-6));
            [full(*r), full(*g), full(*b), (255.0 * a.clamp(0.0, 1.0) + 0.5) as u8]
        };
        let samples = picture.pixels.iter().zip(&picture.alpha).flat_map(pixel).collect();
        (samples, image::ExtendedColorType::Rgba8)
    };
    let side = |n: usize| u32::try_from(n).map_err(|_| format!("{n} pixels are too many"));
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&samples, side(picture.width)?, side(picture.height)?, color)
        .map_err(|cause| cause.to_string())?;
    Ok(bytes)
}

/// The transfer function of IEC 61966-2-1, rounded to 8 bits. NaN is black.
fn srgb(linear: f32) -> u8 {
    let clamped = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    let encoded = if clamped <= 0.0031308 { 12.92 * clamped } else { 1.055 * clamped.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}
