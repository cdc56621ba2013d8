//! The parameter sets by which every lobe is tested.
//!
//! In: nothing. Out: [`Case`]s. It must not know what is asked of them.

use super::{Case, normalize};

/// Indices of refraction next to 1, exact in f32.
const ABOVE_1: f64 = 1.0 + f32::EPSILON as f64;
const BELOW_1: f64 = 1.0 - f32::EPSILON as f64;

/// Two normals: one along an axis, one anywhere.
fn normals() -> [[f64; 3]; 2] {
    [[0.0, 0.0, 1.0], normalize([0.4, -0.5, -0.3])]
}

/// White, seen at an angle; the rest as the closure likes it.
pub fn case(closure: usize, degrees: f64) -> Case {
    Case {
        closure,
        dist: 0,
        refract: 0,
        a: 0.0,
        b: 0.0,
        eta: 0.0,
        // Gold.
        ior: [0.143, 0.375, 1.442],
        extinction: [3.983, 2.386, 1.603],
        n: normals()[(closure + degrees as usize) % 2],
        degrees,
    }
}

/// Lobes that are smooth over the hemisphere, and the simple glossy ones.
fn simple(out: &mut Vec<Case>) {
    for closure in [0, 2] {
        out.extend([0.0, 60.0, 89.9].map(|d| case(closure, d)));
    }
    for a in [0.0, 1e-7, 0.1, 0.3, 1.5] {
        out.extend([30.0, 85.0].map(|d| Case { a, ..case(1, d) }));
    }
    for a in [0.0, 1.0, 20.0, 1e3, 1e6] {
        out.extend([0.0, 45.0, 80.0].map(|d| Case { a, ..case(3, d) }));
    }
    for (a, b) in [(0.0, 0.0), (1e-3, 1e-3), (0.1, 0.1), (1.0, 1.0), (0.05, 0.3), (0.5, 0.1)] {
        out.extend([0.0, 45.0, 80.0, 89.9].map(|d| Case { a, b, ..case(4, d) }));
        for dist in [0, 1] {
            out.extend([0.0, 60.0, 89.9].map(|d| Case { a, b, dist, ..case(10, d) }));
        }
    }
}

/// Mirrors and smooth glass.
fn smooth(out: &mut Vec<Case>) {
    for degrees in [0.0, 30.0, 60.0, 89.9] {
        out.push(case(8, degrees));
        out.extend([11, 21].map(|closure| case(closure, degrees)));
        for eta in [1.5, 1.0 / 1.5, ABOVE_1, BELOW_1, 1.0, 0.0] {
            out.extend([7, 9].map(|closure| Case { eta, ..case(closure, degrees) }));
            out.extend([0, 1, 2].map(|refract| Case { eta, refract, ..case(6, degrees) }));
        }
    }
}

fn rough(out: &mut Vec<Case>, alphas: &[(f64, f64)], etas: &[f64], angles: &[f64]) {
    for dist in [0, 1] {
        for &(a, b) in alphas {
            for &eta in etas {
                for refract in [0, 1, 2] {
                    // The short constructor where it can say it.
                    let closure = if a == b { 6 } else { 5 };
                    out.extend(angles.iter().map(|d| Case { dist, a, b, eta, refract, ..case(closure, *d) }));
                }
            }
        }
    }
}

/// The MaterialX lobes that are smooth over the hemisphere, and hair.
fn materialx(out: &mut Vec<Case>) {
    for closure in [12, 17, 18] {
        out.extend([0.0, 70.0].map(|d| case(closure, d)));
    }
    for a in [0.0, 0.3, 1.0] {
        out.extend([0.0, 45.0, 80.0].map(|d| Case { a, ..case(14, d) }));
        for refract in [0, 1] {
            out.extend([0.0, 45.0, 80.0].map(|d| Case { a, refract, ..case(13, d) }));
        }
    }
    for a in [0.1, 0.4, 1.0] {
        for refract in [0, 1] {
            out.extend([0.0, 45.0, 80.0].map(|d| Case { a, refract, ..case(19, d) }));
        }
    }
    for (a, b, refract) in [(0.05, 0.3, 0), (0.2, 0.5, 1), (0.5, 0.2, -1)] {
        let extinction = [0.1, 0.5, 2.0];
        out.extend([20.0, 60.0].map(|d| Case { a, b, refract, eta: 1.55, extinction, ..case(20, d) }));
    }
}

/// dielectric_bsdf, generalized_schlick_bsdf and conductor_bsdf, without and with a film.
fn facets(out: &mut Vec<Case>, alphas: &[(f64, f64)], angles: &[f64]) {
    for dist in [0, 4] {
        for &(a, b) in alphas {
            for eta in [1.5, 1.0 / 1.5] {
                for refract in [0, 1, 2] {
                    for closure in [15, 16] {
                        out.extend(angles.iter().map(|d| Case { dist, a, b, eta, refract, ..case(closure, *d) }));
                    }
                }
            }
        }
    }
    for &(a, b) in alphas {
        out.extend(angles.iter().map(|d| Case { dist: 4, a, b, ..case(10, *d) }));
    }
}

/// All cases.
pub fn all() -> Vec<Case> {
    let mut out = Vec::new();
    simple(&mut out);
    smooth(&mut out);
    rough(&mut out, &[(0.1, 0.1), (1.0, 1.0), (0.05, 0.3)], &[1.5, 1.0 / 1.5], &[0.0, 45.0, 80.0]);
    rough(&mut out, &[(1e-3, 1e-3)], &[1.5, 1.0 / 1.5], &[0.0, 60.0]);
    rough(&mut out, &[(0.1, 0.1)], &[ABOVE_1, BELOW_1, 0.0], &[30.0]);
    rough(&mut out, &[(1e-7, 1e-7), (0.3, 0.3), (0.3, 1e-7)], &[1.5, 1.0 / 1.5], &[89.9]);
    materialx(&mut out);
    facets(&mut out, &[(0.0, 0.0), (0.1, 0.1), (1.0, 1.0), (0.05, 0.3)], &[50.0]);
    facets(&mut out, &[(0.3, 0.3)], &[0.0, 80.0]);
    // "default" and unknown names.
    out.extend([2, 3].map(|dist| Case { dist, a: 0.2, b: 0.2, eta: 1.5, refract: 2, ..case(5, 30.0) }));
    out
}

/// A few of each kind, for f64.
pub fn some() -> Vec<Case> {
    let mut out = Vec::new();
    simple(&mut out);
    out = out.into_iter().step_by(3).collect();
    smooth(&mut out);
    rough(&mut out, &[(1e-3, 1e-3), (0.1, 0.1), (0.05, 0.3)], &[1.5, 1.0 / 1.5], &[45.0]);
    rough(&mut out, &[(0.3, 0.3)], &[1.5], &[89.9]);
    materialx(&mut out);
    facets(&mut out, &[(0.0, 0.0), (0.2, 0.2)], &[45.0]);
    out
}
