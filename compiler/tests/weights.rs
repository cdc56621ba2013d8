//! A lobe whose weight is the constant 0 leaves no code: for the weights of every shipped material, and on every way that a weight
//! can take to its lobe.

mod common;

use common::Beside;
use oslcl_compiler::artifact::{Artifact, Radiance};
use oslcl_compiler::{Binding, Connection, Group, Layer, Master, Options, compile};
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl")
}

fn artifact(text: &str, bindings: &[(&str, f64)]) -> Artifact {
    let bindings = bindings.iter().map(|(n, v)| ((*n).to_owned(), Binding::Float(*v))).collect();
    let options = Options { bindings, ..Options::default() };
    compile(text, &options, &Beside(folder())).unwrap_or_else(|e| panic!("{e}\n{text}")).artifact
}

fn shipped(name: &str) -> String {
    common::text(&folder().join(format!("{name}.osl")))
}

/// What is there: the lobes, and `emission` and `background`.
fn parts(artifact: &Artifact) -> Vec<&str> {
    let mut out: Vec<&str> = artifact.lobes.iter().map(String::as_str).collect();
    for (name, radiance) in [("emission", artifact.emission), ("background", artifact.background)] {
        out.extend((radiance != Radiance::None).then_some(name));
    }
    out
}

/// The code with another name for its function, which hangs on the parameters.
fn code(artifact: &Artifact) -> String {
    artifact.code.replace(&artifact.entry, "entry").replace(&artifact.name, "name")
}

/// Everything of a shipped material that a weight of 0 takes away: values of other parameters, the weight, what is there and what
/// is left. `1` as a weight for what counts as one minus it.
type Case = (
    &'static str,
    &'static [(&'static str, f64)],
    (&'static str, f64),
    &'static [&'static str],
    &'static [&'static str],
);

const ALL: &[(&str, f64)] = &[
    ("transmission", 0.5),
    ("metalness", 0.5),
    ("sheen", 0.5),
    ("coat", 0.5),
    ("film", 300.0),
    ("emission_color", 1.0),
];
const ALL_PARTS: &[&str] = &["conductor", "dielectric", "oren_nayar_diffuse", "sheen", "thin_film", "emission"];

