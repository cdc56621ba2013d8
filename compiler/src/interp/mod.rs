//! Runs the IR on the host, in f64.
//!
//! In: IR. Out: values. It is the constant folder's engine and the oracle of the tests. It must not know the syntax tree or
//! any target.
//!
//! The library of functions is written anew from the definitions that kernels/osl/ documents, in f64 and without regard for
//! speed, so that it can stand against the kernels.

mod color;
mod geometric;
mod hash;
mod math;
mod noise;
mod noise_gabor;
mod noise_gradient;
mod noise_simplex;
pub mod ops;
mod pattern;
mod points;
mod run;
mod spline;
mod state;
#[cfg(test)]
mod tests;
mod texture;

pub use run::{Error, Outcome, Slot, run};
pub use state::{Globals, Space};

use crate::builtins::{self, FuncId};
use crate::ir::{Const, Ty};
use crate::text;

/// The value of a built-in call on constants; `None` when it reads renderer state, is not known here, or has a result that
/// the device should make itself: one that is not a finite 32-bit float.
///
/// Arguments are not rounded to 32 bits first: what is folded is what the f64 precision computes. Hashes of floats round
/// on their own.
pub fn fold_call(func: FuncId, ret: Ty, args: &[Const]) -> Option<Const> {
    let value = call(builtins::row(func).name, ret, args)?;
    let harmless = |x: &f64| x.abs() <= math::FLT_MAX;
    let whole = match &value {
        Const::Float(x) => harmless(x),
        Const::Triple(v) => v.iter().all(harmless),
        Const::Matrix(m) => m.iter().all(harmless),
        _ => true,
    };
    (whole && value.ty() == Some(ret)).then_some(value)
}

/// A built-in that is a function of its arguments alone.
fn call(name: &str, ret: Ty, args: &[Const]) -> Option<Const> {
    match (name, args) {
        // What gets here is constant.
        ("is_constant", [_]) => return Some(Const::Int(1)),
        ("array_length", [Const::Array(items)]) => return Some(Const::Int(items.len() as i32)),
        _ => {}
    }
    math::call(name, args)
        .or_else(|| geometric::call(name, args))
        .or_else(|| color::call(name, args))
        .or_else(|| pattern::call(name, args))
        .or_else(|| noise::call(name, ret, args))
        .or_else(|| hash::call(name, args))
        .or_else(|| spline::call(name, args))
        .or_else(|| text::call(name, args))
}

/// A built-in on constants that writes to one array on the host: the elements to write, from the first on, and its result.
pub fn fold_call_with_output(func: FuncId, args: &[Const], room: usize) -> Option<(Vec<Const>, Const)> {
    text::call_with_output(builtins::row(func).name, args, room)
}

/// A built-in with output arguments: their values in order.
fn call_with_outputs(name: &str, args: &[Const]) -> Option<Vec<Const>> {
    match name {
        "sincos" => math::sincos(args),
        "fresnel" => geometric::fresnel(args),
        _ => None,
    }
}

/// Applies a function of floats; when any argument is a triple to each component, floats being used for each.
fn each<const N: usize>(args: &[Const], f: impl Fn([f64; N]) -> f64) -> Option<Const> {
    if args.len() != N {
        return None;
    }
    let component = |k: usize| {
        let mut x = [0.0; N];
        for (to, from) in x.iter_mut().zip(args) {
            *to = match from {
                Const::Float(v) => *v,
                Const::Triple(v) => v[k],
                _ => return None,
            };
        }
        Some(f(x))
    };
    if args.iter().any(|a| matches!(a, Const::Triple(_))) {
        Some(Const::Triple([component(0)?, component(1)?, component(2)?]))
    } else {
        component(0).map(Const::Float)
    }
}

fn float(args: &[Const], i: usize) -> Option<f64> {
    match args.get(i)? {
        Const::Float(v) => Some(*v),
        _ => None,
    }
}

fn triple(args: &[Const], i: usize) -> Option<[f64; 3]> {
    match args.get(i)? {
        Const::Triple(v) => Some(*v),
        _ => None,
    }
}

fn matrix(args: &[Const], i: usize) -> Option<&[f64; 16]> {
    match args.get(i)? {
        Const::Matrix(m) => Some(m),
        _ => None,
    }
}
