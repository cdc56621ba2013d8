//! Hard cases of whole scenes: at all scales and places, with surfaces and attributes that are degenerate, in closed rooms.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use oslcl_runtime::film::Picture;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::render;
use oslcl_runtime::scene::{self, Camera, Film, Mesh};
use oslcl_tests::hard_cases::pictures::{corner, distance, furnace, mean, render, sky};
use oslcl_tests::hard_cases::{each, meshes};
use oslcl_tests::scenes::{self, empty, material, mesh, place, wall};
use std::path::Path;

const DIFFUSE: &str = "surface d() { Ci = diffuse(N); }";
const HALF: &str = "surface d() { Ci = 0.5 * diffuse(N); }";

#[test]
fn a_scene_looks_the_same_at_any_scale_and_place() {
    each("scenes", |run, ledger| {
        let base = render(run, ledger, "corner", &corner(1.0, DVec3::ZERO)).0;
        assert!(mean(&base) > 0.05, "something is in the picture");
        let far = DVec3::new(1e7, -2e7, 3e7);
        for (name, scale, shift) in [
            ("scaled by 1e-6", 1e-6, DVec3::ZERO),
            ("scaled by 1e6", 1e6, DVec3::ZERO),
            ("moved 1e7 units away", 1.0, far),
            ("scaled by 1e6 and moved 1e7 units away", 1e6, far),
        ] {
            let picture = render(run, ledger, name, &corner(scale, shift)).0;
            let what = format!("corner {name}: difference of the picture, as a part");
            // Paths that rounding sends elsewhere differ by all of their light; f64 at 1e7 units has 1e-9 of a unit.
            ledger.at_most(&what, distance(&picture, &base), if run.precision.is_double() { 1e-5 } else { 5e-3 });
        }
    });
}

/// The root of the mean squared difference of two pictures' numbers.
fn root_mean_square(a: &Picture, b: &Picture) -> f64 {
    let squares = a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(p, q)| f64::from(p - q).powi(2));
    (squares.sum::<f64>() / (3 * a.pixels.len()) as f64).sqrt()
}

/// Whole scenes in each arithmetic: by the same random numbers they differ where rounding sends a path elsewhere, which must be
/// less than what chance does.
#[test]
fn all_precisions_agree_within_the_sampling_error() {
    const FILES: [&str; 4] = ["scenes/r1.toml", "scenes/r2.toml", "scenes/lake.toml", "../scenes/gallery.toml"];
    let mut standard = Vec::new();
    each("scenes", |run, ledger| {
        if run.precision == Precision::Standard {
            standard.clear();
        }
        for (index, file) in FILES.iter().take(run.count(1, FILES.len())).enumerate() {
            let mut scene = scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("a scene");
            scene.film = Film { width: 64, height: 64 * scene.film.height / scene.film.width };
            scene.integrator.samples = 64;
            let name = file.rsplit('/').next().unwrap_or(file);
            let picture = render(run, ledger, name, &scene).0;
            if run.precision == Precision::Standard {
                scene.integrator.seed += 1;
                let other = render(run, ledger, name, &scene).0;
                // Both have the error of sampling.
                let error = root_mean_square(&picture, &other) / 2.0_f64.sqrt();
                assert!(error > 0.0, "{name}: chance does something");
                standard.push((picture, error));
                continue;
            }
            let (base, error) = &standard[index];
            let what = format!("{name}: difference from standard by the same random numbers, in sampling errors");
            ledger.at_most(&what, root_mean_square(&picture, base) / error, 0.2);
            let what = format!("{name}: difference of the means from standard, as a part");
            ledger.at_most(&what, (mean(&picture) / mean(base) - 1.0).abs(), 1e-3);
        }
    });
}

/// A square with attributes of its own.
fn square(normals: [[f32; 3]; 4], uvs: [[f32; 2]; 4]) -> Mesh {
    Mesh { normals: normals.map(Vec3::from).to_vec(), uvs: uvs.map(Vec2::from).to_vec(), ..wall() }
}

