//! Hard cases of accumulation, random numbers and shaders' arithmetic.

use oslcl_runtime::render::{self, Options};
use oslcl_runtime::scene::{Film, Scene};
use oslcl_tests::hard_cases::numbers::{Numbers, uneven_cube_bits, wrong_sobol_points};
use oslcl_tests::hard_cases::pictures::{mean, render, sky};
use oslcl_tests::hard_cases::{each, pictures};
use oslcl_tests::scenes::{empty, material, mesh, place, wall};

#[test]
fn ten_million_samples_of_a_pixel_add_up() {
    each("accumulation", |run, ledger| {
        let numbers = Numbers::new(run).unwrap_or_else(|e| panic!("{e}"));
        let errors = numbers.sums(10_000_000, 1).expect("samples are added");
        ledger.at_most("1e7 samples of a pixel: relative error of the sum", errors.compensated, 1e-5);
        ledger.at_most(
            "1e7 samples of a pixel: the same without compensation (what was rejected)",
            errors.plain,
            f64::MAX,
        );
    });
}

#[test]
fn counters_go_beyond_32_bits() {
    each("accumulation", |run, ledger| {
        let numbers = Numbers::new(run).unwrap_or_else(|e| panic!("{e}"));
        let start = (1u64 << 32) - 5;
        let wrong = [(start, 1, 10), (start, 1_000_000, 9_000), (u64::MAX >> 1, u32::MAX, 7)].into_iter().filter(
            |(s, n, times)| numbers.count(*s, *n, *times).expect("counts") != s + u64::from(*n) * u64::from(*times),
        );
        ledger.at_most("counters of samples and rays past 2^32: wrong ones", wrong.count() as f64, 0.0);
    });
}

#[test]
fn more_samples_than_are_counted_exactly_are_refused() {
    let mut scene = empty();
    sky(&mut scene, 1.0);
    scene.integrator.samples = (1 << 24) + 1;
    let error = scene.check().expect_err("too many samples").to_string();
    assert!(error.contains("integrator.samples") && error.contains("16777216"), "{error}");
}

/// The last samples that a scene can have are as good as the first: a mean over them, by their index alone.
#[test]
fn the_last_samples_are_as_good_as_the_first() {
    each("accumulation", |run, ledger| {
        let mut scene = empty();
        scene.film = Film { width: 1, height: 1 };
        scene.integrator.samples = run.count(1 << 16, 1 << 24) as u32;
        let source = "surface s() { Ci = (0.5 + 5 * I[0]) * background(); }";
        scene.environment = Some(material(&mut scene, source, &[]));
        let (picture, summary) = render(run, ledger, "one pixel", &scene);
        assert_eq!(summary.counts.samples, u64::from(scene.integrator.samples));
        let noise = 4.0 * 0.5 / f64::from(scene.integrator.samples).sqrt();
        ledger.at_most(
            "one pixel of 2^24 samples (fast: 2^16): error of the mean",
            (mean(&picture) - 0.5).abs(),
            noise + 1e-5,
        );
    });
}

#[test]
fn random_numbers_are_never_one() {
    each("random", |run, ledger| {
        let numbers = Numbers::new(run).unwrap_or_else(|e| panic!("{e}"));
        let [outside, inexact] = numbers.edges().expect("numbers are made");
        ledger.at_most("all 2^24 values of a random number: outside [0, 1)", f64::from(outside), 0.0);
        ledger.at_most("all 2^24 values of a random number: not exact", f64::from(inexact), 0.0);
        let turns = run.count(64, 4096) as u32;
        for (name, first) in [("0", 0u32), ("2^31", 1 << 31), ("2^32 less a few", u32::MAX - 0xffff)] {
            let range = numbers.random(first, 1 << 12, turns, 7).expect("numbers are made");
            ledger.at_most(&format!("counters from {name} on: numbers outside [0, 1)"), f64::from(range.outside), 0.0);
            let count = 4.0 * 4096.0 * f64::from(turns);
            let noise = 5.0 / (12.0 * count).sqrt();
            ledger.at_most(
                &format!("counters from {name} on: distance of the mean from 1/2"),
                (range.mean - 0.5).abs(),
                noise + 1e-6,
            );
            assert!(range.least < 1e-3 && range.most > 0.999 && range.most < 1.0, "{range:?}");
        }
    });
}