const CASES: &[Case] = &[
    ("car_paint", &[], ("coat", 0.0), &["diffuse", "microfacet", "reflection"], &["diffuse", "microfacet"]),
    ("car_paint", &[], ("flake_amount", 0.0), &["diffuse", "microfacet", "reflection"], &["diffuse", "reflection"]),
    ("car_paint", &[], ("flake_amount", 1.0), &["diffuse", "microfacet", "reflection"], &["microfacet", "reflection"]),
    ("car_paint", &[], ("flake_color", 0.0), &["diffuse", "microfacet", "reflection"], &["diffuse", "reflection"]),
    ("car_paint", &[], ("pigment", 0.0), &["diffuse", "microfacet", "reflection"], &["microfacet", "reflection"]),
    ("car_paint", &[("coat", 0.0)], ("flake_amount", 0.0), &["diffuse", "microfacet"], &["diffuse"]),
    ("emitter", &[], ("radiance", 0.0), &["emission"], &[]),
    ("flat_sky", &[], ("radiance", 0.0), &["background"], &[]),
    ("glass", &[], ("tint", 0.0), &["reflection", "refraction"], &["reflection"]),
    ("marble", &[], ("polish", 0.0), &["diffuse", "microfacet"], &["diffuse"]),
    ("matte", &[], ("Cs", 0.0), &["diffuse"], &[]),
    ("matte", &[("roughness", 0.5)], ("Cs", 0.0), &["oren_nayar"], &[]),
    ("matte", &[("roughness", 0.5)], ("roughness", 0.0), &["oren_nayar"], &["diffuse"]),
    ("matte_noise", &[], ("Kd", 0.0), &["diffuse"], &[]),
    ("matte_noise", &[], ("Cs", 0.0), &["diffuse"], &[]),
    ("plastic", &[], ("Cs", 0.0), &["diffuse", "microfacet"], &["microfacet"]),
    ("rough_glass", &[], ("tint", 0.0), &["microfacet"], &[]),
    ("sky", &[], ("intensity", 0.0), &["background"], &[]),
    ("standard_surface", ALL, ("emission_color", 0.0), ALL_PARTS, &ALL_PARTS_BUT_EMISSION),
    (
        "standard_surface",
        ALL,
        ("sheen", 0.0),
        ALL_PARTS,
        &["conductor", "dielectric", "oren_nayar_diffuse", "thin_film", "emission"],
    ),
    (
        "standard_surface",
        ALL,
        ("sheen_color", 0.0),
        ALL_PARTS,
        &["conductor", "dielectric", "oren_nayar_diffuse", "thin_film", "emission"],
    ),
    (
        "standard_surface",
        ALL,
        ("metalness", 0.0),
        ALL_PARTS,
        &["dielectric", "oren_nayar_diffuse", "sheen", "thin_film", "emission"],
    ),
    (
        "standard_surface",
        ALL,
        ("metalness", 1.0),
        ALL_PARTS,
        &["conductor", "dielectric", "sheen", "thin_film", "emission"],
    ),
    (
        "standard_surface",
        ALL,
        ("transmission", 1.0),
        ALL_PARTS,
        &["conductor", "dielectric", "sheen", "thin_film", "emission"],
    ),
    (
        "standard_surface",
        ALL,
        ("film", 0.0),
        ALL_PARTS,
        &["conductor", "dielectric", "oren_nayar_diffuse", "sheen", "emission"],
    ),
    // The same lobe stays where something else needs it.
    ("standard_surface", ALL, ("coat", 0.0), ALL_PARTS, ALL_PARTS),
    ("standard_surface", ALL, ("specular", 0.0), ALL_PARTS, ALL_PARTS),
    (
        "standard_surface",
        &[("coat", 0.0), ("specular", 0.0)],
        ("transmission", 0.0),
        &["oren_nayar_diffuse"],
        &["oren_nayar_diffuse"],
    ),
    (
        "standard_surface",
        &[("specular", 0.0)],
        ("coat", 0.0),
        &["dielectric", "oren_nayar_diffuse"],
        &["oren_nayar_diffuse"],
    ),
    (
        "standard_surface",
        &[("coat", 0.0)],
        ("specular", 0.0),
        &["dielectric", "oren_nayar_diffuse"],
        &["oren_nayar_diffuse"],
    ),
    ("standard_surface", &[("coat", 0.0), ("specular", 0.0)], ("base_color", 0.0), &["oren_nayar_diffuse"], &[]),
    ("textured", &[], ("tint", 0.0), &["diffuse"], &[]),
    ("wood", &[], ("varnish", 0.0), &["diffuse", "microfacet"], &["diffuse"]),
];
const ALL_PARTS_BUT_EMISSION: [&str; 5] = ["conductor", "dielectric", "oren_nayar_diffuse", "sheen", "thin_film"];

#[test]
fn a_weight_of_zero_takes_its_part_of_a_shipped_material_away() {
    for (name, others, weight, with, without) in CASES {
        let text = shipped(name);
        if others.iter().all(|(n, _)| *n != weight.0) {
            assert_eq!(parts(&artifact(&text, others)), *with, "{name} {others:?}");
        }
        let mut bound: Vec<_> = others.iter().copied().filter(|(n, _)| *n != weight.0).collect();
        bound.push(*weight);
        let left = artifact(&text, &bound);
        assert_eq!(parts(&left), *without, "{name} {bound:?}\n{}", left.code);
        // No call of what is gone, no header of it.
        for gone in with.iter().filter(|p| !without.contains(p) && **p != "thin_film") {
            let own = [format!("closure_{gone}"), format!("bsdf/{gone}.h"), format!("{gone}0")];
            for symbol in own {
                assert!(!left.code.contains(&symbol), "{name} {bound:?}: {symbol}\n{}", left.code);
            }
        }
    }
}

