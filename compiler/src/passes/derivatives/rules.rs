//! The derivatives of built-in functions by name; here those that work component by component.
//!
//! In: a call's value and its arguments. Out: its derivatives. Guards are the reference implementation's
//! (src/include/OSL/dual.h): where a function's result is a defined one for a bad argument, the derivative is zero. OSL's
//! x / 0 = 0 and inversesqrt(x <= 0) = 0 are such guards already.

use super::dual::{Dual, Slope};
use super::{Operand, Rewriter};
use crate::builtins::{self, Lowering};
use crate::ir::{BinaryOp, Inst, UnaryOp, ValueId};
use std::f64::consts::{LN_2, LN_10, PI};

const TWO_OVER_SQRT_PI: f64 = std::f64::consts::FRAC_2_SQRT_PI;

/// The smallest normal 32-bit float: below it logarithms are constant.
const FLT_MIN: f64 = f32::MIN_POSITIVE as f64;

impl Rewriter {
    /// The derivatives of the call `v` of a row.
    pub(super) fn rule(&mut self, name: &str, v: ValueId, args: &[Operand]) -> Dual {
        if let Some(d) = self.texture(name, v, args) {
            return Dual { v, d };
        }
        let moves = |r: &Self, a: &Operand| match a {
            Operand::Number(x) => x.d.is_some(),
            Operand::Array(l) => r.companions.contains_key(l),
        };
        if !args.iter().any(|a| moves(self, a)) {
            return Dual { v, d: None };
        }
        let mut numbers: Vec<Dual> = Vec::with_capacity(args.len());
        for arg in args {
            if let Operand::Number(x) = arg {
                numbers.push(*x);
            }
        }
        let componentwise = builtins::find(name).map(|f| builtins::row(f).lowering) == Some(Lowering::Componentwise)
            || matches!(name, "mix_float" | "select_nonzero");
        if componentwise {
            let ty = self.ty(v);
            let numbers: Vec<Dual> = numbers.into_iter().map(|x| self.splat(x, ty)).collect();
            return self.by_component(name, v, &numbers);
        }
        let d = match (name, args) {
            (name, [Operand::Number(x), Operand::Array(knots)]) if name.starts_with("spline") => {
                self.spline(name, v, *x, *knots)
            }
            (name, _) if name.starts_with("noise_") || name.starts_with("pnoise_") => self.noise(name, v, &numbers),
            _ => self.geometric(name, v, &numbers),
        };
        Dual { v, d }
    }

    /// The derivatives of a texture lookup: those of the texture by its coordinates, times the coordinates' as the lookup's
    /// filter has them, be they the shader's or given. `None`: it is no such lookup.
    fn texture(&mut self, name: &str, v: ValueId, args: &[Operand]) -> Option<Slope> {
        let mut values = Vec::with_capacity(args.len());
        for arg in args {
            let Operand::Number(x) = arg else { return None };
            values.push(*x);
        }
        let plain: Vec<ValueId> = values.iter().map(|x| x.v).collect();
        let ty = self.ty(v);
        match (name, values.as_slice()) {
            ("texture_lookup", [_, _, _, dsdx, dtdx, dsdy, dtdy, ..]) => {
                let (ds, dt) = (self.plain("texture_ds", &plain, ty), self.plain("texture_dt", &plain, ty));
                let along = |r: &mut Self, s: Dual, t: Dual| {
                    let (s, t) = (r.splat(s, ty).v, r.splat(t, ty).v);
                    let (s, t) = (r.binary(BinaryOp::Mul, ds, s), r.binary(BinaryOp::Mul, dt, t));
                    r.binary(BinaryOp::Add, s, t)
                };
                let slope = |x: Dual| Dual { v: x.v, d: None };
                Some(Some([along(self, slope(*dsdx), slope(*dtdx)), along(self, slope(*dsdy), slope(*dtdy))]))
            }
            ("texture3d_lookup", [_, p, ..]) => {
                let Some(d) = p.d else { return Some(None) };
                let by = ["texture3d_ds", "texture3d_dt", "texture3d_dr"].map(|row| self.plain(row, &plain, ty));
                Some(Some(d.map(|d| {
                    let mut sum = None;
                    for (k, by) in by.iter().enumerate() {
                        let index = self.int(k as i32);
                        let part = self.value(Inst::Component(d, index), crate::ir::Ty::Float);
                        let part = self.splat(Dual { v: part, d: None }, ty).v;
                        let part = self.binary(BinaryOp::Mul, *by, part);
                        sum = Some(sum.map_or(part, |sum| self.binary(BinaryOp::Add, sum, part)));
                    }
                    sum.unwrap_or(d)
                })))
            }
            _ => None,
        }
    }

