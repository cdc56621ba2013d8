//! OSL's geometric and matrix functions (specification ch. 7.2 and 7.4) on constants.
//!
//! In: a row's name and its arguments. Out: the value, `None` when the name is not one of these. kernels/osl/geometric.h and
//! matrix.h say what bad arguments give.

use super::math::{clamp, quotient, sqrt};
use super::ops::{matrix_determinant, matrix_inverse};
use super::{float, matrix, triple};
use crate::ir::Const;

type V = [f64; 3];

fn zip(a: V, b: V, f: impl Fn(f64, f64) -> f64) -> V {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

fn sub(a: V, b: V) -> V {
    zip(a, b, |x, y| x - y)
}

/// a + k b
fn add_scaled(a: V, k: f64, b: V) -> V {
    zip(a, b, |x, y| x + k * y)
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: V) -> f64 {
    sqrt(dot(a, a))
}

/// The squares stay in range for every finite vector; 0 has no direction.
fn normalize(a: V) -> V {
    let size = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if size == 0.0 {
        return [0.0; 3];
    }
    let a = a.map(|x| x / size);
    let length = length(a);
    if length == 0.0 { [0.0; 3] } else { a.map(|x| x / length) }
}

fn distance_to_segment(a: V, b: V, q: V) -> f64 {
    let d = sub(b, a);
    let t = clamp(quotient(dot(sub(q, a), d), dot(d, d)), 0.0, 1.0);
    length(sub(q, add_scaled(a, t, d)))
}

fn reflect(i: V, n: V) -> V {
    add_scaled(i, -2.0 * dot(n, i), n)
}

/// Snell's law in vector form; 0 beyond the critical angle.
fn refract(i: V, n: V, eta: f64) -> V {
    let cosine = dot(i, n);
    let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if k < 0.0 {
        return [0.0; 3];
    }
    let along = eta * cosine + sqrt(k);
    zip(i, n, |i, n| eta * i - along * n)
}

/// Kr, Kt, R, T: unpolarised reflectance of a dielectric (Cook and Torrance 1982).
pub(super) fn fresnel(args: &[Const]) -> Option<Vec<Const>> {
    let (i, n, eta) = (triple(args, 0)?, triple(args, 1)?, float(args, 2)?);
    let c = dot(i, n).abs();
    let g2 = quotient(1.0, eta * eta) - 1.0 + c * c;
    let (mut kr, mut kt, mut t) = (1.0, 0.0, [0.0; 3]);
    if g2 >= 0.0 {
        let g = g2.sqrt();
        let s = quotient(g - c, g + c);
        let p = quotient(c * (g + c) - 1.0, c * (g - c) + 1.0);
        kr = 0.5 * s * s * (1.0 + p * p);
        kt = (1.0 - kr) * eta * eta;
        t = refract(i, n, eta);
    }
    Some(vec![Const::Float(kr), Const::Float(kt), Const::Triple(reflect(i, n)), Const::Triple(t)])
}

/// About the line through a and b, right-handed (Rodrigues' formula).
fn rotate(p: V, angle: f64, a: V, b: V) -> V {
    let axis = normalize(sub(b, a));
    let v = sub(p, a);
    let (s, c) = angle.sin_cos();
    let turned = add_scaled(v.map(|x| x * c), s, cross(axis, v));
    zip(add_scaled(turned, dot(axis, v) * (1.0 - c), axis), a, |x, y| x + y)
}

/// v * M without the translation.
fn transform_vector(m: &[f64; 16], v: V) -> V {
    [0, 1, 2].map(|c| v[0] * m[c] + v[1] * m[4 + c] + v[2] * m[8 + c])
}

/// A point at infinity becomes zero.
fn transform_point(m: &[f64; 16], p: V) -> V {
    let w = p[0] * m[3] + p[1] * m[7] + p[2] * m[11] + m[15];
    if w == 0.0 {
        return [0.0; 3];
    }
    zip(transform_vector(m, p), [m[12], m[13], m[14]], |x, t| (x + t) / w)
}

fn transpose(m: &[f64; 16]) -> [f64; 16] {
    std::array::from_fn(|k| m[4 * (k % 4) + k / 4])
}

/// The value of the row `name`.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    let v = |i| triple(args, i);
    Some(match name {
        "dot" => Const::Float(dot(v(0)?, v(1)?)),
        "cross" => Const::Triple(cross(v(0)?, v(1)?)),
        "length" => Const::Float(length(v(0)?)),
        "normalize" => Const::Triple(normalize(v(0)?)),
        "distance" if args.len() == 2 => Const::Float(length(sub(v(0)?, v(1)?))),
        "distance" => Const::Float(distance_to_segment(v(0)?, v(1)?, v(2)?)),
        "faceforward_ref" => {
            let n = v(0)?;
            Const::Triple(if dot(v(1)?, v(2)?) > 0.0 { n.map(|x| -x) } else { n })
        }
        "reflect" => Const::Triple(reflect(v(0)?, v(1)?)),
        "refract" => Const::Triple(refract(v(0)?, v(1)?, float(args, 2)?)),
        "rotate" if args.len() == 3 => Const::Triple(rotate(v(0)?, float(args, 1)?, [0.0; 3], v(2)?)),
        "rotate" => Const::Triple(rotate(v(0)?, float(args, 1)?, v(2)?, v(3)?)),
        "transform_point" => Const::Triple(transform_point(matrix(args, 0)?, v(1)?)),
        "transform_vector" => Const::Triple(transform_vector(matrix(args, 0)?, v(1)?)),
        "transform_normal" => Const::Triple(transform_vector(&transpose(&matrix_inverse(matrix(args, 0)?)), v(1)?)),
        "determinant" => Const::Float(matrix_determinant(matrix(args, 0)?)),
        "transpose" => Const::Matrix(transpose(matrix(args, 0)?)),
        _ => return None,
    })
}
