//! What numbers can be, whatever the flow of control: a few ints, or a range.
//!
//! In: IR. Out: for a value, the ints that it can be, where there are few: choices among constants, results of comparisons,
//! counters of loops, what `clamp`, `min`, `max` and `%` leave, cell and hash noise scaled and cut to an int. An answer holds
//! more than the value takes rather than less, with two exceptions that are wrong anyway: what is read without having been
//! stored, and a NaN made an int. It must not know what the answer is for.

use super::counters::Counters;
use super::strings::Strings;
use crate::builtins::{self, FuncId};
use crate::interp::{self, ops};
use crate::ir::{Arg, BinaryOp, Const, Inst, LocalId, Shader, Ty, UnaryOp, ValueId};
use std::collections::BTreeSet;

/// Most ints that count as few.
const FEW: usize = 256;

/// Most steps of one answer.
const FUEL: u32 = 4096;

/// What a number can be.
#[derive(Clone, Debug, PartialEq)]
enum Can {
    Few(BTreeSet<i32>),
    Range(Range),
}

/// From `lo` to `hi`, which is left out if `open`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    lo: f64,
    hi: f64,
    open: bool,
}

const ALL: Range = Range { lo: f64::NEG_INFINITY, hi: f64::INFINITY, open: false };

fn range(lo: f64, hi: f64, open: bool) -> Range {
    if lo.is_nan() || hi.is_nan() { ALL } else { Range { lo, hi, open } }
}

impl Range {
    /// The largest whole number in it.
    fn last(self) -> f64 {
        if self.open && self.hi == self.hi.floor() { self.hi - 1.0 } else { self.hi.floor() }
    }

    fn each(self, f: impl Fn(f64) -> f64) -> Range {
        range(f(self.lo), f(self.hi), false)
    }
}

/// The upper end that is farther up, or the one that is not.
fn upper(a: Range, b: Range, farther: bool) -> (f64, bool) {
    if a.hi == b.hi {
        (a.hi, if farther { a.open && b.open } else { a.open || b.open })
    } else if (a.hi > b.hi) == farther {
        (a.hi, a.open)
    } else {
        (b.hi, b.open)
    }
}

fn least(a: Range, b: Range) -> Range {
    let (hi, open) = upper(a, b, false);
    range(a.lo.min(b.lo), hi, open)
}

fn most(a: Range, b: Range) -> Range {
    let (hi, open) = upper(a, b, true);
    range(a.lo.max(b.lo), hi, open)
}

impl Can {
    fn bits() -> Can {
        Can::Few(BTreeSet::from([0, 1]))
    }

    fn all() -> Can {
        Can::Range(ALL)
    }

    fn range(&self) -> Range {
        match self {
            Can::Range(r) => *r,
            Can::Few(set) => match (set.first(), set.last()) {
                (Some(lo), Some(hi)) => range(f64::from(*lo), f64::from(*hi), false),
                _ => ALL,
            },
        }
    }

    /// As an int: whole numbers, few where they are few, and anything where it may overflow.
    fn int(self) -> Can {
        let Can::Range(r) = self else { return self };
        let (lo, hi) = (r.lo.ceil(), r.last());
        if lo < f64::from(i32::MIN) || hi > f64::from(i32::MAX) {
            return Can::Range(range(f64::from(i32::MIN), f64::from(i32::MAX), false));
        }
        if hi - lo < FEW as f64 {
            Can::Few((lo as i32..=hi as i32).collect())
        } else {
            Can::Range(range(lo, hi, false))
        }
    }

    fn or(self, other: Can) -> Can {
        match (self, other) {
            (Can::Few(mut a), Can::Few(b)) => {
                a.extend(b);
                Can::Few(a)
            }
            // Nothing at all adds nothing.
            (Can::Few(none), other) | (other, Can::Few(none)) if none.is_empty() => other,
            (a, b) => {
                let (a, b) = (a.range(), b.range());
                let (hi, open) = upper(a, b, true);
                Can::Range(range(a.lo.min(b.lo), hi, open))
            }
        }
    }
}

/// Answers for one shader, until it is rewritten.
pub(super) struct Numbers {
    sources: Strings,
    counters: Counters,
}

impl Numbers {
    pub fn of(shader: &Shader) -> Numbers {
        let sources = Strings::of_types(shader, &|ty| matches!(ty, Ty::Int | Ty::Float));
        Numbers { sources, counters: Counters::of(shader) }
    }

    /// The ints that a value can be; `None` when they are not few.
    pub fn few(&self, shader: &Shader, value: ValueId) -> Option<BTreeSet<i32>> {
        match (Walk { shader, numbers: self, inside: Vec::new(), computed: 0, fuel: FUEL }).value(value) {
            Can::Few(set) => Some(set),
            Can::Range(_) => None,
        }
    }
}

