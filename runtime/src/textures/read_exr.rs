//! Reads OpenEXR files: every part, every level of detail.
//!
//! In: bytes. Out: a [`Picture`]. Channels are put in the order R, G, B, A, then others by name.

use super::picture::{Level, Picture, Subimage, Texels};
use exr::prelude::*;
use oslcl_compiler::textures::Info;
use std::io::Cursor;

type Channel = AnyChannel<Levels<FlatSamples>>;

/// Decodes a file.
pub fn decode(bytes: Vec<u8>) -> std::result::Result<Picture, String> {
    let image = read()
        .no_deep_data()
        .all_resolution_levels()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|cause| cause.to_string())?;
    let window = image.attributes.display_window;
    let full = [window.position.x(), window.position.y(), window.size.width() as i32, window.size.height() as i32];
    let shared = facts_of(&image.attributes.other);
    let mut subimages = Vec::new();
    for layer in &image.layer_data {
        let mut sub = subimage(layer)?;
        sub.full = [full[0], full[1], full[2].max(1), full[3].max(1)];
        sub.facts.extend(shared.iter().cloned());
        subimages.push(sub);
    }
    if subimages.is_empty() {
        return Err("it has no parts of flat pixels".to_owned());
    }
    Ok(Picture { format: "openexr", subimages })
}

/// Where a channel stands among the others: its layer, then R, G, B, A, then its name.
fn rank(name: &str) -> (String, usize, String) {
    let (layer, channel) = name.rsplit_once('.').unwrap_or(("", name));
    let known = ["R", "G", "B", "A"].iter().position(|n| n.eq_ignore_ascii_case(channel)).unwrap_or(4);
    (layer.to_owned(), known, channel.to_owned())
}

fn subimage(layer: &Layer<AnyChannels<Levels<FlatSamples>>>) -> std::result::Result<Subimage, String> {
    let mut channels: Vec<&Channel> = layer.channel_data.list.iter().collect();
    channels.sort_by_key(|c| rank(&c.name.to_string()));
    let Some(first) = channels.first() else { return Err("it has a part without channels".to_owned()) };
    if channels.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return Err("it has channels of fewer pixels than others".to_owned());
    }
    let count = channels.len();
    let alpha = channels.iter().position(|c| rank(&c.name.to_string()).1 == 3);
    let half = |samples: &FlatSamples| matches!(samples, FlatSamples::F16(_));
    let all_half = channels.iter().all(|c| c.sample_data.levels_as_slice().iter().all(half));
    // Sizes of levels that are only narrower or only lower do not halve both sides: the first is enough there.
    let (levels, up) = match &first.sample_data {
        Levels::Mip { level_data, rounding_mode } => (level_data.len(), *rounding_mode == exr::math::RoundingMode::Up),
        _ => (1, false),
    };
    let mut sub: Option<Subimage> = None;
    let mut size = [layer.size.width() as u32, layer.size.height() as u32];
    for l in 0..levels {
        let numbers = size[0] as usize * size[1] as usize;
        let mut planes = Vec::with_capacity(count);
        for channel in &channels {
            match channel.sample_data.levels_as_slice().get(l) {
                Some(samples) if samples.len() == numbers => planes.push(samples),
                _ => return Err("its levels of detail have unexpected sizes".to_owned()),
            }
        }
        let level = Level { width: size[0], height: size[1], texels: interleaved(&planes, numbers, all_half) };
        match &mut sub {
            None => sub = Some(Subimage::new(count, alpha, level)),
            Some(sub) => sub.levels.push(level),
        }
        size = size.map(|n| if up { n.div_ceil(2) } else { n / 2 }.max(1));
    }
    let Some(mut sub) = sub.filter(|_| layer.size.area() > 0) else { return Err("it has no pixels".to_owned()) };
    sub.origin = [layer.attributes.layer_position.x(), layer.attributes.layer_position.y()];
    if let Blocks::Tiles(tile) = layer.encoding.blocks {
        sub.tile = Some([tile.width() as u32, tile.height() as u32]);
    }
    sub.name = layer.attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
    sub.facts = facts(&layer.attributes);
    Ok(sub)
}

/// Planes of channels to texels.
fn interleaved(planes: &[&FlatSamples], numbers: usize, half: bool) -> Texels {
    let places = (0..numbers).flat_map(|i| planes.iter().map(move |plane| (i, *plane)));
    if half {
        let of = |(i, plane): (usize, &FlatSamples)| match plane {
            FlatSamples::F16(v) => v[i],
            other => f16::from_f32(other.value_by_flat_index(i).to_f32()),
        };
        return Texels::F16(places.map(of).collect());
    }
    Texels::F32(places.map(|(i, plane)| plane.value_by_flat_index(i).to_f32()).collect())
}

fn facts(attributes: &LayerAttributes) -> Vec<(String, Info)> {
    let mut out = facts_of(&attributes.other);
    let texts = [
        ("wrapmodes", &attributes.wrap_mode_name),
        ("Copyright", &attributes.owner),
        ("ImageDescription", &attributes.comments),
        ("DateTime", &attributes.capture_date),
        ("Software", &attributes.software_name),
    ];
    for (name, text) in texts {
        out.extend(text.as_ref().map(|t| (name.to_owned(), Info::Text(t.to_string()))));
    }
    let matrices =
        [("worldtocamera", &attributes.world_to_camera), ("worldtoscreen", &attributes.world_to_normalized_device)];
    for (name, matrix) in matrices {
        out.extend(matrix.map(|m| (name.to_owned(), Info::Floats(m.iter().map(|x| f64::from(*x)).collect()))));
    }
    if attributes.environment_map == Some(exr::meta::attribute::EnvironmentMap::LatitudeLongitude) {
        // What OpenEXR's convention says of such maps.
        out.push(("textureformat".to_owned(), Info::Text("LatLong Environment".to_owned())));
        out.push(("oiio:updirection".to_owned(), Info::Text("y".to_owned())));
        out.push(("oiio:sampleborder".to_owned(), Info::Ints(vec![1])));
    }
    out
}

fn facts_of(attributes: &std::collections::HashMap<Text, AttributeValue>) -> Vec<(String, Info)> {
    let mut out = Vec::new();
    for (name, value) in attributes {
        let info = match value {
            AttributeValue::Text(t) => Info::Text(t.to_string()),
            AttributeValue::I32(i) => Info::Ints(vec![*i]),
            AttributeValue::F32(x) => Info::Floats(vec![f64::from(*x)]),
            AttributeValue::F64(x) => Info::Floats(vec![*x]),
            AttributeValue::FloatVec2(v) => Info::Floats(vec![f64::from(v.0), f64::from(v.1)]),
            AttributeValue::FloatVec3((x, y, z)) => Info::Floats(vec![f64::from(*x), f64::from(*y), f64::from(*z)]),
            AttributeValue::IntVec2(v) => Info::Ints(vec![v.0, v.1]),
            AttributeValue::Matrix4x4(m) => Info::Floats(m.iter().map(|x| f64::from(*x)).collect()),
            _ => continue,
        };
        out.push((name.to_string(), info));
    }
    // Attributes come in no order; answers must not depend on it.
    out.sort_by(|a, b| a.0.cmp(&b.0));
    for name in ["oiio:AverageColor", "oiio:ConstantColor"] {
        // Written as text by the usual tools.
        if let Some((_, info)) = out.iter_mut().find(|(n, _)| n == name)
            && let Info::Text(text) = info
            && let Some(v) = text.split(',').map(|x| x.trim().parse().ok()).collect::<Option<Vec<f64>>>()
        {
            *info = Info::Floats(v);
        }
    }
    out
}
