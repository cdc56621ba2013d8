//! Hard cases of BSDFs: around every singularity, sampling and evaluation agree, light goes both ways alike, none is made, and none of
//! the numbers is infinite. The ordinary cases, with chi-squared tests, stand in bsdf.rs.

use oslcl_runtime::device::Device;
use oslcl_tests::bsdf::cases::case;
use oslcl_tests::bsdf::{Case, Lab, Sample, dot};
use oslcl_tests::hard_cases::pictures::{furnace, mean, render};
use oslcl_tests::hard_cases::{Ledger, Run, each, meshes};

const REFLECT: i32 = 1;
const DELTA: i32 = 4;

/// Facets in both distributions, as mirrors, glass and metal: closures 5, 10, 15, 16.
fn facets(a: f64, b: f64, eta: f64, degrees: f64) -> Vec<Case> {
    let mut out = Vec::new();
    for dist in [0, 1] {
        let upright =
            |closure, refract| Case { dist, refract, a, b, eta, n: [0.0, 0.0, 1.0], ..case(closure, degrees) };
        out.extend([(5, 0), (5, 1), (5, 2), (10, 0), (15, 2), (16, 2)].map(|(c, r)| upright(c, r)));
    }
    out
}

fn angle(cosine: f64) -> f64 {
    90.0 - cosine.asin().to_degrees()
}

