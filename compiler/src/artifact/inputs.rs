//! What a renderer supplies to a shader beside the globals: userdata of the geometry, and interactive parameters.
//!
//! In: optimised IR. Out: names, types and places.

use crate::ir::{Const, InputLayout, Shader, Source, numbers, slots_of};
use crate::types::{Base, Type};
use serde::{Deserialize, Serialize};

/// A value among the slots: `reals` slots of the size of a `real` from `offset` on (kernels/globals.h). Ints and the ids of
/// strings lie in the first four bytes of their slots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slot {
    /// Of userdata its name; of an interactive parameter its flattened name, in a group with its layer in front
    /// (`layer.param`).
    pub name: String,
    /// Its type in OSL's words, such as `color` or `float[4]`.
    #[serde(rename = "type")]
    pub ty: String,
    /// The type itself.
    #[serde(skip, default = "Type::nothing")]
    pub resolved: Type,
    /// The first slot.
    pub offset: u32,
    /// How many slots.
    pub reals: u32,
    /// The slot of an int that says whether the value is there; `None`: it always is. Where it is not, the parameter has
    /// its default.
    pub has: Option<u32>,
    /// What an interactive parameter starts with, a number per slot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub default: Vec<f64>,
}

impl Slot {
    /// Whether its slots hold ints (or strings, by their ids).
    pub fn is_int(&self) -> bool {
        matches!(self.resolved.base, Base::Int | Base::String)
    }
}

/// The inputs of a shader.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Userdata that the code reads, for each point.
    pub userdata: Vec<Slot>,
    /// Slots that `ShaderGlobals.userdata` points to.
    pub userdata_slots: u32,
    /// Interactive parameters, the same for all points.
    pub interactive: Vec<Slot>,
    /// Slots that `ShaderGlobals.interactive` points to.
    pub interactive_slots: u32,
}

pub(super) fn of(shader: &Shader) -> Inputs {
    let layout = InputLayout::of(shader);
    let mut inputs =
        Inputs { userdata_slots: layout.userdata, interactive_slots: layout.interactive, ..Inputs::default() };
    let flag = |name: &str, source: Source| {
        let index = shader.inputs.iter().position(|i| i.source == source && i.name == name)?;
        layout.first[index]
    };
    for (input, first) in shader.inputs.iter().zip(&layout.first) {
        let Some(offset) = *first else { continue };
        let (list, has) = match input.source {
            Source::Userdata => (&mut inputs.userdata, Source::HasUserdata),
            Source::Interactive => (&mut inputs.interactive, Source::HasInteractive),
            _ => continue,
        };
        let length = input.len.map_or(String::new(), |n| format!("[{n}]"));
        let mut default = Vec::new();
        if let Some(c) = &input.default {
            numbers(c, &mut default);
        }
        list.push(Slot {
            name: input.name.clone(),
            ty: format!("{}{length}", input.declared.base.keyword()),
            resolved: input.declared,
            offset,
            reals: slots_of(input.ty) * input.len.unwrap_or(1),
            has: flag(&input.name, has),
            default,
        });
    }
    inputs
}

/// The strings of the code with those that interactive parameters start with.
pub(super) fn strings(shader: &Shader, mut strings: Vec<String>) -> Vec<String> {
    for input in &shader.inputs {
        match &input.default {
            Some(Const::Str(s)) => strings.push(s.clone()),
            Some(Const::Array(items)) => strings.extend(items.iter().filter_map(|c| match c {
                Const::Str(s) => Some(s.clone()),
                _ => None,
            })),
            _ => {}
        }
    }
    strings.sort();
    strings.dedup();
    strings
}
