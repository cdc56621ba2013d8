//! Runs the `oslcl` command as users do: what it writes, and how it fails.
//!
//! Each failure has to name its object and cause, end with a non-zero code, and leave neither a panic nor a partial file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// What a run said.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

/// An empty folder of the test's own.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder for the test");
    path
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn command(at: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
    command.current_dir(at).args(args).stdin(Stdio::null());
    command
}

fn finish(output: Output) -> Run {
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the output is UTF-8");
    let run = Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
    assert!(!run.err.contains("panicked"), "{}", run.err);
    assert!(run.code.is_some(), "killed by a signal");
    run
}

fn oslcl(at: &Path, args: &[&str]) -> Run {
    finish(command(at, args).output().expect("oslcl starts"))
}

/// The run ends with this code and its message has all these parts.
fn fails(run: &Run, code: i32, parts: &[&str]) {
    assert_eq!(run.code, Some(code), "out: {}\nerr: {}", run.out, run.err);
    for part in parts {
        assert!(run.err.contains(part), "`{part}` is not in: {}", run.err);
    }
}

fn succeeds(run: &Run) {
    assert_eq!(run.code, Some(0), "out: {}\nerr: {}", run.out, run.err);
}

/// Names of all that lies in a folder, sorted.
fn listing(at: &Path) -> Vec<String> {
    let entries = fs::read_dir(at).expect("a folder").flatten();
    let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn write(at: &Path, name: &str, text: impl AsRef<[u8]>) {
    fs::write(at.join(name), text).expect("a file for the test");
}

const GOOD: &str = "surface good(float Kd = 0.5, output color Cout = 0) { Cout = Kd; Ci = Cout * diffuse(N); }";
const BROKEN: &str = "surface broken()\n{\n    Ci = diffuse(N)\n}\n";

#[test]
fn a_missing_file_is_named() {
    let at = folder("missing");
    for verb in ["compile", "check", "info", "shade"] {
        fails(&oslcl(&at, &[verb, "nowhere.osl"]), 1, &["nowhere.osl", "No such file"]);
    }
    assert!(listing(&at).is_empty());
}

#[test]
fn a_misspelt_material_gets_a_suggestion() {
    let at = folder("misspelt");
    fails(&oslcl(&at, &["info", "mate"]), 1, &["`mate`", "did you mean `matte`?"]);
}

#[test]
fn a_folder_and_binary_data_are_no_sources() {
    let at = folder("no_source");
    fails(&oslcl(&at, &["check", "."]), 1, &["cannot read `.`"]);
    write(&at, "bin.osl", b"surface a()\n{\xff}");
    fails(&oslcl(&at, &["check", "bin.osl"]), 1, &["bin.osl", "not UTF-8", "line 2"]);
    write(&at, "empty.osl", "");
    fails(&oslcl(&at, &["check", "empty.osl"]), 1, &["empty.osl", "no shader"]);
}

#[test]
fn a_syntax_error_names_file_line_and_cause() {
    let at = folder("syntax");
    write(&at, "broken.osl", BROKEN);
    for verb in ["compile", "check", "info", "shade"] {
        fails(&oslcl(&at, &[verb, "broken.osl"]), 1, &["broken.osl:3:", "error[E1", "expected `;`"]);
    }
    assert_eq!(listing(&at), ["broken.osl"]);
}

#[test]
fn wrong_usage_is_code_2() {
    let at = folder("usage");
    write(&at, "good.osl", GOOD);
    fails(&oslcl(&at, &[]), 2, &["Usage"]);
    fails(&oslcl(&at, &["paint"]), 2, &["paint"]);
    fails(&oslcl(&at, &["compile"]), 2, &["FILES"]);
    fails(&oslcl(&at, &["shade", "good.osl", "--grid", "0", "1"]), 2, &["--grid", "0"]);
    fails(&oslcl(&at, &["shade", "good.osl", "--precision", "best"]), 2, &["best", "standard"]);
    fails(&oslcl(&at, &["shade", "good.osl", "-o", "Cout"]), 2, &["`--output Cout`", "PARAM=FILE"]);
    fails(&oslcl(&at, &["shade", "good.osl", "-o", "Cout=a.png"]), 2, &["a.png", ".exr"]);
    fails(&oslcl(&at, &["shade", "good.osl", "-p", "Kd"]), 2, &["`--param Kd`", "NAME=VALUE"]);
    fails(&oslcl(&at, &["compile", "good.osl", "../good.osl", "-o", "x"]), 2, &["good.osl", "same files"]);
    fails(&oslcl(&at, &["compile", "good.osl", "b.osl", "-p", "Kd=1"]), 2, &["--param", "one file"]);
    let emit = oslcl(&at, &["compile", "good.osl", "-o", "x.oslpak", "--emit", "spirv"]);
    fails(&emit, 2, &["--emit does not go with a package: `x.oslpak` holds OpenCL C and SPIR-V"]);
    for given in ["x.oslpak", "x.oslpak:good", "NAME=x.oslpak"] {
        let again = oslcl(&at, &["compile", given, "-o", "y.oslpak"]);
        fails(&again, 2, &["is a package: packages are made of sources", "`oslcl compile x.oslpak` takes it apart"]);
    }
    assert_eq!(listing(&at), ["good.osl"]);
}

#[test]
fn parameters_are_checked() {
    let at = folder("params");
    write(&at, "good.osl", GOOD);
    let unknown = oslcl(&at, &["shade", "good.osl", "-p", "kd=1"]);
    fails(&unknown, 1, &["good.osl", "error[E4001]", "no parameter `kd`", "`Kd`"]);
    let text = oslcl(&at, &["compile", "good.osl", "-p", "Kd=high"]);
    fails(&text, 1, &["good.osl:1:", "error[E4002]", "parameter `Kd` is float", "\"high\""]);
    let triple = oslcl(&at, &["compile", "good.osl", "-p", "Kd=1,2,3"]);
    fails(&triple, 1, &["parameter `Kd` is float"]);
    let output = oslcl(&at, &["shade", "good.osl", "-o", "Nope=a.exr"]);
    fails(&output, 1, &["good.osl", "no output parameter `Nope`", "Cout"]);
    assert_eq!(listing(&at), ["good.osl"]);
}

#[test]
fn a_folder_that_takes_no_files_is_named() {
    let at = folder("unwritable");
    write(&at, "good.osl", GOOD);
    // A file where a folder is wanted: refused to everybody, root too.
    write(&at, "taken", "x");
    fails(&oslcl(&at, &["compile", "good.osl", "-o", "taken"]), 1, &["cannot write `taken`"]);
    fails(&oslcl(&at, &["compile", "good.osl", "-o", "taken/below"]), 1, &["cannot write `taken/below`"]);
    fails(&oslcl(&at, &["shade", "good.osl", "-o", "Cout=taken/c.exr"]), 1, &["cannot write `taken/c.exr`"]);
    fails(&oslcl(&at, &["shade", "good.osl", "-o", "Cout=nowhere/c.exr"]), 1, &["cannot write `nowhere/c.exr`"]);
    assert_eq!(listing(&at), ["good.osl", "taken"]);
}

#[test]
fn a_file_that_can_not_be_replaced_leaves_its_sibling_alone() {
    let at = folder("sibling");
    write(&at, "good.osl", GOOD);
    write(&at, "good.cl", "old");
    fs::create_dir(at.join("good.json")).expect("a folder in the way");
    fails(&oslcl(&at, &["compile", "good.osl"]), 1, &["cannot write `good.json`"]);
    assert_eq!(fs::read_to_string(at.join("good.cl")).expect("the old file"), "old");
    assert_eq!(listing(&at), ["good.cl", "good.json", "good.osl"]);
}

#[test]
fn an_error_in_one_file_does_not_stop_the_others() {
    let at = folder("several");
    write(&at, "broken.osl", BROKEN);
    write(&at, "broken.cl", "old");
    write(&at, "good.osl", GOOD);
    let run = oslcl(&at, &["compile", "broken.osl", "nowhere.osl", "good.osl"]);
    fails(&run, 1, &["broken.osl:3:", "nowhere.osl"]);
    assert!(run.out.contains("good.cl"), "{}", run.out);
    assert_eq!(fs::read_to_string(at.join("broken.cl")).expect("the old file"), "old");
    assert_eq!(listing(&at), ["broken.cl", "broken.osl", "good.cl", "good.json", "good.osl"]);
    let run = oslcl(&at, &["check", "broken.osl", "good.osl"]);
    fails(&run, 1, &["broken.osl:3:"]);
    assert!(run.out.contains("good.osl: ok"), "{}", run.out);
}

#[test]
fn without_a_device_the_cause_and_the_cure_are_said() {
    let at = folder("no_device");
    write(&at, "good.osl", GOOD);
    fs::create_dir(at.join("vendors")).expect("a folder");
    for args in [&["devices"][..], &["shade", "good.osl", "-o", "Cout=c.exr"]] {
        let output = command(&at, args).env("OCL_ICD_VENDORS", at.join("vendors")).output();
        fails(&finish(output.expect("oslcl starts")), 1, &["no OpenCL device found", "help: install a driver"]);
    }
    assert_eq!(listing(&at), ["good.osl", "vendors"]);
}

#[test]
fn an_unknown_device_is_named_with_those_there_are() {
    let at = folder("unknown_device");
    write(&at, "good.osl", GOOD);
    for device in ["Voodoo", "99"] {
        let run = oslcl(&at, &["shade", "good.osl", "--device", device, "-o", "Cout=c.exr"]);
        fails(&run, 1, &["no OpenCL device matches", device, "0: "]);
    }
    assert_eq!(listing(&at), ["good.osl"]);
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let at = folder("pipe");
    write(&at, "good.osl", GOOD);
    let cases = [&["devices"][..], &["info", "good.osl"], &["shade", "good.osl", "-g", "300", "300"], &["--help"]];
    for args in cases {
        let mut child = command(&at, args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("oslcl starts");
        drop(child.stdout.take());
        let run = finish(child.wait_with_output().expect("oslcl ends"));
        assert_eq!(run.err, "", "{args:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let at = folder("full");
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let run = finish(command(&at, &["info", "matte"]).stdout(full).output().expect("oslcl starts"));
    fails(&run, 1, &["standard output", "No space left"]);
}

#[test]
fn includes_are_found_and_missed() {
    let at = folder("includes");
    fs::create_dir_all(at.join("a/near")).expect("a folder");
    fs::create_dir_all(at.join("lib")).expect("a folder");
    write(
        &at,
        "a/main.osl",
        "#include \"near/one.h\"\n#include <far.h>\nshader m(output float x = 0) { x = ONE + FAR + D; }",
    );
    write(&at, "a/near/one.h", "#include \"two.h\"\n");
    write(&at, "a/near/two.h", "#define ONE 1\n");
    let args = ["shade", "a/main.osl", "-D", "D=40"];
    fails(&oslcl(&at, &args), 1, &["a/main.osl:2:", "far.h"]);
    write(&at, "lib/far.h", b"\xff");
    let with_lib = [&args[..], &["-I", "lib"]].concat();
    fails(&oslcl(&at, &with_lib), 1, &["a/main.osl:2:", "lib/far.h", "not UTF-8"]);
    write(&at, "lib/far.h", "#define FAR 100\n");
    let run = oslcl(&at, &with_lib);
    succeeds(&run);
    assert_eq!(run.out, "x 141\n");
}

#[test]
fn every_shipped_material_compiles_and_builds_alone() {
    let at = folder("shipped");
    let mut files = Vec::new();
    for name in listing(&root().join("shaders-osl")).iter().filter(|n| n.ends_with(".osl")) {
        files.push(root().join("shaders-osl").join(name).to_string_lossy().into_owned());
    }
    assert!(files.len() >= 10);
    let args: Vec<&str> = ["compile", "-o", "out/deep"].into_iter().chain(files.iter().map(String::as_str)).collect();
    succeeds(&oslcl(&at, &args));
    let device = oslcl_runtime::device::Device::open(None).expect("an OpenCL device");
    let mut seen = 0;
    for name in listing(&at.join("out/deep")) {
        let text = fs::read_to_string(at.join("out/deep").join(&name)).expect("a file");
        if name.ends_with(".json") {
            let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            assert!(json["entry"].is_string() && json["info"]["params"].is_array(), "{name}");
            seen += 1;
        } else if ["car_paint.cl", "metal.cl", "rough_glass.cl"].contains(&name.as_str()) {
            let options = oslcl_runtime::precision::Precision::Standard.build_options();
            let built = oslcl_runtime::device::Program::build(&device, &name, &text, options);
            assert!(built.is_ok(), "{:?}", built.err());
        }
    }
    assert_eq!(seen, files.len());
}

#[test]
fn info_is_text_or_json() {
    let at = folder("info");
    write(&at, "good.osl", GOOD);
    let run = oslcl(&at, &["info", "--json", "good.osl"]);
    succeeds(&run);
    let json: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    assert_eq!(json["name"], "good");
    assert_eq!(json["params"][0]["name"], "Kd");
    assert_eq!(json["params"][0]["default"], 0.5);
    let run = oslcl(&at, &["info", "good.osl"]);
    succeeds(&run);
    for part in ["surface good", "float Kd = 0.5", "output color Cout"] {
        assert!(run.out.contains(part), "{}", run.out);
    }
}

#[test]
fn shade_prints_all_outputs_or_ci() {
    let at = folder("print");
    write(&at, "good.osl", GOOD);
    let run = oslcl(&at, &["shade", "good.osl", "-p", "Kd=0.25"]);
    succeeds(&run);
    assert_eq!(run.out, "Cout 0.25 0.25 0.25\n");
    let source = "surface s() { Ci = u * diffuse(N) + v * emission(); }";
    write(&at, "none.osl", source);
    let run = oslcl(&at, &["shade", "none.osl", "--grid", "2", "1"]);
    succeeds(&run);
    assert_eq!(run.out, "0 0 Ci 0.5 0.5 0.5\n1 0 Ci 1.5 1.5 1.5\n");
}

/// Channels R, G, B of an EXR file, interleaved, with its size.
fn read_exr(path: &Path) -> (usize, usize, Vec<f32>) {
    use exr::prelude::*;
    let image = read_first_flat_layer_from_file(path).expect("an EXR file");
    let size = image.layer_data.size;
    let mut data = vec![0.0; size.area() * 3];
    for channel in &image.layer_data.channel_data.list {
        let at = ["R", "G", "B"].iter().position(|c| channel.name == **c).expect("channels R, G and B");
        channel.sample_data.values_as_f32().enumerate().for_each(|(i, v)| data[i * 3 + at] = v);
    }
    (size.width(), size.height(), data)
}

#[test]
fn shade_agrees_with_the_reference_implementation() {
    let at = folder("reference");
    let reference = root().join("tests/reference/osl");
    let source = reference.join("matte_noise.osl").to_string_lossy().into_owned();
    let (width, height, wanted) = read_exr(&reference.join("matte_noise.exr"));
    for precision in ["fast", "standard", "reference"] {
        let args = ["shade", &source, "--grid", "256", "256", "-o", "Cout=c.exr", "--precision", precision];
        succeeds(&oslcl(&at, &args));
        let (w, h, values) = read_exr(&at.join("c.exr"));
        assert_eq!((w, h), (width, height));
        let worst = values.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // Noise has slopes up to about 10 at a frequency of 5: some units in the last place of P, no more.
        assert!(worst < 1e-5, "{precision}: {worst}");
    }
    assert_eq!(listing(&at), ["c.exr"]);
}

/// A malformed group in a scene is reported where it stands in the scene's file.
#[test]
fn malformed_groups_name_the_line_of_the_scene() {
    let at = folder("malformed_groups");
    let head = "[camera]\norigin = [0, -4, 0]\ntarget = [0, 0, 0]\n\
        [[meshes]]\nname = \"ball\"\nshape = \"sphere\"\nmaterial = \"m\"\n[materials.m]\n";
    let texts = [
        ("group = \"shader matte a; bogus a.x b.y;\"", "scene.toml:9:26: shader group: "),
        ("group = \"\"\"\nshader matte a;\n  bogus a.x b.y;\n\"\"\"", "scene.toml:11:3: shader group: "),
    ];
    for (line, place) in texts {
        fs::write(at.join("scene.toml"), format!("{head}{line}\n")).expect("a scene");
        fails(&oslcl(&at, &["plan", "scene.toml"]), 1, &["E4017", place]);
    }
}

#[test]
fn every_form_is_written() {
    let at = folder("emit");
    write(&at, "good.osl", GOOD);
    succeeds(&oslcl(&at, &["compile", "good.osl", "--emit", "spirv,ir", "--emit", "json"]));
    assert_eq!(listing(&at), ["good.ir", "good.json", "good.osl", "good.spv", "good.spv.cl"]);
    let words = fs::read(at.join("good.spv")).expect("a module");
    assert_eq!(words[..4], [0x03, 0x02, 0x23, 0x07], "the magic number, lowest byte first");
    assert!(fs::read_to_string(at.join("good.ir")).expect("the IR").contains("good"));
    let bridge = fs::read_to_string(at.join("good.spv.cl")).expect("the bridge");
    assert!(bridge.contains("_il(") && !bridge.contains("#include"), "it stands alone");
    succeeds(&oslcl(&at, &["compile", "good.osl", "--emit", "spirv", "--precision", "reference"]));
    assert_ne!(fs::read(at.join("good.spv")).expect("a module"), words);
    fails(&oslcl(&at, &["compile", "good.osl", "--emit", "exe"]), 2, &["exe", "bitcode"]);
}

#[test]
fn an_output_can_be_named() {
    let at = folder("emit-named");
    write(&at, "good.osl", GOOD);
    write(&at, "other.osl", GOOD);
    succeeds(&oslcl(&at, &["compile", "good.osl", "--emit", "spirv", "-o", "new/x.spv"]));
    assert_eq!(listing(&at.join("new")), ["x.spv", "x.spv.cl"]);
    succeeds(&oslcl(&at, &["compile", "good.osl", "-o", "here.cl"]));
    assert_eq!(listing(&at), ["good.osl", "here.cl", "here.json", "new", "other.osl"]);
    fails(&oslcl(&at, &["compile", "good.osl", "-o", "x.spv"]), 2, &["`x.spv`", "add --emit spirv"]);
    fails(&oslcl(&at, &["compile", "good.osl", "other.osl", "-o", "x.cl"]), 2, &["one file"]);
}

#[test]
fn missing_tools_are_named() {
    let at = folder("tools");
    write(&at, "good.osl", GOOD);
    let run = |args: &[&str]| finish(command(&at, args).env("PATH", "/nowhere").output().expect("oslcl starts"));
    let bitcode = run(&["compile", "good.osl", "--emit", "bitcode"]);
    fails(
        &bitcode,
        1,
        &["for bitcode three tools", "clang: none", "llvm-link: none", "llvm-spirv: none", "apt-get install"],
    );
    // What was not asked for can't be left out.
    assert!(!bitcode.err.contains("--road"), "{}", bitcode.err);
    assert_eq!(listing(&at), ["good.osl"]);
    // A device that takes SPIR-V itself needs none; one that takes nothing of the kind says so.
    let shade = run(&["shade", "good.osl", "--road", "spirv"]);
    let takes_it = shade.code == Some(0) && shade.out.contains("Cout 0.5");
    let says_why = shade.err.contains("apt-get install") || shade.err.contains("takes no SPIR-V");
    assert!(takes_it || says_why, "out: {}\nerr: {}", shade.out, shade.err);
}