/// The code is the same as of a shader that never had the part.
#[test]
fn what_a_weight_of_zero_leaves_is_the_shader_without_the_part() {
    let paint = shipped("car_paint");
    let bare = paint
        .replace("    float Kr, Kt;\n    fresnel(I, N, 1 / coat_ior, Kr, Kt);\n    float under = 1 - coat * Kr;\n", "")
        .replace("Ci = under * (", "Ci = (")
        .replace("\n       + coat * reflection(N, coat_ior);", ";");
    assert!(!bare.contains("fresnel") && !bare.contains("reflection"), "{bare}");
    assert_eq!(code(&artifact(&paint, &[("coat", 0.0)])), code(&artifact(&bare, &[])));

    let surface = shipped("standard_surface");
    let start = surface.find("    if (coat > 0)").expect("a coat");
    let end = surface.find("    Ci = body;").expect("an end");
    let bare = format!("{}{}", &surface[..start], &surface[end..]);
    let all = &ALL[..3];
    let uncoated: Vec<_> = all.iter().copied().chain([("coat", 0.0)]).collect();
    assert_eq!(code(&artifact(&surface, &uncoated)), code(&artifact(&bare, all)));
}

/// Statements that end with `reflection` of weight `w` in Ci, beside a diffuse lobe.
const WAYS: &[&str] = &[
    "Ci = diffuse(N) + w * reflection(N);",
    "Ci = diffuse(N) + w * noise(P) * (1 - u) * reflection(N);",
    "Ci = diffuse(N) + w / (1 + u) * reflection(N);",
    "Ci = diffuse(N) + color(w) * color(u, v, 1) * reflection(N);",
    "Ci = diffuse(N) + color(\"hsv\", 0.5, 0, w) * reflection(N);",
    "Ci = diffuse(N) + pow(w, 2) * sqrt(w) * smoothstep(0, 1, w) * reflection(N);",
    "Ci = layer(w * reflection(N), diffuse(N));",
    "Ci = layer(w * (u * reflection(N) + v * reflection(N, 1.3)), diffuse(N));",
    "Ci = layer(diffuse(N), w * reflection(N));",
    "Ci = layer(0.5 * diffuse(N), layer(w * reflection(N), translucent(N)));",
    "Ci = mix(diffuse(N), reflection(N), w);",
    "Ci = mix(diffuse(N), reflection(N), color(w));",
    "Ci = mix(reflection(N), diffuse(N), 1 - w);",
    "Ci = mix(0, w, u) * reflection(N) + diffuse(N);",
    "color t = mix(color(0), color(w), u); Ci = diffuse(N) + t * reflection(N);",
    "Ci = diffuse(N); if (w > 0) Ci += reflection(N);",
    "Ci = diffuse(N); if (w > 0 && u > 0.5) Ci += reflection(N);",
    "Ci = diffuse(N); if (u > 0.5 || v > 0.5) Ci += w * reflection(N);",
    "Ci = diffuse(N); if (w == 0) return; Ci += reflection(N);",
    "Ci = diffuse(N); closure color c = reflection(N); c *= w; Ci += c;",
    "closure color c = 0; for (int i = 0; i < 3; i++) c += w * reflection(N, 1 + i); Ci = diffuse(N) + c;",
    "float k = 0; for (int i = 0; i < int(8 * u); i++) k += w * noise(P + i); Ci = diffuse(N) + k * reflection(N);",
    "float k = w; while (k > 0.5) { k -= u; } Ci = diffuse(N) + (w > 0) * reflection(N);",
    "float k = 0; if (u > 0.5) k = w; else k = w * v; Ci = diffuse(N) + k * reflection(N);",
    "float k = 0; if (u > 0.5) { k = w; if (v > 0.5) k += w * P[0]; } Ci = diffuse(N) + k * reflection(N);",
    "float k = u > 0.5 ? w : w * v; Ci = diffuse(N) + k * reflection(N);",
    "closure color c = u > 0.5 ? reflection(N) : diffuse(N); Ci = diffuse(N) + w * c;",
    "Ci = diffuse(N) + scaled(w, u) * reflection(N);",
    "Ci = diffuse(N) + coat(w, N);",
    "pair p; p.a = w; p.b = u; Ci = diffuse(N) + p.a * p.b * reflection(N);",
    "float a[3] = {w, w * u, 0}; Ci = diffuse(N) + a[int(3 * v)] * reflection(N);",
    "float a[3] = {w, u, v}; Ci = diffuse(N) + a[0] * reflection(N);",
    "color c = 0; c[1] = w; Ci = diffuse(N) + c * reflection(N);",
    "color c = 0; c[int(3 * u)] = w; Ci = diffuse(N) + c * reflection(N);",
    "Ci = diffuse(N) + -w * reflection(N);",
];

