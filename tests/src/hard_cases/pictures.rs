//! Small scenes that are hard, through the whole renderer.
//!
//! In: sizes and places. Out: scenes, and what became of them: mean, brightest pixel, samples that were not finite.

use super::{Ledger, Run};
use crate::scenes::{empty, material, mesh, place, sphere, wall};
use glam::{DAffine3, DMat3, DVec3};
use oslcl_runtime::film::Picture;
use oslcl_runtime::render::{self, Options, Summary};
use oslcl_runtime::scene::{MaterialId, Mesh, Scene};

/// Renders a scene and holds what every picture of the suite has to keep: no sample was repaired, none dropped, no number on the film
/// is infinite or none.
pub fn render(run: &Run<'_>, ledger: &mut Ledger, name: &str, scene: &Scene) -> (Picture, Summary) {
    let options = Options { choices: run.precision.into(), ..Options::default() };
    let (picture, summary) =
        render::render(scene, run.device, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{name}: {e}"));
    let broken = picture.pixels.iter().flatten().filter(|x| !x.is_finite() || **x < 0.0).count();
    let lost = summary.counts.repaired as usize + summary.counts.dropped as usize + broken;
    ledger.at_most(&format!("{name}: samples repaired, numbers on the film not finite"), lost as f64, 0.0);
    (picture, summary)
}

/// The mean of the first channel.
pub fn mean(picture: &Picture) -> f64 {
    oslcl_runtime::film::compare::mean(picture)[0]
}

/// The mean of the distances of two pictures' pixels, as a part of the second's mean.
pub fn distance(a: &Picture, b: &Picture) -> f64 {
    let sum: f64 = a.pixels.iter().zip(&b.pixels).map(|(p, q)| f64::from(p[0] - q[0]).abs()).sum();
    sum / b.pixels.len() as f64 / mean(b)
}

/// A white sky of this radiance.
pub fn sky(scene: &mut Scene, radiance: f64) {
    let source = format!("surface s() {{ Ci = {radiance:?} * background(); }}");
    scene.environment = Some(material(scene, &source, &[]));
}

/// One mesh of one material under a white sky, seen from 5 units away.
pub fn furnace(mesh_data: Mesh, source: &str) -> Scene {
    let mut scene = empty();
    sky(&mut scene, 1.0);
    let m = material(&mut scene, source, &[]);
    let id = mesh(&mut scene, mesh_data);
    place(&mut scene, id, m, DAffine3::IDENTITY);
    scene
}

/// A corner with a ball, a mirror, two shared squares and a lamp. All of it scaled by `scale`, then moved by `shift`, its camera too.
pub fn corner(scale: f64, shift: DVec3) -> Scene {
    let mut scene = empty();
    scene.integrator.samples = 32;
    scene.integrator.max_depth = 6;
    scene.camera.hfov_degrees = 40.0;
    let white = material(&mut scene, "surface d() { Ci = 0.7 * diffuse(N); }", &[]);
    let metal = material(&mut scene, "surface m() { Ci = 0.9 * microfacet(\"ggx\", N, 0.2, 0, 0); }", &[]);
    let lamp = material(&mut scene, "surface l() { Ci = 8 * emission(); }", &[]);
    let [back, floor, light, square] = [0; 4].map(|_| mesh(&mut scene, wall()));
    let ball = mesh(&mut scene, sphere());
    let mut put = |id, m: MaterialId, turn: DMat3, size: f64, at: [f64; 3]| {
        place(&mut scene, id, m, DAffine3::from_mat3_translation(turn * size, DVec3::from(at)));
    };
    put(back, white, DMat3::IDENTITY, 2.0, [0.0, 1.0, 0.0]);
    put(floor, white, DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2), 2.0, [0.0, 0.0, -1.0]);
    put(light, lamp, DMat3::from_rotation_x(1.2), 0.5, [0.0, -0.5, 1.5]);
    put(square, white, DMat3::from_rotation_z(0.6), 0.4, [-0.9, 0.2, 0.5]);
    put(square, metal, DMat3::from_rotation_z(-0.6), 0.4, [0.9, 0.2, 0.5]);
    put(ball, metal, DMat3::IDENTITY, 0.5, [0.1, 0.0, -0.5]);
    let all = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), glam::DQuat::IDENTITY, shift);
    for instance in &mut scene.instances {
        instance.transform = all * instance.transform;
    }
    scene.camera.origin = all.transform_point3(scene.camera.origin);
    scene.camera.target = all.transform_point3(scene.camera.target);
    scene.camera.focus_distance *= scale;
    scene
}
