//! What operations demand of the types of their operands, and the conversions that `assign` makes.
//!
//! In: an operand. Out: the same as an expression of the type wanted, or an error at the operation.

use super::read::{Fit, unfit};
use super::{Element, Op, SymType};
use crate::check::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::types::{Base, Extent, Type};

pub(super) fn array(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty.is_array() { Ok(e) } else { Err(unfit(op, "needs an array")) }
}

pub(super) fn triple(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty.base.is_triple() && !e.ty.is_array() {
        Ok(e)
    } else {
        Err(unfit(op, "needs a color, point, vector or normal"))
    }
}

pub(super) fn matrix(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty == Type::scalar(Base::Matrix) { Ok(e) } else { Err(unfit(op, "needs a matrix")) }
}

/// An operand that is no array.
pub(super) fn single(op: &Op, e: Expr) -> Fit<Expr> {
    if e.ty.is_array() { Err(unfit(op, "does not take arrays")) } else { Ok(e) }
}

/// An int that is true when the value is.
pub(super) fn truth(op: &Op, e: Expr) -> Fit<Expr> {
    let e = single(op, e)?;
    if e.ty == Type::INT {
        return Ok(e);
    }
    let span = e.span;
    Ok(Expr { kind: ExprKind::Truth(Box::new(e)), ty: Type::INT, span })
}

/// A value as one of another type, as `assign` converts.
pub(super) fn fitted(op: &Op, e: Expr, to: Type) -> Fit<Expr> {
    if e.ty == to {
        return Ok(e);
    }
    let triple = |b: Base| b.is_triple();
    let fits = match (to.extent, e.ty.extent) {
        // The destination may be longer: its other elements stay as they are.
        (Extent::Fixed(a), Extent::Fixed(b)) => {
            let same = to.base == e.ty.base || triple(to.base) && triple(e.ty.base);
            return if same && a >= b { Ok(e) } else { Err(mismatch(op, e.ty, to)) };
        }
        (Extent::Scalar, Extent::Scalar) => match (to.base, e.ty.base) {
            (Base::Int | Base::Float, Base::Int | Base::Float) => true,
            (t, Base::Int | Base::Float) if triple(t) || t == Base::Matrix => true,
            (Base::Closure, Base::Int) => matches!(e.kind, ExprKind::Int(0)),
            (Base::Closure, Base::Float) => matches!(e.kind, ExprKind::Float(v) if v == 0.0),
            (t, f) => triple(t) && triple(f),
        },
        _ => false,
    };
    if !fits {
        return Err(mismatch(op, e.ty, to));
    }
    let span = e.span;
    Ok(Expr { kind: ExprKind::Convert(Box::new(e)), ty: to, span })
}

fn mismatch(op: &Op, from: Type, to: Type) -> Diagnostic {
    let show = |t: Type| SymType { element: Element::Base(t.base), extent: t.extent }.spelling();
    unfit(op, format!("cannot turn {} into {}", show(from), show(to)))
}
