//! Where inputs lie: each takes slots of the size of a `real`, one behind the other.
//!
//! In: a shader. Out: for each input its first slot. A triple takes 3 slots, a matrix 16, all else one, an array as many times
//! that as it has elements. An int or a string's id lies in the first four bytes of its slot.

use super::{Const, LocalKind, Shader, Source, Ty};

/// The slots of the inputs of one shader.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InputLayout {
    /// For each input its first slot among those of its kind; `None` for userdata that nothing reads.
    pub first: Vec<Option<u32>>,
    /// Slots of userdata per point.
    pub userdata: u32,
    /// Slots of interactive parameters.
    pub interactive: u32,
}

/// Slots of an element.
pub fn slots_of(ty: Ty) -> u32 {
    match ty {
        Ty::Triple => 3,
        Ty::Matrix => 16,
        _ => 1,
    }
}

impl InputLayout {
    /// Lays out the inputs: userdata that is read, and every interactive parameter, so that its place does not hang on what
    /// the passes could drop.
    pub fn of(shader: &Shader) -> InputLayout {
        let mut read = vec![false; shader.inputs.len()];
        for local in &shader.locals {
            if let LocalKind::Input(i) = local.kind
                && let Some(flag) = read.get_mut(i as usize)
            {
                *flag = true;
            }
        }
        // Who only asks whether there is a value names the value, too, so that the renderer knows what is asked for.
        for i in 0..read.len() {
            let input = &shader.inputs[i];
            if read[i] && input.source == Source::HasUserdata {
                let value = |other: &super::Input| other.source == Source::Userdata && other.name == input.name;
                if let Some(of) = shader.inputs.iter().position(value) {
                    read[of] = true;
                }
            }
        }
        let mut layout = InputLayout::default();
        for (input, read) in shader.inputs.iter().zip(read) {
            let total = match input.source {
                Source::Userdata | Source::HasUserdata if !read => {
                    layout.first.push(None);
                    continue;
                }
                Source::Userdata | Source::HasUserdata => &mut layout.userdata,
                Source::Interactive | Source::HasInteractive => &mut layout.interactive,
            };
            layout.first.push(Some(*total));
            *total += slots_of(input.ty) * input.len.unwrap_or(1);
        }
        layout
    }
}

/// A constant's numbers, one per slot; strings by their ids.
pub fn numbers(c: &Const, out: &mut Vec<f64>) {
    match c {
        Const::Int(v) => out.push(f64::from(*v)),
        Const::Float(v) => out.push(*v),
        Const::Triple(v) => out.extend(v),
        Const::Matrix(m) => out.extend(m),
        Const::Str(s) => out.push(f64::from(crate::strings::string_id(s) as i32)),
        Const::Array(items) => items.iter().for_each(|c| numbers(c, out)),
    }
}
