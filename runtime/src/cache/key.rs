//! The name of a program: a hash of all that decides what the driver makes of it.
//!
//! In: texts and words. Out: [`Key`]. It must not know where they come from.

use std::fmt;

/// All that decides a program's binary.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parts<'a> {
    /// The whole source text, headers in place.
    pub source: &'a str,
    /// Build options.
    pub options: &'a str,
    /// How code gets to the driver, with the versions of tools on the way.
    pub road: &'a str,
    /// SPIR-V modules that are linked with the source.
    pub modules: &'a [&'a [u32]],
    /// The device and its driver: names, versions, and what else changes the code.
    pub device: &'a [String],
    /// Version of this program, which decides how the driver is called.
    pub version: &'a str,
}

/// Names an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key(blake3::Hash);

impl Key {
    /// The key of a program.
    pub fn new(parts: &Parts) -> Key {
        let mut hasher = blake3::Hasher::new();
        // With its length in front, no two lists of parts give the same bytes.
        let mut part = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
        };
        for text in [parts.source, parts.options, parts.road, parts.version] {
            part(text.as_bytes());
        }
        part(&(parts.device.len() as u64).to_le_bytes());
        for text in parts.device {
            part(text.as_bytes());
        }
        for module in parts.modules {
            let bytes: Vec<u8> = module.iter().flat_map(|w| w.to_le_bytes()).collect();
            part(&bytes);
        }
        Key(hasher.finalize())
    }

    /// The key that a file's name says; `None` for other names.
    pub(super) fn parse(hex: &str) -> Option<Key> {
        blake3::Hash::from_hex(hex).ok().map(Key)
    }

    pub(super) fn bytes(&self) -> &[u8; 32] {
        self.0.as_bytes()
    }
}

impl fmt::Display for Key {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0.to_hex())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_part_changes_the_key() {
        let device = ["CPU".to_owned(), "1.0".to_owned()];
        let moved = ["CPU1".to_owned(), ".0".to_owned()];
        let module: &[&[u32]] = &[&[1, 2, 3]];
        let split: &[&[u32]] = &[&[1], &[2, 3]];
        let base = Parts { source: "s", options: "o", road: "r", modules: module, device: &device, version: "1" };
        let all = [
            base,
            Parts { source: "s ", ..base },
            Parts { options: "o ", ..base },
            Parts { source: "so", options: "", ..base },
            Parts { road: "q", ..base },
            Parts { modules: &[], ..base },
            Parts { modules: split, ..base },
            Parts { device: &device[..1], ..base },
            Parts { device: &moved, ..base },
            Parts { version: "2", ..base },
        ];
        let keys: HashSet<Key> = all.iter().map(Key::new).collect();
        assert_eq!(keys.len(), all.len());
        assert_eq!(Key::new(&base), Key::new(&base.clone()));
        assert_eq!(Key::parse(&Key::new(&base).to_string()), Some(Key::new(&base)));
        assert_eq!(Key::parse("other"), None);
    }
}
