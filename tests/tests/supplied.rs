//! What shaders ask of a renderer beside the point: spaces of the picture, attributes, data of vertices, values that change
//! between renders, what they say; in renders, against values that are known.

use glam::{DAffine3, DVec3};
use oslcl_runtime::film::Picture;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::render::{self as renderer, Summary};
use oslcl_runtime::scene::{self, MaterialId, Mesh, ParamValue, Scene, VertexData};
use oslcl_runtime::{device::Device, session::Session};
use oslcl_tests::scenes::{empty, material, mesh, place, render, wall};

/// A wall with this shader over the whole picture.
fn wall_of(source: &str) -> Scene {
    let mut scene = empty();
    scene.integrator.samples = 16;
    let m = material(&mut scene, source, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene
}

fn rendered(scene: &Scene) -> (Picture, Summary) {
    let (picture, summary) = render(scene, Precision::Standard);
    assert_eq!((summary.counts.dropped, summary.counts.repaired), (0, 0));
    (picture, summary)
}

/// The picture of a wall whose shader gives the same everywhere.
fn uniform(scene: &Scene) -> [f32; 3] {
    let (picture, _) = rendered(scene);
    let first = picture.pixels[0];
    for p in &picture.pixels {
        assert!((0..3).all(|c| (p[c] - first[c]).abs() < 1e-4), "{first:?} {p:?}");
    }
    first
}

fn near(a: [f32; 3], b: [f32; 3]) {
    assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-4 * b[c].abs().max(1.0)), "{a:?}, expected {b:?}");
}

#[test]
fn screen_ndc_and_raster_are_the_pictures() {
    // (space, value at the pixel in column x, row y of 16 x 8)
    type Expected = fn(f32, f32) -> [f32; 2];
    let spaces: [(&str, Expected); 3] = [
        ("raster", |x, y| [x, y]),
        ("NDC", |x, y| [x / 16.0, y / 8.0]),
        ("screen", |x, y| [x / 8.0 - 1.0, 0.5 - y / 8.0]),
    ];
    for (space, expected) in spaces {
        // Offset, so that no radiance is negative.
        let mut scene =
            wall_of(&format!("surface s() {{ point p = transform(\"{space}\", P) + 2; Ci = color(p) * emission(); }}"));
        scene.film.height = 8;
        scene.integrator.samples = 64;
        let (picture, summary) = rendered(&scene);
        assert!(summary.plan.decisions.iter().any(|d| d.effect.name() == "other_spaces" && d.is_on()));
        let scale = [0, 1].map(|c| (expected(1.0, 1.0)[c] - expected(0.0, 0.0)[c]).abs());
        for (i, p) in picture.pixels.iter().enumerate() {
            let to = expected((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5);
            assert!((0..2).all(|c| (p[c] - 2.0 - to[c]).abs() < 0.2 * scale[c]), "{space} {i}: {p:?} {to:?}");
        }
        // The wall is 5 away.
        assert!((picture.pixels[0][2] - 2.8).abs() < 1e-3, "{space}");
    }
    let back = "surface s() { point p = transform(\"raster\", \"world\", transform(\"raster\", P));
        Ci = (distance(p, P) < 1e-3 ? 1 : 0) * emission(); }";
    near(uniform(&wall_of(back)), [1.0; 3]);
}

