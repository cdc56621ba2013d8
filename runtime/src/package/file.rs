//! The bytes of a package: a header that says what they are, and that they are whole.
//!
//! In: contents. Out: the file's bytes; or of a file's bytes the contents, when they are those of a package for this version of
//! oslcl. All numbers are little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 0..8 | `89 "OSLPAK" 0A`, which no text begins with, and which a transfer as text would spoil |
//! | 8..12 | version of this format |
//! | 12..16 | version of the interface between artifacts and kernels (`oslcl_compiler::artifact::ABI_VERSION`) |
//! | 16..24 | length of the contents |
//! | 24..56 | BLAKE3 of the bytes before it and the contents |
//! | 56.. | the contents: the length of the table in 8 bytes, the table, one part for each shader; all CBOR |
//!
//! It must not know shaders.

use super::Error;
use oslcl_compiler::artifact::ABI_VERSION;
use serde::Serialize;
use std::path::Path;

/// What every package begins with.
pub const MAGIC: [u8; 8] = *b"\x89OSLPAK\n";

/// Version of the format.
pub const FORMAT: u32 = 1;

/// Bytes before the contents.
pub const HEADER: usize = 56;

/// Bytes of the header that the checksum covers.
const CHECKED: usize = 24;

/// Contents with a header, for artifacts of this interface.
pub fn seal(abi: u32, contents: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER + contents.len());
    out.extend(MAGIC);
    out.extend(FORMAT.to_le_bytes());
    out.extend(abi.to_le_bytes());
    out.extend((contents.len() as u64).to_le_bytes());
    let checksum = checksum(&out, contents);
    out.extend(checksum);
    out.extend(contents);
    out
}

fn checksum(header: &[u8], contents: &[u8]) -> [u8; 32] {
    *blake3::Hasher::new().update(header).update(contents).finalize().as_bytes()
}

/// The contents of a package; `path` is for messages. What is wrong is said in this order: another kind of file, another format,
/// too short or too long, damaged, another interface.
pub fn open<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8], Error> {
    let path = || path.to_owned();
    let truncated = |wanted: u64| Error::Truncated { path: path(), bytes: bytes.len() as u64, wanted };
    let Some(rest) = bytes.strip_prefix(&MAGIC) else {
        // The beginning of the beginning.
        return Err(match !bytes.is_empty() && MAGIC.starts_with(bytes) {
            true => truncated(HEADER as u64),
            false => Error::NotPackage { path: path(), begins: beginning(bytes) },
        });
    };
    let number = |at: usize| Some(u32::from_le_bytes(*rest.get(at..)?.first_chunk()?));
    let format = number(0).ok_or_else(|| truncated(HEADER as u64))?;
    if format != FORMAT {
        return Err(Error::Format { path: path(), found: format, known: FORMAT });
    }
    let abi = number(4).ok_or_else(|| truncated(HEADER as u64))?;
    let length = rest.get(8..).and_then(|r| r.first_chunk()).map(|b| u64::from_le_bytes(*b));
    let (Some(length), Some(contents)) = (length, bytes.get(HEADER..)) else { return Err(truncated(HEADER as u64)) };
    let has = contents.len() as u64;
    if has < length {
        return Err(truncated(length.saturating_add(HEADER as u64)));
    }
    if has > length {
        return Err(Error::TooLong { path: path(), more: has - length });
    }
    if bytes[CHECKED..HEADER] != checksum(&bytes[..CHECKED], contents) {
        return Err(Error::Damaged { path: path() });
    }
    if abi != ABI_VERSION {
        return Err(Error::Abi { path: path(), found: abi, known: ABI_VERSION });
    }
    Ok(contents)
}

/// What a file begins with, for messages.
fn beginning(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(8)];
    match std::str::from_utf8(start) {
        _ if start.is_empty() => "it is empty".to_owned(),
        Ok(text) => format!("it begins with {text:?}"),
        Err(_) => format!("it begins with the bytes {start:02x?}"),
    }
}

/// A value as CBOR.
pub(super) fn encoded(value: &impl Serialize) -> Vec<u8> {
    let mut out = Vec::new();
    // Memory takes what it is given, and nothing that is written here has a form that CBOR lacks.
    let _ = ciborium::into_writer(value, &mut out);
    out
}

/// Table and bodies as contents.
pub(super) fn join(table: &[u8], bodies: &[u8]) -> Vec<u8> {
    let mut out = (table.len() as u64).to_le_bytes().to_vec();
    out.extend(table);
    out.extend(bodies);
    out
}

/// Table and bodies of contents.
pub(super) fn split(contents: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = contents.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_damage_is_told() {
        let bytes = seal(ABI_VERSION, b"some contents");
        let open = |bytes: &[u8]| super::open(Path::new("a.oslpak"), bytes).map(<[u8]>::to_vec);
        assert_eq!(open(&bytes).expect("it is whole"), b"some contents");
        for length in 0..bytes.len() {
            let error = open(&bytes[..length]).expect_err("it is cut off");
            match error {
                Error::NotPackage { .. } => assert_eq!(length, 0),
                Error::Truncated { bytes: has, .. } => assert_eq!(has, length as u64),
                other => panic!("{length}: {other}"),
            }
        }
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut wrong = bytes.clone();
                wrong[at] ^= 1 << bit;
                assert!(open(&wrong).is_err(), "byte {at}, bit {bit}");
            }
        }
        assert!(matches!(open(&[&bytes[..], b"x"].concat()), Err(Error::TooLong { more: 1, .. })));
        let other = open(&seal(ABI_VERSION + 1, b"")).expect_err("of another interface");
        assert!(matches!(other, Error::Abi { found, .. } if found == ABI_VERSION + 1), "{other}");
    }
}
