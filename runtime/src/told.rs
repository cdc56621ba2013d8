//! What materials said while a scene was rendered.
//!
//! In: the records of a render, the materials' artifacts. Out: each text once, with how often it was said. The order of the
//! paths is none that a reader would know, so texts are sorted. It must not know devices.

use crate::materials::Compiled;
use crate::scene::Scene;
use oslcl_compiler::messages::{self, Damaged, Kind, Message};
use std::collections::BTreeMap;

/// One text of one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Told {
    /// Name of the material.
    pub material: String,
    /// What said it.
    pub kind: Kind,
    /// The text.
    pub text: String,
    /// How often.
    pub count: u64,
}

/// Everything that was said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Messages {
    /// By material, then kind, then text.
    pub told: Vec<Told>,
    /// Bytes of records for which there was no room.
    pub lost_bytes: u64,
}

/// What displacement shaders said, while there is more to come.
#[derive(Debug, Default)]
pub(crate) struct Heard {
    counts: BTreeMap<(String, Kind, String), u64>,
    /// Bytes of records for which there was no room.
    pub lost_bytes: u64,
}

impl Heard {
    /// Adds one that a material said.
    pub fn add(&mut self, material: &str, message: Message) {
        *self.counts.entry((material.to_owned(), message.kind, message.text)).or_default() += 1;
    }

    /// Adds all of it to what was said while rendering.
    pub fn give(&self, messages: &mut Messages) {
        messages.lost_bytes += self.lost_bytes;
        let told = self.counts.iter().map(|((material, kind, text), count)| Told {
            material: material.clone(),
            kind: kind.clone(),
            text: text.clone(),
            count: *count,
        });
        messages.told.extend(told);
    }
}

/// Sorts and counts the records, whose points are numbers of materials.
pub(crate) fn collect(
    words: &[u32],
    lost_bytes: u64,
    scene: &Scene,
    compiled: &Compiled,
    strings: &[String],
) -> Result<Messages, Damaged> {
    let mut of_material: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for record in messages::records(words)? {
        of_material.entry(record[1]).or_default().extend(record);
    }
    let mut out = Messages { told: Vec::new(), lost_bytes };
    for (number, words) in of_material {
        let material = scene.materials.get(number as usize).ok_or(Damaged)?;
        let artifact = compiled.artifacts.get(number as usize).and_then(Option::as_ref).ok_or(Damaged)?;
        let mut counts: BTreeMap<(Kind, String), u64> = BTreeMap::new();
        for message in artifact.decoder(strings).messages(&words)? {
            *counts.entry((message.kind, message.text)).or_default() += 1;
        }
        out.told.extend(counts.into_iter().map(|((kind, text), count)| Told {
            material: material.name.clone(),
            kind,
            text,
            count,
        }));
    }
    Ok(out)
}
