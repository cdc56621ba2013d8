//! What an effect promises: forced on where nothing needs it, it changes no bit of the picture; a scene that needs it differs
//! without it; and where it is off, none of its symbols, buffers and launches exist.
//!
//! `case` has a scene for each effect; a new effect does not compile without one.

use glam::{DAffine3, DVec3};
use oslcl_runtime::choices::Choices;
use oslcl_runtime::device::Device;
use oslcl_runtime::plan::{Effect, Overrides};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::programs;
use oslcl_runtime::render::Options;
use oslcl_runtime::scene::{Film, Filter, MaterialId, Mesh, ParamValue, Scene, VertexData};
use oslcl_runtime::session::Session;
use oslcl_runtime::wavefront::Counts;
use oslcl_tests::scenes::{empty, material, mesh, place, sphere, wall};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, OnceLock};

/// The device, one user at a time: PoCL finds none while another thread asks for one.
fn device() -> &'static Mutex<Device> {
    static DEVICE: OnceLock<Mutex<Device>> = OnceLock::new();
    DEVICE.get_or_init(|| Mutex::new(Device::open(None).expect("an OpenCL device")))
}

/// All that can be seen of a render.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    pixels: Vec<[u32; 3]>,
    alpha: Vec<u32>,
    said: Vec<String>,
}

/// A render and what it was made of.
struct Made {
    seen: Seen,
    counts: Counts,
    /// The texts of all programs, as the device gets them.
    text: String,
    buffers: Vec<&'static str>,
    stages: Vec<&'static str>,
    warnings: Vec<String>,
}

fn make(scene: &Scene, force: &[Effect], without: &[Effect], choices: impl Into<Choices>) -> Made {
    let device = device().lock().unwrap_or_else(|e| e.into_inner());
    let overrides = Overrides::new(force.iter().copied(), without.iter().copied());
    let options = Options { choices: Choices { overrides, ..choices.into() }, ..Options::default() };
    let mut session = Session::new(scene, &device, &options).unwrap_or_else(|e| panic!("{force:?} {without:?}: {e}"));
    // Where it is not interactive it keeps its value.
    let _ = session.set(MaterialId(0), "live", &ParamValue::Float(0.25));
    let (picture, summary) = session.render(&mut |_| {}).unwrap_or_else(|e| panic!("{force:?} {without:?}: {e}"));
    let plan = session.plan();
    let text = plan.programs.iter().map(|p| programs::source(plan, p).expect("assembles")).collect();
    Made {
        seen: Seen {
            pixels: picture.pixels.iter().map(|p| p.map(f32::to_bits)).collect(),
            alpha: picture.alpha.iter().map(|a| a.to_bits()).collect(),
            said: summary.messages.told.iter().map(|t| t.text.clone()).collect(),
        },
        counts: summary.counts,
        text,
        buffers: summary.buffers.iter().map(|(name, _)| *name).collect(),
        stages: summary.launches.keys().map(|(stage, _)| stage.name()).collect(),
        warnings: summary.warnings,
    }
}

fn tiny() -> Scene {
    let mut scene = empty();
    scene.film = Film { width: 8, height: 8 };
    scene.integrator.samples = 4;
    scene.integrator.max_depth = 4;
    scene
}

const WHITE: &str = "surface d() { Ci = 0.5 * diffuse(N); }";

/// A mesh of this material under a lamp.
fn of(what: Mesh, source: &str, lamp: &str) -> Scene {
    let mut scene = tiny();
    let m = material(&mut scene, source, &[]);
    let what = mesh(&mut scene, what);
    place(&mut scene, what, m, DAffine3::IDENTITY);
    let l = material(&mut scene, lamp, &[]);
    // In front of it and beside, its front towards it.
    let turned = DAffine3::from_rotation_z(2.5).with_translation(DVec3::new(3.0, -3.0, 0.5));
    let quad = mesh(&mut scene, Mesh { name: "lamp".into(), ..wall() });
    place(&mut scene, quad, l, turned);
    scene
}

trait WithTranslation {
    fn with_translation(self, by: DVec3) -> DAffine3;
}

impl WithTranslation for DAffine3 {
    fn with_translation(mut self, by: DVec3) -> DAffine3 {
        self.translation = by;
        self
    }
}

