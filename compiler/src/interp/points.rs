//! Point clouds on the host: the rows' arguments become questions, and whoever reads files answers them.
//!
//! In: the rows that `lower::points` writes. Out: their values, and the elements of arrays that they write. It must not know files.

use crate::ir::Const;
use crate::points::{PointClouds, Values};
use crate::textures::TextureAccess;

fn clouds(access: Option<&TextureAccess>) -> Option<&dyn PointClouds> {
    access.and_then(|a| a.0.clouds())
}

/// `cloud_count`; `None` when it is another row.
pub(super) fn count(name: &str, args: &[Const], access: Option<&TextureAccess>) -> Option<Const> {
    let ("cloud_count", [Const::Str(file), Const::Triple(at), Const::Float(radius), Const::Int(most)]) = (name, args)
    else {
        return None;
    };
    let found = clouds(access).map_or(0, |c| c.search(file, *at, *radius, usize::try_from(*most).unwrap_or(0)).len());
    Some(Const::Int(found as i32))
}

/// What a row that writes to arrays gives, and the first elements of each. `rooms`: how long they are; `like`: an element of the
/// first.
pub(super) fn call(
    name: &str,
    args: &[Const],
    rooms: &[usize],
    like: Option<&Const>,
    access: Option<&TextureAccess>,
) -> Option<(Const, Vec<Vec<Const>>)> {
    match (name, args) {
        ("cloud_search", [Const::Str(file), Const::Triple(at), Const::Float(radius), Const::Int(most)]) => {
            let most = usize::try_from(*most).unwrap_or(0).min(rooms.iter().copied().min().unwrap_or(0));
            let found = clouds(access).map_or_else(Vec::new, |c| c.search(file, *at, *radius, most));
            let (indices, distances) = found.iter().map(|(i, d)| (Const::Int(*i), Const::Float(*d))).unzip();
            Some((Const::Int(found.len() as i32), vec![indices, distances]))
        }
        ("cloud_get", [Const::Str(file), Const::Array(indices), Const::Int(count), Const::Str(attribute)]) => {
            let count = usize::try_from(*count).unwrap_or(0).min(indices.len());
            let room = rooms.first().copied().unwrap_or(0);
            let indices = indices[..count].iter().map(|i| if let Const::Int(i) = i { *i } else { -1 });
            let values = clouds(access).map_or(Some(Vec::new()), |c| {
                let each = indices.map(|i| elements(c.get(file, i, attribute)?, like?));
                each.collect::<Option<Vec<Vec<Const>>>>()
            });
            let found = values.is_some() && (count == 0 || clouds(access).is_some());
            // Only whole points.
            let mut out = Vec::new();
            for value in values.into_iter().flatten() {
                if out.len() + value.len() <= room {
                    out.extend(value);
                }
            }
            Some((Const::Int(found.into()), vec![out]))
        }
        _ => None,
    }
}

/// The elements of an array that one point fills; `None` where the types differ.
fn elements(values: Values, like: &Const) -> Option<Vec<Const>> {
    Some(match (values, like) {
        (Values::Ints(list), Const::Int(_)) => list.into_iter().map(Const::Int).collect(),
        (Values::Floats(list), Const::Float(_)) => list.into_iter().map(Const::Float).collect(),
        (Values::Triple(t), Const::Triple(_)) => vec![Const::Triple(t)],
        (Values::Text(s), Const::Str(_)) => vec![Const::Str(s)],
        _ => return None,
    })
}
