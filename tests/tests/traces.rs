//! Rays that shaders trace, in renders: against distances and shares of the view that are known, in three precisions, far from
//! the origin, through instances; and what is said where there is nothing to meet.

use glam::{DAffine3, DVec3};
use oslcl_runtime::film::Picture;
use oslcl_runtime::precision::Precision::{self, Fast, Reference, Standard};
use oslcl_runtime::render::{self as renderer, Summary};
use oslcl_runtime::scene::{Mesh, ParamValue, Scene};
use oslcl_tests::scenes::{empty, material, mesh, place, render, sphere, wall};

const BLACK: &str = "surface b() { }";

/// A small wall with this shader over the whole picture, and another thing behind it.
fn before(source: &str, what: Mesh, at: DAffine3) -> Scene {
    let mut scene = empty();
    scene.integrator.samples = 4;
    let m = material(&mut scene, source, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    let black = material(&mut scene, BLACK, &[]);
    let what = mesh(&mut scene, what);
    place(&mut scene, what, black, at);
    scene
}

/// The wall that lies two units behind, twice as large.
fn behind(source: &str) -> Scene {
    let at = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), glam::DQuat::IDENTITY, DVec3::Y * 2.0);
    before(source, Mesh { name: "behind".into(), ..wall() }, at)
}

fn moved(mut scene: Scene, by: DVec3) -> Scene {
    scene.camera.origin += by;
    scene.camera.target += by;
    for instance in &mut scene.instances {
        instance.transform = DAffine3::from_translation(by) * instance.transform;
    }
    scene
}

fn rendered(scene: &Scene, precision: Precision) -> (Picture, Summary) {
    let (picture, summary) = render(scene, precision);
    assert_eq!((summary.counts.dropped, summary.counts.repaired), (0, 0));
    (picture, summary)
}

/// All pixels show this.
fn shows(scene: &Scene, precision: Precision, expected: [f32; 3], tolerance: f32) {
    let (picture, _) = rendered(scene, precision);
    for p in &picture.pixels {
        let near = |c: usize| (p[c] - expected[c]).abs() <= tolerance * expected[c].abs().max(1.0);
        assert!((0..3).all(near), "{p:?}, expected {expected:?}");
    }
}

fn glows(color: &str, statements: &str) -> String {
    format!("surface s() {{ {statements} Ci = color({color}) * emission(); }}")
}

const BACK: &str = "vector back = vector(0, 1, 0);";

#[test]
fn a_ray_meets_what_lies_within_its_distances() {
    let mut tests = format!("{BACK} int right = 0; int all = 0;\n");
    for (call, expected) in [
        ("trace(P, back)", 1),
        ("trace(P, -back)", 0),
        ("trace(P, 7 * back, \"maxdist\", 1.99)", 0),
        ("trace(P, 7 * back, \"maxdist\", 2.01)", 1),
        ("trace(P, back, \"mindist\", 2.01)", 0),
        ("trace(P, back, \"mindist\", 1.99)", 1),
        ("trace(P, back, \"mindist\", 1, \"maxdist\", 0.5)", 0),
        // From in front of the wall: the wall itself, then what is behind it.
        ("trace(P - back, back, \"maxdist\", 1.01)", 1),
        ("trace(P - back, back, \"mindist\", 1.5, \"maxdist\", 2.9)", 0),
        ("trace(P, vector(0))", 0),
        ("trace(P, back / 0)", 0),
        ("trace(P, back * 1e-30)", 1),
        ("trace(P * 1e30, back)", 0),
    ] {
        tests.push_str(&format!("right += {call} == {expected}; all += 1;\n"));
    }
    shows(&behind(&glows("right == all", &tests)), Standard, [1.0; 3], 0.0);
}

