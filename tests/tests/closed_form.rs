//! Scenes whose radiance is known in closed form, through the whole renderer.

use glam::{DAffine3, DMat3, DVec3};
use oslcl_runtime::film::compare::mean;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::scene::{ParamValue, Scene};
use oslcl_tests::scenes::{empty, material, mesh, place, render, sphere, wall};

const DIFFUSE: &str = "surface d(color Cs = 0.5) { Ci = Cs * diffuse(N); }";
const SKY: &str = "surface s(color Le = 1) { Ci = Le * background(); }";

fn check(name: &str, scene: &Scene, expected: f64, tolerance: f64) {
    let (picture, summary) = render(scene, Precision::Standard);
    let mean = mean(&picture);
    assert_eq!((summary.counts.dropped, summary.counts.repaired), (0, 0), "{name}");
    let pixels = (picture.width * picture.height) as u64;
    assert_eq!(
        summary.counts.samples,
        pixels * u64::from(scene.integrator.samples),
        "{name}: every sample counts once"
    );
    for m in &mean {
        assert!((m - expected).abs() <= tolerance * expected.max(1e-3), "{name}: {mean:?}, expected {expected}");
    }
}

fn sky(scene: &mut Scene, source: &str) {
    let id = material(scene, source, &[]);
    scene.environment = Some(id);
}

#[test]
fn an_empty_scene_shows_its_environment() {
    let mut scene = empty();
    sky(&mut scene, "surface s() { Ci = 0.7 * background(); }");
    check("constant", &scene, 0.7, 1e-6);
    let mut scene = empty();
    // The mean over the picture of a linear function of direction, by symmetry its value in the middle's direction.
    sky(&mut scene, "surface s() { Ci = (0.5 + 0 * I[0] + I[2]) * background(); }");
    check("varying", &scene, 0.5, 2e-3);
}

#[test]
fn a_diffuse_wall_under_a_white_sky_shows_its_albedo() {
    let mut scene = empty();
    sky(&mut scene, SKY);
    let m = material(&mut scene, DIFFUSE, &[("Cs", ParamValue::Floats(vec![0.25; 3]))]);
    let wall = mesh(&mut scene, wall());
    place(&mut scene, wall, m, DAffine3::IDENTITY);
    check("wall", &scene, 0.25, 1e-5);
}

#[test]
fn a_furnace_keeps_all_light() {
    for (name, source) in [
        ("diffuse", "surface d() { Ci = diffuse(N); }"),
        ("mirror", "surface d() { Ci = reflection(N); }"),
        ("glass", "surface d() { float e = backfacing() ? 1/1.5 : 1.5; Ci = reflection(N, e) + refraction(N, e); }"),
        ("translucent", "surface d() { Ci = 0.5 * translucent(N) + 0.5 * diffuse(N); }"),
        ("transparent", "surface d() { Ci = transparent(); }"),
    ] {
        let mut scene = empty();
        scene.integrator.max_depth = 200;
        scene.integrator.samples = 16;
        sky(&mut scene, SKY);
        let m = material(&mut scene, source, &[]);
        let ball = mesh(&mut scene, sphere());
        place(&mut scene, ball, m, DAffine3::IDENTITY);
        check(name, &scene, 1.0, 2e-3);
    }
}

/// A square light of side 2 parallel to a small wall, at distance h, its middle over the point: the form factor of four
/// right triangles (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3).
fn square_over_point(h: f64) -> f64 {
    let a = 1.0 / h;
    let s = (1.0 + a * a).sqrt();
    4.0 / (2.0 * std::f64::consts::PI) * 2.0 * (a / s) * (a / s).atan()
}

