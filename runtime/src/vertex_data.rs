//! Userdata of a render: what meshes have at their vertices, and attributes that differ from object to object.
//!
//! In: a scene, the artifacts that ask. Out: what the compiler may count on, the buffers that kernels/userdata.h reads and the
//! functions that read them. It must not know devices.

use crate::attributes;
use crate::scene::{Mesh, MeshId, Scene};
use oslcl_compiler::artifact::Slot;
use oslcl_compiler::attributes::asked;
use oslcl_compiler::types::{Base, Extent, Type};
use oslcl_compiler::{Artifact, Userdata};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Stride of what a shape lacks, as in kernels/userdata.h.
const ABSENT: u32 = u32::MAX;

/// Userdata that the surfaces with this material have.
pub(crate) fn declared(scene: &Scene, material: usize) -> Vec<Userdata> {
    let placed = scene.instances.iter().filter(|i| i.material.0 as usize == material);
    let meshes: Vec<&Mesh> = placed.map(|i| &scene.meshes[i.mesh.0 as usize]).collect();
    let mut names: Vec<(&str, u32)> = Vec::new();
    let coordinates = [("u", 1), ("v", 1), ("s", 1), ("t", 1), ("st", 2), ("st", 3), ("uv", 2), ("uv", 3)];
    let own = meshes.iter().flat_map(|m| m.data.iter().map(|d| (d.name.as_str(), d.channels)));
    for name in coordinates.into_iter().chain(own) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut out = Vec::new();
    for (name, channels) in names {
        let with = meshes.iter().filter(|m| values(m, name, channels).is_some()).count();
        if with == 0 {
            continue;
        }
        let sometimes = with < meshes.len();
        let same_as = match name {
            // A file's data of that name counts more than the coordinates.
            _ if sometimes || meshes.iter().any(|m| m.data.iter().any(|d| d.name == name)) => None,
            "u" | "s" => Some("u".to_owned()),
            "v" | "t" => Some("v".to_owned()),
            _ => None,
        };
        let add = |ty: Type| Userdata { name: name.to_owned(), ty, sometimes, same_as: same_as.clone() };
        match channels {
            1 => out.push(add(Type::scalar(Base::Float))),
            3 => out.extend([add(Type::scalar(Base::Color)), add(of_array(3))]),
            n => out.push(add(of_array(n))),
        }
    }
    out
}

fn of_array(len: u32) -> Type {
    Type { base: Base::Float, extent: Extent::Fixed(len) }
}

/// The numbers of a mesh's vertices, so many each.
fn values<'a>(mesh: &'a Mesh, name: &str, channels: u32) -> Option<Cow<'a, [f32]>> {
    if let Some(data) = mesh.data.iter().find(|d| d.name == name && d.channels == channels) {
        return Some(Cow::Borrowed(&data.values));
    }
    let uvs = || Some(mesh.uvs.iter()).filter(|uvs| uvs.len() > 0);
    Some(Cow::Owned(match (name, channels) {
        ("u" | "s", 1) => uvs()?.map(|t| t.x).collect(),
        ("v" | "t", 1) => uvs()?.map(|t| t.y).collect(),
        ("st" | "uv", 2) => uvs()?.flat_map(|t| [t.x, t.y]).collect(),
        ("st" | "uv", 3) => uvs()?.flat_map(|t| [t.x, t.y, 0.0]).collect(),
        _ => return None,
    }))
}

/// What a placed mesh has for a slot.
enum Found<'a> {
    /// So many numbers per vertex as the slot has.
    Vertices(Cow<'a, [f32]>),
    /// The same everywhere; ints by their bits.
    Constant(Vec<f32>),
}

fn found<'a>(scene: &'a Scene, instance: usize, slot: &Slot) -> Option<Found<'a>> {
    if is_attribute(slot) {
        let value = attributes::at_instance(scene, instance, &slot.name)?;
        let number = |v: f64| if slot.is_int() { f32::from_bits(v as i32 as u32) } else { v as f32 };
        return Some(Found::Constant(value.numbers(slot)?.into_iter().map(number).collect()));
    }
    let mesh = &scene.meshes[scene.instances[instance].mesh.0 as usize];
    values(mesh, &slot.name, slot.reals).map(Found::Vertices)
}

/// Whether a slot holds an attribute, not data of vertices.
pub(crate) fn is_attribute(slot: &Slot) -> bool {
    asked(&slot.name).is_some()
}

/// Columns of the table: one for each slot of each material, in order.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// Numbers, ints by their bits.
    pub values: Vec<f32>,
    /// Per shape and column where its numbers begin and how far those of two vertices are apart.
    pub places: Vec<u32>,
}

/// Slots of all materials, as the columns of the table stand.
fn columns(artifacts: &[Option<Artifact>]) -> Vec<&Slot> {
    let mut out: Vec<&Slot> = Vec::new();
    for slot in artifacts.iter().flatten().flat_map(|a| &a.inputs.userdata) {
        if !out.iter().any(|other| is_same(other, slot)) {
            out.push(slot);
        }
    }
    out
}