    /// The derivatives of the outputs of a call, in order.
    pub(super) fn output_rule(&mut self, name: &str, args: &[Operand]) -> Vec<Slope> {
        let numbers: Vec<Dual> = args
            .iter()
            .filter_map(|a| match a {
                Operand::Number(x) => Some(*x),
                Operand::Array(_) => None,
            })
            .collect();
        match (name, numbers.as_slice()) {
            ("sincos", [x]) => {
                let ty = self.ty(x.v);
                let (sin, cos) = (self.f("sin", &[*x], ty), self.f("cos", &[*x], ty));
                vec![sin.d, cos.d]
            }
            ("fresnel", [i, n, eta]) => self.fresnel(*i, *n, *eta),
            _ => Vec::new(),
        }
    }

    /// 1 / x.
    fn inverse(&mut self, x: ValueId) -> ValueId {
        let one = self.constant(1.0, self.ty(x)).v;
        self.binary(BinaryOp::Div, one, x)
    }

    fn square(&mut self, x: ValueId) -> ValueId {
        self.binary(BinaryOp::Mul, x, x)
    }

    fn negated(&mut self, x: ValueId) -> ValueId {
        self.value(Inst::Unary(UnaryOp::Neg, x), self.ty(x))
    }

    fn scaled(&mut self, x: ValueId, factor: f64) -> ValueId {
        let factor = self.constant(factor, self.ty(x)).v;
        self.binary(BinaryOp::Mul, factor, x)
    }

    /// All numbers have the result's type.
    fn by_component(&mut self, name: &str, v: ValueId, args: &[Dual]) -> Dual {
        let ty = self.ty(v);
        let d = match (name, args) {
            (_, [x]) => match self.slope_of_one(name, v, x.v) {
                Some(factor) => self.scale(factor, x.d),
                None => self.abs(name, *x),
            },
            ("atan2", [y, x]) => {
                // The reference implementation's derivative has the opposite sign, and its test suite holds it to that.
                let (xx, yy) = (self.square(x.v), self.square(y.v));
                let sum = self.binary(BinaryOp::Add, xx, yy);
                let (left, right) = (self.scale(y.v, x.d), self.scale(x.v, y.d));
                let d = self.sub_slopes(left, right);
                self.divide(d, sum)
            }
            ("pow", [u, w]) => return self.pow(*u, *w),
            ("log", [x, base]) => {
                let (top, bottom) = (self.f("log", &[*x], ty), self.f("log", &[*base], ty));
                self.div(top, bottom).d
            }
            // The divisor's derivative is ignored, as in the reference implementation.
            ("fmod", [a, _]) => a.d,
            ("mod", [a, b]) => {
                let quotient = self.binary(BinaryOp::Div, a.v, b.v);
                let whole = self.plain("floor", &[quotient], ty);
                let right = self.scale(whole, b.d);
                self.sub_slopes(a.d, right)
            }
            ("min", [a, b]) => self.where_ge(b.v, a.v, a.d, b.d),
            ("max", [a, b]) => self.where_ge(b.v, a.v, b.d, a.d),
            ("clamp", [x, low, high]) => {
                let upper = self.f("min", &[*x, *high], ty);
                self.f("max", &[upper, *low], ty).d
            }
            ("mix_float", [a, b, x]) => {
                let difference = self.binary(BinaryOp::Sub, b.v, a.v);
                let one = self.constant(1.0, ty).v;
                let rest = self.binary(BinaryOp::Sub, one, x.v);
                let parts = [self.scale(rest, a.d), self.scale(x.v, b.d), self.scale(difference, x.d)];
                let sum = self.add_slopes(parts[0], parts[1]);
                self.add_slopes(sum, parts[2])
            }
            ("select_nonzero", [a, b, mask]) => {
                self.zip_slopes((a.d, ty), (b.d, ty), |r, a, b| r.plain("select_nonzero", &[a, b, mask.v], ty))
            }
            ("linearstep", [low, high, x]) => self.linearstep(*low, *high, *x),
            ("smoothstep", [low, high, x]) => self.smoothstep(*low, *high, *x),
            ("smooth_linearstep", [low, high, x, eps]) => self.smooth_linearstep(*low, *high, *x, *eps),
            _ => None,
        };
        Dual { v, d }
    }

