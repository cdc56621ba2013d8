//! A module's words as bytes, the lowest first: a number each would take twice the room in a file.
//!
//! In: words, a serde format. Out: bytes, and back.

use serde::de::{Deserializer, Error, Visitor};
use serde::ser::Serializer;
use std::fmt;

pub(super) fn serialize<S: Serializer>(words: &[u32], to: S) -> Result<S::Ok, S::Error> {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    to.serialize_bytes(&bytes)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u32>, D::Error> {
    // Owned: readers of streams have no bytes to lend beyond the size of their buffer.
    from.deserialize_byte_buf(Bytes)
}

struct Bytes;

impl Visitor<'_> for Bytes {
    type Value = Vec<u32>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the bytes of words")
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<u32>, E> {
        let (words, rest) = bytes.as_chunks::<4>();
        match rest {
            [] => Ok(words.iter().map(|w| u32::from_le_bytes(*w)).collect()),
            _ => Err(E::invalid_length(bytes.len(), &self)),
        }
    }
}