/// A shader that goes one of these ways.
fn by(way: &str) -> String {
    format!(
        "struct pair {{ float a; float b; }};
         float scaled(float x, float y) {{ if (y > 0.5) return x; return x * y; }}
         closure color coat(float x, normal n) {{ if (x > 0) return x * reflection(n); return 0; }}
         surface way(float w = 0) {{ {way} }}"
    )
}

#[test]
fn a_weight_of_zero_leaves_nothing_whatever_way_it_takes() {
    for way in WAYS {
        let text = by(way);
        let there = artifact(&text, &[("w", 1.0)]);
        assert!(there.lobes.iter().any(|l| l == "reflection"), "{way}: {:?}", there.lobes);
        let left = artifact(&text, &[]);
        assert!(!left.lobes.iter().any(|l| l == "reflection"), "{way}: {:?}\n{}", left.lobes, left.code);
        assert!(!left.code.contains("reflection"), "{way}\n{}", left.code);
        assert!(left.lobes.iter().any(|l| l == "diffuse"), "{way}: {:?}", left.lobes);
    }
}

/// A group of a layer that gives a weight, with this value of `x`, and one that goes a way.
fn connected(giver: &str, way: &str, x: f64) -> Artifact {
    let master = |text: &str| {
        Arc::new(Master::new(text, &Options::default(), &Beside(folder())).unwrap_or_else(|e| panic!("{e}\n{text}")))
    };
    let layer = |name: &str, text: &str| Layer { name: name.to_owned(), master: master(text), bindings: Vec::new() };
    let group = Group {
        name: "group".to_owned(),
        layers: vec![layer("giver", giver), layer("taker", &by(way))],
        connections: vec![Connection {
            from_layer: "giver".to_owned(),
            from: "o".to_owned(),
            to_layer: "taker".to_owned(),
            to: "w".to_owned(),
        }],
        ..Group::default()
    };
    let bindings = vec![("giver.x".to_owned(), Binding::Float(x))];
    let options = Options { bindings, ..Options::default() };
    group.instance(&options).unwrap_or_else(|e| panic!("{e}\n{giver}\n{way}")).artifact
}

#[test]
fn a_connected_layer_that_yields_zero_leaves_nothing() {
    const GIVERS: &[&str] = &[
        "shader giver(float x = 1, output float o = 1) { o = x; }",
        "shader giver(float x = 1, output float o = 1) { o = x * noise(P); }",
        "shader giver(float x = 1, output float o = 1) { if (x > 0) o = x; else o = 0; }",
        "shader giver(float x = 1, output float o = 1) { color c = x * color(1, u, v); o = c[0] + c[1]; }",
        "shader giver(float x = 1, output float o = 1) { o = 0; if (u > 0.5) o += x; }",
    ];
    for giver in GIVERS {
        for way in WAYS {
            let there = connected(giver, way, 1.0);
            assert!(there.lobes.iter().any(|l| l == "reflection"), "{giver} {way}: {:?}", there.lobes);
            let left = connected(giver, way, 0.0);
            assert!(!left.code.contains("reflection"), "{giver} {way}\n{}", left.code);
        }
    }
}

/// What can change later, or from point to point, is not taken for the constant that it starts with.
#[test]
fn a_weight_that_can_change_keeps_its_lobe() {
    let text = by(WAYS[0]).replace("float w = 0", "float w = 0 [[ int interactive = 1 ]]");
    let options = Options { interactive: true, ..Options::default() };
    let live = compile(&text, &options, &Beside(folder())).unwrap_or_else(|e| panic!("{e}")).artifact;
    assert_eq!(parts(&live), ["diffuse", "reflection"]);
    let text = by(WAYS[0]).replace("float w = 0", "float w = 0 [[ int lockgeom = 0 ]]");
    assert_eq!(parts(&artifact(&text, &[])), ["diffuse", "reflection"]);
}
