//! Arithmetic of dual numbers, written as IR.
//!
//! In: values with their derivatives. Out: new values with theirs. Float and triple alike; operands have equal types unless
//! stated. It must not know names of OSL.

use super::Rewriter;
use crate::builtins;
use crate::ir::{Arg, BinaryOp, Const, Inst, Ty, UnaryOp, ValueId};

/// Derivatives by x and y; `None`: both are zero.
pub(super) type Slope = Option<[ValueId; 2]>;

/// A value with its derivatives.
#[derive(Clone, Copy)]
pub(super) struct Dual {
    pub v: ValueId,
    pub d: Slope,
}

impl Rewriter {
    /// A call of a row, for its value only.
    pub(super) fn plain(&mut self, name: &str, args: &[ValueId], ty: Ty) -> ValueId {
        // Every name here is one of the table: the tests of this pass call each formula.
        let Some(func) = builtins::find(name) else { return self.constant(0.0, ty).v };
        self.value(Inst::Call(func, args.iter().map(|v| Arg::Value(*v)).collect()), ty)
    }

    /// A call of a row with its derivatives.
    pub(super) fn f(&mut self, name: &str, args: &[Dual], ty: Ty) -> Dual {
        let values: Vec<ValueId> = args.iter().map(|a| a.v).collect();
        let v = self.plain(name, &values, ty);
        let args: Vec<super::Operand> = args.iter().map(|a| super::Operand::Number(*a)).collect();
        self.rule(name, v, &args)
    }

    pub(super) fn binary(&mut self, op: BinaryOp, a: ValueId, b: ValueId) -> ValueId {
        use BinaryOp::*;
        let ty = if matches!(op, Add | Sub | Mul | Div) { self.ty(a) } else { Ty::Int };
        self.value(Inst::Binary(op, a, b), ty)
    }

    pub(super) fn int(&mut self, i: i32) -> ValueId {
        self.value(Inst::Const(Const::Int(i)), Ty::Int)
    }

    pub(super) fn component(&mut self, a: Dual, i: i32) -> Dual {
        let i = self.int(i);
        let v = self.value(Inst::Component(a.v, i), Ty::Float);
        let d = a.d.map(|d| d.map(|d| self.value(Inst::Component(d, i), Ty::Float)));
        Dual { v, d }
    }

    pub(super) fn triple(&mut self, parts: [Dual; 3]) -> Dual {
        let v = self.value(Inst::Triple(parts.map(|p| p.v)), Ty::Triple);
        Dual { v, d: self.gather(parts) }
    }

    /// The derivatives of a triple of these.
    pub(super) fn gather(&mut self, parts: [Dual; 3]) -> Slope {
        parts.iter().any(|p| p.d.is_some()).then(|| {
            let all = parts.map(|p| self.slope_or_zero(p.d, Ty::Float));
            [0, 1].map(|k| self.value(Inst::Triple(all.map(|d| d[k])), Ty::Triple))
        })
    }

    /// A float as a triple, a number of the wanted type as it is.
    pub(super) fn splat(&mut self, a: Dual, ty: Ty) -> Dual {
        if ty != Ty::Triple || self.ty(a.v) != Ty::Float {
            return a;
        }
        let v = self.value(Inst::Convert(a.v), ty);
        Dual { v, d: a.d.map(|d| d.map(|d| self.value(Inst::Convert(d), ty))) }
    }

    pub(super) fn slope_or_zero(&mut self, d: Slope, ty: Ty) -> [ValueId; 2] {
        d.unwrap_or_else(|| [self.constant(0.0, ty).v; 2])
    }

    /// Combines derivatives, zeros of the given types where there are none.
    pub(super) fn zip_slopes(
        &mut self,
        a: (Slope, Ty),
        b: (Slope, Ty),
        mut f: impl FnMut(&mut Self, ValueId, ValueId) -> ValueId,
    ) -> Slope {
        if a.0.is_none() && b.0.is_none() {
            return None;
        }
        let (a, b) = (self.slope_or_zero(a.0, a.1), self.slope_or_zero(b.0, b.1));
        Some([f(self, a[0], b[0]), f(self, a[1], b[1])])
    }

    pub(super) fn neg_slope(&mut self, d: Slope) -> Slope {
        d.map(|d| d.map(|d| self.value(Inst::Unary(UnaryOp::Neg, d), self.ty(d))))
    }