#[test]
fn sobol_points_are_sums_of_direction_numbers() {
    each("random", |run, ledger| {
        let wrong = wrong_sobol_points(run, 1 << 16).unwrap_or_else(|e| panic!("{e}"));
        ledger.at_most("65,536 points of Sobol's sequence: wrong ones", wrong as f64, 0.0);
    });
}

/// The choice among the cells of an environment takes all of them: with 8 that were 0, a small sun was 4 % too dark.
#[test]
fn all_bits_of_cubes_are_random() {
    each("random", |run, ledger| {
        let uneven = uneven_cube_bits(run, 1 << 16).unwrap_or_else(|e| panic!("{e}"));
        ledger.at_most("bits of 65,536 shared cubes: share of ones less a half", uneven, 0.02);
    });
}

/// A wall whose emission is an expression.
fn glowing(expression: &str) -> Scene {
    let mut scene = empty();
    scene.integrator.samples = 4;
    scene.integrator.max_depth = 1;
    let m = material(&mut scene, &format!("surface g() {{ {expression} }}"), &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, glam::DAffine3::from_scale(glam::DVec3::splat(2.0)));
    scene
}

#[test]
fn shaders_stay_finite_at_the_edges_of_their_arithmetic() {
    each("shaders", |run, ledger| {
        for (name, expression, expected, tolerance) in [
            ("division by zero", "float z = P[1] * 0; Ci = (1 + 1 / z + z / z + 0 / z) * emission();", 1.0, 1e-6),
            (
                "roots and logarithms of negative numbers",
                "float z = P[1] * 0 - 1; Ci = (1 + sqrt(z) + inversesqrt(z) + 0 * log(z) + pow(z, 0.5)) * emission();",
                1.0,
                1e-6,
            ),
            (
                "vectors of length 0",
                "vector z = vector(P[1] * 0); Ci = (1 + length(normalize(z)) + dot(normalize(z), N)) * emission();",
                1.0,
                1e-6,
            ),
            (
                "a loop of 1e6 turns",
                "float s = 0; for (int i = 0; i < 1000000; i++) s += 1; Ci = s * 1e-6 * emission();",
                1.0,
                1e-6,
            ),
            (
                "denormals, flushed or not",
                "float z = P[1] * 0 + 1e-40; Ci = (1 + z + z * 1e30 + sqrt(z) * 0) * emission();",
                1.0,
                1e-6,
            ),
            ("perlin noise at 1e9", "Ci = (0.5 + 0.25 * noise(\"perlin\", P * 1e9)) * emission();", 0.5, 0.25),
            ("simplex noise at 1e9", "Ci = (0.5 + 0.25 * noise(\"simplex\", P * 1e9)) * emission();", 0.5, 0.25),
            ("cell noise at 1e9", "Ci = noise(\"cell\", P * 1e9) * emission();", 0.5, 0.5),
            ("periodic noise at 1e9", "Ci = pnoise(\"uperlin\", P * 1e9, point(1e9)) * emission();", 0.5, 0.5),
            ("gabor noise at 1e9", "Ci = (0.5 + 0.25 * noise(\"gabor\", P * 1e9)) * emission();", 0.5, 0.5),
        ] {
            let picture = render(run, ledger, name, &glowing(expression)).0;
            let error = (mean(&picture) - expected).abs();
            ledger.at_most(&format!("{name}: distance of the mean from {expected}"), error, tolerance);
        }
    });
}

/// The counter itself: radiance that f32 can't hold is repaired and counted in f32, relaxed or not; in f64 it is no hard case.
#[test]
fn what_is_not_finite_is_counted() {
    each("shaders", |run, ledger| {
        // A number that no compiler knows: relaxed arithmetic may fold an infinite one to anything.
        let scene = glowing("float big = 1e30 + P[1] * 1e20; Ci = big * big * emission();");
        let options = Options { choices: run.precision.into(), ..Options::default() };
        let (picture, summary) =
            render::render(&scene, run.device, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
        let samples = 16 * 16 * 4;
        let expected = if run.precision.is_double() { 0 } else { samples };
        ledger.at_most(
            "radiance of 1e60, too much for f32: samples not counted as repaired",
            f64::from(u32::abs_diff(summary.counts.repaired, expected)),
            0.0,
        );
        assert!(picture.pixels.iter().flatten().all(|x| x.is_finite()), "{:?}", pictures::mean(&picture));
    });
}
