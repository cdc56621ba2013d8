//! What an instruction with one constant operand is, whatever the others are.
//!
//! In: an instruction and its constant operands. Out: something simpler. Identities are exact but for three, which the reference
//! implementation has too, so that a weight of the constant 0 leaves nothing behind: `0 * x` and `0 / x` are 0 even where x is
//! infinite or no number, and `x + 0` is x even where that is -0.

use super::{Folder, Simpler};
use crate::builtins;
use crate::interp::ops;
use crate::ir::{Arg, BinaryOp, Const, Inst, Ty, UnaryOp, ValueId};

impl Folder<'_> {
    /// Identities with one constant operand; `ty`: the result's type.
    pub(super) fn identity(&self, inst: &Inst, ty: Ty, args: &[Option<Const>]) -> Option<Simpler> {
        let is = |i: usize, x: f64| match args.get(i) {
            Some(Some(Const::Float(v))) => *v == x,
            Some(Some(Const::Triple(v))) => v.iter().all(|c| *c == x),
            Some(Some(Const::Int(v))) => *v as f64 == x,
            Some(Some(Const::Matrix(m))) if x == 1.0 => *m == ops::IDENTITY,
            _ => false,
        };
        let null = |v: ValueId| matches!(self.shader.values[self.resolve(v).0 as usize].inst, Inst::NullClosure);
        let inst_of = |v: ValueId| &self.shader.values[self.resolve(v).0 as usize].inst;
        Some(match inst {
            Inst::Binary(BinaryOp::Mul, a, _) if is(1, 1.0) => Simpler::Value(*a),
            Inst::Binary(BinaryOp::Mul, _, b) if is(0, 1.0) => Simpler::Value(*b),
            Inst::Binary(BinaryOp::Div, a, _) if is(1, 1.0) => Simpler::Value(*a),
            Inst::Binary(BinaryOp::Sub, a, _) if is(1, 0.0) => Simpler::Value(*a),
            Inst::Binary(BinaryOp::Add, a, _) if is(1, 0.0) => Simpler::Value(*a),
            Inst::Binary(BinaryOp::Add, _, b) if is(0, 0.0) => Simpler::Value(*b),
            Inst::Binary(BinaryOp::BitAnd, ..) if is(0, 0.0) || is(1, 0.0) => Simpler::Const(Const::Int(0)),
            // By a matrix of zeros it is no number that is multiplied: `is` knows none.
            Inst::Binary(BinaryOp::Mul, ..) if is(0, 0.0) || is(1, 0.0) => Simpler::Const(ops::zero(ty)?),
            // A division by zero is 0, too.
            Inst::Binary(BinaryOp::Div, ..) if is(0, 0.0) || is(1, 0.0) => Simpler::Const(ops::zero(ty)?),
            Inst::Unary(UnaryOp::Neg, a) => match inst_of(*a) {
                Inst::Unary(UnaryOp::Neg, inner) => Simpler::Value(self.resolve(*inner)),
                _ => return None,
            },
            Inst::Select(_, a, b) => match &args[0] {
                Some(c) => Simpler::Value(if ops::is_true(c) { *a } else { *b }),
                None if a == b || args[1].is_some() && args[1] == args[2] => Simpler::Value(*a),
                None => return None,
            },
            Inst::Component(t, _) => match (inst_of(*t), &args[1]) {
                (Inst::Triple(parts), Some(Const::Int(i))) => Simpler::Value(self.resolve(parts[ops::clamp(*i, 3)])),
                (Inst::Convert(x), _) => Simpler::Value(self.resolve(*x)),
                _ => return None,
            },
            Inst::ScaleClosure(a, _) if null(*a) || is(1, 0.0) => Simpler::Inst(Inst::NullClosure),
            Inst::ScaleClosure(a, _) if is(1, 1.0) => Simpler::Value(*a),
            Inst::AddClosure(a, b) if null(*a) => Simpler::Value(*b),
            Inst::AddClosure(a, b) if null(*b) => Simpler::Value(*a),
            Inst::Layer(a, b) if null(*a) => Simpler::Value(*b),
            Inst::Layer(a, b) if null(*b) => Simpler::Value(*a),
            Inst::ClosureIsSet(a) if null(*a) => Simpler::Const(Const::Int(0)),
            _ => return None,
        })
    }

    /// `mix(a, b, 0)` is a, `mix(a, b, 1)` is b, and `mix(a, a, x)` is a.
    pub(super) fn mix(&self, func: builtins::FuncId, args: &[Arg]) -> Option<Simpler> {
        let [Arg::Value(a), Arg::Value(b), Arg::Value(x)] = args else { return None };
        if builtins::row(func).name != "mix_float" {
            return None;
        }
        let share = |c: f64| match self.const_of(*x) {
            Some(Const::Float(v)) => *v == c,
            Some(Const::Triple(v)) => v.iter().all(|v| *v == c),
            _ => false,
        };
        let (a, b) = (self.resolve(*a), self.resolve(*b));
        match () {
            () if share(0.0) || a == b || self.const_of(a).is_some_and(|c| self.const_of(b) == Some(c)) => {
                Some(Simpler::Value(a))
            }
            () if share(1.0) => Some(Simpler::Value(b)),
            () => None,
        }
    }
}
