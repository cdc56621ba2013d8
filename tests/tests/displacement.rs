//! Displacement shaders: vertices go where P says, bumps tilt normals only, and what is wrong is said.

use glam::{DAffine3, DVec3};
use oslcl_runtime::film::Picture;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::scene::Scene;
use oslcl_runtime::{device::Device, render as renderer};
use oslcl_tests::scenes::{empty, material, mesh, place, render, sphere, wall};

const SHADE: &str = "surface s() { Ci = (0.5 + 0.5 * N[2]) * emission() + 0.2 * diffuse(N); }";

/// A sphere whose surface is moved by `displacement`, if there is one, at this place.
fn ball(displacement: Option<&str>, transform: DAffine3) -> Scene {
    let mut scene = empty();
    scene.integrator.samples = 16;
    let m = material(&mut scene, SHADE, &[]);
    if let Some(source) = displacement {
        let by = material(&mut scene, source, &[]);
        scene.materials[m.0 as usize].displacement = Some(by);
    }
    let s = mesh(&mut scene, sphere());
    place(&mut scene, s, m, transform);
    scene
}

fn picture(scene: &Scene) -> Picture {
    let (picture, summary) = render(scene, Precision::Standard);
    assert_eq!((summary.counts.dropped, summary.counts.repaired), (0, 0));
    picture
}

/// Pixels that differ by more than the normals of coarse triangles explain.
fn differing(a: &Picture, b: &Picture) -> usize {
    a.pixels.iter().zip(&b.pixels).filter(|(p, q)| (0..3).any(|c| (p[c] - q[c]).abs() > 0.02)).count()
}

#[test]
fn a_sphere_moved_outwards_is_a_larger_sphere() {
    let small = DAffine3::from_scale(DVec3::splat(0.5));
    let moved = picture(&ball(Some("displacement d() { P += 0.25 * N; }"), small));
    let larger = picture(&ball(None, DAffine3::from_scale(DVec3::splat(0.75))));
    let of = moved.pixels.len();
    assert!(differing(&moved, &larger) * 100 < of, "{} of {of} pixels", differing(&moved, &larger));
    assert!(differing(&moved, &picture(&ball(None, small))) * 20 > of, "the shader does something");
}

#[test]
fn spaces_and_instances_are_each_ones_own() {
    // In object space the same, whatever the transform: two placements of one mesh, each displaced.
    let source = "displacement d() { P = transform(\"object\", \"common\", 1.5 * transform(\"object\", P)); }";
    let two = |displacement, scale: f64| {
        let mut scene = ball(
            displacement,
            DAffine3::from_scale_rotation_translation(
                DVec3::splat(0.3 * scale),
                glam::DQuat::from_rotation_z(1.0),
                DVec3::new(-0.5, 0.0, 0.0),
            ),
        );
        let other = scene.instances[0].clone();
        scene.instances.push(oslcl_runtime::scene::Instance {
            transform: DAffine3::from_scale_rotation_translation(
                DVec3::new(0.2, 0.2, 0.4) * scale,
                glam::DQuat::from_rotation_x(0.3),
                DVec3::new(0.5, 0.0, 0.0),
            ),
            ..other
        });
        scene
    };
    let (moved, larger) = (picture(&two(Some(source), 1.0)), picture(&two(None, 1.5)));
    assert!(differing(&moved, &larger) * 100 < moved.pixels.len(), "{}", differing(&moved, &larger));
}

#[test]
fn a_bump_tilts_the_normal_and_moves_nothing() {
    let shown = |displacement: Option<&str>| {
        let mut scene = empty();
        let m = material(&mut scene, "surface s() { Ci = N[2] * emission(); }", &[]);
        if let Some(source) = displacement {
            let by = material(&mut scene, source, &[]);
            scene.materials[m.0 as usize].displacement = Some(by);
        }
        let w = mesh(&mut scene, wall());
        place(&mut scene, w, m, DAffine3::IDENTITY);
        picture(&scene).pixels
    };
    let tilted = shown(Some("displacement d() { N = normalize(N + vector(0, 0, 1)); }"));
    // The wall's normal is -y.
    assert!(tilted.iter().flatten().all(|v| (v - 0.5f32.sqrt()).abs() < 1e-4), "{:?}", tilted[0]);
    assert!(shown(None).iter().flatten().all(|v| v.abs() < 1e-6));
}

fn refusal(scene: &Scene) -> String {
    let device = Device::open(None).expect("an OpenCL device");
    let result = renderer::render(scene, &device, &renderer::Options::default(), &mut |_| {});
    result.map(|_| ()).expect_err("refused").to_string()
}

#[test]
fn what_is_wrong_is_said() {
    let said = refusal(&ball(Some("displacement d() { P = P * 1e38 * (1e38 + u); }"), DAffine3::IDENTITY));
    assert!(said.contains("`d` moves vertex 0 to a place that is not finite"), "{said}");
    let said = refusal(&ball(Some("surface d() { Ci = diffuse(N); }"), DAffine3::IDENTITY));
    assert_eq!(said, "material `m1`: `d` is a surface shader, but vertices are moved by displacement shaders");
    let mut scene = ball(None, DAffine3::IDENTITY);
    scene.materials[0].displacement = Some(oslcl_runtime::scene::MaterialId(7));
    assert!(refusal(&scene).contains("material `m0`"), "{}", refusal(&scene));
}
