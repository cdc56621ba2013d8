//! Names that stand for sets of tiles: UDIM.
//!
//! In: a name with a marker in its last part, folders. Out: the tiles that are there. Tile 1001 + u + 10 v covers s from u to
//! u + 1 and t from v to v + 1; the markers are OpenImageIO's.

use super::Entry;
use std::path::{Path, PathBuf};

/// Tiles of larger numbers are not looked for.
const MAX_SIDE: u32 = 1000;

/// What stands for numbers in a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Marker {
    /// Four digits, 1001 + u + 10 v.
    Udim,
    /// `u` and a number from 0.
    U,
    /// `v` and a number from 0.
    V,
    /// `u` and a number from 1.
    U1,
    /// `v` and a number from 1.
    V1,
}

const MARKERS: [(&str, &[Marker]); 9] = [
    ("<UDIM>", &[Marker::Udim]),
    ("%(UDIM)d", &[Marker::Udim]),
    ("<uvtile>", &[Marker::U, Marker::V]),
    ("<UVTILE>", &[Marker::U1, Marker::V1]),
    ("_u##v##", &[Marker::U, Marker::V]),
    ("<u>", &[Marker::U]),
    ("<v>", &[Marker::V]),
    ("<U>", &[Marker::U1]),
    ("<V>", &[Marker::V1]),
];

/// A piece of a name.
enum Piece<'a> {
    Text(&'a str),
    Number(Marker),
}

/// The set that a name stands for; `None` when it has no marker, or no tile is there.
pub fn find(name: &str, search: &[PathBuf]) -> Option<Entry> {
    let (folder, file) = match name.rsplit_once('/') {
        Some((folder, file)) => (format!("{folder}/"), file),
        None => (String::new(), name),
    };
    let pieces = pieces(file);
    if !pieces.iter().any(|p| matches!(p, Piece::Number(_))) {
        return None;
    }
    let here = if folder.is_empty() { Path::new(".") } else { Path::new(&folder) };
    for place in search.iter().map(|s| s.join(&folder)).chain([here.to_path_buf()]) {
        let mut tiles = Vec::new();
        for entry in std::fs::read_dir(&place).into_iter().flatten().flatten() {
            if let Some(text) = entry.file_name().to_str()
                && let Some((u, v)) = matches(text, &pieces)
                && u < MAX_SIDE
                && v < MAX_SIDE
            {
                tiles.push((u, v, entry.path().to_string_lossy().into_owned()));
            }
        }
        if tiles.is_empty() {
            continue;
        }
        let columns = tiles.iter().map(|t| t.0 + 1).max().unwrap_or(1);
        let rows = tiles.iter().map(|t| t.1 + 1).max().unwrap_or(1);
        let mut files = vec![None; (columns * rows) as usize];
        for (u, v, path) in tiles {
            files[(v * columns + u) as usize] = Some(path);
        }
        return Some(Entry::Tiles { columns, rows, files });
    }
    None
}

fn pieces(file: &str) -> Vec<Piece<'_>> {
    let mut out = Vec::new();
    let mut rest = file;
    'next: while !rest.is_empty() {
        for (i, _) in rest.char_indices() {
            let Some((marker, numbers)) = MARKERS.iter().find(|(m, _)| rest[i..].starts_with(m)) else { continue };
            out.push(Piece::Text(&rest[..i]));
            let between = if marker.eq_ignore_ascii_case("<uvtile>") { "_" } else { "" };
            if marker.starts_with('_') {
                out.push(Piece::Text("_"));
            }
            for (k, number) in numbers.iter().enumerate() {
                if k > 0 {
                    out.push(Piece::Text(between));
                }
                out.push(Piece::Number(*number));
            }
            rest = &rest[i + marker.len()..];
            continue 'next;
        }
        out.push(Piece::Text(rest));
        rest = "";
    }
    out
}

/// Column and row of the tile that a file's name tells.
fn matches(name: &str, pieces: &[Piece<'_>]) -> Option<(u32, u32)> {
    let mut rest = name;
    let (mut u, mut v) = (0, 0);
    for piece in pieces {
        let marker = match piece {
            Piece::Text(text) => {
                rest = rest.strip_prefix(text)?;
                continue;
            }
            Piece::Number(marker) => *marker,
        };
        rest = match marker {
            Marker::Udim => rest,
            Marker::U | Marker::U1 => rest.strip_prefix('u')?,
            Marker::V | Marker::V1 => rest.strip_prefix('v')?,
        };
        let most = if marker == Marker::Udim { 4 } else { 9 };
        let digits = rest.bytes().take(most).take_while(u8::is_ascii_digit).count();
        if digits == 0 || (marker == Marker::Udim && digits != 4) {
            return None;
        }
        let number: u32 = rest[..digits].parse().ok()?;
        rest = &rest[digits..];
        match marker {
            Marker::Udim => {
                let place = number.checked_sub(1001)?;
                (u, v) = (place % 10, place / 10);
            }
            Marker::U => u = number,
            Marker::V => v = number,
            Marker::U1 => u = number.checked_sub(1)?,
            Marker::V1 => v = number.checked_sub(1)?,
        }
    }
    rest.is_empty().then_some((u, v))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_tiles() {
        let of = |pattern: &str, name: &str| matches(name, &pieces(pattern));
        assert_eq!(of("a.<UDIM>.tx", "a.1001.tx"), Some((0, 0)));
        assert_eq!(of("a.<UDIM>.tx", "a.1023.tx"), Some((2, 2)));
        assert_eq!(of("a.<UDIM>.tx", "a.0999.tx"), None);
        assert_eq!(of("a.<UDIM>.tx", "a.10010.tx"), None);
        assert_eq!(of("a_<u>_<v>.tif", "a_u2_v11.tif"), Some((2, 11)));
        assert_eq!(of("a_<U><V>.tif", "a_u2v1.tif"), Some((1, 0)));
        assert_eq!(of("a.<UVTILE>.tif", "a.u1_v3.tif"), Some((0, 2)));
        assert_eq!(of("a_u##v##.tif", "a_u01v02.tif"), Some((1, 2)));
        assert_eq!(of("a.<UDIM>.tx", "b.1001.tx"), None);
    }
}