    pub(super) fn add_slopes(&mut self, a: Slope, b: Slope) -> Slope {
        match (a, b) {
            (Some(a), Some(b)) => Some([0, 1].map(|k| self.binary(BinaryOp::Add, a[k], b[k]))),
            (a, b) => a.or(b),
        }
    }

    pub(super) fn sub_slopes(&mut self, a: Slope, b: Slope) -> Slope {
        match (a, b) {
            (Some(a), Some(b)) => Some([0, 1].map(|k| self.binary(BinaryOp::Sub, a[k], b[k]))),
            (a, None) => a,
            (None, b) => self.neg_slope(b),
        }
    }

    /// Times a factor of the same type.
    pub(super) fn scale(&mut self, factor: ValueId, d: Slope) -> Slope {
        d.map(|d| d.map(|d| self.binary(BinaryOp::Mul, factor, d)))
    }

    /// Divided by a value of the same type; OSL's x / 0 = 0 holds.
    pub(super) fn divide(&mut self, d: Slope, by: ValueId) -> Slope {
        d.map(|d| d.map(|d| self.binary(BinaryOp::Div, d, by)))
    }

    /// The derivatives of `v = a op b`.
    pub(super) fn arithmetic(&mut self, op: BinaryOp, a: Dual, b: Dual, v: ValueId) -> Slope {
        match op {
            BinaryOp::Add => self.add_slopes(a.d, b.d),
            BinaryOp::Sub => self.sub_slopes(a.d, b.d),
            BinaryOp::Mul => {
                let (left, right) = (self.scale(b.v, a.d), self.scale(a.v, b.d));
                self.add_slopes(left, right)
            }
            BinaryOp::Div => {
                let right = self.scale(v, b.d);
                let d = self.sub_slopes(a.d, right);
                self.divide(d, b.v)
            }
            _ => None,
        }
    }

    fn operation(&mut self, op: BinaryOp, a: Dual, b: Dual) -> Dual {
        let v = self.binary(op, a.v, b.v);
        Dual { v, d: self.arithmetic(op, a, b, v) }
    }

    pub(super) fn add(&mut self, a: Dual, b: Dual) -> Dual {
        self.operation(BinaryOp::Add, a, b)
    }

    pub(super) fn sub(&mut self, a: Dual, b: Dual) -> Dual {
        self.operation(BinaryOp::Sub, a, b)
    }

    pub(super) fn mul(&mut self, a: Dual, b: Dual) -> Dual {
        self.operation(BinaryOp::Mul, a, b)
    }

    pub(super) fn div(&mut self, a: Dual, b: Dual) -> Dual {
        self.operation(BinaryOp::Div, a, b)
    }

    /// Times, plus a constant.
    pub(super) fn linear(&mut self, a: Dual, factor: f64, offset: f64) -> Dual {
        let ty = self.ty(a.v);
        let factor = self.constant(factor, ty);
        let product = self.mul(a, factor);
        if offset == 0.0 {
            return product;
        }
        let offset = self.constant(offset, ty);
        self.add(product, offset)
    }

    /// A triple times a float.
    pub(super) fn times(&mut self, a: Dual, factor: Dual) -> Dual {
        let factor = self.splat(factor, Ty::Triple);
        self.mul(a, factor)
    }

    pub(super) fn pick_slope(&mut self, cond: ValueId, a: Slope, b: Slope, ty: Ty) -> Slope {
        self.zip_slopes((a, ty), (b, ty), |r, a, b| r.value(Inst::Select(cond, a, b), ty))
    }

    /// `cond != 0 ? a : b`.
    pub(super) fn pick(&mut self, cond: ValueId, a: Dual, b: Dual) -> Dual {
        let ty = self.ty(a.v);
        let v = self.value(Inst::Select(cond, a.v, b.v), ty);
        Dual { v, d: self.pick_slope(cond, a.d, b.d, ty) }
    }

    /// `x >= edge ? a : b`, for triples by component.
    pub(super) fn where_ge(&mut self, x: ValueId, edge: ValueId, a: Slope, b: Slope) -> Slope {
        let ty = self.ty(x);
        if ty == Ty::Float {
            let cond = self.binary(BinaryOp::Ge, x, edge);
            return self.pick_slope(cond, a, b, ty);
        }
        let mask = self.plain("step", &[edge, x], ty);
        self.zip_slopes((a, ty), (b, ty), |r, a, b| r.plain("select_nonzero", &[b, a, mask], ty))
    }
}
