//! Finds variables that hold zero for good, and makes what is read of them the constant 0.
//!
//! In: IR without closures. Out: the same with constants. Folding follows the flow of control and forgets what loops and branches
//! write; here a variable is known by all that is ever stored in it. A weight that only adds up zeros goes so, and its lobe with it.

use crate::builtins;
use crate::interp::ops;
use crate::ir::{Arg, BinaryOp, Const, Inst, LocalKind, Shader, Stmt, Ty, UnaryOp, Value, ValueId};

/// Most rounds; chains of variables that take more are left as they are.
const MAX_ROUNDS: u32 = 32;

/// Whether anything changed.
pub(super) fn zeros(shader: &mut Shader) -> bool {
    let mut dark: Vec<bool> = shader.locals.iter().map(|l| l.kind == LocalKind::Variable && is_number(l.ty)).collect();
    let mut zero = vec![false; shader.values.len()];
    for round in 0.. {
        if round == MAX_ROUNDS {
            return false;
        }
        for i in 0..zero.len() {
            zero[i] = is_zero(&shader.values[i], &zero, &dark);
        }
        let before = dark.clone();
        for block in shader.blocks() {
            block.walk(&mut |s| match s {
                Stmt::Store(l, v) | Stmt::StoreElem(l, _, v) => dark[l.0 as usize] &= zero[v.0 as usize],
                Stmt::CopyArray(to, from) => dark[to.0 as usize] &= dark[from.0 as usize],
                other => other.written(&mut |l| dark[l.0 as usize] = false),
            });
        }
        // Sets only shrink, so that this ends.
        if dark == before {
            break;
        }
    }
    let mut changed = false;
    for (value, _) in shader.values.iter_mut().zip(zero).filter(|(v, zero)| *zero && !matches!(v.inst, Inst::Const(_)))
    {
        if let Some(c) = ops::zero(value.ty) {
            value.inst = Inst::Const(c);
            changed = true;
        }
    }
    changed
}

fn is_number(ty: Ty) -> bool {
    matches!(ty, Ty::Int | Ty::Float | Ty::Triple)
}

/// Whether a value is zero if those before it that are marked are, and the variables that are marked.
fn is_zero(value: &Value, zero: &[bool], dark: &[bool]) -> bool {
    let is = |v: &ValueId| zero[v.0 as usize];
    is_number(value.ty)
        && match &value.inst {
            Inst::Const(Const::Int(x)) => *x == 0,
            Inst::Const(Const::Float(x)) => *x == 0.0,
            Inst::Const(Const::Triple(x)) => *x == [0.0; 3],
            Inst::Load(l) | Inst::LoadElem(l, _) => dark[l.0 as usize],
            Inst::Unary(UnaryOp::Neg, a) | Inst::Convert(a) | Inst::Component(a, _) => is(a),
            // As folding has it: zero times anything is zero.
            Inst::Binary(BinaryOp::Mul, a, b) => is(a) || is(b),
            Inst::Binary(BinaryOp::Div, a, _) => is(a),
            Inst::Binary(BinaryOp::Add | BinaryOp::Sub, a, b) | Inst::Select(_, a, b) => is(a) && is(b),
            Inst::WithComponent(a, _, b) => is(a) && is(b),
            Inst::Triple(parts) => parts.iter().all(is),
            Inst::Call(func, args) if builtins::row(*func).name == "mix_float" => {
                args.iter().take(2).all(|a| matches!(a, Arg::Value(v) if is(v)))
            }
            _ => false,
        }
}