#[test]
fn what_it_meets_is_told() {
    let mut tests = format!("{BACK} int right = 0; int all = 0; trace(P, 3 * back);\n");
    for (ty, name, value) in [
        ("int", "hit", "x"),
        ("float", "hitdist", "abs(x - 2) < 1e-5"),
        ("point", "P", "distance(x, P + 2 * back) < 1e-5"),
        ("normal", "N", "distance(x, -back) < 1e-5"),
        ("normal", "Ng", "distance(x, -back) < 1e-5"),
        ("vector", "I", "distance(x, back) < 1e-5"),
        ("vector", "dPdu", "distance(x, vector(4, 0, 0)) < 1e-5"),
        ("vector", "dPdv", "distance(x, vector(0, 0, 4)) < 1e-5"),
        ("float", "u", "abs(x - (P[0] + 2) / 4) < 1e-5"),
        ("float", "v", "abs(x - (P[2] + 2) / 4) < 1e-5"),
        ("string", "geom:name", "x == \"behind\""),
    ] {
        tests.push_str(&format!(
            "{{ {ty} x; all += 1; if (getmessage(\"trace\", \"{name}\", x) && {value}) right += 1; else printf(\"{name};\"); }}\n"
        ));
    }
    for precision in [Fast, Standard, Reference] {
        let scene = behind(&glows("right == all", &tests));
        let (_, summary) = rendered(&scene, precision);
        let wrong: Vec<&str> = summary.messages.told.iter().map(|t| t.text.as_str()).collect();
        assert!(wrong.is_empty(), "{precision:?}: {wrong:?}");
        shows(&scene, precision, [1.0; 3], 0.0);
    }
}

#[test]
fn what_is_not_met_is_not_told() {
    let source = glows(
        "getmessage(\"trace\", \"hit\", h) + h, getmessage(\"trace\", \"hitdist\", d), d",
        "int h = 7; float d = 5; if (u > 2) trace(P, N);",
    );
    // No ray yet: what was there stays.
    shows(&behind(&source), Standard, [7.0, 0.0, 5.0], 0.0);
    let source = glows(
        "getmessage(\"trace\", \"hit\", h) + h, getmessage(\"trace\", \"hitdist\", d), d",
        "int h = 7; float d = 5; trace(P, vector(0, 1, 0)); trace(P, vector(0, -1, 0));",
    );
    // The last one counts.
    shows(&behind(&source), Standard, [1.0, 0.0, 5.0], 0.0);
}

/// Of directions spread evenly over the half of space behind the wall, how many a square of side 2 at distance 1 hides: its
/// solid angle is 4 atan(1 / sqrt 3) (Mathar, "Solid Angle of a Rectangular Plate", 2015), of 2 pi.
#[test]
fn the_hidden_share_of_half_the_view_is_the_solid_angle() {
    let source = glows(
        "sum / (n * n)",
        "int n = 64; float sum = 0;
         for (int i = 0; i < n; i++) for (int j = 0; j < n; j++) {
            float y = (i + 0.5) / n, phi = M_2PI * (j + 0.5) / n, r = sqrt(1 - y * y);
            sum += trace(P, vector(r * cos(phi), y, r * sin(phi)));
         }",
    );
    let expected = 4.0 * (1.0f32 / 3.0f32.sqrt()).atan() / (2.0 * std::f32::consts::PI);
    for precision in [Fast, Standard, Reference] {
        let mut scene = before(&source, wall(), DAffine3::from_translation(DVec3::Y));
        // What is seen is the middle alone.
        scene.instances[0].transform = DAffine3::from_scale(DVec3::splat(1e-2));
        scene.camera.hfov_degrees = 0.02;
        scene.integrator.samples = 1;
        scene.film.width = 4;
        scene.film.height = 4;
        shows(&scene, precision, [expected; 3], 0.005);
    }
}