/// A ray to the middle of the lamp.
const TRACED: &str = "P, point(3, -3, 0.5) - P";

const LAMP: &str = "surface l() { Ci = 4 * emission(); }";

/// A wall of this material under a lamp.
fn lit(source: &str) -> Scene {
    of(wall(), source, LAMP)
}

fn under(mut scene: Scene, sky: &str) -> Scene {
    let sky = material(&mut scene, sky, &[]);
    scene.environment = Some(sky);
    scene
}

const FLAT_SKY: &str = "surface s() { Ci = 0.75 * background(); }";
const SKY: &str = "surface s() { Ci = (1 + I[2]) * background(); }";

fn textured(options: &str) -> Scene {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("effects");
    std::fs::create_dir_all(&folder).expect("a folder for pictures");
    let file = folder.join("dots.png");
    let dots = image::ImageBuffer::from_fn(4, 4, |x, y| image::Rgb([(60 * x) as u8, (60 * y) as u8, 200u8]));
    dots.save(&file).expect("a picture is written");
    lit(&format!(
        "surface d() {{ Ci = (color)texture(\"{}\", u, v{options}) * diffuse(N); }}",
        file.to_string_lossy().replace('\\', "/")
    ))
}

/// A scene that needs an effect.
fn needs(effect: Effect) -> Scene {
    use Effect::*;
    let lobe = |closure: &str| lit(&format!("surface d() {{ Ci = {closure}; }}"));
    match effect {
        Surfaces => under(lit(WHITE), FLAT_SKY),
        ThinLens => {
            let mut scene = lit(WHITE);
            scene.camera.lens_radius = 0.3;
            scene
        }
        TentFilter | MiddleFilter => {
            let mut scene = lit(WHITE);
            scene.filter = if effect == TentFilter { Filter::Tent } else { Filter::Middle };
            scene
        }
        Lights | LobeDiffuse => lit(WHITE),
        VaryingLights => of(wall(), WHITE, "surface l() { Ci = 4 * (1 + u) * emission(); }"),
        TwoSidedEmission => {
            let mut scene = lit(WHITE);
            scene.instances[1].transform =
                DAffine3::from_rotation_z(2.5 + std::f64::consts::PI).with_translation(DVec3::new(3.0, -3.0, 0.5));
            scene.conventions.two_sided_emission = true;
            scene
        }
        Environment => under(of(wall(), WHITE, WHITE), FLAT_SKY),
        VaryingEnvironment | EnvironmentSampling => under(of(wall(), WHITE, WHITE), SKY),
        Roulette => {
            let mut scene = of(sphere(), WHITE, LAMP);
            let behind = scene.instances[0].material;
            let quad = scene.instances[1].mesh;
            place(&mut scene, quad, behind, DAffine3::from_translation(DVec3::new(0.0, 0.5, 0.0)));
            scene.integrator.roulette_from = Some(1);
            scene.integrator.max_depth = 8;
            scene
        }
        Instances => {
            let mut scene = of(sphere(), WHITE, LAMP);
            let (ball, m) = (scene.instances[0].mesh, scene.instances[0].material);
            let turned = DAffine3::from_rotation_z(0.3).with_translation(DVec3::new(0.7, 0.3, 0.1));
            place(&mut scene, ball, m, turned);
            scene
        }
        Displacement => {
            let mut scene = of(sphere(), WHITE, LAMP);
            let by = material(&mut scene, "displacement d() { P += 0.2 * N; }", &[]);
            scene.materials[0].displacement = Some(by);
            scene
        }
        Normals => of(sphere(), WHITE, LAMP),
        Uvs => lit("surface d() { Ci = u * diffuse(N); }"),
        Tangents => lit("surface d() { Ci = abs(dPdu[0]) * diffuse(N); }"),
        Derivatives => lit("surface d() { Ci = 10 * filterwidth(u) * diffuse(N); }"),
        SurfaceArea => lit("surface d() { Ci = 0.1 * surfacearea() * diffuse(N); }"),
        ObjectSpace => {
            let mut scene = lit("surface d() { Ci = abs(transform(\"object\", P)) * diffuse(N); }");
            scene.instances[0].transform = DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.3));
            scene
        }
        CameraSpace => lit("surface d() { Ci = abs(transform(\"camera\", P)) * diffuse(N); }"),
        OtherSpaces => lit("surface d() { Ci = abs(transform(\"NDC\", P)) * diffuse(N); }"),
        RayType => lit("surface d() { Ci = raytype(\"camera\") * diffuse(N); }"),
        Userdata => {
            let mut scene = lit("surface d(float worn = 0.5 [[ int lockgeom = 0 ]]) { Ci = worn * diffuse(N); }");
            scene.meshes[0].data =
                vec![VertexData { name: "worn".into(), channels: 1, values: vec![0.1, 0.2, 0.3, 0.9] }];
            scene
        }
        Attributes => {
            let mut scene = lit("surface d() { float k = 0; getattribute(\"team\", k); Ci = k * diffuse(N); }");
            let m = scene.instances[0].material;
            let other = mesh(&mut scene, wall());
            place(&mut scene, other, m, DAffine3::from_translation(DVec3::new(0.5, 0.5, 0.5)));
            scene.instances[0].attributes = vec![("team".to_owned(), ParamValue::Float(0.5))];
            scene.instances[2].attributes = vec![("team".to_owned(), ParamValue::Float(0.75))];
            scene
        }
        Interactive => lit("surface d(float live = 1 [[ int interactive = 1 ]]) { Ci = live * diffuse(N); }"),
        Messages => lit("surface d() { printf(\"here\"); Ci = diffuse(N); }"),
        Traces => lit(&format!("surface d() {{ Ci = trace({TRACED}) * diffuse(N); }}")),
        TraceSets => {
            lit(&format!("surface d() {{ Ci = (1 - trace({TRACED}, \"traceset\", \"-lamp\")) * diffuse(N); }}"))
        }
        TraceNames => lit(&format!(
            "surface d() {{ string n; trace({TRACED}); Ci = getmessage(\"trace\", \"geom:name\", n) && n == \"lamp\"
                ? diffuse(N) : 0; }}"
        )),
        PointClouds => {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("effects");
            std::fs::create_dir_all(&folder).expect("a folder for clouds");
            let text = "ATTRIBUTES\nposition\nTYPES\nV\nNUMBER_OF_PARTICLES: 1\nBEGIN DATA\n0 0 0\n";
            std::fs::write(folder.join("one.pda"), text).expect("a cloud is written");
            let mut scene = lit("surface d() { Ci = pointcloud_search(\"one.pda\", P, 0.5, 1) * diffuse(N); }");
            scene.textures = vec![folder];
            scene
        }
        Textures => textured(""),
        TextureCubic => textured(", \"interp\", \"cubic\""),
        TextureClosest => textured(", \"interp\", \"closest\""),
        Holdout => lit("surface d() { Ci = 0.5 * diffuse(N) + 0.5 * holdout(); }"),
        LobeOrenNayar => lobe("oren_nayar(N, 0.4)"),
        LobeTranslucent => {
            let mut scene = lobe("translucent(N)");
            // Lit from behind.
            scene.instances[1].transform = DAffine3::from_rotation_z(0.5).with_translation(DVec3::new(1.0, 3.0, 0.5));
            scene.instances[1].transform.matrix3 *= -1.0;
            under(scene, FLAT_SKY)
        }
        LobePhong => lobe("phong(N, 8)"),
        LobeWard => lobe("ward(N, dPdu, 0.3, 0.2)"),
        LobeMicrofacet => lobe("microfacet(\"ggx\", N, 0.3, 1.5, 0)"),
        LobeReflection => under(lobe("reflection(N, 1.5)"), SKY),
        LobeRefraction => under(lobe("refraction(N, 1.5)"), SKY),
        LobeTransparent => under(lobe("0.5 * transparent()"), SKY),
        LobeConductor => lobe("conductor_bsdf(N, dPdu, 0.3, 0.2, color(0.2), color(3), \"ggx\")"),
        LobeOrenNayarDiffuse => lobe("oren_nayar_diffuse_bsdf(N, color(0.5), 0.4)"),
        LobeBurleyDiffuse => lobe("burley_diffuse_bsdf(N, color(0.5), 0.4)"),
        LobeDielectric => under(lobe("dielectric_bsdf(N, dPdu, color(1), color(1), 0.2, 0.2, 1.5, \"ggx\")"), FLAT_SKY),
        LobeGeneralizedSchlick => under(
            lobe("generalized_schlick_bsdf(N, dPdu, color(1), color(0), 0.3, 0.3, color(0.1), color(1), 5, \"ggx\")"),
            FLAT_SKY,
        ),
        LobeSheen => lobe("sheen_bsdf(N, color(1), 0.5)"),
        LobeChiangHair => under(
            lobe(
                "chiang_hair_bsdf(N, dPdu, color(1), color(1), color(1), 1.5, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.1, \
                 color(0.2))",
            ),
            FLAT_SKY,
        ),
        LobeThinFilm => under(
            lobe(
                "conductor_bsdf(N, dPdu, 0.3, 0.3, color(0.2), color(3), \"ggx\", \"thinfilm_thickness\", 300.0, \
                 \"thinfilm_ior\", 1.4)",
            ),
            FLAT_SKY,
        ),
        SplitLobes => {
            lit("surface d() { Ci = color(0.5, 0, 0.2) * diffuse(N) + color(0, 0.5, 0) * oren_nayar(N, 0.4); }")
        }
        Adaptive => {
            let mut scene = lit(WHITE);
            scene.integrator.samples = 64;
            scene
        }
        DoublePrecision | SharedCubes | TrustedNormals => lit(WHITE),
    }
}

