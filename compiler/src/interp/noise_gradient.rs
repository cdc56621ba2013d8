//! Perlin's gradient noise in 1 to 4 dimensions (K. Perlin, "Improving Noise", SIGGRAPH 2002).
//!
//! In: the coordinates' cells. Out: a value, or three from bits 0, 8 and 16 of the corners' hashes, in [-1, 1].

use super::hash::hash;
use super::noise::Cell;
use crate::ir::{Const, Ty};

/// Brings each dimension's noise to [-1, 1], as in the reference implementation.
const SCALE: [f64; 4] = [0.25, 0.6616, 0.982, 0.8344];

/// The weight of the upper corner.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// The gradient of the hash h times the offsets d.
fn gradient(h: u32, d: &[f64]) -> f64 {
    let signed = |bit: u32, x: f64| if h >> bit & 1 == 1 { -x } else { x };
    match *d {
        [x] => signed(3, f64::from(1 + (h & 7)) * x),
        [x, y] => {
            let (u, v) = if h & 7 < 4 { (x, y) } else { (y, x) };
            signed(0, u) + signed(1, 2.0 * v)
        }
        [x, y, z] => {
            let h = h & 15;
            let u = if h < 8 { x } else { y };
            let v = match h {
                0..4 => y,
                12 | 14 => x,
                _ => z,
            };
            signed(0, u) + signed(1, v)
        }
        [x, y, z, w] => {
            let h = h & 31;
            let u = if h < 24 { x } else { y };
            let v = if h < 16 { y } else { z };
            let s = if h < 8 { z } else { w };
            signed(0, u) + signed(1, v) + signed(2, s)
        }
        _ => 0.0,
    }
}

/// Perlin noise of the point that the cells hold.
pub(super) fn perlin(cells: &[Cell], ty: Ty) -> Const {
    let n = cells.len();
    let mut sums = [0.0; 3];
    for corner in 0..1_u32 << n {
        let mut words = Vec::with_capacity(n);
        let mut offsets = Vec::with_capacity(n);
        let mut weight = 1.0;
        for (k, cell) in cells.iter().enumerate() {
            let upper = corner >> k & 1 == 1;
            words.push(if upper { cell.upper } else { cell.lower });
            offsets.push(cell.fraction - f64::from(u8::from(upper)));
            let t = fade(cell.fraction);
            weight *= if upper { t } else { 1.0 - t };
        }
        let h = hash(&words);
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += weight * gradient(h >> (8 * k), &offsets);
        }
    }
    let scale = SCALE[n - 1];
    match ty {
        Ty::Triple => Const::Triple(sums.map(|s| s * scale)),
        _ => Const::Float(sums[0] * scale),
    }
}

/// The derivative of [`fade`].
fn fade_slope(t: f64) -> f64 {
    30.0 * t * t * (t * (t - 2.0) + 1.0)
}

/// Row j: the derivatives of the first `components` components by coordinate j. By the product rule over each corner's
/// weight, which is a product over the coordinates.
pub(super) fn slopes(cells: &[Cell], components: usize) -> [f64; 16] {
    let n = cells.len();
    let mut out = [0.0; 16];
    for corner in 0..1_u32 << n {
        let upper = |k: usize| corner >> k & 1 == 1;
        let word = |(k, c): (usize, &Cell)| if upper(k) { c.upper } else { c.lower };
        let words: Vec<u32> = cells.iter().enumerate().map(word).collect();
        let offset = |(k, c): (usize, &Cell)| c.fraction - f64::from(u8::from(upper(k)));
        let offsets: Vec<f64> = cells.iter().enumerate().map(offset).collect();
        let weight = |k: usize| if upper(k) { fade(cells[k].fraction) } else { 1.0 - fade(cells[k].fraction) };
        let turn = |k: usize| if upper(k) { fade_slope(cells[k].fraction) } else { -fade_slope(cells[k].fraction) };
        let h = hash(&words);
        for component in 0..components {
            let h = h >> (8 * component);
            for j in 0..n {
                let mut axis = vec![0.0; n];
                axis[j] = 1.0;
                let all: f64 = (0..n).map(weight).product();
                let others: f64 = (0..n).filter(|k| *k != j).map(weight).product();
                let slope = all * gradient(h, &axis) + turn(j) * others * gradient(h, &offsets);
                out[4 * j + component] += SCALE[n - 1] * slope;
            }
        }
    }
    out
}