struct Walk<'a> {
    shader: &'a Shader,
    numbers: &'a Numbers,
    /// The locals whose stores are being looked at, and how much was computed on the way to each.
    inside: Vec<(LocalId, u32)>,
    /// Instructions on the way here that do more than hand on a value.
    computed: u32,
    fuel: u32,
}

impl Walk<'_> {
    fn value(&mut self, v: ValueId) -> Can {
        if self.fuel == 0 {
            return Can::all();
        }
        self.fuel -= 1;
        let value = &self.shader.values[v.0 as usize];
        let can = match &value.inst {
            Inst::Const(Const::Int(i)) => Can::Few(BTreeSet::from([*i])),
            Inst::Const(Const::Float(x)) => Can::Range(range(*x, *x, false)),
            Inst::Load(l) => match self.counter(v) {
                Some(can) => can,
                None => self.local(*l),
            },
            Inst::LoadElem(l, _) => self.local(*l),
            Inst::Select(_, a, b) => {
                let a = self.value(*a);
                a.or(self.value(*b))
            }
            inst => {
                self.computed += 1;
                let can = self.computed(inst, value.ty);
                self.computed -= 1;
                can
            }
        };
        if value.ty == Ty::Int { can.int() } else { can }
    }

    fn local(&mut self, l: LocalId) -> Can {
        // Handing a value on in a circle adds nothing; computing in a circle may yield anything.
        if let Some((_, computed)) = self.inside.iter().find(|(other, _)| *other == l) {
            return if *computed == self.computed { Can::Few(BTreeSet::new()) } else { Can::all() };
        }
        let Some((values, copies)) = self.numbers.sources.stored(l) else { return Can::all() };
        self.inside.push((l, self.computed));
        let mut can = Can::Few(BTreeSet::new());
        for v in values {
            let next = self.value(*v);
            can = can.or(next);
        }
        for from in copies {
            let next = self.local(*from);
            can = can.or(next);
        }
        self.inside.pop();
        can
    }

    /// A loop's counter, read inside the loop.
    fn counter(&mut self, load: ValueId) -> Option<Can> {
        let (counter, after) = self.numbers.counters.read_by(load)?;
        self.computed += 1;
        let first = self.value(counter.first).range();
        let bound = self.value(counter.bound).range();
        self.computed -= 1;
        let step = f64::from(counter.step);
        let shift = if after { step } else { 0.0 };
        let last = if counter.including { 0.0 } else { step.signum() };
        let (lo, hi) = if step > 0.0 {
            let hi = bound.hi - last;
            (first.lo, if counter.tested_after { hi.max(first.hi) } else { hi })
        } else {
            let lo = bound.lo - last;
            (if counter.tested_after { lo.min(first.lo) } else { lo }, first.hi)
        };
        let none = || Can::Few(BTreeSet::new());
        Some(if lo > hi { none() } else { Can::Range(range(lo + shift, hi + shift, false)) })
    }

    fn computed(&mut self, inst: &Inst, ty: Ty) -> Can {
        match inst {
            Inst::Unary(UnaryOp::Not, _) => Can::bits(),
            Inst::Unary(UnaryOp::Neg, a) => match self.value(*a) {
                Can::Few(set) => Can::Few(set.iter().map(|i| i.wrapping_neg()).collect()),
                Can::Range(r) => Can::Range(range(-r.hi, -r.lo, false)),
            },
            Inst::Convert(a) if ty == Ty::Float => {
                let r = self.value(*a).range();
                Can::Range(r)
            }
            Inst::Convert(a) => {
                let r = self.value(*a).range();
                let hi = if r.hi > 0.0 { r.last() } else { r.hi.trunc() };
                Can::Range(range(r.lo.trunc().max(f64::from(i32::MIN)), hi.min(f64::from(i32::MAX)), false))
            }
            Inst::Binary(op, a, b) => {
                let numbers = |v: &ValueId| matches!(self.shader.values[v.0 as usize].ty, Ty::Int | Ty::Float);
                let (a, b) = if numbers(a) { (self.value(*a), self.value(*b)) } else { (Can::all(), Can::all()) };
                binary(*op, &a, &b, ty)
            }
            Inst::Component(t, _) => match &self.shader.values[t.0 as usize].inst {
                Inst::Call(func, _) => unit(*func),
                _ => Can::all(),
            },
            Inst::Call(func, args) => {
                let mut cans = Vec::new();
                for arg in args {
                    cans.push(match arg {
                        Arg::Value(v) if matches!(self.shader.values[v.0 as usize].ty, Ty::Int | Ty::Float) => {
                            self.value(*v)
                        }
                        _ => Can::all(),
                    });
                }
                call(*func, ty, &cans)
            }
            _ => Can::all(),
        }
    }
}

/// Noises of cells: from 0 to 1. Of their 2^32 values one is 1; it counts as what is below.
fn unit(func: FuncId) -> Can {
    match builtins::row(func).name {
        "noise_cell" | "noise_hash" => Can::Range(range(0.0, 1.0, true)),
        _ => Can::all(),
    }
}