fn lit_wall(light: &str, instanced: bool) -> Scene {
    let mut scene = empty();
    scene.camera.hfov_degrees = 0.02;
    scene.integrator.max_depth = 2;
    scene.integrator.samples = 256;
    let m = material(&mut scene, DIFFUSE, &[]);
    let l = material(&mut scene, light, &[]);
    let square = mesh(&mut scene, wall());
    // The light hangs behind the camera and shines along +y.
    let turn = DMat3::from_rotation_z(std::f64::consts::PI);
    let behind = DAffine3::from_mat3_translation(turn, DVec3::new(0.0, -8.0, 0.0));
    place(&mut scene, square, m, DAffine3::IDENTITY);
    let light = if instanced { square } else { mesh(&mut scene, wall()) };
    place(&mut scene, light, l, behind);
    scene
}

#[test]
fn a_square_light_gives_its_form_factor() {
    let expected = 0.5 * 3.0 * square_over_point(8.0);
    for instanced in [false, true] {
        check("constant light", &lit_wall("surface l() { Ci = 3 * emission(); }", instanced), expected, 2e-3);
        // The same light, but only its shader knows.
        let varying = "surface l() { Ci = 3 * (1 + 0.5 * (u - 0.5)) * emission(); }";
        check("varying light", &lit_wall(varying, instanced), expected, 5e-3);
    }
}

#[test]
fn a_light_shines_on_its_front_only() {
    let mut scene = lit_wall("surface l() { Ci = 3 * emission(); }", false);
    scene.instances[1].transform.matrix3 = DMat3::IDENTITY;
    check("back", &scene, 0.0, 1e-9);
}

#[test]
fn a_bright_patch_of_sky_is_found() {
    // Radiance 1000 within 2 degrees of -y, behind the camera: irradiance on the wall is L pi sin^2.
    let mut scene = empty();
    scene.integrator.max_depth = 2;
    sky(&mut scene, "surface s() { Ci = (-I[1] > cos(radians(2.0)) ? 1000 : 0) * background(); }");
    let m = material(&mut scene, DIFFUSE, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::from_scale(DVec3::splat(3.0)));
    let sine = 2f64.to_radians().sin();
    check("patch", &scene, 0.5 * 1000.0 * sine * sine, 1e-2);
}

#[test]
fn same_seed_same_bits_and_other_seed_other_noise() {
    let mut scene = lit_wall("surface l() { Ci = 3 * emission(); }", false);
    scene.integrator.samples = 4;
    let (first, _) = render(&scene, Precision::Standard);
    let (second, _) = render(&scene, Precision::Standard);
    assert_eq!(first, second);
    scene.integrator.seed = 2;
    assert_ne!(first, render(&scene, Precision::Standard).0);
}

#[test]
fn single_and_double_precision_agree() {
    let scene = lit_wall("surface l() { Ci = 3 * emission(); }", false);
    let (single, double) = (render(&scene, Precision::Standard).0, render(&scene, Precision::Reference).0);
    let (a, b) = (mean(&single)[0], mean(&double)[0]);
    assert!((a - b).abs() < 1e-5 * b, "{a} {b}");
}

#[test]
fn holdout_cuts_a_hole_into_alpha() {
    let mut scene = empty();
    sky(&mut scene, SKY);
    let m = material(&mut scene, "surface h() { Ci = 0.25 * holdout(); }", &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    let (picture, _) = render(&scene, Precision::Standard);
    assert!(picture.alpha.iter().all(|a| (a - 0.75).abs() < 1e-6), "{:?}", picture.alpha);
    assert_eq!(mean(&picture), [0.0; 3]);
}

#[test]
fn glass_transmits_what_it_does_not_reflect() {
    // One sheet of a dielectric seen head-on: transmittance 1 - F0 into the sky behind, F0 from the sky in front.
    let mut scene = empty();
    scene.camera.hfov_degrees = 0.02;
    sky(&mut scene, "surface s() { Ci = (I[1] > 0 ? 1.0 : 0.0) * background(); }");
    let m = material(&mut scene, "surface g() { Ci = reflection(N, 1.5) + refraction(N, 1.5); }", &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene.integrator.samples = 1024;
    check("sheet", &scene, 0.96, 2e-3);
}
