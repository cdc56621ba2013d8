//! Runs `oslcl plan` as users do: the table, its JSON, and what `--measure` says.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const SCENE: &str = r#"[camera]
origin = [0, -4, 1]
target = [0, 0, 0]
lens_radius = 0.1
[film]
width = 16
height = 12
[integrator]
samples = 1
roulette = false
[materials.paint]
shader = "car_paint"
params = { flake_amount = 0.0,
  coat = 0.8 }
[materials.clay]
osl = "surface clay() { Ci = 0.5 * oren_nayar_diffuse_bsdf(N, color(1), 0.2); }"
[environment]
shader = "flat_sky"
[[meshes]]
name = "one"
shape = "quad"
size = 2
material = "paint"
[[meshes]]
name = "two"
shape = "sphere"
material = "clay"
[[meshes]]
name = "three"
shape = "sphere"
material = "clay"
[[meshes]]
name = "four"
shape = "sphere"
material = "clay"
"#;

/// A folder with the scene.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("plan").join(test);
    fs::create_dir_all(&path).expect("a folder for the test");
    fs::write(path.join("s.toml"), SCENE).expect("a scene");
    path
}

/// Standard output and standard error of a plan.
fn plan(at: &Path, args: &[&str]) -> (String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
    command.current_dir(at).args(["plan", "s.toml", "--cache-dir", "cache"]).args(args).stdin(Stdio::null());
    let output = command.output().expect("oslcl starts");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{args:?}: {out}{err}");
    (out.into_owned(), err.into_owned())
}

fn json(at: &Path, args: &[&str]) -> Value {
    let (out, _) = plan(at, &[args, &["--json"]].concat());
    serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}"))
}

fn effect<'a>(plan: &'a Value, name: &str) -> &'a Value {
    let all = plan["effects"].as_array().expect("effects");
    all.iter().find(|e| e["effect"] == name).unwrap_or_else(|| panic!("{name} is not in the plan"))
}

#[test]
fn the_table_has_what_is_on_first_and_the_rest_in_one_list() {
    let at = folder("table");
    let (out, err) = plan(&at, &[]);
    assert_eq!(err, "");
    let (on, off) = out.split_once("\noff (").unwrap_or_else(|| panic!("{out}"));
    for row in [
        "surfaces",
        "thin_lens",
        "environment",
        "normals",
        "lobe_diffuse",
        "lobe_oren_nayar_diffuse",
        "lobe_reflection",
    ] {
        // A name, blanks, the state: never run together.
        let is_row = |l: &&str| l.split_whitespace().take(2).eq([row, "on"]);
        assert!(on.lines().any(|l| is_row(&l)), "{row}: {out}");
    }
    assert!(off.contains("thin_film") && off.contains("double_precision") && !off.contains("lobe_reflection"), "{out}");
    for line in [
        "    asked for by camera (s.toml:4): lens_radius = 0.1",
        "    asked for by material `paint` (s.toml:11)",
        "      at shaders-osl/car_paint.osl:20, controlled by coat = 0.8 (s.toml:14; 0 leaves it out)",
        "    adds macros HAS_LOBE_REFLECTION",
        "    and by 1 more (-v names them)",
    ] {
        assert!(on.lines().any(|l| l == line), "{line}: {out}");
    }
    assert!(!out.contains("mesh `four`"), "{out}");
    let (all, err) = plan(&at, &["-v"]);
    assert_eq!(err, "", "the log is for -vv");
    assert!(
        all.contains("mesh `four` (s.toml:32): has normals") && all.contains("  material `paint`: follow_path"),
        "{all}"
    );
}

#[test]
fn what_is_forced_or_left_out_is_told() {
    let at = folder("overrides");
    let args = ["--without", "thin_lens", "--force", "raytype"];
    let (out, err) = plan(&at, &args);
    let warning = "warning: without `thin_lens`: all distances are in focus (asked for by camera (s.toml:4): lens_radius = 0.1)\n";
    assert_eq!(err, warning);
    assert!(
        out.contains("left out, though the scene calls for it:\n  thin_lens: all distances are in focus\n"),
        "{out}"
    );
    assert!(out.lines().any(|l| l.split_whitespace().take(2).eq(["raytype", "forced"])), "{out}");
    let plan = json(&at, &args);
    let lens = effect(&plan, "thin_lens");
    assert_eq!((&lens["on"], &lens["left_out"], &lens["forced"]), (&false.into(), &true.into(), &false.into()));
    assert_eq!(lens["warning"], warning.trim_end());
    assert_eq!(plan["warnings"][0], warning.trim_end());
    let raytype = effect(&plan, "raytype");
    assert_eq!((&raytype["on"], &raytype["forced"]), (&true.into(), &true.into()));
    assert_eq!(raytype["bytes_per_path"], 4);
}

#[test]
fn what_is_forced_in_vain_is_noted_once() {
    let at = folder("in-vain");
    let (_, err) = plan(&at, &["--force", "trace_sets", "--force", "userdata", "--force", "raytype"]);
    let note =
        "note: forcing `userdata`, `traces` and `trace_sets` adds no code: only materials that ask for it bring it\n";
    assert_eq!(err, note);
}

#[test]
fn json_has_all_of_it() {
    let plan = json(&folder("json"), &[]);
    let coat = effect(&plan, "lobe_reflection");
    assert_eq!(coat["macros"], serde_json::json!(["HAS_LOBE_REFLECTION"]));
    assert!(coat["kernels"].as_array().is_some_and(|k| k.iter().any(|k| k["program"] == "material `paint`")), "{coat}");
    let asker = &coat["asked_by"][0];
    assert_eq!((&asker["file"], &asker["line"]), (&"s.toml".into(), &11.into()));
    let place = &asker["shader"][0];
    assert_eq!((&place["file"], &place["line"]), (&"shaders-osl/car_paint.osl".into(), &20.into()));
    let decider = serde_json::json!({
        "parameter": "coat", "value": "0.8", "off_at": "0", "file": "s.toml", "line": 14, "set_by_scene": true
    });
    assert_eq!(place["controlled_by"], serde_json::json!([decider]));
    let off = effect(&plan, "lobe_microfacet");
    assert_eq!(
        (&off["on"], &off["asked_by"], &off["kernels"]),
        (&false.into(), &Value::Array(vec![]), &Value::Array(vec![]))
    );
    assert!(plan["programs"][0]["macros"].as_array().is_some_and(|m| m.contains(&"HAS_SURFACES".into())));
}

#[test]
fn what_an_effect_costs_is_measured() {
    let at = folder("measure");
    let args = ["--measure", "--size", "8x6", "--spp", "2", "--runs", "2"];
    let (out, _) = plan(&at, &args);
    assert!(out.lines().next().is_some_and(|l| l.ends_with("to") && l.contains("ms/sample")), "{out}");
    assert!(
        out.contains("without it the picture is wrong by ") && out.contains(": all distances are in focus"),
        "{out}"
    );
    assert!(out.contains("\na sample as planned: "), "{out}");
    let plan = json(&at, &args);
    assert_eq!(plan["measured"]["seconds_per_sample"].as_array().map(Vec::len), Some(2));
    let lens = &effect(&plan, "thin_lens")["measured"];
    assert!(lens["seconds_per_sample"].is_number() && lens["difference"].as_f64().is_some_and(|d| d > 0.0), "{lens}");
    assert_eq!(lens["wrong"], "all distances are in focus");
    assert!(effect(&plan, "holdout").get("measured").is_none(), "what is off is measured with -v alone");
}
