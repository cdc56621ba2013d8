//! The form of an entry: a header and a driver's binary.
//!
//! In: a key and a binary, or a file's bytes. Out: the other. It must not know files.
//!
//! Magic (8 bytes), version of this form (4), length of the binary (8), BLAKE3 of key and binary (32), binary. Integers are
//! little-endian. The key is part of the checksum, so that an entry under another's name is damage like any other.

use super::Key;
use std::fmt;

const MAGIC: &[u8; 8] = b"oslclbin";
const VERSION: u32 = 1;
const HEADER: usize = 8 + 4 + 8 + 32;

/// What is wrong with an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// Too short for a header, or it does not begin like an entry.
    Foreign,
    /// Another version of the form.
    Version(u32),
    /// More or fewer bytes than the header says.
    Length,
    /// Other bytes than were written.
    Checksum,
    /// No file at all: a folder stands in its place.
    Folder,
}

impl fmt::Display for Damage {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Damage::Foreign => out.write_str("it does not begin like an entry"),
            Damage::Version(found) => write!(out, "it has version {found} of the form, not {VERSION}"),
            Damage::Length => out.write_str("it is longer or shorter than it says"),
            Damage::Checksum => out.write_str("its checksum is wrong"),
            Damage::Folder => out.write_str("a folder stands in its place"),
        }
    }
}

/// The bytes of an entry.
pub(super) fn encode(key: &Key, binary: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER + binary.len());
    out.extend(MAGIC);
    out.extend(VERSION.to_le_bytes());
    out.extend((binary.len() as u64).to_le_bytes());
    out.extend(checksum(key, binary).as_bytes());
    out.extend(binary);
    out
}

/// The binary in the bytes of an entry.
pub(super) fn decode<'a>(key: &Key, bytes: &'a [u8]) -> Result<&'a [u8], Damage> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(Damage::Foreign)?;
    let (version, rest) = rest.split_first_chunk().ok_or(Damage::Foreign)?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return Err(Damage::Version(version));
    }
    let (length, rest) = rest.split_first_chunk().ok_or(Damage::Foreign)?;
    let (sum, binary) = rest.split_first_chunk::<32>().ok_or(Damage::Foreign)?;
    if binary.len() as u64 != u64::from_le_bytes(*length) {
        return Err(Damage::Length);
    }
    if checksum(key, binary) != blake3::Hash::from(*sum) {
        return Err(Damage::Checksum);
    }
    Ok(binary)
}

fn checksum(key: &Key, binary: &[u8]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(key.bytes()).update(binary);
    hasher.finalize()
}