/// A convex body hides nothing from its own points, and all that lies behind them.
#[test]
fn surfaces_do_not_meet_themselves() {
    let source = "surface s() {
        vector side = normalize(cross(Ng, vector(0.3, 0.5, 0.8)));
        float out = 0, within = 1;
        for (int i = 0; i < 8; i++) {
            vector d = side * pow(10, i / 2) + Ng;
            out += trace(P, d);
            within *= trace(P, -d, \"mindist\", 0);
        }
        Ci = color(out, within, trace(transform(\"object\", \"common\", transform(\"object\", P)), Ng)) * emission();
    }";
    for precision in [Fast, Standard, Reference] {
        for by in [DVec3::ZERO, DVec3::new(3e4, -1e5, 2e4)] {
            for copies in [1, 2] {
                let mut scene = empty();
                scene.integrator.samples = 4;
                // Within the picture's edges.
                scene.camera.hfov_degrees = 8.0;
                let m = material(&mut scene, source, &[]);
                let ball = mesh(&mut scene, sphere());
                for k in 0..copies {
                    // The second one out of sight, so that both are instances.
                    let at = DAffine3::from_rotation_x(0.4) * DAffine3::from_scale(DVec3::new(1.0, 1.3, 0.9));
                    place(&mut scene, ball, m, DAffine3::from_translation(DVec3::X * 1000.0 * k as f64) * at);
                }
                shows(&moved(scene, by), precision, [0.0, 1.0, 0.0], 0.0);
            }
        }
    }
}

#[test]
fn distances_hold_far_from_the_origin() {
    let ask = format!("{BACK} float d; int h = trace(P, back); getmessage(\"trace\", \"hitdist\", d);");
    let source = glows("d, h, 0", &ask);
    for by in [1e3, 1e6] {
        for precision in [Standard, Reference] {
            shows(&moved(behind(&source), DVec3::new(by, -by, by / 2.0)), precision, [2.0, 1.0, 0.0], 1e-6);
        }
    }
}

fn sets(source: &str) -> Scene {
    let mut scene = behind(source);
    // A third wall, further back, and one more that has no attribute.
    let m = scene.instances[1].material;
    for (k, name) in ["far", "farther"].into_iter().enumerate() {
        let quad = mesh(&mut scene, Mesh { name: name.into(), ..wall() });
        let at = DVec3::Y * (4.0 + 2.0 * k as f64);
        place(
            &mut scene,
            quad,
            m,
            DAffine3::from_scale_rotation_translation(DVec3::splat(4.0), glam::DQuat::IDENTITY, at),
        );
    }
    scene.instances[1].attributes.push(("traceset".into(), ParamValue::Str("a".into())));
    let both = ParamValue::Strs(vec!["a".into(), "b".into()]);
    scene.instances[2].attributes.push(("traceset".into(), both));
    scene.instances[3].attributes.push(("geom:name".into(), ParamValue::Str("last".into())));
    scene
}

#[test]
fn sets_of_objects_are_traced_alone() {
    let mut nearest = format!("{BACK} int right = 0; int all = 0;\n");
    let mut any = nearest.clone();
    for (set, distance) in [
        ("\"\"", 2.0),
        ("\"a\"", 2.0),
        ("\"b\"", 4.0),
        ("\"-a\"", 6.0),
        ("\"-b\"", 2.0),
        ("\"last\"", 6.0),
        ("\"behind\"", 2.0),
        ("\"-nobody\"", 2.0),
        ("\"nobody\"", 0.0),
        ("u < 2 ? \"b\" : \"-a\"", 4.0),
    ] {
        nearest.push_str(&format!(
            "{{ float d = 0; string s = {set}; trace(P, back, \"traceset\", s);
                getmessage(\"trace\", \"hitdist\", d); right += abs(d - {distance}) < 1e-5; all += 1; }}\n"
        ));
        let found = u8::from(distance > 0.0);
        any.push_str(&format!(
            "{{ string s = {set}; right += trace(P, back, \"traceset\", s) == {found}; all += 1; }}\n"
        ));
    }
    for tests in [nearest, any] {
        shows(&sets(&glows("right == all", &tests)), Standard, [1.0; 3], 0.0);
    }
    // Of two levels.
    let mut scene = sets(&glows("trace(P, vector(0, 1, 0), \"traceset\", \"b\", \"maxdist\", 4.1)", ""));
    let (quad, m) = (scene.instances[2].mesh, scene.instances[2].material);
    place(&mut scene, quad, m, DAffine3::from_translation(DVec3::X * 100.0));
    shows(&scene, Standard, [1.0; 3], 0.0);
    let names = "trace(P, vector(0, 1, 0)); string n; getmessage(\"trace\", \"geom:name\", n); printf(\"%s;\", n);";
    let names = glows("1", names);
    let (_, summary) = rendered(&sets(&names), Standard);
    let said: Vec<&str> = summary.messages.told.iter().map(|t| t.text.as_str()).collect();
    assert_eq!(said, ["behind;"]);
}

fn warnings(scene: &Scene) -> String {
    let (_, compiled) = renderer::plan(scene, &Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    compiled.warnings.concat()
}

#[test]
fn what_is_not_done_is_said_with_its_place() {
    let one = |body: &str| warnings(&behind(&format!("surface s() {{\n    {body}\n}}")));
    assert_eq!(one("Ci = trace(P, N) * diffuse(N);"), "");
    let said = one("Ci = trace(P, N, \"shade\", 1) * diffuse(N);");
    assert!(said.contains("W3003") && said.contains("\"shade\"") && said.contains("m0.osl:2:10"), "{said}");
    let said = one("float x; trace(P, N); if (getmessage(\"trace\", \"Kd\", x)) Ci = x * diffuse(N);");
    assert!(said.contains("W3003") && said.contains("\"Kd\""), "{said}");
    let said = one("color x; trace(P, N); if (getmessage(\"trace\", \"P\", x)) Ci = x * diffuse(N);");
    assert!(said.contains("W3003") && said.contains("a point, not a color"), "{said}");
    let said = one("Ci = trace(P, N, \"traceset\", \"nobody\") * diffuse(N);");
    assert!(said.contains("\"nobody\""), "{said}");
    let refused = |body: &str| {
        let scene = behind(&format!("surface s(string x = \"a\" [[ int interactive = 1 ]]) {{ {body} }}"));
        renderer::plan(&scene, &Standard.into()).map(|_| ()).expect_err("refused").to_string()
    };
    assert!(refused("Ci = trace(P, N, \"mindist\", \"x\") * diffuse(N);").contains("takes a float"));
    assert!(refused("Ci = trace(P, N, x, 1) * diffuse(N);").contains("a string literal"));
    assert!(refused("Ci = trace(P, N, \"mindits\", 1) * diffuse(N);").contains("mindist"));
    assert!(refused("Ci = trace(P, N, \"shade\") * diffuse(N);").contains("no value"));
    assert!(
        refused("float y; trace(P, N); getmessage(\"trace\", format(\"%g\", u), y); Ci = y * diffuse(N);")
            .contains("E3001")
    );
}

#[test]
fn displacement_shaders_meet_nothing_and_are_told() {
    let mut scene = behind(&glows("1", ""));
    let by = material(
        &mut scene,
        "displacement d() { P += (1 + 3 * trace(P, vector(0, 1, 0))) * vector(0, -0.5, 0); }",
        &[],
    );
    scene.materials[0].displacement = Some(by);
    let said = warnings(&scene);
    assert!(said.contains("W3003") && said.contains("before the scene is built"), "{said}");
    shows(&scene, Standard, [1.0; 3], 0.0);
}

/// Lights ask their shader at another point than the one that is seen; environments have none.
#[test]
fn lights_and_environments_trace_too() {
    // Through the lamp's back: the wall.
    let lamp = |weight: &str| {
        let mut scene = before("surface d() { Ci = diffuse(N); }", wall(), DAffine3::from_translation(DVec3::Y * 9.0));
        let l = material(&mut scene, &format!("surface l() {{ Ci = {weight} * emission(); }}"), &[]);
        let quad = mesh(&mut scene, wall());
        let turned = DAffine3::from_rotation_z(2.5);
        place(&mut scene, quad, l, DAffine3::from_translation(DVec3::new(3.0, -3.0, 0.5)) * turned);
        scene.integrator.samples = 16;
        rendered(&scene, Standard).0
    };
    let traced = lamp("(1 + 2 * trace(P, point(0) - P) + trace(P, P - point(0)) + (u > 2))");
    let plain = lamp("(3 + (u > 2))");
    assert_eq!(traced.pixels, plain.pixels);
    assert!(plain.pixels[0][0] > 0.0);
    // What is seen of the sky does not lie behind anything.
    let sky = |weight: &str| {
        let mut scene = before("surface d() { Ci = diffuse(N); }", wall(), DAffine3::from_translation(DVec3::Y * 9.0));
        scene.environment =
            Some(material(&mut scene, &format!("surface s() {{ Ci = {weight} * background(); }}"), &[]));
        scene.camera.hfov_degrees = 40.0;
        scene.integrator.max_depth = 1;
        rendered(&scene, Standard).0
    };
    let traced = sky(
        "color(trace(point(0, -5, 0), I), trace(point(0, -5, 0), vector(0, 1, 0)), trace(P - 0.25, vector(0, 1, 0)))",
    );
    for p in traced.pixels.iter().filter(|p| **p != [0.0; 3]) {
        assert!(p[0] < 0.01 && (p[1] - p[2]).abs() < 0.01, "{p:?}");
    }
    assert!((traced.pixels[0][1] - 1.0).abs() < 1e-6 && traced.pixels[0][0] == 0.0, "{:?}", traced.pixels[0]);
}

#[test]
fn derivatives_of_what_is_met_are_zero() {
    let source = glows(
        "abs(Dx(d)) + filterwidth(d), length(Dx(p)), d > 1",
        "float d; point p; trace(P, vector(0.1 * P[0], 1, 0)); getmessage(\"trace\", \"hitdist\", d);
         getmessage(\"trace\", \"P\", p);",
    );
    shows(&behind(&source), Standard, [0.0, 0.0, 1.0], 0.0);
}

#[test]
fn layers_of_a_group_share_what_was_met() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("traces");
    std::fs::create_dir_all(&folder).expect("a folder for shaders");
    std::fs::write(folder.join("asks.osl"), "shader asks(output float hit = 0) { hit = trace(P, vector(0, 1, 0)); }")
        .expect("written");
    let told = "surface told(float hit = 0) { float d = 0; if (hit) getmessage(\"trace\", \"hitdist\", d); Ci = color(hit, d, 0) * emission(); }";
    std::fs::write(folder.join("told.osl"), told).expect("written");
    let mut scene = behind(BLACK);
    scene.materials[0].group = true;
    scene.materials[0].source = "shader asks a; shader told b; connect a.hit b.hit;".to_owned();
    scene.shaders = vec![folder];
    shows(&scene, Standard, [1.0, 2.0, 0.0], 1e-6);
}

#[test]
fn the_same_bits_come_out_again() {
    let mut scene = behind(
        "surface s() { float d = 1; trace(P, vector(u - 0.5, 1, v - 0.5)); getmessage(\"trace\", \"hitdist\", d);
        Ci = d * diffuse(N); }",
    );
    let ball = mesh(&mut scene, sphere());
    let m = scene.instances[0].material;
    place(&mut scene, ball, m, DAffine3::from_translation(DVec3::new(0.5, 1.2, 0.0)));
    place(&mut scene, ball, m, DAffine3::from_translation(DVec3::new(-0.5, 1.2, 0.0)));
    scene.environment = Some(material(&mut scene, "surface s() { Ci = background(); }", &[]));
    let (first, _) = rendered(&scene, Standard);
    assert_eq!(first.pixels, rendered(&scene, Standard).0.pixels);
    assert!(first.pixels.iter().any(|p| p[0] > 0.1));
}
