//! OSL's splines and their inverses (specification ch. 7.6) on constants.
//!
//! In: a row's name and its arguments, the knots as an array. Out: the value, `None` when the name is not one of these.
//! kernels/osl/spline.h says what holds for too few knots and where the inverse has several answers.

use super::float;
use super::math::clamp;
use crate::ir::Const;

/// Rows: t^3, t^2, t, 1; columns: the four knots (Foley, van Dam et al. 1990, ch. 11.2).
type Basis = [[f64; 4]; 4];

const CATMULLROM: Basis = [[-0.5, 1.5, -1.5, 0.5], [1.0, -2.5, 2.0, -0.5], [-0.5, 0.0, 0.5, 0.0], [0.0, 1.0, 0.0, 0.0]];
const BEZIER: Basis = [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
const SIXTH: f64 = 1.0 / 6.0;
const BSPLINE: Basis =
    [[-SIXTH, 0.5, -0.5, SIXTH], [0.5, -1.0, 0.5, 0.0], [-0.5, 0.0, 0.5, 0.0], [SIXTH, 4.0 * SIXTH, SIXTH, 0.0]];
/// Knots: value, slope, value, slope.
const HERMITE: Basis = [[2.0, 1.0, -2.0, 1.0], [-3.0, -2.0, 3.0, -1.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
/// These two keep the outer knots of a cubic.
const LINEAR: Basis = [[0.0; 4], [0.0; 4], [0.0, -1.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0]];
const CONSTANT: Basis = [[0.0; 4], [0.0; 4], [0.0; 4], [0.0, 1.0, 0.0, 0.0]];

/// The basis and the number of knots from one segment to the next.
fn basis(name: &str) -> Option<(&'static Basis, usize)> {
    Some(match name {
        "catmullrom" => (&CATMULLROM, 1),
        "bezier" => (&BEZIER, 3),
        "bspline" => (&BSPLINE, 1),
        "hermite" => (&HERMITE, 2),
        "linear" => (&LINEAR, 1),
        "constant" => (&CONSTANT, 1),
        _ => return None,
    })
}

fn segments(knots: usize, step: usize) -> usize {
    knots.saturating_sub(4) / step + 1
}

fn spline(basis: &Basis, step: usize, x: f64, knots: &[f64]) -> f64 {
    let segments = segments(knots.len(), step);
    let t = clamp(x, 0.0, 1.0) * segments as f64;
    let segment = (t as usize).min(segments - 1);
    let t = t - segment as f64;
    let knot = |k: usize| knots.get(segment * step + k).or(knots.last()).copied().unwrap_or(0.0);
    let coefficient = |row: &[f64; 4]| (0..4).map(|k| row[k] * knot(k)).sum::<f64>();
    basis.iter().fold(0.0, |sum, row| sum * t + coefficient(row))
}

/// By x; 0 beyond [0, 1], where the curve is constant.
fn slope(basis: &Basis, step: usize, x: f64, knots: &[f64]) -> f64 {
    if !(0.0..=1.0).contains(&x) {
        return 0.0;
    }
    // The derivative's rows: 3 t^2, 2 t, 1.
    let [cubic, square, line, _] = basis;
    let derived = [[0.0; 4], cubic.map(|c| 3.0 * c), square.map(|c| 2.0 * c), *line];
    segments(knots.len(), step) as f64 * spline(&derived, step, x, knots)
}

/// By halving, in the first segment whose ends bracket y.
fn inverse(basis: &Basis, step: usize, y: f64, knots: &[f64]) -> f64 {
    let n = knots.len();
    let (low, high) = if step == 1 { (1.min(n - 1), n.saturating_sub(2)) } else { (0, n - 1) };
    let sign = if knots[1.min(n - 1)] < knots[n.saturating_sub(2)] { 1.0 } else { -1.0 };
    if sign * y <= sign * knots[low] {
        return 0.0;
    }
    if sign * y >= sign * knots[high] {
        return 1.0;
    }
    let error = |x: f64| spline(basis, step, x, knots) - y;
    let segments = segments(n, step);
    let (mut start, mut e0, mut nearest) = (0.0, error(0.0), 0.0);
    for s in 1..=segments {
        let end = s as f64 / segments as f64;
        let e1 = error(end);
        if e0 * e1 <= 0.0 {
            let (mut a, mut b) = (start, end);
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                let e = error(middle);
                if e == 0.0 {
                    return middle;
                }
                if (e < 0.0) == (e0 < 0.0) { a = middle } else { b = middle }
            }
            return 0.5 * (a + b);
        }
        let first = if e0 < e1 { e0 > 0.0 } else { e0 < 0.0 };
        nearest = if first { start } else { end };
        (start, e0) = (end, e1);
    }
    nearest
}

/// The value of the row `name`.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    let (inverts, kind) = match name.strip_prefix("splineinverse_") {
        Some(kind) => (true, kind),
        None => (false, name.strip_prefix("spline_")?),
    };
    let (kind, spline): (_, fn(&Basis, usize, f64, &[f64]) -> f64) = match kind.strip_suffix("_slope") {
        Some(kind) => (kind, slope),
        None => (kind, spline),
    };
    let (basis, step) = basis(kind)?;
    let x = float(args, 0)?;
    let Some(Const::Array(knots)) = args.get(1) else { return None };
    let component = |k: usize| -> Option<Vec<f64>> {
        let part = |c: &Const| match c {
            Const::Float(v) if k == 0 => Some(*v),
            Const::Triple(v) => Some(v[k]),
            _ => None,
        };
        knots.iter().map(part).collect()
    };
    match knots.first()? {
        Const::Float(_) if inverts => Some(Const::Float(inverse(basis, step, x, &component(0)?))),
        Const::Float(_) => Some(Const::Float(spline(basis, step, x, &component(0)?))),
        Const::Triple(_) if !inverts => {
            let value = |k: usize| Some(spline(basis, step, x, &component(k)?));
            Some(Const::Triple([value(0)?, value(1)?, value(2)?]))
        }
        _ => None,
    }
}
