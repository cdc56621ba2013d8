//! Checks at run time that numbers are finite, for those who ask for them: what is assigned to a variable and is NaN or infinite
//! is reported, in the reference implementation's words.
//!
//! In: a value and the place that it goes to. Out: a statement that reports. It must not know what reads the report.
//! The reference looks at each operation's result, its own temporaries too; here at what variables get.

use super::Lower;
use super::place::{Place, Storage};
use crate::ast::BinaryOp;
use crate::check::typed::{Callee, Expr, ExprKind};
use crate::ir::{Arg, Block, Inst, Stmt, Ty, UnaryOp, ValueId};
use crate::messages::PLACE;
use crate::source::Span;

/// The reference's name of an operation.
fn operation(e: &Expr) -> &'static str {
    match &e.kind {
        ExprKind::Convert(inner) => operation(inner),
        ExprKind::Call(Callee::Builtin { id, .. }, _) => crate::builtins::row(*id).name,
        ExprKind::Binary(op, ..) | ExprKind::AssignOp(op, ..) => match op {
            BinaryOp::Mul => "mul",
            BinaryOp::Div => "div",
            BinaryOp::Sub => "sub",
            _ => "add",
        },
        ExprKind::Neg(_) => "neg",
        ExprKind::Construct(_) => e.ty.base.keyword(),
        ExprKind::Index(..) => "aref",
        ExprKind::Component(..) => "compref",
        ExprKind::Element(..) => "mxcompref",
        _ => "assign",
    }
}

impl Lower<'_> {
    /// Reports a float or a triple that is not finite; its first bad component is named.
    pub(super) fn check_finite(&mut self, place: &Place, value: ValueId, e: &Expr) {
        if !self.settings.finite_checks {
            return;
        }
        let mut at = place;
        let local = loop {
            match at {
                Place::Stored(Storage::Local(local), _) => break *local,
                Place::Component(inner, _) | Place::Element(inner, ..) => at = inner,
                _ => return,
            }
        };
        let span = e.span;
        let parts = match self.ty_of(value) {
            Ty::Float => vec![value],
            Ty::Triple => [0, 1, 2].map(|i| self.component(value, i, span)).to_vec(),
            _ => return,
        };
        // What a function returns goes on to a variable of its caller.
        if matches!(self.frames.last(), Some(f) if matches!(&f.result, Some(Storage::Local(l)) if *l == local)) {
            return;
        }
        let name = self.out.locals[local.0 as usize].name.replace('%', "%%");
        let behind = format!("value in {name} at {PLACE} (op {})", operation(e));
        let mut rest = Block::default();
        for part in parts.into_iter().rev() {
            rest = self.in_block(|l| {
                let finite = l.internal("isfinite", vec![Arg::Value(part)], Ty::Int, span);
                let bad = l.value(Inst::Unary(UnaryOp::Not, finite), Ty::Int, span);
                let then = l.in_block(|l| {
                    // NaN has a sign that means nothing.
                    let nan = l.internal("isnan", vec![Arg::Value(part)], Ty::Int, span);
                    let one = l.in_block(|l| l.report_error(&format!("Detected nan {behind}"), &[], span));
                    let other = l.in_block(|l| l.report_error(&format!("Detected %g {behind}"), &[part], span));
                    l.push(Stmt::If(nan, one, other));
                });
                l.push(Stmt::If(bad, then, rest));
            });
        }
        rest.stmts.into_iter().for_each(|s| self.push(s));
    }

    fn component(&mut self, of: ValueId, index: i32, span: Span) -> ValueId {
        let index = self.int(index, span);
        self.value(Inst::Component(of, index), Ty::Float, span)
    }
}
