//! The derivatives of steps, splines and noises (specification ch. 7.5, 7.6).
//!
//! In: a call's value and its arguments. Out: its derivatives. Noises and splines have rows that give their slopes: the
//! partial derivatives come from one call, whatever the number of directions.

use super::Rewriter;
use super::dual::{Dual, Slope};
use crate::ir::{Arg, BinaryOp, Inst, LocalId, Ty, ValueId};

impl Rewriter {
    /// (x - low) / (high - low).
    fn position(&mut self, low: Dual, high: Dual, x: Dual) -> Dual {
        let (top, bottom) = (self.sub(x, low), self.sub(high, low));
        self.div(top, bottom)
    }

    pub(super) fn linearstep(&mut self, low: Dual, high: Dual, x: Dual) -> Slope {
        // Where the edges coincide the quotient is 0, and so is its derivative.
        let t = self.position(low, high, x);
        let ty = self.ty(t.v);
        let (zero, one) = (self.constant(0.0, ty), self.constant(1.0, ty));
        self.f("clamp", &[t, zero, one], ty).d
    }

    pub(super) fn smoothstep(&mut self, low: Dual, high: Dual, x: Dual) -> Slope {
        let t = self.position(low, high, x);
        let rest = self.linear(t, -2.0, 3.0);
        let square = self.mul(t, t);
        let curve = self.mul(rest, square);
        let inner = self.where_ge(x.v, high.v, None, curve.d);
        self.where_ge(x.v, low.v, inner, None)
    }

    pub(super) fn smooth_linearstep(&mut self, low: Dual, high: Dual, x: Dual, eps: Dual) -> Slope {
        let t = self.position(low, high, x);
        let ty = self.ty(t.v);
        let one = self.constant(1.0, ty);
        let width = self.sub(high, low);
        let eps = self.div(eps, width);
        // A parabola of half-width eps joins the flat part and the slope.
        let mut ramp = |r: &mut Self, x: Dual| {
            let square = r.mul(x, x);
            let half = r.linear(square, 0.25, 0.0);
            r.div(half, eps).d
        };
        let from_start = self.add(t, eps);
        let start = ramp(self, from_start);
        let end_of_all = self.add(one, eps);
        let to_end = self.sub(end_of_all, t);
        let end = ramp(self, to_end);
        let end = self.neg_slope(end);
        let end_of_slope = self.sub(one, eps).v;
        // From the last piece to the first: beyond, end, slope, start, before.
        let d = self.where_ge(t.v, end_of_all.v, None, end);
        let d = self.where_ge(end_of_slope, t.v, t.d, d);
        let d = self.where_ge(t.v, eps.v, d, start);
        let minus = self.constant(-1.0, ty).v;
        let before = self.binary(BinaryOp::Mul, minus, eps.v);
        self.where_ge(before, t.v, None, d)
    }

    /// A spline: by its position through the slope's row, by its knots through itself, since it is linear in them. An inverse:
    /// the reciprocal of the curve's slope; knots count as constant there, as in the reference implementation.
    pub(super) fn spline(&mut self, name: &str, v: ValueId, x: Dual, knots: LocalId) -> Slope {
        let ty = self.ty(v);
        if let Some(basis) = name.strip_prefix("splineinverse_") {
            let slope = self.of_array(&format!("spline_{basis}_slope"), v, knots, ty);
            let d = self.divide(x.d, slope);
            // Values beyond the knots give 0 or 1.
            let (zero, one) = (self.constant(0.0, ty).v, self.constant(1.0, ty).v);
            let inside = self.where_ge(v, one, None, d);
            let inside = self.where_ge(zero, v, None, inside);
            // So do curves that overshoot: there is no position with this value, and the answer is an end of a segment.
            let found = self.of_array(&format!("spline_{basis}"), v, knots, ty);
            let error = self.binary(BinaryOp::Sub, found, x.v);
            let error = self.plain("fabs", &[error], ty);
            let tolerance = self.constant(1e-3, ty).v;
            return self.where_ge(tolerance, error, inside, None);
        }
        let by_x = match name {
            "spline_constant" => None,
            _ if x.d.is_none() => None,
            _ => {
                let slope = self.of_array(&format!("{name}_slope"), x.v, knots, ty);
                let x = self.splat(x, ty);
                self.scale(slope, x.d)
            }
        };
        let pair = self.companions.get(&knots).copied();
        let by_knots = pair.map(|pair| pair.map(|knots| self.of_array(name, x.v, knots, ty)));
        self.add_slopes(by_x, by_knots)
    }

    fn of_array(&mut self, name: &str, x: ValueId, array: LocalId, ty: Ty) -> ValueId {
        let Some(func) = crate::builtins::find(name) else { return self.constant(0.0, ty).v };
        self.value(Inst::Call(func, vec![Arg::Value(x), Arg::Array(array)]), ty)
    }

    /// Gradient noise of coordinates; behind them come periods, which count as constant. The slopes' row gives a matrix: row j
    /// holds the derivatives of the result's components by coordinate j.
    pub(super) fn noise(&mut self, name: &str, v: ValueId, args: &[Dual]) -> Slope {
        let ty = self.ty(v);
        let (prefix, kind) = name.split_once('_')?;
        let coordinates = if prefix == "pnoise" { &args[..args.len() / 2] } else { args };
        let signed = kind.trim_start_matches('u');
        let several = if ty == Ty::Triple { "_triple" } else { "" };
        let values: Vec<ValueId> = args.iter().map(|a| a.v).collect();
        let slopes = self.plain(&format!("{prefix}_{signed}_slopes{several}"), &values, Ty::Matrix);
        let mut sum = None;
        let mut row = 0;
        for x in coordinates {
            let of_triple = self.ty(x.v) == Ty::Triple;
            let d = match (ty, of_triple) {
                (Ty::Triple, true) => x.d.map(|d| d.map(|d| self.plain("transform_vector", &[slopes, d], Ty::Triple))),
                (Ty::Triple, false) => {
                    let by = [0, 1, 2].map(|k| self.element(slopes, row, k));
                    let by = self.value(Inst::Triple(by), Ty::Triple);
                    let x = self.splat(*x, Ty::Triple);
                    self.scale(by, x.d)
                }
                (_, true) => {
                    let by = [0, 1, 2].map(|j| self.element(slopes, j, 0));
                    let by = self.value(Inst::Triple(by), Ty::Triple);
                    x.d.map(|d| d.map(|d| self.plain("dot", &[by, d], Ty::Float)))
                }
                (_, false) => {
                    let by = self.element(slopes, row, 0);
                    self.scale(by, x.d)
                }
            };
            sum = self.add_slopes(sum, d);
            row += if of_triple { 3 } else { 1 };
        }
        if signed == kind {
            return sum;
        }
        // In [0, 1] instead of [-1, 1].
        let half = self.constant(0.5, ty).v;
        self.scale(half, sum)
    }

    fn element(&mut self, m: ValueId, row: i32, column: i32) -> ValueId {
        let (row, column) = (self.int(row), self.int(column));
        self.value(Inst::MatrixElement(m, row, column), Ty::Float)
    }
}