#[test]
fn the_camera_has_attributes() {
    let source = "surface s() {
        float fov = 0; int size[2] = {0, 0}; int version = 0; string kind = \"\"; string me = \"\"; float none = 7;
        int found = getattribute(\"camera:fov\", fov) + getattribute(\"camera:resolution\", size)
            + getattribute(\"osl:version\", version) + getattribute(\"camera:projection\", kind)
            + getattribute(\"shader:shadername\", me) + getattribute(\"no such\", none);
        Ci = color(found + (kind == \"perspective\") + (me == \"s\") + (version > 10000) + none,
            fov, 100 * size[0] + size[1]) * emission(); }";
    near(uniform(&wall_of(source)), [5.0 + 3.0 + 7.0, 20.0, 1616.0]);
}

const WEAR: &str = "surface s() {
    float wear = 9; string team = \"\"; color tint = 0; float e = 0;
    int found = getattribute(\"wear\", wear);
    found += 2 * getattribute(\"team\", team) + 4 * getattribute(\"tint\", tint) + 8 * getattribute(\"tint\", 1, e);
    Ci = color(wear + tint[0], (team == \"red\") + 10 * e, found) * emission(); }";

fn named(list: &[(&str, ParamValue)]) -> scene::Attributes {
    list.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
}

#[test]
fn attributes_are_looked_up_from_the_object_outwards() {
    let mut scene = wall_of(WEAR);
    near(uniform(&scene), [9.0, 0.0, 0.0]);
    scene.attributes = named(&[("wear", ParamValue::Int(3)), ("team", ParamValue::Str("blue".into()))]);
    near(uniform(&scene), [3.0, 0.0, 3.0]);
    scene.materials[0].attributes = named(&[("wear", ParamValue::Float(0.5))]);
    scene.meshes[0].attributes = named(&[("team", ParamValue::Str("red".into()))]);
    near(uniform(&scene), [0.5, 1.0, 3.0]);
    scene.instances[0].attributes =
        named(&[("wear", ParamValue::Float(0.25)), ("tint", ParamValue::Floats(vec![1.0, 0.5, 0.0]))]);
    near(uniform(&scene), [1.25, 6.0, 15.0]);
    let (plan, _) = renderer::plan(&scene, &Precision::Standard.into()).expect("plans");
    assert!(plan.decisions.iter().all(|d| d.effect.name() != "attributes" || !d.is_on()), "known when it is compiled");
}

#[test]
fn objects_differ_in_their_attributes() {
    // Two walls beside each other: one mesh placed twice, then two meshes.
    for shared in [true, false] {
        let mut scene = wall_of(WEAR);
        scene.attributes = named(&[("wear", ParamValue::Int(3))]);
        let other = if shared { scene.instances[0].mesh } else { mesh(&mut scene, wall()) };
        let m = scene.instances[0].material;
        scene.instances[0].transform = DAffine3::from_translation(DVec3::new(-1.0, 0.0, 0.0));
        place(&mut scene, other, m, DAffine3::from_translation(DVec3::new(1.0, 0.0, 0.0)));
        scene.instances[1].attributes = named(&[
            ("wear", ParamValue::Float(0.5)),
            ("team", ParamValue::Str("red".into())),
            ("tint", ParamValue::Floats(vec![1.0, 0.5, 0.0])),
        ]);
        let (picture, summary) = rendered(&scene);
        near(picture.pixels[16 * 8 + 2], [3.0, 0.0, 1.0]);
        near(picture.pixels[16 * 8 + 13], [1.5, 6.0, 15.0]);
        assert!(summary.plan.decisions.iter().any(|d| d.effect.name() == "attributes" && d.is_on()));
    }
}

const LABELLED: &str = "surface s() { string kind = \"none\"; int n = 0;
    getattribute(\"kind\", kind); getattribute(\"n\", n);
    string label = format(\"%s-%d\", kind, n);
    Ci = color(strlen(label), label == \"leaf-12\", endswith(label, \"k-3\")) * emission(); }";

#[test]
fn texts_are_made_of_what_objects_differ_in() {
    let mut scene = wall_of(LABELLED);
    near(uniform(&scene), [6.0, 0.0, 0.0]);
    let m = scene.instances[0].material;
    let other = scene.instances[0].mesh;
    scene.instances[0].transform = DAffine3::from_translation(DVec3::new(-1.0, 0.0, 0.0));
    place(&mut scene, other, m, DAffine3::from_translation(DVec3::new(1.0, 0.0, 0.0)));
    let label = |kind: &str, n| named(&[("kind", ParamValue::Str(kind.into())), ("n", ParamValue::Int(n))]);
    scene.instances[0].attributes = label("leaf", 12);
    scene.instances[1].attributes = label("trunk", 3);
    let (picture, _) = rendered(&scene);
    near(picture.pixels[16 * 8 + 2], [7.0, 1.0, 0.0]);
    near(picture.pixels[16 * 8 + 13], [7.0, 0.0, 1.0]);
    // What one of them lacks is what the shader said before.
    scene.instances[1].attributes = named(&[("n", ParamValue::Int(3))]);
    let (picture, _) = rendered(&scene);
    near(picture.pixels[16 * 8 + 2], [7.0, 1.0, 0.0]);
    near(picture.pixels[16 * 8 + 13], [6.0, 0.0, 0.0]);
}

const PAINTED: &str =
    "surface s(color Cd = color(0, 0, 5) [[ int lockgeom = 0 ]], float st[2] = {7, 7} [[ int lockgeom = 0 ]],
    float s = 3 [[ int lockgeom = 0 ]], color locked = color(1, 2, 3))
    { Ci = (Cd + color(0, 0, 10 * st[1] + 100 * s)) * emission(); }";

/// Cd runs from black to (1, 2, 0) along x.
fn painted() -> VertexData {
    let values = vec![0., 0., 0., 1., 2., 0., 1., 2., 0., 0., 0., 0.];
    VertexData { name: "Cd".into(), channels: 3, values }
}

#[test]
fn data_of_vertices_is_interpolated() {
    let mut scene = wall_of(PAINTED);
    scene.integrator.samples = 64;
    scene.meshes[0].data.push(painted());
    let check = |scene: &Scene, has_data: bool| {
        let (picture, _) = rendered(scene);
        // Half of what the camera sees across the wall, from its middle: 5 tan 10 degrees of 1.
        let half = 5.0 * 10f32.to_radians().tan();
        for (i, p) in picture.pixels.iter().enumerate() {
            let at = |k: usize| (((k as f32 + 0.5) / 8.0 - 1.0) * half + 1.0) / 2.0;
            let (u, v) = (at(i % 16), 1.0 - at(i / 16));
            let cd = if has_data { [u, 2.0 * u, 0.0] } else { [0.0, 0.0, 5.0] };
            let to = [cd[0], cd[1], cd[2] + 10.0 * v + 100.0 * u];
            assert!((p[0] - to[0]).abs() < 0.02 && (p[1] - to[1]).abs() < 0.04, "{i}: {p:?} {to:?}");
            assert!((p[2] - to[2]).abs() < 2.0, "{i}: {p:?} {to:?}");
        }
    };
    check(&scene, true);
    // The same in memory that begins elsewhere and as an instance of a shared mesh.
    let m = scene.instances[0].material;
    let more = mesh(&mut scene, wall());
    place(&mut scene, more, m, DAffine3::from_translation(DVec3::new(0.0, 9.0, 0.0)));
    let first = scene.instances[0].mesh;
    scene.instances.reverse();
    check(&scene, true);
    place(&mut scene, first, m, DAffine3::from_translation(DVec3::new(0.0, 12.0, 0.0)));
    check(&scene, true);
    scene.meshes[0].data.clear();
    check(&scene, false);
    // Without coordinates the defaults count.
    let mut scene = wall_of(PAINTED);
    scene.meshes[0].uvs.clear();
    near(uniform(&scene), [0.0, 0.0, 5.0 + 70.0 + 300.0]);
}

#[test]
fn files_bring_data_of_vertices() {
    let folder = std::env::temp_dir().join(format!("oslcl-supplied-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float wear\nproperty list uchar int near\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n\
        -9 0 -9 255 0 51 0.5 2 1 2\n9 0 -9 255 0 51 0.5 0\n0 0 9 255 0 51 0.5 1 7\n3 0 1 2\n";
    std::fs::write(folder.join("a.ply"), ply).expect("a file");
    let obj = "v -9 0 -9 0.25 0.5 0.75\nv 9 0 -9 0.25 0.5 0.75\nv 0 0 9 0.25 0.5 0.75\nf 1 2 3\n";
    std::fs::write(folder.join("a.obj"), obj).expect("a file");
    let text = |file: &str| {
        format!(
            "[camera]\norigin = [0, -5, 0]\ntarget = [0, 0, 0]\nhfov = 5\n[film]\nwidth = 8\nheight = 8\n\
             [integrator]\nsamples = 4\n\
             [materials.m]\nosl = 'surface s(color Cd = 9 [[ int lockgeom = 0 ]], float wear = 9 [[ int lockgeom = 0 ]]) {{ float a = 0; getattribute(\"a\", a); Ci = (Cd + wear + a) * emission(); }}'\n\
             attributes = {{ a = 100 }}\ninteractive = [\"wear\"]\n\
             [[meshes]]\nname = \"a\"\nfile = \"{file}\"\nmaterial = \"m\"\nattributes = {{ a = 1000 }}\n"
        )
    };
    let load = |file: &str| scene::parse(&text(file), &folder.join("s.toml")).unwrap_or_else(|e| panic!("{e}"));
    near(uniform(&load("a.ply")), [1001.5, 1000.5, 1000.7]);
    near(uniform(&load("a.obj")), [1009.25, 1009.5, 1009.75]);
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn values_change_without_building_again() {
    let source = "surface s(float Kd = 0.25 [[ int interactive = 1 ]], color tint = color(1, 0.5, 0), int on = 1)
        { Ci = (Kd * on) * tint * emission(); }";
    let mut scene = wall_of(source);
    scene.materials[0].interactive = vec!["tint".into(), "on".into()];
    let device = Device::open(None).expect("an OpenCL device");
    let mut session = Session::new(&scene, &device, &renderer::Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let id = MaterialId(0);
    let (first, summary) = session.render(&mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.plan.decisions.iter().any(|d| d.effect.name() == "interactive" && d.is_on()));
    assert_eq!(first.pixels, rendered(&scene).0.pixels);
    session.set(id, "Kd", &ParamValue::Float(0.75)).unwrap_or_else(|e| panic!("{e}"));
    session.set(id, "tint", &ParamValue::Floats(vec![0.5, 1.0, 2.0])).unwrap_or_else(|e| panic!("{e}"));
    session.set(id, "on", &ParamValue::Int(2)).unwrap_or_else(|e| panic!("{e}"));
    let (second, _) = session.render(&mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    let bound = [
        ("Kd", ParamValue::Float(0.75)),
        ("tint", ParamValue::Floats(vec![0.5, 1.0, 2.0])),
        ("on", ParamValue::Int(2)),
    ];
    let mut other = wall_of("");
    other.materials.clear();
    material(&mut other, source, &bound);
    let bound = rendered(&other).0;
    assert_eq!(second.pixels, bound.pixels);
    assert!(first.pixels != second.pixels);
    let refused = |r: Result<(), renderer::Error>| r.expect_err("refused").to_string();
    let said = refused(session.set(id, "Ks", &ParamValue::Float(1.0)));
    assert_eq!(said, "material `m0`: `Ks` is no interactive parameter; these are: Kd, tint, on");
    let said = refused(session.set(id, "Kd", &ParamValue::Str("x".into())));
    assert_eq!(said, "material `m0`: the value does not fit `Kd`, which is of type float");
    assert!(refused(session.set(MaterialId(4), "Kd", &ParamValue::Int(1))).contains("number 4"));
    // Rendered once, it is a value like all others.
    let (plan, _) = renderer::plan(&scene, &Precision::Standard.into()).expect("plans");
    assert!(plan.programs.iter().all(|p| !p.macros.iter().any(|m| m.contains("INTERACTIVE"))));
}

#[test]
fn shaders_learn_about_their_surface_and_messages_within() {
    let source = "surface s() { float x = 0; setmessage(\"a\", 3.0); getmessage(\"a\", x);
        Ci = color(surfacearea() + x, raytype(\"camera\"), backfacing()) * emission(); }";
    near(uniform(&wall_of(source)), [7.0, 1.0, 0.0]);
}

#[test]
fn what_is_printed_comes_once_with_its_count() {
    let mut scene = wall_of("surface s(string t = \"x\") { printf(\"%s %d\\n\", t, (int)raytype(\"camera\")); }");
    scene.integrator.samples = 2;
    let (_, summary) = rendered(&scene);
    let told = &summary.messages.told;
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!((told[0].text.as_str(), told[0].count), ("x 1\n", 16 * 16 * 2));
    scene.film = scene::Film { width: 512, height: 512 };
    scene.integrator.samples = 4;
    let (_, summary) = rendered(&scene);
    assert!(summary.messages.lost_bytes > 0 && summary.messages.told.len() == 1);
}

#[test]
fn damaged_data_is_refused() {
    let mut scene = wall_of(PAINTED);
    scene.meshes[0] = Mesh { data: vec![VertexData { values: vec![1.0; 5], ..painted() }], ..wall() };
    let said = renderer::plan(&scene, &Precision::Standard.into()).map(|_| ()).expect_err("refused").to_string();
    assert!(said.contains("vertex data"), "{said}");
}
