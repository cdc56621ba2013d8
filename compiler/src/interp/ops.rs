//! The operators of the IR on constants, in f64, with OSL's defined results for bad arithmetic.
//!
//! In: an instruction and its operands' values. Out: its value. This is the one place on the host that says what
//! operators mean; the folder and the interpreter both ask it.

use crate::ir::{BinaryOp, Const, Inst, Ty, UnaryOp};
use crate::types::truncated;

/// The identity, row-major.
pub const IDENTITY: [f64; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

/// Whether a constant counts as true.
pub fn is_true(c: &Const) -> bool {
    match c {
        Const::Int(v) => *v != 0,
        Const::Float(v) => *v != 0.0,
        Const::Triple(v) => v.iter().any(|x| *x != 0.0),
        Const::Matrix(v) => v.iter().any(|x| *x != 0.0),
        Const::Str(s) => !s.is_empty(),
        Const::Array(_) => true,
    }
}

/// Zero or "" of a type; `None` for closures.
pub fn zero(ty: Ty) -> Option<Const> {
    Some(match ty {
        Ty::Int => Const::Int(0),
        Ty::Float => Const::Float(0.0),
        Ty::Triple => Const::Triple([0.0; 3]),
        Ty::Matrix => Const::Matrix([0.0; 16]),
        Ty::Str => Const::Str(String::new()),
        Ty::Closure => return None,
    })
}

/// The value of a pure instruction that is no call, from its operands in order; `None` when it is none or when the types
/// are not as verified.
pub fn evaluate(inst: &Inst, ty: Ty, args: &[Const]) -> Option<Const> {
    Some(match (inst, args) {
        (Inst::Const(c), _) => c.clone(),
        (Inst::Unary(op, _), [a]) => unary(*op, a)?,
        (Inst::Binary(op, _, _), [a, b]) => binary(*op, a, b)?,
        (Inst::Convert(_), [a]) => convert(a, ty)?,
        (Inst::Triple(_), [Const::Float(x), Const::Float(y), Const::Float(z)]) => Const::Triple([*x, *y, *z]),
        (Inst::Matrix(_), parts) => {
            let mut m = [0.0; 16];
            for (to, part) in m.iter_mut().zip(parts) {
                let Const::Float(x) = part else { return None };
                *to = *x;
            }
            Const::Matrix(m)
        }
        (Inst::Component(..), [Const::Triple(v), Const::Int(i)]) => Const::Float(v[clamp(*i, 3)]),
        (Inst::MatrixElement(..), [Const::Matrix(m), Const::Int(r), Const::Int(c)]) => {
            Const::Float(m[clamp(*r, 4) * 4 + clamp(*c, 4)])
        }
        (Inst::WithComponent(..), [Const::Triple(v), Const::Int(i), Const::Float(x)]) => {
            let mut v = *v;
            v[clamp(*i, 3)] = *x;
            Const::Triple(v)
        }
        (Inst::WithMatrixElement(..), [Const::Matrix(m), Const::Int(r), Const::Int(c), Const::Float(x)]) => {
            let mut m = *m;
            m[clamp(*r, 4) * 4 + clamp(*c, 4)] = *x;
            Const::Matrix(m)
        }
        (Inst::Select(..), [c, a, b]) => {
            if is_true(c) {
                a.clone()
            } else {
                b.clone()
            }
        }
        _ => return None,
    })
}

/// An index in 0..len, as OSL clamps it.
pub fn clamp(index: i32, len: usize) -> usize {
    (index.max(0) as usize).min(len - 1)
}

fn unary(op: UnaryOp, a: &Const) -> Option<Const> {
    Some(match (op, a) {
        (UnaryOp::Neg, Const::Int(v)) => Const::Int(v.wrapping_neg()),
        (UnaryOp::Neg, Const::Float(v)) => Const::Float(-v),
        (UnaryOp::Neg, Const::Triple(v)) => Const::Triple(v.map(|x| -x)),
        (UnaryOp::Neg, Const::Matrix(m)) => Const::Matrix(m.map(|x| -x)),
        (UnaryOp::Compl, Const::Int(v)) => Const::Int(!v),
        (UnaryOp::Not, Const::Int(v)) => Const::Int((*v == 0) as i32),
        _ => return None,
    })
}

/// int -> float, float -> int (`truncated`), float -> triple, float -> matrix (diagonal).
fn convert(a: &Const, to: Ty) -> Option<Const> {
    Some(match (a, to) {
        (Const::Int(v), Ty::Float) => Const::Float(*v as f64),
        (Const::Float(v), Ty::Int) => Const::Int(truncated(*v)),
        (Const::Float(v), Ty::Triple) => Const::Triple([*v; 3]),
        (Const::Float(v), Ty::Matrix) => Const::Matrix(IDENTITY.map(|x| x * v)),
        _ => return None,
    })
}

/// A quotient that is no finite 32-bit float is 0 (OSL's reference implementation; the specification leaves it open).
pub fn divide(a: f64, b: f64) -> f64 {
    super::math::quotient(a, b)
}

fn binary(op: BinaryOp, a: &Const, b: &Const) -> Option<Const> {
    use BinaryOp::*;
    match (a, b) {
        (Const::Int(a), Const::Int(b)) => Some(Const::Int(int(op, *a, *b))),
        (Const::Float(a), Const::Float(b)) => {
            let (a, b) = (*a, *b);
            Some(match op {
                Add | Sub | Mul | Div => Const::Float(float(op, a, b)?),
                Eq => Const::Int((a == b) as i32),
                Ne => Const::Int((a != b) as i32),
                Lt => Const::Int((a < b) as i32),
                Le => Const::Int((a <= b) as i32),
                Gt => Const::Int((a > b) as i32),
                Ge => Const::Int((a >= b) as i32),
                _ => return None,
            })
        }
        (Const::Triple(a), Const::Triple(b)) => match op {
            Eq => Some(Const::Int((a == b) as i32)),
            Ne => Some(Const::Int((a != b) as i32)),
            _ => {
                let mut out = [0.0; 3];
                for i in 0..3 {
                    out[i] = float(op, a[i], b[i])?;
                }
                Some(Const::Triple(out))
            }
        },
        (Const::Matrix(a), Const::Matrix(b)) => Some(match op {
            Eq => Const::Int((a == b) as i32),
            Ne => Const::Int((a != b) as i32),
            Mul => Const::Matrix(matrix_product(a, b)),
            Div => Const::Matrix(matrix_product(a, &matrix_inverse(b))),
            _ => return None,
        }),
        (Const::Str(a), Const::Str(b)) => match op {
            Eq => Some(Const::Int((a == b) as i32)),
            Ne => Some(Const::Int((a != b) as i32)),
            _ => None,
        },
        _ => None,
    }
}

fn float(op: BinaryOp, a: f64, b: f64) -> Option<f64> {
    Some(match op {
        BinaryOp::Add => a + b,
        BinaryOp::Sub => a - b,
        BinaryOp::Mul => a * b,
        BinaryOp::Div => divide(a, b),
        _ => return None,
    })
}

fn int(op: BinaryOp, a: i32, b: i32) -> i32 {
    use BinaryOp::*;
    match op {
        Add => a.wrapping_add(b),
        Sub => a.wrapping_sub(b),
        Mul => a.wrapping_mul(b),
        Div => {
            if b == 0 {
                0
            } else {
                a.wrapping_div(b)
            }
        }
        Mod => {
            if b == 0 {
                0
            } else {
                a.wrapping_rem(b)
            }
        }
        Eq => (a == b) as i32,
        Ne => (a != b) as i32,
        Lt => (a < b) as i32,
        Le => (a <= b) as i32,
        Gt => (a > b) as i32,
        Ge => (a >= b) as i32,
        BitAnd => a & b,
        BitOr => a | b,
        BitXor => a ^ b,
        Shl => a.wrapping_shl(b as u32),
        Shr => a.wrapping_shr(b as u32),
    }
}

/// `a b` for row vectors: first a, then b. Row-major.
pub fn matrix_product(a: &[f64; 16], b: &[f64; 16]) -> [f64; 16] {
    let mut out = [0.0; 16];
    for r in 0..4 {
        for c in 0..4 {
            out[r * 4 + c] = (0..4).map(|k| a[r * 4 + k] * b[k * 4 + c]).sum();
        }
    }
    out
}

/// The determinant, by minors of pairs of rows: exact for small integers.
pub fn matrix_determinant(m: &[f64; 16]) -> f64 {
    let minor =
        |row: usize, i: usize, j: usize| m[row * 4 + i] * m[row * 4 + 4 + j] - m[row * 4 + 4 + i] * m[row * 4 + j];
    // Pairs of columns for the upper rows, the others for the lower ones, and the permutation's sign.
    let pairs = [
        (0, 1, 2, 3, 1.0),
        (0, 2, 1, 3, -1.0),
        (0, 3, 1, 2, 1.0),
        (1, 2, 0, 3, 1.0),
        (1, 3, 0, 2, -1.0),
        (2, 3, 0, 1, 1.0),
    ];
    pairs.into_iter().map(|(i, j, k, l, sign)| sign * minor(0, i, j) * minor(2, k, l)).sum()
}

/// The inverse by Gauss-Jordan elimination with partial pivoting; the identity when the matrix is singular, as the
/// reference implementation's: when one over the determinant is no finite 32-bit float.
pub fn matrix_inverse(m: &[f64; 16]) -> [f64; 16] {
    if divide(1.0, matrix_determinant(m)) == 0.0 {
        return IDENTITY;
    }
    let mut a = *m;
    let mut inv = IDENTITY;
    for col in 0..4 {
        let pivot = (col..4).max_by(|&i, &j| a[i * 4 + col].abs().total_cmp(&a[j * 4 + col].abs())).unwrap_or(col);
        let p = a[pivot * 4 + col];
        if p == 0.0 || !p.is_finite() {
            return IDENTITY;
        }
        for k in 0..4 {
            a.swap(col * 4 + k, pivot * 4 + k);
            inv.swap(col * 4 + k, pivot * 4 + k);
        }
        for k in 0..4 {
            a[col * 4 + k] /= p;
            inv[col * 4 + k] /= p;
        }
        for row in (0..4).filter(|r| *r != col) {
            let f = a[row * 4 + col];
            for k in 0..4 {
                a[row * 4 + k] -= f * a[col * 4 + k];
                inv[row * 4 + k] -= f * inv[col * 4 + k];
            }
        }
    }
    inv
}
