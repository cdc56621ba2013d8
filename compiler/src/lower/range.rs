//! Checks of indices at run time, for those who ask for them: a wrong index is reported, in the reference implementation's
//! words; it counts as the nearest element in any case.
//!
//! In: an expression that is indexed, the index's value. Out: a statement that reports. It must not know what reads the report.

use super::Lower;
use super::place::Place;
use crate::check::typed::{Expr, ExprKind};
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, LocalId, Stmt, Ty, ValueId};
use crate::messages::{GROUP, LAYER, PLACE};
use crate::source::Span;
use crate::types::Base;

/// How long what is indexed is.
#[derive(Clone, Copy)]
enum Len {
    Known(u32),
    /// As long as what is bound to this parameter.
    Unsized(LocalId),
}

impl Lower<'_> {
    /// Reports an element outside an array.
    pub(super) fn check_element(&mut self, base: &Expr, place: &Place, index: ValueId, span: Span) {
        if self.settings.range_checks
            && let Some(local) = place.first_local()
            && let Some(len) = self.out.locals[local.0 as usize].len
        {
            let len = if self.is_open(local) { Len::Unsized(local) } else { Len::Known(len) };
            self.check_index(base, index, len, span);
        }
    }

    /// Reports a component outside a triple, or a row or column outside a matrix.
    pub(super) fn check_component(&mut self, base: &Expr, index: ValueId, span: Span) {
        if self.settings.range_checks {
            let len = if base.ty.base == Base::Matrix { 4 } else { 3 };
            self.check_index(base, index, Len::Known(len), span);
        }
    }

    fn check_index(&mut self, base: &Expr, index: ValueId, len: Len, span: Span) {
        if let (Inst::Const(Const::Int(i)), Len::Known(len)) = (&self.out.values[index.0 as usize].inst, len)
            && (0..i64::from(len)).contains(&i64::from(*i))
        {
            return;
        }
        let zero = self.int(0, span);
        let len_value = match len {
            Len::Known(len) => self.int(len.min(i32::MAX as u32) as i32, span),
            Len::Unsized(local) => self.internal("array_length", vec![Arg::Array(local)], Ty::Int, span),
        };
        let below = self.value(Inst::Binary(BinaryOp::Lt, index, zero), Ty::Int, span);
        let above = self.value(Inst::Binary(BinaryOp::Ge, index, len_value), Ty::Int, span);
        let outside = self.value(Inst::Binary(BinaryOp::BitOr, below, above), Ty::Int, span);
        // Names are no formats.
        let name = self.spelled(base).replace('%', "%%");
        let format = format!(
            "Index [%d] out of range {name}[0..%d]: {PLACE} (group {GROUP}, layer {LAYER}, shader {})",
            self.tree.name.replace('%', "%%"),
        );
        let then = self.in_block(|l| {
            let one = l.int(1, span);
            let last = l.value(Inst::Binary(BinaryOp::Sub, len_value, one), Ty::Int, span);
            l.report_error(&format, &[index, last], span);
        });
        self.push(Stmt::If(outside, then, Block::default()));
    }

    /// What is indexed, as written.
    fn spelled(&self, e: &Expr) -> String {
        match &e.kind {
            ExprKind::Var(id) => self.tree.var(*id).name.clone(),
            ExprKind::Index(base, _) => self.spelled(base),
            ExprKind::Field(base, index) => {
                let field = match base.ty.base {
                    Base::Struct(id) => self.tree.structure(id).fields.get(*index as usize).map(|f| f.0.clone()),
                    _ => None,
                };
                format!("{}.{}", self.spelled(base), field.unwrap_or_default())
            }
            _ => "value".to_owned(),
        }
    }
}
