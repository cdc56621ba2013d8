//! Values of constant expressions, for metadata, array lengths and the defaults of the reflection.

use super::typed::{Expr, ExprKind};
use crate::ast::BinaryOp;
use crate::reflect::Value;
use crate::types::{Base, Type, truncated};

/// The value, when the expression is made of literals, conversions, constructors and arithmetic.
pub(crate) fn value(e: &Expr) -> Option<Value> {
    Some(match &e.kind {
        ExprKind::Int(v) => Value::Int(*v),
        ExprKind::Float(v) => Value::Float(*v),
        ExprKind::Str(s) => Value::Str(s.clone()),
        ExprKind::Convert(inner) => convert(value(inner)?, e.ty)?,
        ExprKind::Neg(inner) => map(value(inner)?, &|v| -v, &|v: i32| v.wrapping_neg())?,
        ExprKind::Compl(inner) => match value(inner)? {
            Value::Int(v) => Value::Int(!v),
            _ => return None,
        },
        ExprKind::List(items) => Value::List(items.iter().map(value).collect::<Option<Vec<_>>>()?),
        ExprKind::Construct(args) => construct(args, e.ty)?,
        ExprKind::Binary(op, l, r) => binary(*op, value(l)?, value(r)?)?,
        _ => return None,
    })
}

fn number(v: &Value) -> Option<f64> {
    match v {
        Value::Int(i) => Some(*i as f64),
        Value::Float(f) => Some(*f),
        _ => None,
    }
}

fn convert(v: Value, to: Type) -> Option<Value> {
    if to.is_array() {
        return Some(v);
    }
    Some(match (to.base, &v) {
        (Base::Int, _) => Value::Int(truncated(number(&v)?)),
        (Base::Float, _) => Value::Float(number(&v)?),
        (Base::Matrix, Value::Int(_) | Value::Float(_)) => {
            let d = number(&v)?;
            Value::List((0..16).map(|i| Value::Float(if i % 5 == 0 { d } else { 0.0 })).collect())
        }
        (b, Value::Int(_) | Value::Float(_)) if b.is_triple() => Value::List(vec![Value::Float(number(&v)?); 3]),
        (Base::Closure, _) => return None,
        _ => v,
    })
}

fn construct(args: &[Expr], ty: Type) -> Option<Value> {
    let parts = args.iter().map(value).collect::<Option<Vec<_>>>()?;
    let wanted = if ty.base == Base::Matrix { 16 } else { 3 };
    if parts.len() == wanted {
        return Some(Value::List(parts));
    }
    match parts.into_iter().next() {
        Some(only) if args.len() == 1 => convert(only, ty),
        _ => None,
    }
}

fn map(v: Value, f: &dyn Fn(f64) -> f64, i: &dyn Fn(i32) -> i32) -> Option<Value> {
    Some(match v {
        Value::Int(v) => Value::Int(i(v)),
        Value::Float(v) => Value::Float(f(v)),
        Value::List(items) => Value::List(items.into_iter().map(|v| map(v, f, i)).collect::<Option<Vec<_>>>()?),
        Value::Str(_) => return None,
    })
}

fn binary(op: BinaryOp, l: Value, r: Value) -> Option<Value> {
    Some(match (l, r) {
        (Value::Int(a), Value::Int(b)) => Value::Int(match op {
            BinaryOp::Add => a.wrapping_add(b),
            BinaryOp::Sub => a.wrapping_sub(b),
            BinaryOp::Mul => a.wrapping_mul(b),
            BinaryOp::Div => {
                if b == 0 {
                    0
                } else {
                    a.wrapping_div(b)
                }
            }
            BinaryOp::Mod => {
                if b == 0 {
                    0
                } else {
                    a.wrapping_rem(b)
                }
            }
            BinaryOp::BitOr => a | b,
            BinaryOp::BitAnd => a & b,
            BinaryOp::BitXor => a ^ b,
            BinaryOp::Shl => a.wrapping_shl(b as u32),
            BinaryOp::Shr => a.wrapping_shr(b as u32),
            _ => return None,
        }),
        (Value::Float(a), Value::Float(b)) => Value::Float(match op {
            BinaryOp::Add => a + b,
            BinaryOp::Sub => a - b,
            BinaryOp::Mul => a * b,
            BinaryOp::Div => {
                if b == 0.0 {
                    0.0
                } else {
                    a / b
                }
            }
            _ => return None,
        }),
        (Value::List(a), Value::List(b)) if a.len() == b.len() && a.len() == 3 => {
            Value::List(a.into_iter().zip(b).map(|(a, b)| binary(op, a, b)).collect::<Option<Vec<_>>>()?)
        }
        _ => return None,
    })
}
