//! Implicit conversions and how well an argument fits a formal.

use super::Checker;
use super::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::types::{Base, Extent, Type};

/// How well one argument fits, after the reference implementation's scheme: higher is better, `None` does not fit.
pub(super) type Score = Option<u32>;

/// Fit of a value of type `from` where `to` is wanted.
pub(super) fn score(to: Type, from: Type) -> Score {
    if to == from {
        return Some(100);
    }
    if to.is_array() || from.is_array() {
        let same = to.base == from.base && to.is_array() && from.is_array();
        let fits = match (to.extent, from.extent) {
            (Extent::Unsized, _) => true,
            (Extent::Fixed(a), Extent::Fixed(b)) => a == b,
            _ => false,
        };
        return (same && fits).then_some(44);
    }
    match (to.base, from.base) {
        (Base::Float, Base::Int) => Some(77),
        (a, b) if a.is_point_like() && b.is_point_like() => Some(32),
        (a, b) if a.is_triple() && b.is_triple() => Some(27),
        _ => assignable(to.base, from.base).then_some(23),
    }
}

/// Implicit conversions between base types: int and float to wider ones, triples among each other.
fn assignable(to: Base, from: Base) -> bool {
    if to == from {
        return true;
    }
    match (to, from) {
        (Base::Float | Base::Matrix, Base::Int | Base::Float) => true,
        (t, Base::Int | Base::Float) if t.is_triple() => true,
        (t, f) => t.is_triple() && f.is_triple(),
    }
}

impl Checker {
    /// Whether a value of `from` may be assigned to `to`.
    pub(super) fn fits(&self, to: Type, from: Type) -> bool {
        match (to.extent, from.extent) {
            (Extent::Scalar, Extent::Scalar) => assignable(to.base, from.base),
            // The destination may be longer: its other elements stay as they are.
            (Extent::Fixed(a), Extent::Fixed(b)) => to.base == from.base && a >= b,
            (Extent::Unsized, Extent::Fixed(_))
            | (Extent::Unsized, Extent::Unsized)
            | (Extent::Fixed(_), Extent::Unsized) => to.base == from.base,
            _ => false,
        }
    }

    /// `expr` as a value of type `to`; reports when it does not fit. `what` says where it goes: "the variable `x`".
    pub(super) fn convert(&mut self, expr: Expr, to: Type, what: &str) -> Option<Expr> {
        if self.converts(&expr, to) {
            return Some(wrap(expr, to));
        }
        let (found, wanted) = (self.show(expr.ty), self.show(to));
        let mut d = Diagnostic::error("E2003", expr.span, format!("{what} needs {wanted}, found {found}"));
        if to.base == Base::Int && expr.ty == Type::FLOAT {
            d = d.help("write `(int)` before it to cut off the fraction");
        }
        if to == Type::scalar(Base::Closure) && matches!(expr.ty.base, Base::Int | Base::Float | Base::Color) {
            d = d.help("a number becomes light only through a closure, such as `x * emission()` or `x * diffuse(N)`");
        }
        self.fail(d)
    }

    /// Whether `convert` would succeed. `0` is the null closure.
    pub(super) fn converts(&self, expr: &Expr, to: Type) -> bool {
        let zero = match expr.kind {
            ExprKind::Int(v) => v == 0,
            ExprKind::Float(v) => v == 0.0,
            _ => false,
        };
        (zero && to == Type::scalar(Base::Closure)) || self.fits(to, expr.ty)
    }
}

fn wrap(expr: Expr, to: Type) -> Expr {
    // Whole arrays are copied element by element by lower; the type stays the source's.
    if expr.ty == to || to.is_array() {
        return expr;
    }
    let span = expr.span;
    Expr { kind: ExprKind::Convert(Box::new(expr)), ty: to, span }
}