/// A scene that does without an effect.
fn spares(effect: Effect) -> Scene {
    use Effect::*;
    match effect {
        // What is there without anything in it.
        Surfaces | LobeDiffuse | Roulette | Normals => under(tiny(), SKY),
        // Both kinds of light are there.
        _ => {
            let scene = under(of(wall(), WHITE, LAMP), FLAT_SKY);
            if matches!(effect, Lights | VaryingLights | TwoSidedEmission) {
                return under(of(wall(), WHITE, WHITE), SKY);
            }
            if matches!(effect, Environment | VaryingEnvironment) {
                return lit(WHITE);
            }
            scene
        }
    }
}

/// What an effect has in the kernels: its macro, and what is there only for it.
fn symbols(effect: Effect) -> (&'static [&'static str], &'static [&'static str], &'static [&'static str]) {
    use Effect::*;
    // Texts; buffers; stages.
    match effect {
        Surfaces => (
            &["PATH_hit_u", "QUEUE_scatter ", "nearest_hit("],
            &["nodes", "triangles", "triangle_ids", "corners", "shapes"],
            &["follow_path"],
        ),
        ThinLens => (&[], &[], &[]),
        Lights => (&["sample_triangle_light("], &["lights", "light_words"], &[]),
        VaryingLights => (&["PATH_light_u"], &[], &["shade_light", "light_power"]),
        VaryingEnvironment => (&["QUEUE_environment "], &[], &["environment"]),
        EnvironmentSampling => (
            &["sample_environment(", "QUEUE_environment_light"],
            &["environment_cells", "environment_alias"],
            &["environment_light", "environment_map"],
        ),
        Instances => (&["PATHU_hit_instance"], &["instances", "instance_roots"], &[]),
        Normals => (&[], &["normals"], &[]),
        Uvs => (&[], &["uvs"], &[]),
        Derivatives => (&["PATH_cone_width", "footprint_surface("], &[], &[]),
        SurfaceArea => (&[], &["areas"], &[]),
        ObjectSpace => (&[], &["object_spaces"], &[]),
        OtherSpaces => (&[], &["other_spaces"], &[]),
        RayType => (&["PATHU_raytype"], &[], &[]),
        Userdata | Attributes => (&["material_userdata("], &["userdata", "userdata_places"], &[]),
        Interactive => (&["MATERIAL_INTERACTIVE"], &["interactive"], &[]),
        Messages => (&["record_open("], &["messages"], &[]),
        Traces => (&["scene_follow("], &[], &[]),
        TraceSets => (&["scene_set("], &["trace_sets"], &[]),
        TraceNames => (&["trace_names"], &["trace_names"], &[]),
        PointClouds => (&["cloud_nearest("], &["clouds"], &[]),
        Textures => (&["texture_node("], &["textures"], &[]),
        Holdout => (&["PATH_hole"], &[], &[]),
        SplitLobes => (&["PATHU_turn"], &[], &[]),
        Adaptive => (&["c->pixels["], &["pixels"], &[]),
        LobeThinFilm => (&["PATH_lobe_film"], &[], &[]),
        LobeDiffuse => (&["diffuse_eval("], &[], &[]),
        LobeOrenNayar => (&["oren_nayar_eval("], &[], &[]),
        LobeTranslucent => (&["translucent_eval("], &[], &[]),
        LobePhong => (&["phong_eval("], &[], &[]),
        LobeWard => (&["ward_eval("], &[], &[]),
        LobeMicrofacet => (&["microfacet_eval("], &[], &[]),
        LobeReflection => (&["reflection_sample("], &[], &[]),
        LobeRefraction => (&["refraction_sample("], &[], &[]),
        LobeTransparent => (&["transparent_sample("], &[], &[]),
        LobeConductor => (&["closure_conductor_bsdf"], &[], &[]),
        LobeOrenNayarDiffuse => (&["closure_oren_nayar_diffuse"], &[], &[]),
        LobeBurleyDiffuse => (&["closure_burley_diffuse"], &[], &[]),
        LobeDielectric => (&["closure_dielectric"], &[], &[]),
        LobeGeneralizedSchlick => (&["PATH_lobe_exponent"], &[], &[]),
        LobeSheen => (&["closure_sheen"], &[], &[]),
        LobeChiangHair => (&["PATH_lobe_c4"], &[], &[]),
        TentFilter | MiddleFilter | TwoSidedEmission | Environment | Roulette | Displacement | Tangents
        | CameraSpace | TextureCubic | TextureClosest | DoublePrecision | SharedCubes | TrustedNormals => {
            (&[], &[], &[])
        }
    }
}

