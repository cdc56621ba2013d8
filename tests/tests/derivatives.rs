//! Derivatives against differences: `Dx` and `Dy` of many expressions, as the interpreter computes them in f64, must be what
//! central differences of the expression's value say.
//!
//! The globals move along their own derivatives: a point (x, y) of the plane is u + x dudx + y dudy, and so on. Points are
//! away from the places where an expression has a corner. The differential tests hold the device to the interpreter.

use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Master, NoIncludes, Options};
use oslcl_runtime::film::compare::mean;
use oslcl_runtime::precision::Precision;
use oslcl_tests::points;
use oslcl_tests::scenes::{empty, material, mesh, place, render, wall};

/// Step of the differences; their error is about its square.
const STEP: f64 = 1e-5;

/// The point moved by `t` along x (k = 0) or y (k = 1).
fn moved(g: &Globals, k: usize, t: f64) -> Globals {
    let along = |v: [f64; 3], d: [f64; 3]| [0, 1, 2].map(|i| v[i] + t * d[i]);
    Globals {
        p: along(g.p, g.dp[k]),
        i: along(g.i, g.di[k]),
        ps: along(g.ps, g.dps[k]),
        u: g.u + t * g.du[k],
        v: g.v + t * g.dv[k],
        ..g.clone()
    }
}

/// Points in general position, with slopes of their own.
fn general() -> Vec<Globals> {
    let mut grid = points::pools(0, 120, points::Reach::Narrow);
    for g in &mut grid {
        // Into (0.1, 0.9) and (-1, 1): where all functions are at home.
        let unit = |x: f64| 0.5 + 0.4 * (7.0 * x).sin();
        (g.u, g.v) = (unit(g.u), unit(g.v + 0.3));
        g.p = g.p.map(|x| (3.0 * x).sin());
        g.i = g.i.map(|x| (5.0 * x).cos());
        g.n = [0.36, 0.48, 0.8];
    }
    grid
}

