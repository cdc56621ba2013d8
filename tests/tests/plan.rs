//! The plan: what a scene calls for is there, and nothing of what it doesn't.

use glam::DAffine3;
use oslcl_runtime::choices::Choices;
use oslcl_runtime::plan::{Effect, Overrides, Plan};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::scene::{self, Material, MaterialId, ParamValue, Scene, VertexData};
use oslcl_runtime::{device::Device, explain, programs, render, session::Session};
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
            "surface d() { float s; string n; trace(P, N, \"traceset\", \"-a\"); getmessage(\"trace\", \"u\", s);
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
    plan.programs.iter().map(|p| programs::source(&plan, p).expect("assembles")).collect()
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
        session.plan().programs.iter().map(|p| programs::source(session.plan(), p).expect("assembles")).collect();
    let full = text_of(&scene) + &live;
    for present in SYMBOLS {
        assert!(full.contains(present), "{present}");
    }
}

/// The effects of a wall of a shipped material, its code, and the assembled source of all programs.
fn shipped(name: &str, params: &[(&str, f64)]) -> (BTreeSet<&'static str>, String, String) {
    let mut scene = empty();
    let mut material = Material::from_shipped("m", name).unwrap_or_else(|e| panic!("{e}"));
    for (name, value) in params {
        material = material.with(name, ParamValue::Float(*value));
    }
    scene.materials.push(material);
    let w = mesh(&mut scene, wall());
    place(&mut scene, w, MaterialId(0), DAffine3::IDENTITY);
    let sky = material_of_sky(&mut scene);
    scene.environment = Some(sky);
    let (plan, _) = render::plan(&scene, &Precision::Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    let code = plan.programs.iter().map(|p| p.code.as_str()).collect();
    (effects(&scene), code, text_of(&scene))
}

/// So that what emits can be left without emission.
fn material_of_sky(scene: &mut Scene) -> MaterialId {
    material(scene, "surface s() { Ci = background(); }", &[])
}

/// What a lobe brings into the assembled source: its macro, its constructor in the material's code.
fn symbols(lobe: &str) -> [String; 2] {
    [format!("#define HAS_LOBE_{}", lobe.to_uppercase()), format!("closure_{lobe}_")]
}

/// A weight of the constant 0 of a shipped material leaves no lobe, no macro, no call, no field of path state.
#[test]
fn a_weight_of_zero_leaves_nothing_of_a_shipped_material() {
    /// A material, values of others of its parameters, a weight that takes something away, and its lobes, macros or fields.
    type Case = (
        &'static str,
        &'static [(&'static str, f64)],
        (&'static str, f64),
        &'static [&'static str],
        &'static [&'static str],
    );
    const CASES: &[Case] = &[
        ("car_paint", &[], ("coat", 0.0), &["reflection"], &["osl_fresnel_"]),
        (
            "car_paint",
            &[("coat", 0.0)],
            ("flake_amount", 0.0),
            &["microfacet"],
            &["PATH_lobe_eta", "PATH_lobe_ax", "PATH_lobe_ay", "PATH_lobe_T", "osl_noise_cell"],
        ),
        ("car_paint", &[], ("flake_amount", 1.0), &["diffuse"], &[]),
        ("wood", &[], ("varnish", 0.0), &["microfacet"], &["PATH_lobe_eta", "PATH_lobe_ax", "osl_fresnel_"]),
        ("marble", &[], ("polish", 0.0), &["microfacet"], &["PATH_lobe_eta", "PATH_lobe_ax"]),
        ("glass", &[], ("tint", 0.0), &["refraction"], &[]),
        ("plastic", &[], ("Cs", 0.0), &["diffuse"], &["osl_fresnel_"]),
        (
            "standard_surface",
            &[("specular", 0.0)],
            ("coat", 0.0),
            &["dielectric"],
            &["PATH_lobe_eta", "PATH_lobe_c0", "PATH_lobe_T", "#define HAS_TANGENTS"],
        ),
        (
            "standard_surface",
            &[("coat", 0.0)],
            ("specular", 0.0),
            &["dielectric"],
            &["PATH_lobe_eta", "PATH_lobe_c0", "#define HAS_TANGENTS"],
        ),
        ("standard_surface", &[("sheen", 0.5)], ("sheen", 0.0), &["sheen"], &[]),
        ("standard_surface", &[("metalness", 0.5)], ("metalness", 0.0), &["conductor"], &[]),
        ("standard_surface", &[("metalness", 0.5)], ("metalness", 1.0), &["oren_nayar_diffuse"], &[]),
        ("standard_surface", &[("metalness", 0.5), ("specular", 0.0)], ("coat", 0.0), &["dielectric"], &[]),
        (
            "standard_surface",
            &[("transmission", 0.5), ("specular", 0.0), ("coat", 0.0)],
            ("transmission", 0.0),
            &["dielectric"],
            &["PATH_lobe_c0"],
        ),
        (
            "standard_surface",
            &[("film", 300.0)],
            ("film", 0.0),
            &[],
            &["#define HAS_LOBE_THIN_FILM", "PATH_lobe_film", "PATH_lobe_film_ior"],
        ),
        (
            "standard_surface",
            &[("emission_color", 1.0)],
            ("emission_color", 0.0),
            &[],
            &["#define HAS_LIGHTS", "*lights", "*light_words", "#define MATERIAL_EMITS"],
        ),
        (
            "emitter",
            &[],
            ("radiance", 0.0),
            &[],
            &["#define HAS_LIGHTS", "*lights", "#define QUEUE_shadow", "PATH_shadow_o"],
        ),
        ("matte", &[("roughness", 0.5)], ("roughness", 0.0), &["oren_nayar"], &["PATH_lobe_ax"]),
    ];
    for (name, others, weight, lobes, more) in CASES {
        let (on, code_with, with) = shipped(name, others);
        let bound: Vec<_> = others.iter().copied().filter(|(n, _)| *n != weight.0).chain([*weight]).collect();
        let (left, code_without, without) = shipped(name, &bound);
        for lobe in *lobes {
            let effect = format!("lobe_{lobe}");
            assert!(
                on.contains(effect.as_str()) && !left.contains(effect.as_str()),
                "{name} {bound:?}: {effect}: {left:?}"
            );
        }
        // Fields are defined by the layout, and each symbol is there where it is needed, or this would hold nothing.
        let defined = |s: &str| if s.starts_with("PATH_") { format!("#define {s} ") } else { s.to_owned() };
        for symbol in lobes.iter().flat_map(|l| symbols(l)).chain(more.iter().map(|s| defined(s))) {
            // Kernels' headers define functions that nobody calls: what is called stands in the material's code.
            let is_call = symbol.starts_with("osl_") || symbol.starts_with("closure_");
            let (with, without) = if is_call { (&code_with, &code_without) } else { (&with, &without) };
            assert!(with.contains(&symbol), "{name} {others:?}: no {symbol} to lose");
            assert!(!without.contains(&symbol), "{name} {bound:?}: {symbol} is left");
        }
    }
}

