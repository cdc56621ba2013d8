//! OSL's step functions (specification ch. 7.6) on constants.
//!
//! In: a row's name and its arguments. Out: the value, `None` when the name is not one of these. Where both edges coincide
//! they are all `step` (kernels/osl/pattern.h).

use super::each;
use super::math::{clamp, quotient};
use crate::ir::Const;

fn step(edge: f64, x: f64) -> f64 {
    if x < edge { 0.0 } else { 1.0 }
}

fn linearstep(low: f64, high: f64, x: f64) -> f64 {
    if low == high { step(low, x) } else { clamp((x - low) / (high - low), 0.0, 1.0) }
}

fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    if x < low {
        0.0
    } else if x >= high {
        1.0
    } else {
        let t = (x - low) / (high - low);
        t * t * (3.0 - 2.0 * t)
    }
}

/// `linearstep` whose corners are parabolas over eps on either side.
fn smooth_linearstep(low: f64, high: f64, x: f64, eps: f64) -> f64 {
    if low == high {
        return step(low, x);
    }
    let scale = quotient(1.0, high - low);
    let (t, e) = ((x - low) * scale, eps * scale);
    let k = quotient(0.25, e);
    if t <= -e {
        0.0
    } else if t >= e && t <= 1.0 - e {
        t
    } else if t >= 1.0 + e {
        1.0
    } else if t < e {
        k * (t + e) * (t + e)
    } else {
        1.0 - k * (1.0 + e - t) * (1.0 + e - t)
    }
}

/// The value of the row `name`.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    match name {
        "step" => each(args, |[edge, x]| step(edge, x)),
        "linearstep" => each(args, |[low, high, x]| linearstep(low, high, x)),
        "smoothstep" => each(args, |[low, high, x]| smoothstep(low, high, x)),
        "smooth_linearstep" => each(args, |[low, high, x, eps]| smooth_linearstep(low, high, x, eps)),
        _ => None,
    }
}