fn is_same(a: &Slot, b: &Slot) -> bool {
    (&a.name, a.reals, a.is_int()) == (&b.name, b.reals, b.is_int())
}

/// Numbers in the table, at most: places are 32 bits wide.
const MOST: u64 = u32::MAX as u64;

/// Fills the table. `first_vertices`: by shape, what the kernels' corners count from.
pub(crate) fn table(scene: &Scene, artifacts: &[Option<Artifact>], first_vertices: &[u32]) -> Result<Table, TooMuch> {
    let columns = columns(artifacts);
    let mut table = Table::default();
    let mut seen: HashMap<MeshId, usize> = HashMap::new();
    for (instance, first) in first_vertices.iter().enumerate() {
        let before = *seen.entry(scene.instances[instance].mesh).or_insert(instance);
        for (c, slot) in columns.iter().enumerate() {
            // A shared mesh has its numbers once.
            if before != instance && !is_attribute(slot) {
                let at = 2 * (before * columns.len() + c);
                table.places.extend_from_within(at..at + 2);
                continue;
            }
            let (values, stride) = match found(scene, instance, slot) {
                None => {
                    table.places.extend([0, ABSENT]);
                    continue;
                }
                Some(Found::Vertices(values)) => (values, slot.reals),
                Some(Found::Constant(values)) => (Cow::Owned(values), 0),
            };
            let at = table.values.len() as u32;
            // It may wrap; corners bring it back.
            table.places.extend([at.wrapping_sub(first.wrapping_mul(stride)), stride]);
            table.values.extend_from_slice(&values);
            if table.values.len() as u64 > MOST {
                return Err(TooMuch);
            }
        }
    }
    Ok(table)
}

/// More userdata than can be numbered.
#[derive(Debug, thiserror::Error)]
#[error("the userdata of the scene's vertices is more than 2^32 numbers")]
pub struct TooMuch;

/// The function that fills a point's slots for an artifact; empty when it has none. Slots that do not count are as those of
/// which a shape has nothing.
pub(crate) fn code(artifact: &Artifact, artifacts: &[Option<Artifact>], counts: &dyn Fn(&Slot) -> bool) -> String {
    let inputs = &artifact.inputs;
    if inputs.userdata_slots == 0 {
        return String::new();
    }
    let columns = columns(artifacts);
    let any = inputs.userdata.iter().any(counts);
    let header = if any { "userdata.h" } else { "context.h" };
    let mut text = format!(
        "\n#define USERDATA_COLUMNS {}u\n#include \"{header}\"\n\
         static inline void material_userdata(const Context *c, uint shape, __global const uint *corner, real u, real v, \
         real *slots)\n{{\n    int found;\n    uchar *bytes;\n",
        columns.len()
    );
    for slot in &inputs.userdata {
        let column = columns.iter().position(|c| is_same(c, slot)).unwrap_or(0);
        if !counts(slot) {
            // By bytes: a store of reals need not reach what is read as an int.
            let (first, count) = (slot.offset, slot.reals);
            let _ = writeln!(text, "    bytes = (uchar *)(slots + {first});");
            let _ = writeln!(text, "    for (uint i = 0; i < {count}u * sizeof(real); i++) bytes[i] = 0;");
            if let Some(has) = slot.has {
                let _ = writeln!(text, "    *(int *)(slots + {has}) = 0;");
            }
            continue;
        }
        let read = if slot.is_int() { "userdata_ints" } else { "userdata_reals" };
        let _ = writeln!(
            text,
            "    found = {read}(c, shape, {column}u, {}u, corner, u, v, slots + {});",
            slot.reals, slot.offset
        );
        if let Some(has) = slot.has {
            let _ = writeln!(text, "    *(int *)(slots + {has}) = found;");
        }
    }
    text.push_str("}\n");
    text
}

/// The slots of a mesh's vertices for a shader that runs there: a number each, and whether it is an int.
pub(crate) fn at_vertices(scene: &Scene, instance: usize, artifact: &Artifact) -> Vec<Vec<(f64, bool)>> {
    let inputs = &artifact.inputs;
    let count = scene.meshes[scene.instances[instance].mesh.0 as usize].positions.len();
    let mut out = vec![vec![(0.0, false); inputs.userdata_slots as usize]; count];
    for slot in &inputs.userdata {
        let found = found(scene, instance, slot);
        for (vertex, slots) in out.iter_mut().enumerate() {
            if let Some(flag) = slot.has.and_then(|has| slots.get_mut(has as usize)) {
                *flag = (f64::from(u8::from(found.is_some())), true);
            }
            let reals = slot.reals as usize;
            let values = match &found {
                None => continue,
                Some(Found::Vertices(all)) => &all[vertex * reals..(vertex + 1) * reals],
                Some(Found::Constant(values)) => values,
            };
            for (i, value) in values.iter().enumerate() {
                let number = if slot.is_int() { f64::from(value.to_bits() as i32) } else { f64::from(*value) };
                slots[slot.offset as usize + i] = (number, slot.is_int());
            }
        }
    }
    out
}