/// The families, by name.
fn families() -> Vec<(&'static str, Vec<Case>)> {
    let mut out: Vec<(&'static str, Vec<Case>)> = Vec::new();
    let roughness = [0.0, 1e-7, 1e-5, 1e-4, 2e-4, 1e-3, 1e-2, 0.1, 1.0];
    let over = |list: &[f64], f: &dyn Fn(f64) -> Vec<Case>| list.iter().flat_map(|x| f(*x)).collect::<Vec<Case>>();
    out.push((
        "roughness 0, 1e-7 .. 1",
        over(&roughness, &|a| [0.0, 60.0, 85.0].iter().flat_map(|d| facets(a, a, 1.5, *d)).collect()),
    ));
    out.push((
        "roughness 1e-4 : 1",
        over(&[0.0, 60.0, 85.0], &|d| [facets(1e-4, 1.0, 1.5, d), facets(1.0, 1e-4, 1.5, d)].concat()),
    ));
    let cosines = [1e-2, 1e-4, 1e-6, 1e-8];
    let smooth = |degrees: f64| {
        [0, 1, 2, 3, 4, 13, 14, 17, 19].map(|c| Case { a: 0.3, b: 0.3, n: [0.0, 0.0, 1.0], ..case(c, degrees) })
    };
    out.push((
        "cosines to 1e-8",
        over(&cosines, &|c| [facets(0.1, 0.1, 1.5, angle(c)), smooth(angle(c)).to_vec()].concat()),
    ));
    out.push(("cosines to 1e-8, mirrors", over(&cosines, &|c| facets(0.0, 0.0, 1.5, angle(c)))));
    let near = [1.0 - 1e-7, 1.0 - 1e-6, 1.0, 1.0 + 1e-7, 1.0 + 1e-6];
    out.push((
        "ior 1 +- 1e-7",
        over(&near, &|e| {
            [facets(0.0, 0.0, e, 50.0), facets(0.1, 0.1, e, 50.0), facets(0.0, 0.0, e, angle(1e-4))].concat()
        }),
    ));
    // sin of the critical angle is 1/1.5.
    let critical = (1.0f64 / 1.5).asin().to_degrees();
    let around = [-1e-2, -1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-2].map(|d| critical + d);
    out.push((
        "the edge of total reflection",
        over(&around, &|d| [facets(0.0, 0.0, 1.0 / 1.5, d), facets(0.05, 0.05, 1.0 / 1.5, d)].concat()),
    ));
    out.push((
        "ior 1e-3 and 1e3",
        over(&[1e-3, 1e3], &|e| {
            [0.0, 60.0, 85.0].iter().flat_map(|d| [facets(0.0, 0.0, e, *d), facets(0.2, 0.2, e, *d)].concat()).collect()
        }),
    ));
    let mut metals = Vec::new();
    for n in [1e-3, 1.0, 1e3] {
        for k in [0.0, 1.0, 1e3] {
            for (a, degrees) in [(0.0, 30.0), (0.1, 0.0), (0.1, 60.0), (0.1, 85.0), (1e-3, 30.0)] {
                metals.push(Case { a, b: a, ior: [n; 3], extinction: [k; 3], n: [0.0, 0.0, 1.0], ..case(10, degrees) });
            }
        }
    }
    out.push(("conductors, n 1e-3 .. 1e3, k 0 .. 1e3", metals));
    out
}

/// What is measured of a family: the worst over its cases.
#[derive(Default)]
struct Worst {
    broken: f64,
    energy: f64,
    pdf: f64,
    value: f64,
    reciprocity: f64,
}

/// A part of some samples, of `drawn`; fewer than a hundredth of these, or than a hundred, are taken for as many: a lobe of which
/// three samples in 1e5 are seen says nothing by those.
fn share(count: usize, of: usize, drawn: usize) -> f64 {
    count as f64 / of.max(100).max(drawn / 100) as f64
}

/// Whether two numbers differ by more than a twentieth.
fn apart(a: f64, b: f64) -> bool {
    (a - b).abs() > 0.05 * a.abs().max(b.abs()) + 1e-9
}

fn examine(lab: &Lab, c: &Case, count: usize, seed: u32, worst: &mut Worst) {
    let drawn = lab.sample(c, count, seed).expect("the lobe is sampled");
    let fine = |s: &Sample| {
        let numbers = [s.wi, s.value, s.f, s.swapped, s.albedo3];
        let unit = s.flags == 0 || (dot(s.wi, s.wi) - 1.0).abs() < 1e-4;
        let good = |x: &f64| x.is_finite() && *x >= 0.0;
        numbers.iter().flatten().all(|x| x.is_finite())
            && unit
            && [s.pdf, s.eval_pdf, s.albedo].iter().all(good)
            && s.value.iter().all(good)
    };
    worst.broken += drawn.iter().filter(|s| !fine(s)).count() as f64;
    // Of each channel by itself: what reflects one may let through another.
    for channel in 0..3 {
        let values = || drawn.iter().map(|s| if s.flags != 0 { s.value[channel] } else { 0.0 });
        let mean = values().sum::<f64>() / count as f64;
        let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count as f64;
        worst.energy = worst.energy.max(mean - 4.5 * (variance / count as f64).sqrt());
    }
    let rough: Vec<&Sample> = drawn.iter().filter(|s| s.flags != 0 && s.flags & DELTA == 0).collect();
    worst.pdf = worst.pdf.max(share(rough.iter().filter(|s| apart(s.pdf, s.eval_pdf)).count(), rough.len(), count));
    let off = |s: &&&Sample| apart(s.value[0], s.f[0] / s.eval_pdf.max(f64::MIN_POSITIVE));
    worst.value = worst.value.max(share(rough.iter().filter(off).count(), rough.len(), count));
    let (n, co) = (c.n, dot(c.n, c.wo()));
    let both: Vec<&&Sample> =
        rough.iter().filter(|s| s.flags & REFLECT != 0 && dot(n, s.wi) > 1e-2 && co > 1e-2).collect();
    let uneven = |s: &&&&Sample| apart(s.f[0] * co, s.swapped[0] * dot(n, s.wi));
    worst.reciprocity = worst.reciprocity.max(share(both.iter().filter(uneven).count(), both.len(), count));
}

fn hold(run: &Run<'_>, ledger: &mut Ledger, name: &str, worst: &Worst) {
    let double = run.precision.is_double();
    ledger.at_most(&format!("{name}: samples with a number that is not finite, or negative"), worst.broken, 0.0);
    ledger.at_most(&format!("{name}: light scattered, less 4.5 sigma"), worst.energy, 1.0 + 1e-5);
    // Where a lobe is as sharp as directions are known, single directions say little of the density.
    let sharp = match name {
        "roughness 0, 1e-7 .. 1" | "conductors, n 1e-3 .. 1e3, k 0 .. 1e3" | "roughness 1e-4 : 1" => 0.06,
        _ => 0.01,
    };
    let bound = if double { 1e-3 } else { sharp };
    ledger.at_most(&format!("{name}: share of samples whose density is 5 % off that of evaluation"), worst.pdf, bound);
    ledger.at_most(&format!("{name}: share of samples whose value is 5 % off f / pdf"), worst.value, bound);
    ledger.at_most(&format!("{name}: share of samples 5 % off reciprocity"), worst.reciprocity, bound);
}

#[test]
fn lobes_hold_around_their_singularities() {
    each("bsdf", |run, ledger| {
        let lab = Lab::on(Device::open(run.number).expect("a device"), run.precision).expect("the kernels build");
        for (name, cases) in families() {
            let mut worst = Worst::default();
            // The fast part takes every third.
            for (k, c) in cases.iter().enumerate().step_by(if run.full { 1 } else { 3 }) {
                examine(&lab, c, run.count(1 << 12, 1 << 15), 1 + k as u32, &mut worst);
            }
            hold(run, ledger, name, &worst);
        }
    });
}

#[test]
fn a_thousand_bounces_neither_lose_nor_make_light() {
    each("bsdf", |run, ledger| {
        // From within a ball of albedo 1: each bounce leaves with probability 1/1000, so that 999 bounces let 1 - 0.999^999 out.
        let mut scene =
            furnace(meshes::ball(24, 12), "surface d() { Ci = 0.001 * transparent() + 0.999 * diffuse(N); }");
        scene.camera.origin = glam::DVec3::new(0.0, -0.5, 0.0);
        scene.integrator.max_depth = 1000;
        scene.integrator.samples = run.count(4, 64) as u32;
        let picture = render(run, ledger, "diffuse ball", &scene).0;
        let expected = 1.0 - 0.999f64.powi(999);
        let noise = 4.5 * (expected * (1.0 - expected) / (256.0 * f64::from(scene.integrator.samples))).sqrt();
        ledger.at_most(
            "white diffuse ball to depth 1,000: error of the mean",
            (mean(&picture) - expected).abs(),
            noise,
        );
        // Each path brings all of its light or none.
        let whole = |x: f32| {
            let paths = f64::from(x) * f64::from(scene.integrator.samples);
            (paths - paths.round()).abs()
        };
        let error = picture.pixels.iter().map(|p| whole(p[0])).fold(0.0, f64::max);
        ledger.at_most(
            "white diffuse ball to depth 1,000: what paths lose or gain, at most",
            error / f64::from(scene.integrator.samples),
            1e-4,
        );
        for (name, source) in [
            ("mirror", "surface m() { Ci = 0.001 * transparent() + 0.999 * reflection(N); }"),
            (
                "metal of k = 1e3",
                "surface m() { Ci = 0.001 * transparent() + 0.999 * conductor_bsdf(N, dPdu, 0, 0, color(1), color(1e3), \"ggx\"); }",
            ),
        ] {
            let mut inside = furnace(meshes::ball(24, 12), source);
            inside.camera = scene.camera.clone();
            inside.integrator = scene.integrator;
            let picture = render(run, ledger, name, &inside).0;
            ledger.at_most(&format!("{name} to depth 1,000: mean"), mean(&picture), expected + noise + 1e-5);
        }
    });
}
