//! OSL's mathematical functions (specification ch. 7.1) on constants.
//!
//! In: a row's name and its arguments. Out: the value, `None` when the name is not one of these. kernels/osl/math.h says
//! what bad arguments give; the limits are those of a 32-bit float here too.

use super::{each, float};
use crate::ir::Const;

/// Largest finite float.
pub const FLT_MAX: f64 = f32::MAX as f64;
/// Smallest normal float.
pub const FLT_MIN: f64 = f32::MIN_POSITIVE as f64;

/// a / b; 0 when that is no finite float.
pub fn quotient(a: f64, b: f64) -> f64 {
    let q = a / b;
    if q.abs() <= FLT_MAX { q } else { 0.0 }
}

/// Where the exponentials of the reference implementation stop: 2^126, and 2^-126 below (`FLT_MIN`).
const POWER_MAX: f64 = 8.507_059_173_023_461e37;

/// A power within those limits; NaN is the smallest.
fn power(x: f64) -> f64 {
    if x > FLT_MIN { x.min(POWER_MAX) } else { FLT_MIN }
}

/// What a logarithm takes: positive, normal, finite. NaN is the smallest.
fn log_argument(x: f64) -> f64 {
    if x > FLT_MIN { x.min(FLT_MAX) } else { FLT_MIN }
}

fn unit(x: f64) -> f64 {
    // `clamp` keeps NaN.
    x.clamp(-1.0, 1.0)
}

/// 0 for negative numbers and NaN.
pub fn sqrt(x: f64) -> f64 {
    if x >= 0.0 { x.sqrt() } else { 0.0 }
}

/// x to the y; 0 where that has no real value. From 2^24 on every y is even, as floats are.
pub fn pow(x: f64, y: f64) -> f64 {
    if y == 0.0 {
        return 1.0;
    } else if x == 0.0 {
        return 0.0;
    } else if y == 1.0 {
        return x;
    } else if y == 2.0 {
        return if x * x > FLT_MAX { FLT_MAX } else { x * x };
    }
    // C's power of 1 is 1 for any exponent, the reference's is 2 to the 0 * y.
    let base = log_argument(x.abs());
    let size = power(if base == 1.0 { (0.0 * y).exp2() } else { base.powf(y) });
    let fits = y.abs() < 16_777_216.0;
    if x < 0.0 && fits && y != y.floor() {
        0.0
    } else if x < 0.0 && fits && y % 2.0 != 0.0 {
        -size
    } else {
        size
    }
}

fn expm1(x: f64) -> f64 {
    if x > -100.0 { x.exp_m1().min(POWER_MAX) } else { -1.0 }
}

fn log(x: f64) -> f64 {
    log_argument(x).ln()
}

/// The exponent of |x|: its 11 bits, without the bias. That of NaN is a float's, as in the reference.
fn logb(x: f64) -> f64 {
    if x.is_nan() {
        return 128.0;
    }
    let bits = log_argument(x.abs()).to_bits();
    (bits >> 52) as f64 - 1023.0
}

fn sign(x: f64) -> f64 {
    if x < 0.0 {
        -1.0
    } else if x == 0.0 {
        0.0
    } else {
        1.0
    }
}

fn fmod(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a % b }
}

/// a - b floor(a / b), with one rounding; a where b is 0. For large quotients the exact remainder with the sign of b.
fn modulo(a: f64, b: f64) -> f64 {
    let q = quotient(a, b).floor();
    if q.abs() < 0.25 / f64::EPSILON {
        return (-b).mul_add(q, a);
    }
    let r = a % b;
    if r != 0.0 && (r < 0.0) != (b < 0.0) { r + b } else { r }
}

/// The first unless the second is smaller.
pub fn min(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The first unless the second is larger.
pub fn max(a: f64, b: f64) -> f64 {
    if a < b { b } else { a }
}

/// The lower bound wins over the upper one.
pub fn clamp(x: f64, low: f64, high: f64) -> f64 {
    max(min(x, high), low)
}

fn ints(name: &str, args: &[Const]) -> Option<i32> {
    let mut v = [0; 3];
    for (to, from) in v.iter_mut().zip(args) {
        let Const::Int(i) = from else { return None };
        *to = *i;
    }
    let [a, b, c] = v;
    Some(match (name, args.len()) {
        ("abs" | "fabs", 1) => a.wrapping_abs(),
        ("mod", 2) if b == 0 => a,
        ("mod", 2) => a.wrapping_rem(b),
        ("min", 2) => a.min(b),
        ("max", 2) => a.max(b),
        ("clamp", 3) => a.min(c).max(b),
        _ => return None,
    })
}

/// The value of the row `name`.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    if let Some(Const::Int(_)) = args.first() {
        return ints(name, args).map(Const::Int);
    }
    let one = |f: fn(f64) -> f64| each(args, |[x]| f(x));
    let two = |f: fn(f64, f64) -> f64| each(args, |[x, y]| f(x, y));
    let count = args.len();
    match name {
        "radians" => one(f64::to_radians),
        "degrees" => one(f64::to_degrees),
        "sin" => one(f64::sin),
        "cos" => one(f64::cos),
        "tan" => one(f64::tan),
        "asin" => one(|x| unit(x).asin()),
        "acos" => one(|x| unit(x).acos()),
        "atan" => one(f64::atan),
        "atan2" => two(f64::atan2),
        "sinh" => one(|x| x.sinh().clamp(-POWER_MAX / 2.0, POWER_MAX / 2.0)),
        // `min` takes the number of a number and a NaN.
        "cosh" => one(|x| x.cosh().min(POWER_MAX / 2.0)),
        "tanh" => one(f64::tanh),
        "pow" => two(pow),
        "exp" => one(|x| power(x.exp())),
        "exp2" => one(|x| power(x.exp2())),
        "expm1" => one(expm1),
        "log" if count == 1 => one(log),
        "log" => two(|x, base| quotient(log(x), log(base))),
        "log2" => one(|x| log_argument(x).log2()),
        "log10" => one(|x| log_argument(x).log10()),
        "logb" => one(logb),
        "sqrt" => one(sqrt),
        "inversesqrt" => one(|x| if x > 0.0 { 1.0 / x.sqrt() } else { 0.0 }),
        "cbrt" => one(f64::cbrt),
        "hypot" if count == 2 => two(|x, y| sqrt(x * x + y * y)),
        "hypot" => each(args, |[x, y, z]| sqrt(x * x + y * y + z * z)),
        "abs" | "fabs" => one(f64::abs),
        "sign" => one(sign),
        "floor" => one(f64::floor),
        "ceil" => one(f64::ceil),
        "round" => one(f64::round),
        "trunc" => one(f64::trunc),
        "fmod" => two(fmod),
        "mod" => two(modulo),
        "min" => two(min),
        "max" => two(max),
        "clamp" => each(args, |[x, low, high]| clamp(x, low, high)),
        "mix_float" => each(args, |[a, b, t]| a * (1.0 - t) + b * t),
        "select_nonzero" => each(args, |[a, b, condition]| if condition != 0.0 { b } else { a }),
        "isnan" => Some(Const::Int(float(args, 0)?.is_nan().into())),
        "isinf" => Some(Const::Int(float(args, 0)?.is_infinite().into())),
        "isfinite" => Some(Const::Int(float(args, 0)?.is_finite().into())),
        "erf" => one(libm::erf),
        "erfc" => one(libm::erfc),
        _ => None,
    }
}

/// Sine and cosine.
pub(super) fn sincos(args: &[Const]) -> Option<Vec<Const>> {
    Some(vec![each(args, |[x]| x.sin())?, each(args, |[x]| x.cos())?])
}
