//! Simplex noise in 1 to 4 dimensions (K. Perlin 2001; S. Gustavson, "Simplex noise demystified", 2005).
//!
//! In: coordinates. Out: a value, or three for the seeds 0, 1 and 2, in [-1, 1].

use super::hash::finish;
use crate::ir::{Const, Ty};

/// Brings each dimension's noise to [-1, 1], as in the reference implementation.
const SCALE: [f64; 4] = [0.36, 64.0, 68.0, 54.0];

const GRADIENTS_2: [[i8; 2]; 8] = [[-1, -1], [1, 0], [-1, 0], [1, 1], [-1, 1], [0, -1], [0, 1], [1, -1]];

/// The middles of a cube's edges, four of them twice.
const GRADIENTS_3: [[i8; 3]; 16] = [
    [1, 0, 1],
    [0, 1, 1],
    [-1, 0, 1],
    [0, -1, 1],
    [1, 0, -1],
    [0, 1, -1],
    [-1, 0, -1],
    [0, -1, -1],
    [1, -1, 0],
    [1, 1, 0],
    [-1, 1, 0],
    [-1, -1, 0],
    [1, 0, 1],
    [-1, 0, 1],
    [0, 1, -1],
    [0, -1, -1],
];

fn scramble(a: u32, b: u32, c: u32) -> u32 {
    finish([a, b, c ^ 0xdead_beef])
}

/// The gradient at a lattice point times the offset from it.
fn gradient(point: &[u32], seed: u32, d: &[f64]) -> f64 {
    match (point, d) {
        ([i], [x]) => {
            let h = scramble(*i, seed, 0);
            let g = f64::from(1 + (h & 7));
            if h & 8 == 0 { g * x } else { -g * x }
        }
        ([i, j], [..]) => {
            let g = GRADIENTS_2[scramble(*i, *j, seed) as usize & 7];
            g.iter().zip(d).map(|(g, d)| f64::from(*g) * d).sum()
        }
        ([i, j, k], [..]) => {
            let g = GRADIENTS_3[scramble(*i, *j, scramble(*k, seed, 0)) as usize & 15];
            g.iter().zip(d).map(|(g, d)| f64::from(*g) * d).sum()
        }
        ([i, j, k, l], [..]) => {
            // One axis has no part; the others' signs are the three low bits.
            let h = scramble(*i, *j, scramble(*k, *l, seed)) & 31;
            let flat = (h / 8) as usize;
            let axes = (0..4).filter(|a| *a != flat);
            axes.zip([2, 1, 0]).map(|(a, bit)| if h >> bit & 1 == 0 { d[a] } else { -d[a] }).sum()
        }
        _ => 0.0,
    }
}

/// In one dimension a cell has two ends, and the falloff is (1 - r^2)^4.
fn one(x: f64, seed: u32) -> f64 {
    let cell = x.floor() as i32 as u32;
    let corner = |step: u32| {
        let d = x - x.floor() - f64::from(step);
        (1.0 - d * d).powi(4) * gradient(&[cell.wrapping_add(step)], seed, &[d])
    };
    corner(0) + corner(1)
}

/// A corner of a cell: its lattice point, and the offset from it.
type Corner = (Vec<u32>, Vec<f64>);

/// The cell of the skewed lattice, then its corners in the order of the offsets' size.
fn corners(x: &[f64]) -> Vec<Corner> {
    let n = x.len();
    let root = (n as f64 + 1.0).sqrt();
    let skew = (root - 1.0) / n as f64;
    let unskew = (1.0 - 1.0 / root) / n as f64;
    let s = x.iter().sum::<f64>() * skew;
    let origin: Vec<f64> = x.iter().map(|x| (x + s).floor()).collect();
    let t = origin.iter().sum::<f64>() * unskew;
    let offset: Vec<f64> = x.iter().zip(&origin).map(|(x, i)| x - i + t).collect();
    // How many other coordinates each one exceeds; which of two equal ones comes first does not matter.
    let exceeds = |a: usize, b: usize| if a < b { offset[a] >= offset[b] } else { offset[a] > offset[b] };
    let rank: Vec<usize> = (0..n).map(|a| (0..n).filter(|b| a != *b && exceeds(a, *b)).count()).collect();
    let mut corners = Vec::with_capacity(n + 1);
    for corner in 0..=n {
        let steps: Vec<bool> = rank.iter().map(|r| r + corner >= n).collect();
        let point: Vec<u32> =
            origin.iter().zip(&steps).map(|(i, s)| (*i as i32 as u32).wrapping_add((*s).into())).collect();
        let back = corner as f64 * unskew;
        let d: Vec<f64> = offset.iter().zip(&steps).map(|(o, s)| o - f64::from(u8::from(*s)) + back).collect();
        corners.push((point, d));
    }
    corners
}

fn many(x: &[f64], seed: u32) -> f64 {
    let mut sum = 0.0;
    for (point, d) in corners(x) {
        let r2: f64 = d.iter().map(|d| d * d).sum();
        // `max` would lose a NaN.
        let weight = if r2 > 0.5 { 0.0 } else { (0.5 - r2).powi(4) };
        sum += weight * gradient(&point, seed, &d);
    }
    sum
}

/// Row j: the derivatives of the first `components` components by coordinate j.
pub(super) fn slopes(x: &[f64], components: usize) -> [f64; 16] {
    let n = x.len();
    // In one dimension the cell's two ends and another falloff.
    let (corners, radius) = if n == 1 {
        let cell = x[0].floor() as i32 as u32;
        let f = x[0] - x[0].floor();
        (vec![(vec![cell], vec![f]), (vec![cell.wrapping_add(1)], vec![f - 1.0])], 1.0)
    } else {
        (corners(x), 0.5)
    };
    let mut out = [0.0; 16];
    for (point, d) in corners {
        let r2: f64 = d.iter().map(|d| d * d).sum();
        let t = if r2 > radius { 0.0 } else { radius - r2 };
        for component in 0..components {
            let along = gradient(&point, component as u32, &d);
            for j in 0..n {
                let mut axis = vec![0.0; n];
                axis[j] = 1.0;
                let slope = t.powi(4) * gradient(&point, component as u32, &axis) - 8.0 * t.powi(3) * d[j] * along;
                out[4 * j + component] += SCALE[n - 1] * slope;
            }
        }
    }
    out
}

/// Simplex noise of a point.
pub(super) fn simplex(x: &[f64], ty: Ty) -> Const {
    let value = |seed: u32| SCALE[x.len() - 1] * if x.len() == 1 { one(x[0], seed) } else { many(x, seed) };
    match ty {
        Ty::Triple => Const::Triple([0, 1, 2].map(value)),
        _ => Const::Float(value(0)),
    }
}
