//! OSL's noises (specification ch. 7.6) on constants: the coordinates' lattice cells, and the kinds made of hashed words.
//!
//! In: a row's name, the result's type and the arguments. Out: the value, `None` when the name is not one of these.
//! Written over any number of dimensions, unlike the kernels, which unroll them; kernels/osl/noise*.h name the sources.

use super::hash::{bits, hash};
use super::{float, noise_gabor, noise_gradient, noise_simplex, triple};
use crate::ir::{Const, Ty};

/// A coordinate's lattice cell: its number, the next one's, and the fraction in it.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub lower: u32,
    pub upper: u32,
    pub fraction: f64,
}

impl Cell {
    fn new(x: f64) -> Cell {
        let lower = x.floor() as i32 as u32;
        Cell { lower, upper: lower.wrapping_add(1), fraction: x - x.floor() }
    }

    /// Numbers modulo the whole part of the period, at least 1.
    fn periodic(x: f64, period: f64) -> Cell {
        let period = if period >= 1.0 { period as i32 } else { 1 };
        let Cell { lower, fraction, .. } = Cell::new(x);
        let lower = (lower as i32).rem_euclid(period);
        let upper = if lower + 1 == period { 0 } else { lower + 1 };
        Cell { lower: lower as u32, upper: upper as u32, fraction }
    }
}

/// The word of hash noise under a period; in 32-bit floats, as the kernels.
fn hash_wrap(x: f64, period: f64) -> u32 {
    let period = if period >= 1.0 { (period as f32).floor() } else { 1.0 };
    let x = x as f32;
    (-period).mul_add((x / period).floor(), x).to_bits()
}

/// 32 bits to [0, 1].
fn unit(bits: u32) -> f64 {
    f64::from(bits) / f64::from(u32::MAX)
}

/// One value, or three from one more word.
fn of_words(words: &[u32], ty: Ty) -> Const {
    match ty {
        Ty::Triple => Const::Triple([0, 1, 2].map(|k| unit(hash(&[words, &[k]].concat())))),
        _ => Const::Float(unit(hash(words))),
    }
}

fn map(c: Const, f: impl Fn(f64) -> f64) -> Const {
    match c {
        Const::Float(x) => Const::Float(f(x)),
        Const::Triple(v) => Const::Triple(v.map(f)),
        other => other,
    }
}

/// The numbers of floats and triples, one behind the other.
fn numbers(args: &[Const]) -> Option<Vec<f64>> {
    let mut out = Vec::with_capacity(8);
    for arg in args {
        match arg {
            Const::Float(x) => out.push(*x),
            Const::Triple(v) => out.extend(v),
            _ => return None,
        }
    }
    Some(out)
}

/// Point, differences, period, options: in the order of the row.
fn gabor(periodic: bool, ty: Ty, args: &[Const]) -> Option<Const> {
    let differences = [triple(args, 1)?, triple(args, 2)?];
    let period = if periodic { Some(triple(args, 3)?) } else { None };
    let at = 3 + usize::from(periodic);
    let [Const::Int(anisotropic), .., Const::Int(filter)] = args.get(at..)? else { return None };
    let options = noise_gabor::Options {
        anisotropic: *anisotropic,
        direction: triple(args, at + 1)?,
        bandwidth: float(args, at + 2)?,
        impulses: float(args, at + 3)?,
        filter: *filter != 0,
    };
    Some(noise_gabor::gabor(triple(args, 0)?, differences, period, &options, ty))
}

/// The value of the row `name`.
pub(super) fn call(name: &str, ty: Ty, args: &[Const]) -> Option<Const> {
    let (periodic, kind) = match name.strip_prefix("pnoise_") {
        Some(kind) => (true, kind),
        None => (false, name.strip_prefix("noise_")?),
    };
    if kind == "gabor" {
        return gabor(periodic, ty, args);
    }
    let (kind, slopes) = match kind.split_once("_slopes") {
        Some((kind, rest)) => (kind, Some(if rest.is_empty() { 1 } else { 3 })),
        None => (kind, None),
    };
    let all = numbers(args)?;
    let (x, periods) = all.split_at(if periodic { all.len() / 2 } else { all.len() });
    if !(1..=4).contains(&x.len()) || (periodic && periods.len() != x.len()) {
        return None;
    }
    let cells = || -> Vec<Cell> {
        match periodic {
            true => x.iter().zip(periods).map(|(x, p)| Cell::periodic(*x, *p)).collect(),
            false => x.iter().map(|x| Cell::new(*x)).collect(),
        }
    };
    if let Some(components) = slopes {
        return Some(Const::Matrix(match kind {
            "perlin" => noise_gradient::slopes(&cells(), components),
            "simplex" => noise_simplex::slopes(x, components),
            _ => return None,
        }));
    }
    let to_unit = |c| map(c, |v| 0.5 * (v + 1.0));
    Some(match kind {
        "perlin" => noise_gradient::perlin(&cells(), ty),
        "uperlin" => to_unit(noise_gradient::perlin(&cells(), ty)),
        "cell" => of_words(&cells().iter().map(|c| c.lower).collect::<Vec<_>>(), ty),
        "hash" if periodic => of_words(&x.iter().zip(periods).map(|(x, p)| hash_wrap(*x, *p)).collect::<Vec<_>>(), ty),
        "hash" => of_words(&x.iter().map(|x| bits(*x)).collect::<Vec<_>>(), ty),
        "simplex" => noise_simplex::simplex(x, ty),
        "usimplex" => to_unit(noise_simplex::simplex(x, ty)),
        _ => return None,
    })
}
