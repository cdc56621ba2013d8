//! Hard cases of lights: tiny, touching, all around, faint and bright, many; environments with one pixel and none.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use oslcl_runtime::scene::{Camera, MaterialId, Mesh, Scene};
use oslcl_tests::hard_cases::pictures::{mean, render};
use oslcl_tests::hard_cases::{Run, each, meshes};
use oslcl_tests::scenes::{empty, material, mesh, place, wall};

const HALF: &str = "surface d() { Ci = 0.5 * diffuse(N); }";

/// A spot of a wall of albedo 1/2 at the origin, seen along +y from so close that it is one point.
fn spot() -> Scene {
    let mut scene = empty();
    scene.camera.hfov_degrees = 0.02;
    scene.integrator.max_depth = 2;
    scene.integrator.samples = 64;
    let m = material(&mut scene, HALF, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene
}

/// Hangs a mesh (front towards -y) behind the camera, so that it shines at the spot from distance h.
fn lamp(scene: &mut Scene, shape: Mesh, radiance: f64, size: f64, h: f64) -> MaterialId {
    let m = material(scene, &format!("surface l() {{ Ci = {radiance:?} * emission(); }}"), &[]);
    let id = mesh(scene, shape);
    let turn = DMat3::from_rotation_z(std::f64::consts::PI) * size;
    place(scene, id, m, DAffine3::from_mat3_translation(turn, DVec3::new(0.0, -h, 0.0)));
    m
}

/// Radiance of the spot under a square lamp of half side `a` at distance h: four times the form factor of a right-angled corner
/// (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3).
fn under_square(radiance: f64, a: f64, h: f64) -> f64 {
    let r = a / h;
    let s = (1.0 + r * r).sqrt();
    0.5 * radiance * 4.0 / std::f64::consts::PI * (r / s) * (r / s).atan()
}

/// How far a picture's mean is from what it should be, as a part.
fn off(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

#[test]
fn lamps_of_any_size_and_power_give_their_form_factor() {
    each("lights", |run, ledger| {
        for (name, radiance, size, h, bound) in [
            ("lamp 1e-6 across", 1e12, 5e-7, 8.0, 1e-5),
            ("lamp 1e-6 across, 1e-6 away", 1.0, 5e-7, 1e-6, 0.02),
            ("lamp of 1e-12", 1e-12, 1.0, 8.0, 2e-3),
            ("lamp of 1e12", 1e12, 1.0, 8.0, 2e-3),
            ("lamp a million times wider than its distance", 1.0, 1e3, 1e-3, 0.02),
        ] {
            let mut scene = spot();
            // The camera looks from between lamp and wall.
            let near = if h < 1.0 { h * 0.5 } else { 5.0 };
            scene.camera.origin = DVec3::new(0.0, -near, 0.0);
            scene.integrator.samples = run.count(64, 1024) as u32;
            lamp(&mut scene, wall(), radiance, size, h);
            let picture = render(run, ledger, name, &scene).0;
            // A wall 2 units wide is known to 5e-7 in f32: half the distance of a lamp 1e-6 away.
            let bound = if h < 1e-5 && !run.precision.is_double() { 0.1 } else { bound };
            ledger.at_most(
                &format!("{name}: error of the mean"),
                off(mean(&picture), under_square(radiance, size, h)),
                bound,
            );
        }
    });
}

#[test]
fn a_hundred_thousand_lamps_shine_as_one() {
    each("lights", |run, ledger| {
        let mut scene = spot();
        scene.integrator.samples = run.count(64, 1024) as u32;
        lamp(&mut scene, meshes::grid(224), 3.0, 1.0, 8.0);
        let picture = render(run, ledger, "100,352 lamps", &scene).0;
        ledger.at_most("100,352 lamps: error of the mean", off(mean(&picture), under_square(3.0, 1.0, 8.0)), 2e-3);
    });
}

#[test]
fn faint_lamps_beside_bright_ones_are_not_lost() {
    each("lights", |run, ledger| {
        // 1e12 shines away from the wall, 1e-12 at it: its share of the choice is 1e-24.
        let mut scene = spot();
        scene.integrator.samples = run.count(256, 4096) as u32;
        scene.camera.origin = DVec3::new(0.0, -0.25, 0.0);
        lamp(&mut scene, wall(), 1e-12, 2.0, 0.5);
        let bright = lamp(&mut scene, wall(), 1e12, 1.0, 20.0);
        let away = scene.instances.iter_mut().find(|i| i.material == bright).expect("the lamp");
        away.transform.matrix3 = DMat3::IDENTITY;
        let picture = render(run, ledger, "1e-12 beside 1e12", &scene).0;
        ledger.at_most(
            "1e-12 beside 1e12: error of the mean",
            off(mean(&picture), under_square(1e-12, 2.0, 0.5)),
            0.02,
        );
    });
}

/// A cube that shines inwards.
fn shining_room(size: f64) -> Mesh {
    let mut room = meshes::cube(2);
    for t in &mut room.triangles {
        t.swap(1, 2);
    }
    room.positions.iter_mut().for_each(|p| *p *= size as f32);
    room
}

#[test]
fn light_from_all_sides_shows_the_albedo() {
    each("lights", |run, ledger| {
        // The lamp fills the hemisphere; in the second its sides touch the wall, in the third they cut it.
        for (name, size, bound) in
            [("lamp all around", 10.0, 5e-3), ("lamp that touches", 1.0, 5e-3), ("lamp that cuts", 0.7, 5e-3)]
        {
            let mut scene = empty();
            scene.camera = Camera::look_at(DVec3::new(0.0, -0.65, 0.0), DVec3::ZERO);
            scene.camera.hfov_degrees = 80.0;
            scene.integrator.max_depth = 2;
            scene.integrator.samples = run.count(256, 4096) as u32;
            let m = material(&mut scene, HALF, &[]);
            let l = material(&mut scene, "surface l() { Ci = emission(); }", &[]);
            let w = mesh(&mut scene, wall());
            let room = mesh(&mut scene, shining_room(size));
            place(&mut scene, w, m, DAffine3::IDENTITY);
            place(&mut scene, room, l, DAffine3::IDENTITY);
            let picture = render(run, ledger, name, &scene).0;
            ledger.at_most(&format!("{name}: error of the mean"), off(mean(&picture), 0.5), bound);
        }
    });
}

/// A wall under an environment.
fn under_sky(run: &Run<'_>, source: &str) -> Scene {
    let mut scene = empty();
    scene.integrator.max_depth = 2;
    scene.integrator.samples = run.count(256, 4096) as u32;
    scene.environment = Some(material(&mut scene, source, &[]));
    let m = material(&mut scene, HALF, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::from_scale(DVec3::splat(3.0)));
    scene
}

/// The shader of a sky in which only the cell in direction (0.3, -0.8, 0.4) of an equal-area map of 512 x 256 has this radiance, all
/// others another; and how much light that cell brings to a wall that faces -y, over the radiance.
fn one_pixel(bright: f64, rest: f64) -> (String, f64) {
    let d = Vec3::new(0.3, -0.8, 0.4).normalize().as_dvec3();
    let turn = (d.y.atan2(d.x) / std::f64::consts::TAU).rem_euclid(1.0);
    let (x, y) = ((turn * 512.0).floor(), ((1.0 - d.z) * 0.5 * 256.0).floor());
    let source = format!(
        "surface s() {{ float t = atan2(I[1], I[0]) / (2 * M_PI); t = t < 0 ? t + 1 : t; \
         int on = floor(t * 512) == {x:?} && floor((1 - I[2]) * 128) == {y:?}; Ci = (on ? {bright:?} : {rest:?}) * background(); }}"
    );
    // The integral of -d.y over the cell, by its middle: it is 0.7 degrees across.
    let (turn, z) = ((x + 0.5) / 512.0 * std::f64::consts::TAU, 1.0 - 2.0 * (y + 0.5) / 256.0);
    let cosine = -turn.sin() * (1.0 - z * z).sqrt();
    (source, cosine * 4.0 * std::f64::consts::PI / (512.0 * 256.0))
}

#[test]
fn skies_of_one_pixel_and_of_none() {
    each("lights", |run, ledger| {
        let (source, form) = one_pixel(1e9, 1.0);
        let picture = render(run, ledger, "sky of 1 with one pixel of 1e9", &under_sky(run, &source)).0;
        let expected = 0.5 * (1e9 * form / std::f64::consts::PI + 1.0);
        ledger.at_most("sky of 1 with one pixel of 1e9: error of the mean", off(mean(&picture), expected), 5e-3);
        let (source, form) = one_pixel(1e9, 0.0);
        let picture = render(run, ledger, "black sky with one pixel of 1e9", &under_sky(run, &source)).0;
        let expected = 0.5 * 1e9 * form / std::f64::consts::PI;
        ledger.at_most("black sky with one pixel of 1e9: error of the mean", off(mean(&picture), expected), 5e-3);
        // One pixel behind the wall takes nearly all samples of the map; the rest of the sky must come out right all the same.
        let behind = "surface s() { Ci = (I[1] > 0.9999 ? 1e9 : 1) * background(); }";
        let picture = render(run, ledger, "sky of 1 with 1e9 behind the wall", &under_sky(run, behind)).0;
        ledger.at_most("sky of 1 with 1e9 behind the wall: error of the mean", off(mean(&picture), 0.5), 0.02);
        let black = "surface s() { Ci = (I[1] > 2 ? 1 : 0) * background(); }";
        let picture = render(run, ledger, "black sky", &under_sky(run, black)).0;
        ledger.at_most("black sky: mean", mean(&picture), 0.0);
    });
}
