//! Reads of what the renderer supplies beside the globals, as OpenCL C: slots behind `sg->userdata` and `sg->interactive`.
//!
//! In: an input of the shader. Out: text. Offsets are those of [`InputLayout`].

use crate::ir::{InputLayout, Shader, Source, Ty};

/// Where an input lies: the text of a pointer to its first slot, and the address space.
pub(super) fn pointer(shader: &Shader, layout: &InputLayout, input: u32) -> (String, &'static str) {
    let first = layout.first.get(input as usize).copied().flatten().unwrap_or(0);
    match shader.inputs.get(input as usize).map(|i| i.source) {
        Some(Source::Interactive | Source::HasInteractive) => (format!("sg->interactive + {first}"), "__global "),
        _ => (format!("sg->userdata + {first}"), ""),
    }
}

/// The value behind a pointer into the slots, and the helper of kernels/osl/ that the text calls, if any.
pub(super) fn read(pointer: &str, space: &str, ty: Ty) -> (String, Option<&'static str>) {
    match ty {
        Ty::Float => (format!("*({pointer})"), None),
        Ty::Triple => (format!("vload3(0, {pointer})"), None),
        Ty::Matrix => {
            let loader = if space.is_empty() { "op_load_slots_m" } else { "op_load_global_m" };
            (format!("{loader}({pointer})"), Some(loader))
        }
        _ => (format!("*({space}const int *)({pointer})"), None),
    }
}