    /// The derivative of `v = f(x)` by x; `None` for functions that are no smooth ones.
    fn slope_of_one(&mut self, name: &str, v: ValueId, x: ValueId) -> Option<ValueId> {
        let ty = self.ty(x);
        Some(match name {
            "radians" => self.constant(PI / 180.0, ty).v,
            "degrees" => self.constant(180.0 / PI, ty).v,
            "sin" => self.plain("cos", &[x], ty),
            "cos" => {
                let sin = self.plain("sin", &[x], ty);
                self.negated(sin)
            }
            "tan" => self.inverse_square_of("cos", x),
            "asin" | "acos" => {
                let xx = self.square(x);
                let one = self.constant(1.0, ty).v;
                let rest = self.binary(BinaryOp::Sub, one, xx);
                let slope = self.plain("inversesqrt", &[rest], ty);
                if name == "acos" { self.negated(slope) } else { slope }
            }
            "atan" => {
                let xx = self.square(x);
                let one = self.constant(1.0, ty).v;
                let sum = self.binary(BinaryOp::Add, one, xx);
                self.inverse(sum)
            }
            "sinh" => self.plain("cosh", &[x], ty),
            "cosh" => self.plain("sinh", &[x], ty),
            "tanh" => self.inverse_square_of("cosh", x),
            "exp" => v,
            "exp2" => self.scaled(v, LN_2),
            "expm1" => self.plain("exp", &[x], ty),
            "log" => self.slope_of_log(x, 1.0),
            "log2" => self.slope_of_log(x, LN_2),
            "log10" => self.slope_of_log(x, LN_10),
            "sqrt" => {
                let slope = self.plain("inversesqrt", &[x], ty);
                self.scaled(slope, 0.5)
            }
            "inversesqrt" => {
                let quotient = self.binary(BinaryOp::Div, v, x);
                self.scaled(quotient, -0.5)
            }
            "cbrt" => {
                let square = self.square(v);
                let triple = self.scaled(square, 3.0);
                self.inverse(triple)
            }
            _ => return None,
        })
    }

    fn inverse_square_of(&mut self, name: &str, x: ValueId) -> ValueId {
        let f = self.plain(name, &[x], self.ty(x));
        let square = self.square(f);
        self.inverse(square)
    }

    fn slope_of_log(&mut self, x: ValueId, ln_base: f64) -> ValueId {
        let ty = self.ty(x);
        // Zero below the smallest number that logarithms tell apart.
        let edge = self.constant(FLT_MIN, ty).v;
        let large = self.plain("step", &[edge, x], ty);
        let scaled = self.scaled(x, ln_base);
        self.binary(BinaryOp::Div, large, scaled)
    }

    /// What has no slope of its own.
    fn abs(&mut self, name: &str, x: Dual) -> Slope {
        match name {
            "abs" | "fabs" => {
                let zero = self.constant(0.0, self.ty(x.v)).v;
                let negative = self.neg_slope(x.d);
                self.where_ge(x.v, zero, x.d, negative)
            }
            _ => None,
        }
    }

    /// 2 / sqrt(pi) e^(-x^2), the derivative of erf.
    pub(super) fn gaussian(&mut self, x: ValueId) -> ValueId {
        let square = self.square(x);
        let negative = self.negated(square);
        let bell = self.plain("exp", &[negative], self.ty(x));
        self.scaled(bell, TWO_OVER_SQRT_PI)
    }

    /// As the reference implementation, which with derivatives computes the value as u u^(w - 1): 0 where both are 0.
    fn pow(&mut self, u: Dual, w: Dual) -> Dual {
        let ty = self.ty(u.v);
        let one = self.constant(1.0, ty).v;
        let less = self.binary(BinaryOp::Sub, w.v, one);
        let below = self.plain("pow", &[u.v, less], ty);
        let v = self.binary(BinaryOp::Mul, below, u.v);
        let by_u = self.binary(BinaryOp::Mul, w.v, below);
        let left = self.scale(by_u, u.d);
        let right = if w.d.is_some() {
            let log = self.plain("log", &[u.v], ty);
            let by_w = self.binary(BinaryOp::Mul, log, v);
            let right = self.scale(by_w, w.d);
            let zero = self.constant(0.0, ty).v;
            self.where_ge(zero, u.v, None, right)
        } else {
            None
        };
        Dual { v, d: self.add_slopes(left, right) }
    }
}
