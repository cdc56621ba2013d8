//! The plan: what a scene calls for is there, and nothing of what it doesn't.

use glam::DAffine3;
use oslcl_runtime::plan::Effect;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::scene::{Scene, VertexData};
use oslcl_runtime::{device::Device, programs, render, session::Session};
use oslcl_tests::scenes::{empty, material, mesh, place, sphere, wall};
use std::collections::BTreeSet;

/// A wall with this material, and the effects that the plan finds.
fn wall_of(source: &str) -> Scene {
    let mut scene = empty();
    let m = material(&mut scene, source, &[]);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, m, DAffine3::IDENTITY);
    scene
}

fn effects(scene: &Scene) -> BTreeSet<&'static str> {
    let (plan, _) = render::plan(scene, &Precision::Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    plan.decisions.iter().filter(|d| d.is_on()).map(|d| d.effect.name()).collect()
}

fn check(scene: &Scene, expected: &[&'static str]) {
    assert_eq!(effects(scene), expected.iter().copied().collect());
}

const DIFFUSE: &str = "surface d() { Ci = 0.5 * diffuse(N); }";

#[test]
fn each_effect_is_asked_for_by_what_needs_it() {
    check(&wall_of(DIFFUSE), &["surfaces", "lobe_diffuse"]);
    check(&wall_of("surface d() { Ci = 2 * emission(); }"), &["surfaces", "lights"]);
    check(&wall_of("surface d() { Ci = u * emission(); }"), &["surfaces", "lights", "varying_lights", "uvs"]);
    check(&wall_of("surface d() { Ci = ward(N, dPdu, 0.1, 0.2); }"), &["surfaces", "lobe_ward", "tangents", "uvs"]);
    check(
        &wall_of("surface d() { Ci = filterwidth(u) * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "derivatives", "uvs"],
    );
    // N has no derivatives.
    check(&wall_of("surface d() { Ci = diffuse(N) + filterwidth(N[0]) * emission(); }"), &["surfaces", "lobe_diffuse"]);
    check(&wall_of("surface d() { Ci = surfacearea() * diffuse(N); }"), &["surfaces", "lobe_diffuse", "surface_area"]);
    check(
        &wall_of("surface d() { Ci = transform(\"object\", P)[0] * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "object_space"],
    );
    check(
        &wall_of("surface d() { Ci = transform(\"camera\", P)[0] * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "camera_space"],
    );
    check(&wall_of("surface d() { Ci = raytype(\"camera\") * diffuse(N); }"), &["surfaces", "lobe_diffuse", "raytype"]);
    check(&wall_of("surface d() { Ci = holdout(); }"), &["surfaces", "holdout"]);
    let mut scene = wall_of(DIFFUSE);
    let by = material(&mut scene, "displacement d() { P += 0.1 * N; }", &[]);
    scene.materials[0].displacement = Some(by);
    check(&scene, &["surfaces", "lobe_diffuse", "displacement", "normals"]);
    check(
        &wall_of("surface d() { printf(\"%g\\n\", P); Ci = diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "messages"],
    );
    check(
        &wall_of("surface d() { Ci = transform(\"NDC\", P)[0] * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "other_spaces"],
    );
    // A wall has such coordinates, and all of it: they are u and v.
    check(
        &wall_of("surface d(float s = 0 [[ int lockgeom = 0 ]]) { Ci = s * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "uvs"],
    );
    check(
        &wall_of("surface d(float st[2] = {0, 0} [[ int lockgeom = 0 ]]) { Ci = st[0] * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "userdata"],
    );
    check(
        &wall_of("surface d(float other = 0 [[ int lockgeom = 0, int interactive = 1 ]]) { Ci = other * diffuse(N); }"),
        &["surfaces"],
    );
    check(
        &wall_of("surface d(int say = 0) { if (say) printf(\"x\"); Ci = diffuse(N); }"),
        &["surfaces", "lobe_diffuse"],
    );
    check(&wall_of("surface d() { Ci = trace(P, N) * diffuse(N); }"), &["surfaces", "lobe_diffuse", "traces"]);
    check(
        &wall_of(
            "surface d() { float u; string n; trace(P, N, \"traceset\", \"-a\"); getmessage(\"trace\", \"u\", u);
                getmessage(\"trace\", \"geom:name\", n); Ci = (u + (n == \"a\")) * diffuse(N); }",
        ),
        &["surfaces", "lobe_diffuse", "traces", "trace_sets", "trace_names", "uvs"],
    );
    check(
        &wall_of("surface d() { Ci = pointcloud_search(\"a.geo\", P, 1, 1) * diffuse(N); }"),
        &["surfaces", "lobe_diffuse", "point_clouds"],
    );
    check(
        &wall_of("surface d(int on = 0) { Ci = on && trace(P, N) ? 0 : diffuse(N); }"),
        &["surfaces", "lobe_diffuse"],
    );
}

#[test]
fn a_lobe_of_constant_weight_zero_leaves_nothing() {
    let source = "surface d(float coat = 0) { Ci = diffuse(N) + coat * microfacet(\"ggx\", N, 0.1, 1.5, 0); }";
    check(&wall_of(source), &["surfaces", "lobe_diffuse"]);
}

#[test]
fn settings_and_geometry_ask_too() {
    let mut scene = wall_of(DIFFUSE);
    scene.camera.lens_radius = 0.1;
    scene.integrator.roulette_from = Some(3);
    let ball = mesh(&mut scene, sphere());
    let m = scene.instances[0].material;
    place(&mut scene, ball, m, DAffine3::IDENTITY);
    place(&mut scene, ball, m, DAffine3::from_translation(glam::DVec3::X));
    check(&scene, &["surfaces", "lobe_diffuse", "thin_lens", "roulette", "normals", "instances"]);
    let sky = material(&mut scene, "surface s() { Ci = background(); }", &[]);
    scene.environment = Some(sky);
    assert!(effects(&scene).contains("environment") && !effects(&scene).contains("environment_sampling"));
    let sky = material(&mut scene, "surface s() { Ci = max(0, I[2]) * background(); }", &[]);
    scene.environment = Some(sky);
    assert!(effects(&scene).contains("environment_sampling"));
    let (plan, _) = render::plan(&scene, &Precision::Reference.into()).expect("plans");
    assert!(plan.has(Effect::DoublePrecision));
}

#[test]
fn textures_are_there_when_asked_for() {
    let find = |source: &str, wanted: &[&str]| {
        let found = effects(&wall_of(source));
        let textures: Vec<&str> = found.iter().copied().filter(|e| e.starts_with("texture")).collect();
        assert_eq!(textures, wanted, "{source}");
        text_of(&wall_of(source))
    };
    let off =
        find("surface d(string file = \"\") { Ci = diffuse(N); if (file != \"\") Ci *= texture(file, u, v); }", &[]);
    assert!(!off.contains("#define HAS_TEXTURE") && !off.contains("\"osl/texture"), "no texture, no code");
    let cubic =
        find("surface d() { Ci = (color)texture(\"a.tif\", u, v) * diffuse(N); }", &["texture_cubic", "textures"]);
    assert!(
        cubic.contains("*textures")
            && cubic.contains("#define HAS_TEXTURE_CUBIC")
            && !cubic.contains("#define HAS_TEXTURE_CLOSEST")
    );
    find("surface d() { Ci = (color)texture(\"a.tif\", u, v, \"interp\", \"linear\") * diffuse(N); }", &["textures"]);
    find(
        "surface d() { Ci = (color)environment(\"a.tif\", N, \"interp\", \"closest\") * diffuse(N); }",
        &["texture_closest", "textures"],
    );
}

/// The text of all programs, as the device gets it.
fn text_of(scene: &Scene) -> String {
    let (plan, _) = render::plan(scene, &Precision::Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    plan.programs.iter().map(|p| programs::source(&plan, p, 64).expect("assembles")).collect()
}

/// Symbols of effects.
const SYMBOLS: [&str; 44] = [
    "#define HAS_LIGHTS",
    "#define HAS_ENVIRONMENT",
    "#define HAS_NORMALS",
    "#define HAS_UVS",
    "#define HAS_INSTANCES",
    "#define HAS_THIN_LENS",
    "#define HAS_ROULETTE",
    "#define HAS_LOBE_MICROFACET",
    "#define HAS_DERIVATIVES",
    "#define HAS_TEXTURES",
    "#define HAS_MESSAGES",
    "#define HAS_OTHER_SPACES",
    "#define HAS_USERDATA",
    "#define MATERIAL_INTERACTIVE",
    "#define HAS_TRACES",
    "#define HAS_TRACE_SETS",
    "#define HAS_TRACE_NAMES",
    "*trace_sets,",
    "*trace_names,",
    "#define HAS_POINT_CLOUDS",
    "*clouds,",
    "int cloud_nearest(",
    "#define HAS_LOBE_SHEEN",
    "#define HAS_LOBE_DIELECTRIC",
    "#define HAS_LOBE_THIN_FILM",
    "*textures,",
    "*messages,",
    "*other_spaces,",
    "*userdata,",
    "*userdata_places,",
    "*interactive,",
    "void material_userdata(",
    "record_open",
    "#define PATH_cone_width",
    "#define PATH_shadow_o",
    "#define PATH_pdf",
    "#define QUEUE_shadow",
    "#define QUEUE_environment",
    "*normals",
    "*lights",
    "*instances",
    "LOBE_KERNEL void sample_light",
    "__kernel void trace_shadow",
    "__kernel void environment",
];

#[test]
fn what_is_off_has_no_macro_no_buffer_and_no_queue() {
    let plain = text_of(&wall_of(DIFFUSE));
    for absent in SYMBOLS {
        assert!(!plain.contains(absent), "{absent}");
    }
    // Each of those is there when asked for, or the check above would hold nothing.
    let mut scene = wall_of(
        "surface d(float s = 0 [[ int lockgeom = 0 ]]) {
            printf(\"%g\", s);
            string met;
            trace(P, N, \"traceset\", \"a\");
            getmessage(\"trace\", \"geom:name\", met);
            if (met == \"a\" && pointcloud_search(\"a.geo\", P, 1, 1)) return;
            point p = transform(\"raster\", P);
            Ci = Dx(P) * diffuse(N) + u * emission() + microfacet(\"ggx\", N, 0.1, 1.5, 0)
                + (color)texture(\"a.tif\", p[0], p[1]) * sheen_bsdf(N, color(1), 0.5)
                + dielectric_bsdf(N, dPdu, color(1), color(1), 0.1, 0.1, 1.5, \"ggx\", \"thinfilm_thickness\", 300.0,
                    \"thinfilm_ior\", 1.4);
        }",
    );
    scene.meshes[0].data =
        vec![VertexData { name: "s".into(), channels: 1, values: vec![0.0; scene.meshes[0].positions.len()] }];
    scene.camera.lens_radius = 0.1;
    scene.integrator.roulette_from = Some(3);
    let ball = mesh(&mut scene, sphere());
    let m = scene.instances[0].material;
    place(&mut scene, ball, m, DAffine3::IDENTITY);
    place(&mut scene, ball, m, DAffine3::IDENTITY);
    let sky = material(&mut scene, "surface s() { Ci = max(0, I[2]) * background(); }", &[]);
    scene.environment = Some(sky);
    let mut live = wall_of("surface d(float k = 1) { Ci = k * diffuse(N); }");
    live.materials[0].interactive = vec!["k".into()];
    assert!(!text_of(&live).contains("nteractive,"), "what is rendered once has no such parameters");
    let device = Device::open(None).expect("an OpenCL device");
    let session = Session::new(&live, &device, &render::Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let live: String =
        session.plan().programs.iter().map(|p| programs::source(session.plan(), p, 64).expect("assembles")).collect();
    let full = text_of(&scene) + &live;
    for present in SYMBOLS {
        assert!(full.contains(present), "{present}");
    }
}