/// The lines of a text that count: those in branches of `#if` that what was defined before them leaves out are dropped. Conditions of
/// other things than `defined` count as true both ways.
fn live(text: &str) -> String {
    let mut defined: BTreeSet<String> = BTreeSet::new();
    // Per open `#if`: whether this branch counts, and whether a branch did for sure.
    let mut open: Vec<(bool, bool)> = Vec::new();
    let mut out = String::new();
    for line in text.lines() {
        let counts = open.iter().all(|(on, _)| *on);
        let directive = line.trim_start();
        let (word, rest) = directive.split_once(char::is_whitespace).unwrap_or((directive, ""));
        let rest = rest.split("//").next().unwrap_or("").trim();
        match word {
            "#ifdef" | "#ifndef" | "#if" => {
                let value = match word {
                    "#ifdef" => Some(defined.contains(rest)),
                    "#ifndef" => Some(!defined.contains(rest)),
                    _ => condition(rest, &defined),
                };
                open.push((value != Some(false), value == Some(true)));
            }
            "#elif" => {
                if let Some((on, done)) = open.last_mut() {
                    let value = condition(rest, &defined);
                    *on = !*done && value != Some(false);
                    *done |= value == Some(true);
                }
            }
            "#else" => {
                if let Some((on, done)) = open.last_mut() {
                    *on = !*done;
                }
            }
            "#endif" => {
                open.pop();
            }
            _ if counts => {
                if word == "#define" {
                    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                    defined.insert(name);
                }
                let code = line.split("//").next().unwrap_or("");
                out.push_str(code);
                out.push('\n');
            }
            _ => {}
        }
    }
    out
}