/// Checks expressions of one type at once: one shader, three outputs for each.
fn check(ty: &str, expressions: &[&str]) {
    let width = if ty == "float" { 1 } else { 3 };
    let mut params = Vec::new();
    let mut body = String::new();
    let mut outputs = Vec::new();
    for (i, e) in expressions.iter().enumerate() {
        for what in ["e", "x", "y"] {
            params.push(format!("output {ty} {what}{i} = 0"));
            outputs.push(format!("{what}{i}"));
        }
        body.push_str(&format!("{{ {ty} value = {e}; e{i} = value; x{i} = Dx(value); y{i} = Dy(value); }}\n"));
    }
    let source = format!("shader test({})\n{{\n{PREAMBLE}{body}}}\n", params.join(", "));
    let options = Options::default();
    let master = Master::new(&source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    let points = general();
    let values = |points: &[Globals]| {
        master.evaluate_all(&options, &outputs, points).unwrap_or_else(|e| panic!("the interpreter: {e}"))
    };
    let here = values(&points);
    let mut worst = vec![(0_u32, 0_u32, String::new()); expressions.len()];
    for k in 0..2 {
        let shifted = |t: f64| values(&points.iter().map(|g| moved(g, k, t)).collect::<Vec<_>>());
        let (ahead, behind, near) = (shifted(STEP), shifted(-STEP), shifted(0.5 * STEP));
        for (p, point) in points.iter().enumerate() {
            for (i, expression) in expressions.iter().enumerate() {
                for c in 0..width {
                    let (a, b) = (ahead[p][3 * i].1[c], behind[p][3 * i].1[c]);
                    let (difference, slope) = ((a - b) / (2.0 * STEP), here[p][3 * i + 1 + k].1[c]);
                    // A corner lies between: the two halves disagree.
                    let half = (near[p][3 * i].1[c] - here[p][3 * i].1[c]) / (0.5 * STEP);
                    let bent = (half - difference).abs() > 1e-2 * (1.0 + difference.abs());
                    let wrong = (slope - difference).abs() > 2e-5 * (1.0 + difference.abs());
                    worst[i].0 += 1;
                    if wrong && !bent {
                        worst[i].1 += 1;
                        worst[i].2 = format!(
                            "D{} of `{expression}`[{c}]: {slope}, differences say {difference}, at u {} v {} P {:?}",
                            ["x", "y"][k],
                            point.u,
                            point.v,
                            point.p
                        );
                    }
                }
            }
        }
    }
    let wrong: Vec<&str> = worst.iter().filter(|w| w.1 > 0).map(|w| w.2.as_str()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Variables that the expressions use.
const PREAMBLE: &str = "
    vector A = vector(P) + vector(0.2, 0.1, 1.5);
    vector B = vector(u, v * v, u - v);
    color C = color(0.2 + 0.5 * u, 0.9 * v, 0.3 + 0.2 * u * v);
    matrix M = matrix(1, 2, 0, 0.1,  0, 1, 3, 0,  1, 0, 2, 0.2,  0.5, 0.25, 1, 2);
    float knots[7] = {0, u, v, P[0], P[1], u * v, 1};
    color colors[5] = {C, color(u), color(v, u, P[2]), color(0, 1, 0), C * C};
    float still[7] = {0, 0.1, 0.25, 0.5, 0.8, 1.1, 1.2};
";

#[test]
fn operators_and_control_flow() {
    check(
        "float",
        &[
            "u + v * 2 - 3 / (1 + u)",
            "-u * u * v",
            "A[0] * B[1] / A[2]",
            "u < v ? u * u : v * v",
            "(int)(3 * u) + v",
            "select(u, v * v, P[0])",
        ],
    );
    check(
        "vector",
        &["A * B + u", "A / (2 + B)", "-A * v", "vector(u * v, v, P[1])", "B * (u < 0.5 ? A : B)", "2 * A - B / u"],
    );
}

#[test]
fn mathematical_functions() {
    check(
        "float",
        &[
            "radians(u) + degrees(v)",
            "sin(u) * cos(v) + tan(u * v)",
            "asin(u) + acos(v)",
            "atan(3 * u)",
            "sinh(u) + cosh(v) + tanh(u * v)",
            "pow(u, v) + pow(v, 3)",
            "exp(u) + exp2(v) + expm1(u * v)",
            "log(u) + log2(v) + log10(u * v)",
            "log(2 * u, 3 + v)",
            "sqrt(u) + inversesqrt(v) + cbrt(u * v)",
            "hypot(u, v) + hypot(u, v, P[0])",
            "abs(P[0]) + fabs(P[1])",
            "mod(7 * u, 0.3 + 0.1 * v)",
            "fmod(7 * u, 0.4)",
            "min(u, v) + max(u * u, P[0])",
            "clamp(P[0], 0.3 * u, 0.5 + 0.4 * v)",
            "mix(u, v * v, P[0])",
            "erf(u) + erfc(v * v)",
            "linearstep(0.2 * u, 0.9 * v + 0.3, P[0])",
            "smoothstep(0.2 * u, 0.9 * v + 0.3, P[0])",
            "smooth_linearstep(0.1 * u, 0.5 + 0.3 * v, P[0], 0.1 + 0.05 * u)",
            "aastep(u, P[0], 0.3 + 0.1 * v, v)",
        ],
    );
    check(
        "color",
        &[
            "sin(C) + sqrt(C) * log(C)",
            "pow(C, u) + pow(C, color(v))",
            "mod(3 * C, 0.7 + u * 0.1)",
            "min(C, color(u)) + max(C, color(v)) + clamp(C, color(0.3 * u), color(0.6))",
            "mix(C, color(u, v, 1), v) + mix(C, color(v), C)",
            "smoothstep(color(0), color(u + 0.5), C) + linearstep(color(0), color(1), C)",
            "abs(C - 0.4) + exp(C) + atan(C)",
        ],
    );
}

#[test]
fn geometric_functions() {
    check(
        "float",
        &[
            "dot(A, B)",
            "length(A)",
            "distance(point(A), point(B))",
            "distance(point(0), point(B), point(A))",
            "determinant(M) * u",
        ],
    );
    check(
        "vector",
        &[
            "cross(A, B)",
            "normalize(A)",
            "faceforward(A, B, vector(N))",
            "reflect(A, normalize(B + vector(N)))",
            "refract(normalize(A), -normalize(A + B), 0.7 + 0.1 * u)",
            "rotate(point(A), u * 3, point(B), point(A) + vector(v, 1, u))",
            "rotate(point(A), v, vector(u, 1, v))",
            "transform(M, point(A))",
            "transform(M, A)",
            "transform(M, normal(A))",
            "transform(\"object\", point(A))",
            "vector(\"camera\", u, v, 1)",
        ],
    );
}

#[test]
fn calls_with_outputs() {
    let source = "shader test(output float e0 = 0, output float x0 = 0, output float y0 = 0,
        output float e1 = 0, output float x1 = 0, output float y1 = 0,
        output vector e2 = 0, output vector x2 = 0, output vector y2 = 0) {
        float s, c;
        sincos(3 * u, s, c);
        e0 = s * v + c; x0 = Dx(e0); y0 = Dy(e0);
        vector A = normalize(vector(P) + vector(0.2, 0.1, 1.5));
        float kr, kt;
        vector r, t;
        fresnel(A, normal(-normalize(A + 0.3 * vector(u, v, 0))), 0.8 + 0.1 * u, kr, kt, r, t);
        e1 = kr + 2 * kt; x1 = Dx(e1); y1 = Dy(e1);
        e2 = r + 3 * t; x2 = Dx(e2); y2 = Dy(e2);
    }";
    let names = ["e0", "x0", "y0", "e1", "x1", "y1", "e2", "x2", "y2"].map(str::to_owned);
    let options = Options::default();
    let master = Master::new(source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    for g in general() {
        let values = |g: &Globals| master.evaluate(&options, &names, g).unwrap_or_else(|e| panic!("{e}"));
        let here = values(&g);
        for k in 0..2 {
            let (ahead, behind) = (values(&moved(&g, k, STEP)), values(&moved(&g, k, -STEP)));
            for e in [0, 3, 6] {
                for c in 0..here[e].1.len() {
                    let difference = (ahead[e].1[c] - behind[e].1[c]) / (2.0 * STEP);
                    let slope = here[e + 1 + k].1[c];
                    let near = (slope - difference).abs() <= 2e-5 * (1.0 + difference.abs());
                    assert!(near, "{}[{c}]: {slope}, differences say {difference} at {:?}", here[e].0, g.p);
                }
            }
        }
    }
}

#[test]
fn colours() {
    check("float", &["luminance(C)"]);
    check(
        "color",
        &[
            "transformc(\"rgb\", \"hsv\", C)",
            "transformc(\"hsv\", \"rgb\", C)",
            "transformc(\"rgb\", \"hsl\", C)",
            "transformc(\"hsl\", \"rgb\", C)",
            "transformc(\"rgb\", \"YIQ\", C)",
            "transformc(\"XYZ\", \"rgb\", C)",
            "transformc(\"rgb\", \"xyY\", C)",
            "transformc(\"xyY\", \"rgb\", C)",
            "transformc(\"rgb\", \"sRGB\", C)",
            "transformc(\"sRGB\", \"rgb\", C)",
            "color(\"hsv\", u, v, 0.5)",
        ],
    );
}

#[test]
fn noises() {
    let mut expressions: Vec<String> = Vec::new();
    for kind in ["perlin", "uperlin", "simplex", "usimplex"] {
        for coordinates in ["5 * u", "5 * u, 3 * v", "4 * P", "4 * P, 2 * v"] {
            expressions.push(format!("noise(\"{kind}\", {coordinates})"));
        }
    }
    for kind in ["perlin", "uperlin"] {
        for coordinates in ["5 * u, 3", "5 * u, 3 * v, 2, 4", "4 * P, point(2, 3, 4)", "4 * P, 2 * v, point(3), 2"] {
            expressions.push(format!("pnoise(\"{kind}\", {coordinates})"));
        }
    }
    let floats: Vec<String> = expressions.iter().map(|e| format!("(float){e}")).collect();
    let colors: Vec<String> = expressions.iter().map(|e| format!("(color){e}")).collect();
    check("float", &floats.iter().map(String::as_str).collect::<Vec<_>>());
    check("color", &colors.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn splines() {
    let bases = ["catmull-rom", "bezier", "bspline", "hermite", "linear", "constant"];
    let floats: Vec<String> = bases.iter().map(|b| format!("spline(\"{b}\", u, knots)")).collect();
    let triples: Vec<String> = bases.iter().map(|b| format!("spline(\"{b}\", v, colors)")).collect();
    check("float", &floats.iter().map(String::as_str).collect::<Vec<_>>());
    check("color", &triples.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn an_inverse_of_a_spline_has_the_inverse_slope() {
    // Differences say little: the value is as coarse as the reference's few steps to the root. At that root, though, the
    // slopes of a spline and of its inverse undo each other. Where there is no root, there is no slope.
    for basis in ["catmull-rom", "bspline", "linear"] {
        let source = format!(
            "shader test(output float x = 0, output float y = 0, output float dx = 0, output float dy = 0) {{ {PREAMBLE}
            float there = splineinverse(\"{basis}\", u, still);
            float back = spline(\"{basis}\", there, still);
            x = Dx(back); y = Dy(back); dx = Dx(u); dy = Dy(u); if (there <= 0 || there >= 1 || abs(back - u) > 0.9e-3) x = y = dx = dy = 0; }}"
        );
        let options = Options::default();
        let master = Master::new(&source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let outputs = ["x", "y", "dx", "dy"].map(str::to_owned);
        let found = master.evaluate_all(&options, &outputs, &general()).unwrap_or_else(|e| panic!("{e}"));
        let inside = found.iter().filter(|point| point[2].1[0] != 0.0).count();
        assert!(inside > 3, "{basis}: only {inside} points");
        for point in found {
            for (got, wanted) in [(0, 2), (1, 3)] {
                let (got, wanted) = (point[got].1[0], point[wanted].1[0]);
                assert!((got - wanted).abs() <= 1e-9 * (1.0 + wanted.abs()), "{basis}: {got}, not {wanted}");
            }
        }
    }
}

#[test]
fn what_the_reference_gives_no_derivatives_has_none() {
    let source = "shader test(output float o[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1}, output float a = 0) {
        float all[9] = { floor(3 * u), ceil(v), round(u), trunc(v), sign(u), step(0.5, u), cellnoise(P), hashnoise(P),
            luminance(blackbody(5000 * u)) };
        for (int i = 0; i < 9; ++i) o[i] = Dx(all[i]);
        a = Dx(atan2(u, v));
    }";
    let options = Options::default();
    let master = Master::new(source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
    for g in general() {
        let values = master.evaluate(&options, &["o".to_owned(), "a".to_owned()], &g).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(values[0].1, [0.0; 9]);
        // The reference implementation has the opposite sign here, and its suite holds it to that.
        let (y, x) = (g.u, g.v);
        let slope = -(x * g.du[0] - y * g.dv[0]) / (x * x + y * y);
        assert!((values[1].1[0] - slope).abs() < 1e-12, "{} {slope}", values[1].1[0]);
    }
}

/// A wall across the view: what a pixel covers there is known.
#[test]
fn a_renderer_knows_what_its_pixels_cover() {
    let across = 2.0 * 5.0 * 10_f64.to_radians().tan() / 16.0;
    for (source, expected) in [
        ("surface e() { Ci = color(Dx(P)[0], -Dy(P)[2], filterwidth(P)[0]) * emission(); }", [across; 3]),
        ("surface e() { Ci = color(2 * Dx(u), -2 * Dy(v), 1 + Dy(u)) * emission(); }", [across, across, 1.0]),
        (
            "surface e() { Ci = color(dot(normalize(calculatenormal(P)), N), 10 * area(P), 5 * Dx(I)[0]) * emission(); }",
            // Off the axis the direction turns slower: the mean of (1 + z^2) / (1 + x^2 + z^2)^1.5 over the picture.
            [1.0, 10.0 * across * across, 0.9797 * across],
        ),
    ] {
        let mut scene = empty();
        let m = material(&mut scene, source, &[]);
        let w = mesh(&mut scene, wall());
        place(&mut scene, w, m, glam::DAffine3::IDENTITY);
        let (picture, summary) = render(&scene, Precision::Standard);
        assert_eq!((summary.counts.dropped, summary.counts.repaired), (0, 0));
        let found = mean(&picture);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 5e-3 * expected, "{source}: {found:?}, expected {expected}");
        }
    }
}

/// Behind a mirror the footprint is there: the sky's direction still has one.
#[test]
fn footprints_survive_bounces() {
    let mut scene = empty();
    let m = material(&mut scene, "surface m() { Ci = 0.5 * reflection(N) + 0.5 * diffuse(N); }", &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, glam::DAffine3::IDENTITY);
    let sky = material(&mut scene, "surface s() { Ci = color(length(filterwidth(I)) > 0, 0, 0) * background(); }", &[]);
    scene.environment = Some(sky);
    let (picture, _) = render(&scene, Precision::Standard);
    let found = mean(&picture);
    // The mirror's half of the light has a footprint. Behind the diffuse half the sky is found in two ways, which must see the same
    // sky to be weighed against each other, and rays that are sent there have none.
    assert!((found[0] - 0.5).abs() < 0.01, "{found:?}");
}
