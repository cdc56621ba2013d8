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

/// How far the surface is moved, by place.
const ROUGH: &str = "point moved = P + (0.1 * noise(\"perlin\", 3 * P)) * N;";

#[test]
fn a_noisy_surface_has_the_normals_that_it_says() {
    let small = DAffine3::from_scale(DVec3::splat(0.7));
    // Rough enough for its shadowless shading to differ from the ball's, seen as a bump and as a displacement.
    let fine = |source: Option<&str>| {
        let mut scene = ball(source, small);
        scene.meshes[0] = oslcl_runtime::scene::shapes::sphere(2.0, 192, 96);
        picture(&scene)
    };
    let whole = |rest: &str| fine(Some(&format!("displacement d() {{ {ROUGH} {rest} }}")));
    let bump = whole("N = normalize(calculatenormal(moved));");
    let displaced = whole("P = moved; N = normalize(calculatenormal(P));");
    let plain = fine(None);
    let error = |a: &Picture, b: &Picture| {
        // Silhouettes are another matter.
        let inside = |i: usize| (i as f64 % 16.0 - 7.5).hypot((i / 16) as f64 - 7.5) < 4.5;
        let pairs = a.pixels.iter().zip(&b.pixels).enumerate().filter(|(i, _)| inside(*i));
        pairs.map(|(_, (p, q))| f64::from((p[0] - q[0]).abs())).sum::<f64>()
    };
    let (with, without) = (error(&bump, &displaced), error(&plain, &displaced));
    assert!(with < 0.5 * without, "{with} against {without}");
}

#[test]
fn displacement_shaders_speak_and_are_counted() {
    let mut scene = ball(None, DAffine3::IDENTITY);
    let source = "displacement d() { float far[2]; string kind = \"none\"; getattribute(\"kind\", kind);
        printf(\"%s %d\\n\", kind, filterwidth(u) > 0 && filterwidth(u) < 0.5 && filterwidth(P) != 0); }";
    let by = material(&mut scene, source, &[]);
    scene.materials[0].displacement = Some(by);
    let kind = |k: &str| vec![("kind".to_owned(), oslcl_runtime::scene::ParamValue::Str(k.into()))];
    scene.instances.push(scene.instances[0].clone());
    scene.instances[0].attributes = kind("left");
    scene.instances[1].attributes = kind("right");
    let (_, summary) = render(&scene, Precision::Standard);
    let told: Vec<(&str, u64)> = summary.messages.told.iter().map(|t| (t.text.as_str(), t.count)).collect();
    let vertices = scene.meshes[0].positions.len() as u64;
    assert_eq!(told, [("left 1\n", vertices), ("right 1\n", vertices)]);
    assert!(summary.messages.told.iter().all(|t| t.material == "m1"));
}

#[test]
fn displacement_reads_textures_data_and_spaces() {
    let folder = std::env::temp_dir().join(format!("oslcl-displacement-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let grey = Picture { width: 4, height: 4, pixels: vec![[0.25; 3]; 16], ..Picture::default() };
    oslcl_runtime::film::write(&folder.join("grey.exr"), &grey, 0.0).expect("written");
    let textured = "displacement d(float lift = 0 [[ int lockgeom = 0 ]]) {
        point c = transform(\"camera\", transform(\"NDC\", \"camera\", transform(\"NDC\", P)));
        P += ((float)texture(\"grey.exr\", u, v, \"wrap\", \"clamp\") + lift) * N; }";
    let mut scene = ball(Some(textured), DAffine3::from_scale(DVec3::splat(0.25)));
    scene.textures.push(folder.clone());
    let count = scene.meshes[0].positions.len();
    let data = oslcl_runtime::scene::VertexData { name: "lift".into(), channels: 1, values: vec![0.25; count] };
    scene.meshes[0].data.push(data);
    let moved = picture(&scene);
    let larger = picture(&ball(None, DAffine3::from_scale(DVec3::splat(0.75))));
    assert!(differing(&moved, &larger) * 100 < moved.pixels.len(), "{}", differing(&moved, &larger));
    std::fs::remove_dir_all(&folder).expect("removed");
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