fn compares(op: BinaryOp) -> bool {
    matches!(op, BinaryOp::Eq | BinaryOp::Ne | BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge)
}

fn binary(op: BinaryOp, a: &Can, b: &Can, ty: Ty) -> Can {
    if let (Can::Few(x), Can::Few(y)) = (a, b)
        && let Some(set) = pairs(x, y, &|i, j| {
            let inst = Inst::Binary(op, ValueId(0), ValueId(0));
            ops::evaluate(&inst, ty, &[Const::Int(i), Const::Int(j)])
        })
    {
        return set;
    }
    let (a, b) = (a.range(), b.range());
    let constant = (b.lo == b.hi).then_some(b.lo);
    Can::Range(match op {
        op if compares(op) => return Can::bits(),
        BinaryOp::Add => range(a.lo + b.lo, a.hi + b.hi, a.open || b.open),
        BinaryOp::Sub => range(a.lo - b.hi, a.hi - b.lo, a.open),
        BinaryOp::Mul => {
            let ends = [a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi];
            if ends.iter().any(|x| x.is_nan()) {
                return Can::all();
            }
            let open = (a.open || b.open) && a.lo >= 0.0 && b.lo >= 0.0;
            range(ends.iter().copied().fold(ends[0], f64::min), ends.iter().copied().fold(ends[0], f64::max), open)
        }
        BinaryOp::Div => match constant {
            Some(c) if c > 0.0 && ty == Ty::Float => range(a.lo / c, a.hi / c, a.open),
            Some(c) if c > 0.0 => range((a.lo / c).trunc(), (a.hi / c).trunc(), false),
            _ => ALL,
        },
        BinaryOp::Mod => match constant {
            Some(c) if c != 0.0 => remainder(a, c.abs() - 1.0, false),
            _ => ALL,
        },
        BinaryOp::BitAnd if a.lo >= 0.0 => range(0.0, a.hi.min(if b.lo >= 0.0 { b.hi } else { a.hi }), false),
        BinaryOp::BitAnd if b.lo >= 0.0 => range(0.0, b.hi, false),
        _ => ALL,
    })
}

/// What is left of a division: no larger than `most`, and with the sign of `a`.
fn remainder(a: Range, most: f64, open: bool) -> Range {
    range(if a.lo >= 0.0 { 0.0 } else { -most }, if a.hi <= 0.0 { 0.0 } else { most }, open)
}

/// The results for all pairs, where they are few ints.
fn pairs(a: &BTreeSet<i32>, b: &BTreeSet<i32>, f: &dyn Fn(i32, i32) -> Option<Const>) -> Option<Can> {
    if a.len().saturating_mul(b.len()) > FUEL as usize {
        return None;
    }
    let mut set = BTreeSet::new();
    for i in a {
        for j in b {
            let Some(Const::Int(k)) = f(*i, *j) else { return None };
            set.insert(k);
        }
    }
    (set.len() <= FEW).then_some(Can::Few(set))
}

fn call(func: FuncId, ty: Ty, args: &[Can]) -> Can {
    if let (Ty::Int, [Can::Few(a), Can::Few(b)]) = (ty, args)
        && let Some(set) = pairs(a, b, &|i, j| interp::fold_call(func, ty, &[Const::Int(i), Const::Int(j)]))
    {
        return set;
    }
    let ranges: Vec<Range> = args.iter().map(Can::range).collect();
    Can::Range(match (builtins::row(func).name, ranges.as_slice()) {
        ("min", [a, b]) => least(*a, *b),
        ("max", [a, b]) => most(*a, *b),
        ("clamp", [x, a, b]) => most(least(*x, *b), *a),
        ("abs" | "fabs", [a]) if a.lo >= 0.0 => *a,
        ("abs" | "fabs", [a]) => range(0.0, a.hi.abs().max(a.lo.abs()), false),
        ("floor", [a]) => range(a.lo.floor(), a.last(), false),
        ("ceil", [a]) => a.each(f64::ceil),
        ("round", [a]) => a.each(f64::round),
        ("trunc", [a]) => a.each(f64::trunc),
        ("mod", [a, b]) if ty == Ty::Int && b.lo == b.hi && b.lo > 0.0 => remainder(*a, b.lo - 1.0, false),
        ("mod", [_, b]) if ty == Ty::Float && b.lo == b.hi && b.lo > 0.0 => range(0.0, b.lo, true),
        ("fmod", [a, b]) if b.lo == b.hi && b.lo != 0.0 => remainder(*a, b.lo.abs(), true),
        ("sign", [_]) => range(-1.0, 1.0, false),
        ("step" | "smoothstep", _) => range(0.0, 1.0, false),
        ("raytype" | "backfacing" | "isnan" | "isinf" | "isfinite" | "startswith" | "endswith", _) => {
            return Can::bits();
        }
        _ => return unit(func),
    })
}