/// A scene from a file, whose parts have places.
fn written() -> Scene {
    let text = "[camera]
origin = [0, -4, 1]
target = [0, 0, 0]
lens_radius = 0.1
[integrator]
roulette = 3
[environment]
shader = \"sky\"
[materials.paint]
shader = \"car_paint\"
params = { flake_size = 0.02,
  coat = 0.8 }
[materials.own]
osl = \"\"\"
surface own(float k = 0.5, int raw = 1)
{
    color c = k * transform(\"camera\", P)[0];
    Ci = c * diffuse(N);
    if (raw)
        Ci += ward(N, dPdu, 0.1, 0.2);
}\"\"\"
[materials.layers]
group = \"param float coat 0.5; shader car_paint top;\"
params = { flake_amount = 0.5 }
[[meshes]]
name = \"ball\"
shape = \"sphere\"
material = \"paint\"
[[meshes]]
name = \"quad\"
shape = \"quad\"
material = \"own\"
[[meshes]]
name = \"more\"
shape = \"quad\"
material = \"layers\"
";
    scene::parse(text, std::path::Path::new("s.toml")).unwrap_or_else(|e| panic!("{e}"))
}

/// All that is said of who asks for an effect: the part with its line, and the places in shaders with the parameters that decide.
fn asked(plan: &Plan, effect: Effect) -> Vec<String> {
    let mut out = Vec::new();
    for asker in plan.decisions.iter().filter(|d| d.effect == effect).flat_map(|d| &d.asked_by) {
        let at = asker.at.as_ref().map_or(String::new(), |at| format!(" {}:{}", at.file.display(), at.line));
        out.push(format!("{}{at} {}", asker.who(), asker.why).trim_end().to_owned());
        for place in &asker.shader {
            let deciders: Vec<String> = place.deciders.iter().map(|d| d.to_string()).collect();
            out.push(format!("{}:{} {}", place.file, place.line, deciders.join(", ")).trim_end().to_owned());
        }
    }
    out
}

#[test]
fn askers_have_lines_and_the_parameters_that_decide() {
    let (plan, _) = render::explained_plan(&written(), &Precision::Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(asked(&plan, Effect::ThinLens), ["camera s.toml:4 lens_radius = 0.1"]);
    assert_eq!(asked(&plan, Effect::Roulette), ["integrator s.toml:6 roulette = 3"]);
    assert_eq!(asked(&plan, Effect::Surfaces), ["mesh `ball` s.toml:25 one of 3 placed meshes"]);
    assert_eq!(asked(&plan, Effect::Normals), ["mesh `ball` s.toml:25 has normals"]);
    let coat = "shaders-osl/car_paint.osl:20 coat = 0.8 (s.toml:12; 0 leaves it out)";
    assert_eq!(
        asked(&plan, Effect::LobeReflection),
        [
            "material `layers` s.toml:22",
            "car_paint.osl:20 coat = 0.5 (s.toml:23; 0 leaves it out)",
            "material `paint` s.toml:9",
            coat,
        ]
    );
    let flakes = asked(&plan, Effect::LobeMicrofacet);
    assert!(flakes[1].contains("flake_amount = 0.5 (s.toml:24; 0 leaves it out)"), "{flakes:?}");
    // Shaders in the scene file have its lines.
    assert_eq!(
        asked(&plan, Effect::CameraSpace),
        ["material `own` s.toml:13", "s.toml:17 k = 0.5 (s.toml:15; 0 leaves it out)"]
    );
    assert_eq!(
        asked(&plan, Effect::LobeWard),
        ["material `own` s.toml:13", "s.toml:20 raw = 1 (s.toml:15; 0 leaves it out)"]
    );
    assert_eq!(
        asked(&plan, Effect::Tangents),
        ["material `own` s.toml:13 dPdu", "s.toml:20 raw = 1 (s.toml:15; 0 leaves it out)"]
    );
    let sky = asked(&plan, Effect::EnvironmentSampling);
    assert!(
        sky[0] == "material `environment` s.toml:7" && sky[1].starts_with("shaders-osl/sky.osl:21 intensity = 1"),
        "{sky:?}"
    );
    // A plan that nobody asked to explain itself has places, but no parameters.
    let (plain, _) = render::plan(&written(), &Precision::Standard.into()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(asked(&plain, Effect::CameraSpace), ["material `own` s.toml:13", "s.toml:17"]);
}

#[test]
fn what_an_effect_adds_is_in_the_programs_and_in_no_plan_without_it() {
    let scene = written();
    let choices = Choices::from(Precision::Standard);
    let (plan, compiled) = render::plan(&scene, &choices).unwrap_or_else(|e| panic!("{e}"));
    let added = explain::added(&scene, &plan, &compiled).unwrap_or_else(|e| panic!("{e}"));
    let on: Vec<Effect> = plan.decisions.iter().filter(|d| d.is_on()).map(|d| d.effect).collect();
    assert_eq!(added.iter().map(|a| a.effect).collect::<Vec<_>>(), on);
    let of = |effect| added.iter().find(|a| a.effect == effect).expect("on");
    let own =
        |effect| -> BTreeSet<&str> { of(effect).kernels.iter().filter(|k| k.alone).map(|k| k.stage.name()).collect() };
    assert_eq!(own(Effect::VaryingEnvironment), BTreeSet::from(["environment"]));
    assert_eq!(
        own(Effect::EnvironmentSampling),
        BTreeSet::from(["environment_light", "environment_map", "sample_light", "sample_next", "trace_shadow"])
    );
    assert!(of(Effect::EnvironmentSampling).macros.contains(&"HAS_SHADED_LIGHTS".to_owned()));
    assert_eq!(of(Effect::EnvironmentSampling).buffers, ["environment_cells", "environment_alias"]);
    for added in &added {
        // Each effect has its own macro, and some kernel that asks for it.
        assert!(added.macros.contains(&added.effect.macro_name()), "{added:?}");
        assert!(!added.kernels.is_empty(), "{added:?}");
        if matches!(added.effect, Effect::Surfaces | Effect::VaryingEnvironment | Effect::Environment) {
            continue;
        }
        let choices = Choices { overrides: Overrides::new([], [added.effect]), ..choices };
        let (without, _) = render::plan(&scene, &choices).unwrap_or_else(|e| panic!("{e}"));
        let text: String = without.programs.iter().map(|p| programs::source(&without, p).expect("assembles")).collect();
        for name in &added.macros {
            // A lobe's constructor stays with a material that names it; nothing else has the macro.
            let stays = added.effect.name().starts_with("lobe_");
            assert!(stays || !text.contains(&format!("#define {name}\n")), "{added:?}");
        }
        for buffer in &added.buffers {
            assert!(!text.contains(&format!("*{buffer},")), "{added:?}");
        }
    }
}
