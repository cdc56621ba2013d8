//! Lobes' constructors as calls of OpenCL C.
//!
//! In: a closure's row and its arguments as text. Out: the call's text, its header. The functions live in kernels/bsdf/NAME.h.

use super::names::lobe_constructor;
use crate::builtins::{self, ClosureId};
use crate::ir::{Const, LobeSlot, SlotArg};

/// An argument: its text, and whether it is the constant 0.
pub(super) struct Argument {
    pub text: String,
    pub is_zero: bool,
}

/// Whether a constant is the float 0.
pub(super) fn is_zero(c: &Const) -> bool {
    matches!(c, Const::Float(x) if *x == 0.0)
}

/// Whether the arguments put a film on the lobe: its thickness is not the constant 0.
pub(crate) fn has_film(id: ClosureId, thickness_is_zero: impl Fn(usize) -> bool) -> bool {
    builtins::closure(id).takes_film() && !thickness_is_zero(builtins::sig::closure_arity(id) - 2)
}

/// Whether a slot's lobe lies under a film.
pub(crate) fn slot_has_film(slot: &LobeSlot) -> bool {
    has_film(slot.closure, |at| matches!(&slot.args[at], SlotArg::Const(c) if is_zero(c)))
}

/// The constructor's call. It gets neither the tint nor the film: the back end multiplies the one and wraps the other around.
pub(super) fn constructor(id: ClosureId, args: &[Argument]) -> String {
    let row = builtins::closure(id);
    let film = if row.takes_film() { args.len() - 2 } else { args.len() };
    let types = row.args.split(',').chain(row.keys.split(',').filter_map(|k| k.split(' ').next()));
    let types: Vec<&str> = types.filter(|t| !t.is_empty()).collect();
    let mut codes = Vec::new();
    let mut list: Vec<String> = row.state.iter().map(|field| format!("sg->{field}")).collect();
    for (i, arg) in args.iter().enumerate().take(film) {
        if row.tint.is_none_or(|t| usize::from(t) != i) {
            codes.push(types[i]);
            list.push(arg.text.clone());
        }
    }
    let call = format!("{}({})", lobe_constructor(row.name, &codes.join(",")), list.join(", "));
    if has_film(id, |at| args[at].is_zero) {
        return format!("lobe_film({call}, {}, {})", args[film].text, args[film + 1].text);
    }
    call
}

/// The header of a lobe.
pub(super) fn header(lobe: &str) -> &'static str {
    const HEADERS: &[&str] = &[
        "bsdf/diffuse.h",
        "bsdf/oren_nayar.h",
        "bsdf/translucent.h",
        "bsdf/phong.h",
        "bsdf/ward.h",
        "bsdf/microfacet.h",
        "bsdf/reflection.h",
        "bsdf/refraction.h",
        "bsdf/conductor.h",
        "bsdf/oren_nayar_diffuse.h",
        "bsdf/burley_diffuse.h",
        "bsdf/dielectric.h",
        "bsdf/generalized_schlick.h",
        "bsdf/sheen.h",
        "bsdf/chiang_hair.h",
    ];
    let is_its = |h: &&&str| h.strip_prefix("bsdf/").and_then(|h| h.strip_suffix(".h")) == Some(lobe);
    HEADERS.iter().find(is_its).copied().unwrap_or("bsdf/bsdf.h")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtins::ClosureRole;

    #[test]
    fn every_lobe_has_its_header() {
        for row in builtins::CLOSURES {
            if let ClosureRole::Lobe(name) = row.role {
                assert_eq!(header(name), format!("bsdf/{name}.h"));
            }
        }
    }
}
