//! What rays that shaders trace need to know of objects: to which sets they belong, and what they are called.
//!
//! In: a scene, the artifacts that ask. Out: the buffers that kernels/traces.h reads. An object is in the sets that its attribute
//! `traceset` names (looked for as `getattribute` does) and in the one of its own name; `-NAME` is the set of all others. Its
//! name is its attribute `geom:name`, else its mesh's. It must not know devices.

use crate::attributes;
use crate::scene::{ParamValue, Scene};
use oslcl_compiler::Artifact;
use oslcl_compiler::strings::string_id;
use std::collections::BTreeSet;

/// The attribute that names an object's sets.
const SETS: &str = "traceset";

/// The attribute that names an object.
const NAME: &str = "geom:name";

/// Words for the device.
#[derive(Debug, Default)]
pub(crate) struct Traced {
    /// How many sets there are, their strings' ids, then for each shape their bits, in whole words.
    pub sets: Vec<u32>,
    /// The id of each shape's name.
    pub names: Vec<u32>,
}

/// All sets that the shaders trace.
fn asked(artifacts: &[Option<Artifact>]) -> BTreeSet<&str> {
    artifacts.iter().flatten().flat_map(|a| a.traces.sets.iter().map(String::as_str)).collect()
}

/// Fills the buffers.
pub(crate) fn build(scene: &Scene, artifacts: &[Option<Artifact>]) -> Traced {
    let sets = asked(artifacts);
    let mut out = Traced { sets: vec![sets.len() as u32], names: Vec::new() };
    out.sets.extend(sets.iter().map(|name| string_id(name)));
    for instance in 0..scene.instances.len() {
        let bits: Vec<bool> = sets.iter().map(|set| has(scene, instance, set)).collect();
        out.sets.extend(bits.chunks(32).map(|c| c.iter().rev().fold(0, |word, bit| word << 1 | u32::from(*bit))));
        out.names.push(string_id(name(scene, instance)));
    }
    out
}

/// What an object is called.
fn name(scene: &Scene, instance: usize) -> &str {
    match attributes::of_instance(scene, instance, NAME) {
        Some(ParamValue::Str(name)) => name,
        _ => &scene.meshes[scene.instances[instance].mesh.0 as usize].name,
    }
}

/// The names of all objects: shaders may print them.
pub(crate) fn names(scene: &Scene) -> impl Iterator<Item = String> + '_ {
    (0..scene.instances.len()).map(|i| name(scene, i).to_owned())
}

/// Whether rays for this set meet the object.
fn has(scene: &Scene, instance: usize, set: &str) -> bool {
    if let Some(others) = set.strip_prefix('-') {
        return !is_in(scene, instance, others);
    }
    is_in(scene, instance, set)
}

fn is_in(scene: &Scene, instance: usize, set: &str) -> bool {
    let named = match attributes::of_instance(scene, instance, SETS) {
        Some(ParamValue::Str(one)) => one == set,
        Some(ParamValue::Strs(list)) => list.iter().any(|one| one == set),
        _ => false,
    };
    named || name(scene, instance) == set
}

/// What is odd about the sets that shaders trace: those that nothing is in.
pub(crate) fn warnings<'a>(scene: &'a Scene, artifacts: &'a [Option<Artifact>]) -> impl Iterator<Item = String> + 'a {
    let sets = asked(artifacts).into_iter().map(|set| set.strip_prefix('-').unwrap_or(set));
    let empty = sets.filter(|set| (0..scene.instances.len()).all(|i| !is_in(scene, i, set)));
    empty.map(|set| {
        format!("warning: `trace` asks for the set \"{set}\", but no object's attribute `{SETS}` names it\n")
    })
}
