//! Gabor noise in f64 (A. Lagae et al., "Filtering Solid Gabor Noise", SIGGRAPH 2011).
//!
//! In: a point, its differences between pixels, the period if any, the options. Out: a value, or three for the seeds 0, 1
//! and 2. kernels/osl/noise_gabor.h says what the options mean. Random numbers are 32-bit floats, as there.

use super::hash::hash;
use crate::ir::{Const, Ty};
use std::f64::consts::{PI, TAU};

/// sqrt(pi / ln 2), as the reference implementation rounds it.
const WIDTH: f32 = 2.128_934;

/// Volume of the unit sphere, as it rounds that.
const SPHERE: f64 = 1.33333 * PI;

type V3 = [f64; 3];
type M2 = [[f64; 2]; 2];

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: V3) -> V3 {
    let length = dot(&v, &v).sqrt();
    if length == 0.0 { v } else { v.map(|x| x / length) }
}

fn determinant(m: M2) -> f64 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

fn inverse(m: M2) -> M2 {
    let d = determinant(m);
    [[m[1][1] / d, -m[0][1] / d], [-m[1][0] / d, m[0][0] / d]]
}

fn add(m: M2, diagonal: f64) -> M2 {
    [[m[0][0] + diagonal, m[0][1]], [m[1][0], m[1][1] + diagonal]]
}

fn scale(m: M2, by: f64) -> M2 {
    m.map(|row| row.map(|x| x * by))
}

fn times(v: [f64; 2], m: M2) -> [f64; 2] {
    [v[0] * m[0][0] + v[1] * m[1][0], v[0] * m[0][1] + v[1] * m[1][1]]
}

/// The multiplicative generator of a cell.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(3_039_177_861);
        self.0 as f32 / u32::MAX as f32
    }
}

/// The options that have a meaning.
pub(super) struct Options {
    pub anisotropic: i32,
    pub direction: V3,
    pub bandwidth: f64,
    pub impulses: f64,
    pub filter: bool,
}

/// A value and its derivatives by the point.
type Sloped = (f64, V3);

/// A wave under a Gaussian: weight exp(exponent) cos(phase), with the derivatives of exponent and phase.
fn wave(weight: f64, (exponent, dexponent): (f64, V3), (phase, dphase): (f64, V3)) -> Sloped {
    let e = weight * exponent.exp();
    let (s, c) = phase.sin_cos();
    (e * c, [0, 1, 2].map(|i| e * (c * dexponent[i] - s * dphase[i])))
}

/// A pixel's footprint: tangent space, and its Gaussian's matrix there.
struct Footprint {
    t: V3,
    b: V3,
    n: V3,
    sigma: M2,
}

impl Footprint {
    /// `None`: nothing to filter.
    fn new(dx: V3, dy: V3) -> Option<Footprint> {
        let n = cross(dx, dy);
        if dot(&n, &n) < 1e-6 {
            return None;
        }
        let n = unit(n);
        let t = unit(if n[0].abs() < 0.9 { [0.0, n[2], -n[1]] } else { [-n[2], 0.0, n[0]] });
        let b = cross(n, t);
        let m = [0, 1].map(|i| [dx[i] * t[0] + dy[i] * t[1], dx[i] * b[0] + dy[i] * b[1]]);
        let entry = |i: usize, j: usize| 0.25 * (m[0][i] * m[0][j] + m[1][i] * m[1][j]);
        let sigma = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
        (determinant(sigma) >= 1e-18).then_some(Footprint { t, b, n, sigma })
    }

    /// A kernel of unit weight, sliced (eq. 6) and filtered (eq. 10).
    fn kernel(&self, a: f64, omega: V3, phase: f64, x: V3) -> Sloped {
        let [plane, at] = [omega, x].map(|v| [dot(&v, &self.t), dot(&v, &self.b)]);
        let (depth, across) = (dot(&self.n, &x), dot(&omega, &self.n));
        let sigma_g = a * a / TAU;
        let sigma_f = scale(inverse(self.sigma), 1.0 / (4.0 * PI * PI));
        let both = add(sigma_f, sigma_g);
        let c_f = 1.0 / (TAU * determinant(self.sigma).sqrt());
        let weight = c_f / (TAU * determinant(both).sqrt()) * (-0.5 * dot(&times(plane, inverse(both)), &plane)).exp();
        let product = inverse(add(inverse(sigma_f), 1.0 / sigma_g));
        let plane = times(plane, scale(product, 1.0 / sigma_g));
        let a2 = TAU * determinant(product).sqrt();
        // Along the tangents and the normal.
        let sum = |t: f64, b: f64, n: f64| [0, 1, 2].map(|i| t * self.t[i] + b * self.b[i] + n * self.n[i]);
        let exponent = -PI * (a * a * depth * depth + a2 * dot(&at, &at));
        let dexponent = sum(-TAU * a2 * at[0], -TAU * a2 * at[1], -TAU * a * a * depth);
        let phase = TAU * (dot(&plane, &at) + depth * across) + phase;
        wave(weight, (exponent, dexponent), (phase, sum(TAU * plane[0], TAU * plane[1], TAU * across)))
    }
}

fn wrap(cell: f64, period: f64) -> f64 {
    let period = period.floor().max(1.0);
    cell - period * (cell / period).floor()
}