/// `defined(A)`, `!defined(A)`, joined by `&&` or `||` and at most one level of parentheses around a disjunction.
fn condition(text: &str, defined: &BTreeSet<String>) -> Option<bool> {
    let term = |term: &str| {
        let (negated, name) = match term.trim().trim_matches(|c| c == '(' || c == ')').strip_prefix('!') {
            Some(rest) => (true, rest),
            None => (false, term.trim().trim_matches(|c| c == '(' || c == ')')),
        };
        let name = name.trim().strip_prefix("defined")?.trim().trim_matches(|c| c == '(' || c == ')');
        Some(defined.contains(name.trim()) != negated)
    };
    let any = |part: &str| part.split("||").map(term).try_fold(false, |all, t| Some(all | t?));
    let all = |part: &str| part.split("&&").map(any).try_fold(true, |all, t| Some(all & t?));
    // Without parentheses `&&` binds more tightly.
    if text.contains("&&") && text.contains("||") && !text.contains("((") && !text.contains("&& (") {
        return text.split("||").map(all).try_fold(false, |any, t| Some(any | t?));
    }
    all(text)
}

/// The line that defines an effect's macro.
fn definition(effect: Effect) -> String {
    match effect {
        // Userdata and attributes come in one array.
        Effect::Attributes => "#define HAS_USERDATA".to_owned(),
        other => format!("#define {}", other.macro_name()),
    }
}

