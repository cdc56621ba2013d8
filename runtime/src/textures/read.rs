//! Reads texture files of any known format.
//!
//! In: a path. Out: a [`Picture`] with the levels that the file has, or words about what is wrong. It must not know shaders.

use super::picture::{Level, Picture, Subimage, Texels};
use super::{read_exr, read_tiff};
use image::{ColorType, DynamicImage, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::Path;

/// Largest file that is decoded, in bytes of decoded texels: what one device buffer could hold, with room to spare.
pub(super) const MAX_BYTES: usize = 8 << 30;

/// Reads a file; what it holds decides how, not its name.
pub fn read(path: &Path) -> Result<Picture, String> {
    let bytes = std::fs::read(path).map_err(|cause| cause.to_string())?;
    match bytes.get(..4) {
        Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+") => read_tiff::decode(bytes),
        Some([0x76, 0x2f, 0x31, 0x01]) => read_exr::decode(bytes),
        _ => plain(bytes, path),
    }
}

/// Formats of one picture without levels.
fn plain(bytes: Vec<u8>, path: &Path) -> Result<Picture, String> {
    let by_name = ImageFormat::from_path(path).ok();
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|cause| cause.to_string())?;
    if reader.format().is_none()
        && let Some(format) = by_name
    {
        reader.set_format(format);
    }
    let format = match reader.format() {
        Some(ImageFormat::Png) => "png",
        Some(ImageFormat::Jpeg) => "jpeg",
        Some(ImageFormat::Hdr) => "hdr",
        Some(ImageFormat::Bmp) => "bmp",
        Some(ImageFormat::Tga) => "targa",
        _ => return Err("it is no TIFF, EXR, HDR, PNG, JPEG, TGA or BMP file".to_owned()),
    };
    let picture = reader.decode().map_err(|cause| cause.to_string())?;
    let (width, height) = (picture.width(), picture.height());
    if width == 0 || height == 0 {
        return Err("it has no pixels".to_owned());
    }
    let color = picture.color();
    let channels = usize::from(color.channel_count());
    let alpha = color.has_alpha().then(|| channels - 1);
    let mut texels = match (color, picture) {
        (ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8, p) => Texels::U8(p.into_bytes()),
        (_, DynamicImage::ImageLuma16(p)) => Texels::U16(p.into_raw()),
        (_, DynamicImage::ImageLumaA16(p)) => Texels::U16(p.into_raw()),
        (_, DynamicImage::ImageRgb16(p)) => Texels::U16(p.into_raw()),
        (_, DynamicImage::ImageRgba16(p)) => Texels::U16(p.into_raw()),
        (_, DynamicImage::ImageRgb32F(p)) => Texels::F32(p.into_raw()),
        (_, DynamicImage::ImageRgba32F(p)) => Texels::F32(p.into_raw()),
        (color, _) => return Err(format!("its pixels are {color:?}, which textures cannot be")),
    };
    if let Some(alpha) = alpha {
        associate(&mut texels, channels, alpha);
    }
    let sub = Subimage::new(channels, alpha, Level { width, height, texels });
    Ok(Picture { format, subimages: vec![sub] })
}

/// Multiplies colours by alpha, where the file keeps them apart: textures are filtered so.
pub(super) fn associate(texels: &mut Texels, channels: usize, alpha: usize) {
    fn each<T: Copy>(list: &mut [T], channels: usize, alpha: usize, mut f: impl FnMut(T, T) -> T) {
        for texel in list.chunks_exact_mut(channels) {
            let a = texel[alpha];
            for (c, x) in texel.iter_mut().enumerate() {
                if c != alpha {
                    *x = f(*x, a);
                }
            }
        }
    }
    match texels {
        Texels::U8(v) => each(v, channels, alpha, |x, a| ((u32::from(x) * u32::from(a) + 127) / 255) as u8),
        Texels::U16(v) => {
            each(v, channels, alpha, |x, a| ((u64::from(x) * u64::from(a) + 32767) / 65535) as u16);
        }
        Texels::F16(v) => {
            each(v, channels, alpha, |x, a| exr::prelude::f16::from_f32(x.to_f32() * a.to_f32()));
        }
        Texels::F32(v) => each(v, channels, alpha, |x, a| x * a),
    }
}
