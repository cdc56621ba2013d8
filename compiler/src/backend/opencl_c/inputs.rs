//! Reads of what the renderer supplies beside the globals: slots behind `sg->userdata` and `sg->interactive`.

use super::names::ctype;
use super::writer::{Expr, Prec, Writer};
use crate::ir::{LocalId, Source, Ty, slots_of};

impl Writer<'_> {
    /// Where an input lies: the text of a pointer to its first slot, and the address space.
    fn slot(&self, input: u32) -> (String, &'static str) {
        let first = self.inputs.first.get(input as usize).copied().flatten().unwrap_or(0);
        let source = self.shader.inputs.get(input as usize).map(|i| i.source);
        match source {
            Some(Source::Interactive | Source::HasInteractive) => (format!("sg->interactive + {first}"), "__global "),
            _ => (format!("sg->userdata + {first}"), ""),
        }
    }

    /// The value of a single input.
    pub(super) fn input(&mut self, input: u32) -> Expr {
        let (pointer, space) = self.slot(input);
        let ty = self.shader.inputs.get(input as usize).map_or(Ty::Int, |i| i.ty);
        let prec = if matches!(ty, Ty::Triple | Ty::Matrix) { Prec::Primary } else { Prec::Unary };
        Expr::new(self.read_slot(&pointer, space, ty), prec)
    }

    fn read_slot(&mut self, pointer: &str, space: &str, ty: Ty) -> String {
        match ty {
            Ty::Float => format!("*({pointer})"),
            Ty::Triple => format!("vload3(0, {pointer})"),
            Ty::Matrix => {
                let loader = if space.is_empty() { "op_load_slots_m" } else { "op_load_global_m" };
                format!("{}({pointer})", self.op(loader))
            }
            _ => format!("*({space}const int *)({pointer})"),
        }
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
