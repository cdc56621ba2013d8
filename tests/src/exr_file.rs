//! Reads the reference pictures.
//!
//! In: the path of an EXR file with the channels R, G, B. Out: size and pixels.

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use std::path::Path;

/// Width, height, and pixels from the top row on.
pub fn read_rgb(path: &Path) -> Result<(usize, usize, Vec<[f32; 3]>), exr::error::Error> {
    let image = read_first_flat_layer_from_file(path)?;
    let size = image.layer_data.size;
    let mut pixels = vec![[0.0; 3]; size.area()];
    for channel in &image.layer_data.channel_data.list {
        let Some(k) = ["R", "G", "B"].iter().position(|n| channel.name == **n) else { continue };
        match &channel.sample_data {
            FlatSamples::F32(v) => pixels.iter_mut().zip(v).for_each(|(p, x)| p[k] = *x),
            FlatSamples::F16(v) => pixels.iter_mut().zip(v).for_each(|(p, x)| p[k] = x.to_f32()),
            FlatSamples::U32(_) => {}
        }
    }
    Ok((size.width(), size.height(), pixels))
}