#[test]
fn degenerate_attributes_break_nothing() {
    let front = [0.0, -1.0, 0.0];
    let flat = [front; 4];
    let plain = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
    let uses_all = "surface a() { Ci = 0.4 * diffuse(N) + 0.6 * microfacet(\"ggx\", N, dPdu, 0.05, 0.5, 0, 0); }";
    each("scenes", |run, ledger| {
        for (name, mesh) in [
            ("all uv the same", square(flat, [[0.5, 0.5]; 4])),
            ("uv along a line", square(flat, [[0., 0.], [1., 1.], [2., 2.], [3., 3.]])),
            ("uv 1e-20 apart", square(flat, plain.map(|t| t.map(|x| x * 1e-20)))),
            ("uv 1e20 apart", square(flat, plain.map(|t| t.map(|x| x * 1e20)))),
            ("normals of length 0", square([[0.0; 3]; 4], plain)),
            ("normals flipped", square([[0.0, 1.0, 0.0]; 4], plain)),
            ("normals that cancel", square([[1., 0., 0.], [-1., 0., 0.], [1., 0., 0.], [-1., 0., 0.]], plain)),
            (
                "normals below the horizon",
                square([[1., -0.001, 0.], [0., -0.001, 1.], [-1., 0.001, 0.], [0., 0.001, -1.]], plain),
            ),
            ("normals of length 1e-30", square([[0.0, -1e-30, 0.0]; 4], plain)),
        ] {
            let picture = render(run, ledger, name, &furnace(mesh, uses_all)).0;
            // In a white room nothing is brighter than white.
            let brightest = picture.pixels.iter().flatten().fold(0.0f32, |a, b| a.max(*b));
            ledger.at_most(&format!("{name}: brightest pixel in a white room"), f64::from(brightest), 1.0 + 1e-5);
        }
        // Not seen at all, but in the tree and among the lights.
        let mut dust = meshes::grid(4);
        let first = dust.positions.len() as u32;
        dust.positions.extend([Vec3::ZERO, Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
        dust.uvs.extend([Vec2::ZERO; 4]);
        dust.triangles.extend([[first; 3], [first, first + 2, first + 3], [first, first + 1, first + 2]]);
        let glowing = "surface g() { Ci = 0.25 * emission() + 0.5 * diffuse(N); }";
        let picture = render(run, ledger, "triangles without area", &furnace(dust, glowing)).0;
        ledger.at_most("triangles without area that glow: error of the mean", (mean(&picture) - 0.75).abs(), 1e-5);
    });
}

#[test]
fn surfaces_in_one_place_show_one_of_them() {
    each("scenes", |run, ledger| {
        let mut scene = furnace(wall(), HALF);
        for _ in 0..3 {
            let again = mesh(&mut scene, wall());
            place(&mut scene, again, oslcl_runtime::scene::MaterialId(1), DAffine3::IDENTITY);
        }
        let picture = render(run, ledger, "four walls in one place", &scene).0;
        ledger.at_most("four walls in one place: error of the mean", (mean(&picture) - 0.5).abs(), 1e-5);
        // Glass in glass in the same place: each interface may be met or missed, but no light is lost or made.
        let glass = "surface g() { float e = backfacing() ? 1/1.5 : 1.5; Ci = reflection(N, e) + refraction(N, e); }";
        let mut scene = furnace(meshes::ball(24, 12), glass);
        scene.integrator.max_depth = 200;
        let again = mesh(&mut scene, meshes::ball(24, 12));
        place(&mut scene, again, oslcl_runtime::scene::MaterialId(1), DAffine3::IDENTITY);
        let picture = render(run, ledger, "glass in glass in one place", &scene).0;
        ledger.at_most("glass in glass in one place: error of the mean", (mean(&picture) - 1.0).abs(), 2e-3);
    });
}

#[test]
fn no_light_enters_a_closed_room() {
    each("scenes", |run, ledger| {
        for (name, size, at) in [
            ("room", 1.0, DVec3::ZERO),
            ("room of 1e-6", 1e-6, DVec3::ZERO),
            ("room of 1e6, 1e7 away", 1e6, DVec3::splat(1e7)),
        ] {
            let mut scene = empty();
            scene.camera = Camera::look_at(at, at + DVec3::new(0.3, 1.0, 0.2) * size);
            scene.camera.hfov_degrees = 120.0;
            scene.integrator.max_depth = 64;
            scene.integrator.samples = run.count(8, 1024) as u32;
            sky(&mut scene, 1e9);
            let m = material(&mut scene, DIFFUSE, &[]);
            let room = mesh(&mut scene, meshes::cube(6));
            place(
                &mut scene,
                room,
                m,
                DAffine3::from_scale_rotation_translation(DVec3::splat(size), glam::DQuat::from_rotation_z(0.3), at),
            );
            let picture = render(run, ledger, name, &scene).0;
            ledger.at_most(&format!("{name}, a sky of 1e9 around it: mean inside"), mean(&picture), 0.0);
        }
    });
}

#[test]
fn a_cover_close_to_a_lamp_hides_it() {
    each("scenes", |run, ledger| {
        // A cover in front of a lamp, both 2 units across, 3 units from a wall that both see.
        let lit = |gap: f64| {
            let mut scene = empty();
            scene.integrator.max_depth = 2;
            let white = material(&mut scene, HALF, &[]);
            let lamp = material(&mut scene, "surface l() { Ci = emission(); }", &[]);
            let black = material(&mut scene, "surface b() { Ci = 0; }", &[]);
            let [a, b, c] = [0; 3].map(|_| mesh(&mut scene, wall()));
            let turn = DMat3::from_rotation_z(std::f64::consts::PI);
            place(&mut scene, a, white, DAffine3::IDENTITY);
            place(&mut scene, b, lamp, DAffine3::from_mat3_translation(turn, DVec3::new(0.0, -8.0, 0.0)));
            place(&mut scene, c, black, DAffine3::from_mat3_translation(turn * 1.5, DVec3::new(0.0, -8.0 + gap, 0.0)));
            scene
        };
        let gap = if run.precision.is_double() { 1e-9 } else { 1e-4 };
        let picture = render(run, ledger, "cover", &lit(gap)).0;
        ledger.at_most(
            "cover 1e-4 units (f64: 1e-9) from a lamp, 8 from the wall: light that passes",
            mean(&picture),
            0.0,
        );
    });
}

#[test]
fn flattening_transforms_are_refused_by_name() {
    for (scale, singular) in [
        (DVec3::new(1.0, 1.0, 0.0), true),
        (DVec3::new(1.0, 1e-13, 1.0), true),
        (DVec3::new(f64::NAN, 1.0, 1.0), true),
        (DVec3::new(1e6, 1.0, 1.0), false),
        (DVec3::new(1.0, 1e-6, 1e-6), false),
        (DVec3::new(-1e-20, 1e-20, 1e-26), false),
    ] {
        let mut scene = empty();
        let m = material(&mut scene, DIFFUSE, &[]);
        let w = mesh(&mut scene, wall());
        scenes::place(&mut scene, w, m, DAffine3::from_scale(scale));
        let found = render::plan(&scene, &Precision::Standard.into()).err().map(|e| e.to_string());
        let named = found.as_ref().is_some_and(|e| e.contains("the transform of `instance 0` is singular"));
        assert_eq!((named, found.is_some()), (singular, singular), "{scale}: {found:?}");
    }
}
