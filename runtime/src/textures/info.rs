//! What `gettextureinfo` can know about a file (OSL specification ch. 7, "Texture").
//!
//! In: a name, the kind of information, the type that is wanted. Out: an answer of exactly this type, or none: as in
//! OpenImageIO, an answer of another type or length is no answer.

use super::{Entry, Library, Picture};
use oslcl_compiler::textures::{Info, InfoType};

/// Answers about a file, a tile of a set, or a set whose tiles all agree.
pub fn info(
    library: &Library,
    file: &str,
    tile: Option<(u32, u32)>,
    name: &str,
    ty: InfoType,
    count: usize,
) -> Option<Info> {
    let entry = library.entry(file);
    let exists =
        |yes: bool| (name == "exists" && ty == InfoType::Int && count == 1).then(|| Info::Ints(vec![i32::from(yes)]));
    match (&*entry, tile) {
        (Entry::Missing(_), _) => exists(false),
        (Entry::File(picture), _) => exists(true).or_else(|| of_picture(picture, name, ty, count)),
        (Entry::Tiles { columns, files, .. }, Some((u, v))) => match files.get((v * columns + u) as usize) {
            Some(Some(file)) => info(library, file, None, name, ty, count),
            _ => exists(false),
        },
        (Entry::Tiles { files, .. }, None) => {
            let mut tiles = files.iter().flatten().map(|f| library.entry(f)).filter_map(|e| match &*e {
                Entry::File(picture) => Some(exists(true).or_else(|| of_picture(picture, name, ty, count))),
                _ => None,
            });
            let first = tiles.next()??;
            tiles.all(|other| other.as_ref() == Some(&first)).then_some(first)
        }
    }
}

fn of_picture(picture: &Picture, name: &str, ty: InfoType, count: usize) -> Option<Info> {
    let sub = picture.subimages.first()?;
    let level = sub.levels.first()?;
    let size = [level.width as i32, level.height as i32];
    let ints = |v: &[i32]| Some(Info::Ints(v.to_vec()));
    let window = |x: i32, y: i32, w: i32, h: i32| {
        let (x1, y1) = (x.saturating_add(w - 1), y.saturating_add(h - 1));
        match count {
            4 => ints(&[x, y, x1, y1]),
            _ => ints(&[x, y, 0, x1, y1, 0]),
        }
    };
    let color = |color: Option<Vec<f64>>| {
        let color = color?;
        Some(Info::Floats((0..count).map(|c| color.get(c).copied().unwrap_or(0.0)).collect()))
    };
    let alpha = |color: Option<Vec<f64>>| Some(Info::Floats(vec![*color?.get(sub.alpha?)?]));
    use InfoType::{Float, Int, Text};
    match (name, ty, count) {
        ("resolution", Int, 2) => return ints(&size),
        ("resolution", Int, 3) => return ints(&[size[0], size[1], 1]),
        ("channels", Int, 1) => return ints(&[sub.channels as i32]),
        ("channels", Float, 1) => return Some(Info::Floats(vec![sub.channels as f64])),
        ("subimages", Int, 1) => return ints(&[picture.subimages.len() as i32]),
        ("miplevels", Int, 1) => return ints(&[sub.levels.len() as i32]),
        ("broken" | "UDIM", Int, 1) => return ints(&[0]),
        ("texturetype" | "type", Text, 1) => {
            return Some(Info::Text(if sub.is_environment() { "Environment" } else { "Plain Texture" }.to_owned()));
        }
        ("textureformat", Text, 1) => {
            return Some(Info::Text(sub.text("textureformat").unwrap_or("Plain Texture").to_owned()));
        }
        ("fileformat", Text, 1) => return Some(Info::Text(picture.format.to_owned())),
        ("datawindow", Int, 4 | 6) => return window(sub.origin[0], sub.origin[1], size[0], size[1]),
        ("displaywindow", Int, 4 | 6) => return window(sub.full[0], sub.full[1], sub.full[2], sub.full[3]),
        ("averagecolor", Float, _) => return color(sub.average()),
        ("averagealpha", Float, 1) => return alpha(sub.average()),
        ("constantcolor", Float, _) => return color(sub.constant()),
        ("constantalpha", Float, 1) => return alpha(sub.constant()),
        _ => {}
    }
    match (sub.fact(name)?, ty) {
        (Info::Ints(v), Int) if v.len() == count => Some(Info::Ints(v.clone())),
        (Info::Ints(v), Float) if v.len() == count => Some(Info::Floats(v.iter().map(|i| f64::from(*i)).collect())),
        (Info::Floats(v), Float) if v.len() == count => Some(Info::Floats(v.clone())),
        (Info::Text(text), Text) if count == 1 => Some(Info::Text(text.clone())),
        _ => None,
    }
}
