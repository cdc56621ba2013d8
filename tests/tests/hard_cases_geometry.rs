//! Hard cases of geometry: rays through edges and vertices, off surfaces, at all scales.

use glam::{DAffine3, DMat3, DVec3};
use oslcl_runtime::scene::Mesh;
use oslcl_tests::hard_cases::rays::Target;
use oslcl_tests::hard_cases::{each, meshes};

/// A mesh, where it stands, where the camera stands, and whether its triangles are shared.
struct Placed {
    name: &'static str,
    mesh: Mesh,
    place: DAffine3,
    camera: DVec3,
    instanced: bool,
}

fn placed(name: &'static str, mesh: Mesh, place: DAffine3, camera: DVec3, instanced: bool) -> Placed {
    Placed { name, mesh, place, camera, instanced }
}

fn turned(scale: DVec3) -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(0.4) * DMat3::from_diagonal(scale))
}

/// Closed meshes around the origin, convex ones first.
fn closed() -> Vec<Placed> {
    let away = DVec3::new(1e7, -2e7, 0.5e7);
    let moved = DAffine3::from_translation(away);
    let scale = |s: f64| turned(DVec3::splat(s));
    let near = DVec3::new(0.0, -5.0, 0.0);
    vec![
        placed("ball", meshes::ball(48, 24), DAffine3::IDENTITY, near, false),
        placed("cube along the axes", meshes::cube(8), DAffine3::IDENTITY, near, false),
        placed("ball from 1,000 of its radii", meshes::ball(48, 24), DAffine3::IDENTITY, near * 200.0, false),
        placed("ball, scale 1e-6", meshes::ball(48, 24), scale(1e-6), near * 1e-6, false),
        placed("ball, scale 1e6", meshes::ball(48, 24), scale(1e6), near * 1e6, false),
        placed("ball 1e7 away with its camera", meshes::ball(48, 24), moved, away + near, false),
        placed("shared ball", meshes::ball(48, 24), scale(1.0), near, true),
        placed("shared ball, scale 1e-6", meshes::ball(48, 24), scale(1e-6), near * 1e-6, true),
        placed("shared ball, scale 1e6", meshes::ball(48, 24), scale(1e6), near * 1e6, true),
        placed("shared ball 1e7 away with its camera", meshes::ball(48, 24), moved, away + near, true),
        placed("mirrored shared ball", meshes::ball(48, 24), turned(DVec3::new(-1.0, 2.0, 0.5)), near, true),
        placed(
            "shared ball, scales 1000 : 1 : 0.001",
            meshes::ball(48, 24),
            turned(DVec3::new(1e3, 1.0, 1e-3)),
            near,
            true,
        ),
        placed("ball, scales 1000 : 1 : 0.001", meshes::ball(48, 24), turned(DVec3::new(1e3, 1.0, 1e-3)), near, false),
    ]
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    each("geometry", |run, ledger| {
        let mut all = closed();
        all.push(placed("ball of needles", meshes::needles(), DAffine3::IDENTITY, DVec3::new(0.0, -5.0, 0.0), false));
        let each = run.count(1_000_000, 100_000_000) / all.len();
        let (mut leaks, mut rays) = (0u64, 0u64);
        for (k, p) in all.iter().enumerate() {
            let target =
                Target::new(run, &p.mesh, p.place, p.camera, p.instanced).unwrap_or_else(|e| panic!("{}: {e}", p.name));
            let shots = target.shoot(each, 0.9, false, 1 + k as u32).expect("rays are shot");
            assert!(shots.rays as usize >= each / 10 * 9, "{}: {} rays", p.name, shots.rays);
            leaks += u64::from(shots.leaks);
            rays += u64::from(shots.rays);
            ledger.at_most(&format!("{}: leaks through edges and vertices", p.name), f64::from(shots.leaks), 0.0);
        }
        assert!(rays as usize >= run.count(900_000, 90_000_000));
        ledger.at_most("leaks of all of these rays together", leaks as f64, 0.0);
    });
}
