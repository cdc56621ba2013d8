//! Reads of what the renderer supplies beside the globals: slots behind `sg->userdata` and `sg->interactive`.

use super::writer::{Expr, Prec, Writer};
use crate::backend::names::ctype;
use crate::backend::slots;
use crate::ir::{LocalId, Ty, slots_of};

impl Writer<'_> {
    fn slot(&self, input: u32) -> (String, &'static str) {
        slots::pointer(self.shader, &self.inputs, input)
    }

    /// The value of a single input.
    pub(super) fn input(&mut self, input: u32) -> Expr {
        let (pointer, space) = self.slot(input);
        let ty = self.shader.inputs.get(input as usize).map_or(Ty::Int, |i| i.ty);
        let prec = if matches!(ty, Ty::Triple | Ty::Matrix) { Prec::Primary } else { Prec::Unary };
        Expr::new(self.read_slot(&pointer, space, ty), prec)
    }

    fn read_slot(&mut self, pointer: &str, space: &str, ty: Ty) -> String {
        let (text, helper) = slots::read(pointer, space, ty);
        helper.map(|h| self.op(h));
        text
    }

    /// Declares an array of inputs and fills it, at the top of the function.
    pub(super) fn declare_input(&mut self, l: LocalId, input: u32, len: u32) {
        let ty = self.shader.locals[l.0 as usize].ty;
        let name = self.name(l).to_owned();
        let (pointer, space) = self.slot(input);
        let element = self.read_slot(&format!("{pointer} + {} * i", slots_of(ty)), space, ty);
        self.put(None, &format!("{} {name}[{len}];", ctype(ty)));
        self.put(None, &format!("for (int i = 0; i < {len}; i++) {name}[i] = {element};"));
    }
}
