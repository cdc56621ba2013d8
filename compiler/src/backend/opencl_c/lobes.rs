//! Calls of lobes' constructors, and of their albedos.
//!
//! In: a closure's row and its arguments. Out: OpenCL C, by [`crate::backend::lobes`].

use super::writer::{Expr, Prec, Writer};
use crate::backend::lobes::{Argument, constructor, header, is_zero};
use crate::builtins::{self, ClosureId, ClosureRole};
use crate::ir::{Inst, LobeSlot, SlotArg, ValueId};

/// The lobe of a slot.
pub(super) fn of_slot(w: &mut Writer, slot: &LobeSlot) -> String {
    let mut args = Vec::with_capacity(slot.args.len());
    for arg in &slot.args {
        args.push(match arg {
            SlotArg::Const(c) => Argument { text: w.constant(c), is_zero: is_zero(c) },
            SlotArg::Local(l) => Argument { text: w.load(*l).text, is_zero: false },
        });
    }
    constructor(slot.closure, &args)
}

/// `Inst::Albedo`.
pub(super) fn albedo(w: &mut Writer, id: ClosureId, args: &[ValueId]) -> Expr {
    let row = builtins::closure(id);
    let ClosureRole::Lobe(lobe) = row.role else { return Expr::new("(real3)(0.0)", Prec::Unary) };
    w.includes.extend(["lobe.h", header(lobe)]);
    let zeros: Vec<bool> =
        args.iter().map(|v| matches!(&w.shader.values[v.0 as usize].inst, Inst::Const(c) if is_zero(c))).collect();
    let values: Vec<Expr> = args.iter().map(|a| w.operand(*a)).collect();
    let list: Vec<Argument> =
        values.iter().zip(zeros).map(|(e, is_zero)| Argument { text: e.text.clone(), is_zero }).collect();
    let text = format!("{lobe}_albedo3({}, -sg->I)", constructor(id, &list));
    Expr::new(text, Prec::Primary).reads(&values.iter().collect::<Vec<_>>())
}
