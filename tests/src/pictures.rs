//! Small texture files of every kind that is read, written for tests.
//!
//! In: a folder. Out: the files that tests/corpus/textures names. Texels are simple functions of their place, the same in
//! every run.

use exr::prelude::*;
use image::{ImageBuffer, Rgba};
use std::fs::File;
use std::path::Path;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// A number in 0 to 1 that depends on everything.
fn wave(x: usize, y: usize, c: usize) -> f32 {
    let t = (x * 37 + y * 101 + c * 53) % 97;
    t as f32 / 96.0
}

/// Writes them all.
pub fn write(folder: &Path) {
    png(&folder.join("rgba.png"), 16, 8, |x, y, c| if c == 3 { 255 } else { (255.0 * wave(x, y, c)) as u8 });
    for (name, color) in [("1001", [128, 20, 20]), ("1002", [20, 128, 20]), ("1011", [20, 20, 128])] {
        let size = if name == "1001" { 8 } else { 4 };
        png(&folder.join(format!("set.{name}.png")), size, size, |x, y, c| {
            if c == 3 { 255 } else { color[c] + (16.0 * wave(x, y, c)) as u8 }
        });
    }
    levels(&folder.join("mip.tif"));
    one_channel(&folder.join("grey.exr"));
    window(&folder.join("window.exr"));
    parts(&folder.join("parts.exr"));
    sky(&folder.join("sky.exr"));
}

fn png(path: &Path, width: u32, height: u32, texel: impl Fn(usize, usize, usize) -> u8) {
    let pixel = |x: u32, y: u32| Rgba([0, 1, 2, 3].map(|c| texel(x as usize, y as usize, c)));
    ImageBuffer::from_fn(width, height, pixel).save(path).expect("a picture is written");
}

/// 16-bit RGB with levels of detail of its own, each of another brightness.
fn levels(path: &Path) {
    let mut file = TiffEncoder::new(File::create(path).expect("a file")).expect("a TIFF");
    let matrix: Vec<f32> = (0..16).map(|i| i as f32 / 4.0).collect();
    for (level, size) in [16u32, 8, 4, 2, 1].into_iter().enumerate() {
        let texels: Vec<u16> = (0..size as usize * size as usize * 3)
            .map(|i| (i / 3 % size as usize, i / 3 / size as usize, i % 3))
            .map(|(x, y, c)| (65535.0 * (0.5 + 0.1 * level as f32) * wave(x, y, c)) as u16)
            .collect();
        let mut image = file.new_image::<colortype::RGB16>(size, size).expect("a level");
        let tags = image.encoder();
        tags.write_tag(Tag::NewSubfileType, u32::from(level > 0)).expect("a tag");
        tags.write_tag(Tag::from_u16_exhaustive(33302), "Plain Texture").expect("a tag");
        tags.write_tag(Tag::from_u16_exhaustive(33303), "mirror,clamp").expect("a tag");
        tags.write_tag(Tag::from_u16_exhaustive(33306), &matrix[..]).expect("a tag");
        tags.write_tag(Tag::DateTime, "2001:02:03 04:05:06").expect("a tag");
        image.write_data(&texels).expect("texels");
    }
}

fn layer(size: (usize, usize), channels: &[&str], half: bool, scale: f32) -> Layer<AnyChannels<FlatSamples>> {
    let list = channels.iter().enumerate().map(|(c, name)| {
        let values = (0..size.0 * size.1).map(|i| scale * wave(i % size.0, i / size.0, c));
        let samples = if half {
            FlatSamples::F16(values.map(f16::from_f32).collect())
        } else {
            FlatSamples::F32(values.collect())
        };
        AnyChannel::new(*name, samples)
    });
    Layer::new(size, LayerAttributes::default(), Encoding::UNCOMPRESSED, AnyChannels::sort(list.collect()))
}

fn one_channel(path: &Path) {
    let image = Image::from_layer(layer((8, 8), &["Y"], true, 1.0));
    image.write().to_file(path).expect("a picture is written");
}

/// A part of a larger picture.
fn window(path: &Path) {
    let mut layer = layer((8, 4), &["R", "G", "B"], false, 2.0);
    layer.attributes.layer_position = Vec2(3, 2);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (16, 12));
    image.write().to_file(path).expect("a picture is written");
}

fn parts(path: &Path) {
    let named = |name: &str, size, scale| {
        let mut layer = layer(size, &["R", "G", "B"], true, scale);
        layer.attributes.layer_name = Some(name.into());
        layer
    };
    let layers = [named("first", (8, 8), 1.0), named("second", (4, 8), 3.0)].into_iter().collect::<Layers<_>>();
    let attributes = ImageAttributes::new(IntegerBounds::new((0, 0), (8, 8)));
    Image::from_layers(attributes, layers).write().to_file(path).expect("a picture is written");
}

/// A latitude-longitude map.
fn sky(path: &Path) {
    let mut layer = layer((32, 16), &["R", "G", "B", "A"], false, 4.0);
    layer.attributes.environment_map = Some(exr::meta::attribute::EnvironmentMap::LatitudeLongitude);
    Image::from_layer(layer).write().to_file(path).expect("a picture is written");
}
