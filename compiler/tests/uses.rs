//! Where a shader uses what a renderer provides, and which parameters decide: places are lines of the source, and a value that is
//! said to take something away takes it away.

mod common;

use common::Beside;
use oslcl_compiler::artifact::{Artifact, Use};
use oslcl_compiler::{Binding, Options, compile};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl")
}

fn explained(text: &str, bindings: &[(String, Binding)]) -> Artifact {
    let options = Options { bindings: bindings.to_vec(), explain: true, ..Options::default() };
    compile(text, &options, &Beside(folder())).unwrap_or_else(|e| panic!("{e}\n{text}")).artifact
}

/// `WHAT LINE: PARAMETER, PARAMETER = VALUE ends at END, ...`
fn print(used: &Use) -> String {
    let control = |c: &oslcl_compiler::artifact::Control| {
        let value = c.value.as_ref().map_or(String::new(), |v| format!(" = {v}"));
        let off = c.off_at.as_ref().map_or(String::new(), |v| format!(" ends at {v}"));
        format!("{}{value}{off}", c.param)
    };
    let controls: Vec<String> = used.controls.iter().map(control).collect();
    format!("{} {}: {}", used.what, used.line, controls.join(", ")).trim_end_matches(": ").to_owned()
}

fn check(text: &str, expect: &[&str]) {
    let artifact = explained(text, &[]);
    let globals = |u: &&Use| !u.what.starts_with("global ");
    let uses: Vec<String> = artifact.uses.iter().filter(globals).map(print).collect();
    assert_eq!(uses, expect, "{text}");
}

#[test]
fn a_use_has_its_place_and_the_parameters_that_decide() {
    check("surface s(float w = 0.5)\n{\n  Ci = w * diffuse(N);\n}", &["lobe_diffuse 3: w = 0.5 ends at 0"]);
    check(
        "surface s(float w = 0.5, color c = color(1, 0, 0), float ior = 1.5, int on = 1)\n{\n  Ci = mix(c * diffuse(N), reflection(N, ior), w);\n  if (on)\n    Ci += translucent(N);\n}",
        &[
            "lobe_diffuse 3: w = 0.5 ends at 1, c = (1, 0, 0) ends at 0",
            "lobe_reflection 3: w = 0.5 ends at 0",
            "lobe_translucent 5: on = 1 ends at 0",
        ],
    );
    // The weight of the base hangs on all that covers it; how rough it is decides nothing.
    check(
        "surface s(float coat = 1, float rough = 0.3)\n{\n  Ci = layer(coat * microfacet(\"ggx\", N, rough, 1.5, 0), diffuse(N));\n}",
        &["lobe_microfacet 3: coat = 1 ends at 0", "lobe_diffuse 3: coat = 1, rough = 0.3"],
    );
    check(
        "surface s(string file = \"a.tif\", string space = \"camera\", float k = 1)\n{\n  color c = 1;\n  if (file != \"\")\n    c = texture(file, u, v);\n  if (k > 0)\n    c *= transform(space, P)[0] * surfacearea();\n  Ci = c * diffuse(N);\n}",
        &[
            "lobe_diffuse 8: file = \"a.tif\", space = \"camera\", k = 1",
            "texture a.tif 5: file = \"a.tif\" ends at \"\"",
            "camera_space 7: space = \"camera\" ends at \"\", k = 1 ends at 0",
            "surface_area 7: k = 1 ends at 0",
            "derivatives 5: file = \"a.tif\" ends at \"\"",
        ],
    );
}

fn binding(value: &str, ty: &str) -> Binding {
    match ty {
        "string" => Binding::Str(value.trim_matches('"').to_owned()),
        "int" => Binding::Int(value.parse().expect("an int")),
        _ => Binding::Float(value.parse().expect("a number")),
    }
}

/// Of the shipped materials, as they are and with all their parts on.
#[test]
fn what_is_said_to_take_a_part_away_does() {
    let all = [("transmission", 0.5), ("metalness", 0.5), ("sheen", 0.5), ("film", 300.0), ("emission_color", 1.0)];
    let mut ends = Vec::new();
    for path in common::shaders(&folder()) {
        let text = common::text(&path);
        let name = common::name(&path);
        let plain = explained(&text, &[]);
        let on: Vec<(String, Binding)> = all
            .iter()
            .filter(|(n, _)| plain.info.params.iter().any(|p| p.name == *n))
            .map(|(n, v)| ((*n).to_owned(), Binding::Float(*v)))
            .collect();
        for bound in [Vec::new(), on] {
            let artifact = explained(&text, &bound);
            for (used, control) in artifact.uses.iter().flat_map(|u| u.controls.iter().map(move |c| (u, c))) {
                let ty = &artifact.info.params.iter().find(|p| p.name == control.param).expect("a parameter").ty;
                assert_eq!(text.lines().nth(control.line as usize - 1).map(|l| l.contains(&control.param)), Some(true));
                let Some(end) = &control.off_at else { continue };
                let mut bound: Vec<_> = bound.iter().filter(|(n, _)| *n != control.param).cloned().collect();
                bound.push((control.param.clone(), binding(end, ty)));
                let left = explained(&text, &bound);
                let there = left.uses.iter().any(|u| u.what == used.what && u.line == used.line);
                assert!(!there, "{name}: {} at {end}: {}", control.param, print(used));
                ends.push(format!("{name} {} {} {end}", used.what, control.param));
            }
        }
    }
    for expected in [
        "car_paint.osl lobe_reflection coat 0",
        "car_paint.osl lobe_microfacet flake_amount 0",
        "car_paint.osl lobe_diffuse flake_amount 1",
        "standard_surface.osl lobe_sheen sheen 0",
        "standard_surface.osl lobe_conductor metalness 0",
        "standard_surface.osl lobe_oren_nayar_diffuse metalness 1",
        "standard_surface.osl lobe_thin_film film 0",
        "standard_surface.osl emission emission_color 0",
        "wood.osl lobe_microfacet varnish 0",
        "emitter.osl emission radiance 0",
    ] {
        assert!(ends.iter().any(|e| e == expected), "{expected}: {ends:#?}");
    }
}