fn is_defined(text: &str, effect: Effect) -> bool {
    let line = definition(effect);
    text.lines().any(|l| l.strip_prefix(&line).is_some_and(|rest| rest.is_empty() || rest.starts_with(' ')))
}

/// The tests take every fourth effect each: the device is one, but texts and materials are prepared beside it. Unless
/// OSLCL_SLOW_TESTS asks for all, only every eighth of those: each is a set of programs to build.
fn quarter(which: usize) -> impl Iterator<Item = Effect> {
    let all = std::env::var_os("OSLCL_SLOW_TESTS").is_some();
    let (first, step) = if all { (which, 4) } else { (5 * which, 32) };
    Effect::choosable().skip(first).step_by(step)
}

fn forced_changes_nothing(effects: impl Iterator<Item = Effect>) {
    let mut wrong = Vec::new();
    for effect in effects {
        let scene = spares(effect);
        let plain = make(&scene, &[], &[], Precision::Standard);
        let forced = make(&scene, &[effect], &[], Precision::Standard);
        let (texts, buffers, stages) = symbols(effect);
        let code = live(&plain.text);
        if is_defined(&code, effect) {
            wrong.push(format!("{}: its macro is there unasked", effect.name()));
        }
        for text in texts.iter().filter(|t| code.contains(**t)) {
            wrong.push(format!("{}: `{text}` is there unasked", effect.name()));
        }
        for buffer in buffers.iter().filter(|b| plain.buffers.contains(b)) {
            wrong.push(format!("{}: buffer {buffer} is there unasked", effect.name()));
        }
        for stage in stages.iter().filter(|s| plain.stages.contains(s)) {
            wrong.push(format!("{}: stage {stage} is launched unasked", effect.name()));
        }
        for buffer in buffers.iter().filter(|b| !forced.buffers.contains(b)) {
            wrong.push(format!("{}: forced, but buffer {buffer} is missing", effect.name()));
        }
        if !is_defined(&forced.text, effect) && !effect.is_of_materials() {
            wrong.push(format!("{}: forced, but its macro is missing", effect.name()));
        }
        if effect == Effect::DoublePrecision {
            // How numbers are computed, not what: the same picture but for rounding.
            let near = |a: &u32, b: &u32| (f32::from_bits(*a) - f32::from_bits(*b)).abs() < 1e-3;
            let pairs = plain.seen.pixels.iter().flatten().zip(forced.seen.pixels.iter().flatten());
            let off = pairs.filter(|(a, b)| !near(a, b)).count();
            if off > 3 {
                wrong.push(format!("double_precision: {off} numbers differ by more than rounding"));
            }
        } else if plain.seen != forced.seen {
            let off = plain.seen.pixels.iter().zip(&forced.seen.pixels).filter(|(a, b)| a != b).count();
            wrong.push(format!("{}: forced, it changes {off} pixels", effect.name()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn removed_is_missed(effects: impl Iterator<Item = Effect>) {
    let mut wrong = Vec::new();
    for effect in effects {
        let scene = needs(effect);
        let mut choices = Choices::default();
        match effect {
            Effect::DoublePrecision => choices.precision = Precision::Reference,
            Effect::SplitLobes => choices.set("lobes", "all").expect("a value"),
            Effect::Adaptive => choices.set("adaptive", "0.5").expect("a value"),
            _ => {}
        }
        let with = make(&scene, &[], &[], choices);
        let without = make(&scene, &[], &[effect], choices);
        let (texts, buffers, stages) = symbols(effect);
        let (code, left) = (live(&with.text), live(&without.text));
        if !is_defined(&code, effect) {
            wrong.push(format!("{}: asked for, but its macro is missing", effect.name()));
        }
        // Each of these is there when asked for, or nothing would be held by their absence elsewhere.
        for text in texts.iter().filter(|t| !code.contains(**t)) {
            wrong.push(format!("{}: `{text}` is missing", effect.name()));
        }
        for buffer in buffers.iter().filter(|b| !with.buffers.contains(b)) {
            wrong.push(format!("{}: buffer {buffer} is missing", effect.name()));
        }
        for stage in stages.iter().filter(|s| !with.stages.contains(s)) {
            wrong.push(format!("{}: stage {stage} is missing", effect.name()));
        }
        for buffer in buffers.iter().filter(|b| without.buffers.contains(b)) {
            wrong.push(format!("{}: removed, but buffer {buffer} is there", effect.name()));
        }
        for stage in stages.iter().filter(|s| without.stages.contains(s)) {
            wrong.push(format!("{}: removed, but stage {stage} is launched", effect.name()));
        }
        if left.len() > code.len() && effect != Effect::DoublePrecision && effect != Effect::Instances {
            wrong.push(format!("{}: removed, but there is more code than before", effect.name()));
        }
        if with.seen == without.seen {
            wrong.push(format!("{}: nothing changes without it", effect.name()));
        }
        let start = format!("warning: without `{}`: {} (asked for by ", effect.name(), effect.missed());
        if !without.warnings.iter().any(|w| w.starts_with(&start)) {
            wrong.push(format!("{}: no warning; there are {:?}", effect.name(), without.warnings));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

macro_rules! quarters {
    ($check:ident: $($name:ident $which:literal),*) => {
        $(#[test]
        fn $name() {
            $check(quarter($which));
        })*
    };
}

quarters!(forced_changes_nothing: forced_changes_nothing_1 0, forced_changes_nothing_2 1, forced_changes_nothing_3 2,
    forced_changes_nothing_4 3);
quarters!(removed_is_missed: removed_is_missed_1 0, removed_is_missed_2 1, removed_is_missed_3 2, removed_is_missed_4 3);

#[test]
fn all_effects_together_change_nothing_either() {
    let all: Vec<Effect> = Effect::choosable().filter(|e| *e != Effect::DoublePrecision).collect();
    for scene in [under(lit(WHITE), SKY), under(tiny(), FLAT_SKY)] {
        let plain = make(&scene, &[], &[], Precision::Standard);
        let forced = make(&scene, &all, &[], Precision::Standard);
        assert_eq!(plain.seen, forced.seen);
    }
}

/// Where the sky is known without a shader, CPUs take the samples of a slot in a row (kernels/stages/trace.cl): more than a launch
/// takes of them, in a picture of more pixels than there are slots, with all that a sample's end counts.
#[test]
fn samples_in_a_row_are_the_same_samples() {
    let units = device().lock().unwrap_or_else(|e| e.into_inner()).info.units.clamp(1, 16);
    let side = f64::from(units * 8192 + 64).sqrt().ceil() as u32;
    let source = "surface h() { Ci = 0.3 * diffuse(N) + 0.2 * reflection(N) + 0.2 * holdout() + 0.1 * transparent(); }";
    let mut scene = under(of(sphere(), source, LAMP), FLAT_SKY);
    scene.film = Film { width: side, height: side };
    scene.integrator.samples = 70;
    for settings in
        [&[][..], &[("lobes", "all"), ("path_state", "half")], &[("adaptive", "0.01"), ("sampler", "independent")]]
    {
        let mut choices = Choices::default();
        settings.iter().for_each(|(name, value)| choices.set(name, value).unwrap_or_else(|e| panic!("{e}")));
        let alone = make(&scene, &[], &[], choices);
        let forced = make(&scene, &[Effect::VaryingEnvironment], &[], choices);
        assert_eq!(alone.counts, forced.counts, "{settings:?}");
        assert!(alone.seen == forced.seen, "{settings:?}: other bits");
    }
}

#[test]
fn conditions_decide_which_lines_count() {
    let text = "#define A\n#if defined(A) && !defined(B)\n1\n#else\n2\n#endif\n#ifdef B\n3\n#elif defined(A)\n4\n#else\n5\n#endif\n\
                #if defined(C) || defined(A)\n6\n#endif\n";
    assert_eq!(live(text), "#define A\n1\n4\n6\n");
}