/// What the kernels of one cell add to the noise.
struct Noise<'a> {
    options: &'a Options,
    period: Option<V3>,
    footprint: Option<Footprint>,
    a: f64,
    radius: f64,
}

impl Noise<'_> {
    /// Kernels in a sphere of the radius.
    fn impulses(&self) -> f64 {
        self.options.impulses.clamp(1.0, 32.0)
    }

    fn frequency(&self, random: &mut Random) -> V3 {
        let direction = self.options.direction;
        if self.options.anisotropic == 1 {
            return direction;
        }
        let (s, c) = (TAU * f64::from(random.next())).sin_cos();
        if self.options.anisotropic != 0 {
            let length = dot(&direction, &direction).sqrt();
            return [length * c, length * s, 0.0];
        }
        let z = 2.0 * f64::from(random.next()) - 1.0;
        let r = (1.0 - z * z).max(0.0).sqrt();
        unit([c * r, s * r, z])
    }

    /// x is counted from the cell's corner, in cells.
    fn cell(&self, corner: V3, x: V3, seed: u32) -> Sloped {
        let corner = match self.period {
            Some(p) => [wrap(corner[0], p[0]), wrap(corner[1], p[1]), wrap(corner[2], p[2])],
            None => corner,
        };
        let [i, j, k] = corner.map(|c| c as i32 as u32);
        let mut random = Random(hash(&[i, j, k, seed]).max(1));
        // In 32 bits and this order, as the reference implementation: whether there is one more is a matter of the last digit.
        let radius = self.radius as f32;
        let (many, cube) = (self.impulses() as f32, radius * radius * radius);
        let limit = (-(many / (SPHERE as f32 * cube) * cube)).exp();
        let mut count = 0;
        let mut product = random.next();
        while product > limit && count < 64 {
            count += 1;
            product *= random.next();
        }
        let mut sum = (0.0, [0.0; 3]);
        for _ in 0..count {
            let [z, y, x0] = [random.next(), random.next(), random.next()].map(f64::from);
            let at = [x[0] - x0, x[1] - y, x[2] - z].map(|d| d * self.radius);
            let omega = self.frequency(&mut random);
            let phase = TAU * f64::from(random.next());
            if dot(&at, &at) >= self.radius * self.radius {
                continue;
            }
            let plain = || {
                let k = -PI * self.a * self.a;
                let gaussian = (k * dot(&at, &at), at.map(|x| 2.0 * k * x));
                wave(1.0, gaussian, (TAU * dot(&omega, &at) + phase, omega.map(|w| TAU * w)))
            };
            let filtered = self.footprint.as_ref().map(|f| f.kernel(self.a, omega, phase, at));
            let (value, slope) = filtered.filter(|v| v.0.is_finite()).unwrap_or_else(plain);
            sum.0 += value;
            sum.1 = [0, 1, 2].map(|i| sum.1[i] + slope[i]);
        }
        sum
    }

    fn value(&self, p: V3, seed: u32) -> Sloped {
        let x = p.map(|c| c / self.radius);
        let corner = x.map(f64::floor);
        let (mut sum, mut slope) = (0.0, [0.0; 3]);
        for k in 0..27 {
            let step = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1].map(f64::from);
            let at = |i: usize| corner[i] + step[i];
            let from = |i: usize| x[i] - corner[i] - step[i];
            let (value, d) = self.cell([at(0), at(1), at(2)], [from(0), from(1), from(2)], seed);
            sum += value;
            slope = [0, 1, 2].map(|i| slope[i] + d[i]);
        }
        let variance = 1.0 / (4.0 * 2.0_f64.sqrt() * self.a.powi(3));
        let amplitude = (self.radius.powi(3) * SPHERE / self.impulses()).sqrt() / (6.0 * variance.sqrt());
        (sum * amplitude, slope.map(|d| d * amplitude))
    }
}

/// What a call tells.
pub(super) struct Call {
    pub p: V3,
    pub differences: [V3; 2],
    pub period: Option<V3>,
    pub options: Options,
}

impl Call {
    fn noise(&self) -> Noise<'_> {
        let octaves = self.options.bandwidth.clamp(0.01, 100.0).exp2();
        let a = 2.0 * (octaves - 1.0) / (octaves + 1.0) * f64::from(WIDTH);
        let [dx, dy] = self.differences;
        Noise {
            options: &self.options,
            period: self.period,
            footprint: if self.options.filter { Footprint::new(dx, dy) } else { None },
            a,
            radius: (-0.02_f64.ln() / PI).sqrt() / a,
        }
    }

    /// The noise.
    pub(super) fn value(&self, ty: Ty) -> Const {
        let noise = self.noise();
        match ty {
            Ty::Triple => Const::Triple([0, 1, 2].map(|seed| noise.value(self.p, seed).0)),
            _ => Const::Float(noise.value(self.p, 0).0),
        }
    }

    /// Row j holds the derivatives of the result's components by coordinate j of the point.
    pub(super) fn slopes(&self, components: usize) -> [f64; 16] {
        let noise = self.noise();
        let mut out = [0.0; 16];
        for component in 0..components {
            for (j, d) in noise.value(self.p, component as u32).1.into_iter().enumerate() {
                out[4 * j + component] = d;
            }
        }
        out
    }
}
