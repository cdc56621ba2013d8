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

#[test]
fn a_layer_passes_on_what_its_top_leaves() {
    // A smooth coat's albedo is exact, so nothing is lost; with albedo 1 each layer shows the white sky.
    let coat = "dielectric_bsdf(N, dPdu, color(1), color(0), 0, 0, 1.5, \"ggx\")";
    let white = "oren_nayar_diffuse_bsdf(N, color(1), 0.7, \"energy_compensation\", 1)";
    let glass = "dielectric_bsdf(N, dPdu, color(1), color(1), 0, 0, 1.5, \"ggx\")";
    let film = "dielectric_bsdf(N, dPdu, color(1), color(0), 0, 0, 1.5, \"ggx\", \"thinfilm_thickness\", 350, \"thinfilm_ior\", 1.33)";
    for (name, ci, expected, tolerance) in [
        ("coat", format!("layer({coat}, {white})"), 1.0, 2e-3),
        ("film", format!("layer({film}, {white})"), 1.0, 2e-3),
        ("coats", format!("layer(0.5 * {coat}, layer({coat}, {white}))"), 1.0, 2e-3),
        ("opaque", format!("layer({glass}, {white})"), 1.0, 2e-3),
        ("sheen", format!("layer(sheen_bsdf(N, color(1), 0.4, \"mode\", 1), {white})"), 1.0, 5e-3),
        // What is under a white surface is not seen.
        ("white", format!("layer({white}, uniform_edf(5))"), 1.0, 0.02),
        ("nothing on top", format!("layer(0, 0.5 * {white}) + layer(transparent(), 0)"), 1.5, 5e-3),
    ] {
        let mut scene = empty();
        scene.integrator.samples = 256;
        scene.integrator.max_depth = 32;
        sky(&mut scene, SKY);
        let m = material(&mut scene, &format!("surface l() {{ Ci = {ci}; }}"), &[]);
        let wall = mesh(&mut scene, wall());
        place(&mut scene, wall, m, DAffine3::IDENTITY);
        check(name, &scene, expected, tolerance);
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
fn a_sampled_sky_is_as_sharp_for_paths_as_for_shadow_rays() {
    // A path that saw it blurred would add light that shadow rays have counted already.
    let mut scene = empty();
    sky(&mut scene, "surface s() { Ci = (filterwidth(I[0]) > 0 ? 3 : 1) * background(); }");
    let m = material(&mut scene, DIFFUSE, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::from_scale(DVec3::splat(3.0)));
    check("sharp", &scene, 0.5, 1e-2);
}

#[test]
fn a_light_that_nearly_touches_a_surface_is_not_hidden_by_itself() {
    // A plate of radiance 3 a hundredth before the wall, through whose dark back the camera looks.
    let mut scene = empty();
    let m = material(&mut scene, DIFFUSE, &[]);
    let plate = material(&mut scene, "surface l() { Ci = 3 * emission() + transparent(); }", &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::from_scale(DVec3::splat(3.0)));
    let turned = DAffine3::from_rotation_z(std::f64::consts::PI) * DAffine3::from_scale(DVec3::splat(3.0));
    let l = mesh(&mut scene, wall());
    place(&mut scene, l, plate, DAffine3::from_translation(DVec3::new(0.0, -0.01, 0.0)) * turned);
    check("plate", &scene, 1.5, 2e-2);
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

/// A glowing square of side 0.4 in front of a black sky, in the middle of the picture.
fn small_light(lens_radius: f64, focus_distance: f64) -> Scene {
    let mut scene = empty();
    scene.integrator.max_depth = 1;
    scene.integrator.samples = 256;
    scene.camera.lens_radius = lens_radius;
    scene.camera.focus_distance = focus_distance;
    let l = material(&mut scene, "surface l() { Ci = 3 * emission(); }", &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, l, DAffine3::from_scale(DVec3::splat(0.2)));
    scene
}

#[test]
fn a_lens_blurs_what_is_out_of_focus_only() {
    let pinhole = render(&small_light(0.0, 5.0), Precision::Standard).0;
    let focused = render(&small_light(0.3, 5.0), Precision::Standard).0;
    let blurred = render(&small_light(0.3, 2.5), Precision::Standard).0;
    let at = |p: &oslcl_runtime::film::Picture, x: usize| f64::from(p.pixels[8 * p.width + x][0]);
    // The square spans 3.6 of 16 pixels; the blur of a lens of 0.3 focused at 2.5 spans 0.6 at distance 5, 5.4 pixels.
    assert!((at(&focused, 8) - 3.0).abs() < 1e-5 && at(&focused, 12) == 0.0, "sharp in focus");
    assert!(at(&blurred, 8) < 2.5 && at(&blurred, 11) > 0.05, "spread out of focus");
    let (a, b, c) = (mean(&pinhole)[0], mean(&focused)[0], mean(&blurred)[0]);
    assert!((a - b).abs() < 0.02 * a && (a - c).abs() < 0.03 * a, "no light is lost: {a} {b} {c}");
}

#[test]
fn shaders_see_the_state_that_they_ask_for() {
    for (what, source, expected) in [
        ("area 36", "surface l() { Ci = surfacearea() * emission(); }", 36.0),
        ("camera rays", "surface l() { Ci = raytype(\"camera\") * 2 * emission(); }", 2.0),
        ("front", "surface l() { Ci = (backfacing() ? 7 : 2) * emission(); }", 2.0),
        ("depth in camera space", "surface l() { Ci = transform(\"camera\", P)[2] * emission(); }", 5.0),
        ("flat in object space", "surface l() { Ci = (1 + transform(\"object\", P)[1]) * emission(); }", 1.0),
        ("texture coordinates", "surface l() { Ci = (u + v) * emission(); }", 1.0),
        ("tangent", "surface l() { Ci = length(dPdu) * emission(); }", 6.0),
    ] {
        let mut scene = empty();
        scene.integrator.max_depth = 1;
        let m = material(&mut scene, source, &[]);
        let w = mesh(&mut scene, wall());
        place(&mut scene, w, m, DAffine3::from_scale(DVec3::splat(3.0)));
        check(what, &scene, expected, 5e-3);
    }
}

/// Small meshes all over the picture: each mesh once per place, or shared by all places.
fn scattered(shared: bool, triangles: usize) -> Scene {
    let mut scene = empty();
    scene.film = oslcl_runtime::scene::Film { width: 64, height: 64 };
    scene.integrator.samples = 4;
    sky(&mut scene, SKY);
    let m = material(&mut scene, DIFFUSE, &[]);
    let mut piece = wall();
    piece.triangles.truncate(triangles);
    let first = mesh(&mut scene, piece.clone());
    for k in 0..7 {
        let id = if shared || k == 0 { first } else { mesh(&mut scene, piece.clone()) };
        let turn = DMat3::from_rotation_y(f64::from(k)) * DMat3::from_diagonal(DVec3::new(-0.3, 0.3, 0.2));
        let at = DVec3::new(f64::from(k % 3) * 0.7 - 0.7, 0.1 * f64::from(k), f64::from(k / 3) * 0.6 - 0.6);
        place(&mut scene, id, m, DAffine3::from_mat3_translation(turn, at));
    }
    scene
}

#[test]
fn shared_meshes_look_like_copies() {
    for triangles in [1, 2] {
        let alone = render(&scattered(false, triangles), Precision::Standard).0;
        let shared = render(&scattered(true, triangles), Precision::Standard).0;
        let differ = alone.pixels.iter().zip(&shared.pixels).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-3).count();
        // A ray along an edge may fall on either side.
        assert!(differ <= 8, "{differ} of 4,096 pixels differ");
        assert!(mean(&alone)[0] < 0.98, "something is in the picture");
    }
}
