//! Runs `oslcl render`, `plan` and `compare` as users do: what they write, and how they fail.
//!
//! Each failure has to name its object and cause, end with a non-zero code, and leave neither a panic nor a partial file, nor
//! harm a good picture that was there before.

use oslcl_runtime::film::{self, Picture};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// What a run said.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

/// A folder of the test's own.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Folder {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("render").join(test);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder for the test");
        Folder(path)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.0.join(name), text).expect("a file for the test");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).expect("a file of the test")
    }

    fn picture(&self, name: &str) -> Picture {
        film::read_exr(&self.0.join(name)).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Names of all that lies here, sorted.
    fn listing(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("a folder").flatten();
        let mut names: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
        command.current_dir(&self.0).args(args).stdin(Stdio::null());
        command
    }

    fn oslcl(&self, args: &[&str]) -> Run {
        finish(self.command(args).output().expect("oslcl starts"))
    }

    /// Renders the scene `text` over a good picture, which has to survive; the message must have all these parts.
    fn refuses(&self, text: &str, parts: &[&str]) {
        self.write("s.toml", text);
        self.write("good.exr", "a good picture");
        let before = self.listing();
        fails(&self.oslcl(&["render", "s.toml", "-o", "good.exr"]), 1, parts);
        assert_eq!(self.read("good.exr"), b"a good picture", "the scene:\n{text}");
        assert_eq!(self.listing(), before, "the scene:\n{text}");
    }

    /// Renders the scene `text`, which has to work.
    fn accepts(&self, text: &str) -> Picture {
        self.write("s.toml", text);
        let run = self.oslcl(&["render", "s.toml", "-o", "p.exr", "--quiet"]);
        succeeds(&run);
        assert_eq!((run.out.as_str(), run.err.as_str()), ("", ""), "the scene:\n{text}");
        self.picture("p.exr")
    }
}

fn finish(output: Output) -> Run {
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the output is UTF-8");
    let run = Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
    assert!(!run.err.contains("panicked"), "{}", run.err);
    assert!(run.code.is_some(), "killed by a signal: {}", run.err);
    run
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

const CAMERA: &str = "[camera]\norigin = [0, -4, 1]\ntarget = [0, 0, 0]\n[film]\nwidth = 16\nheight = 12\n";
const SKY: &str = "[environment]\nshader = \"flat_sky\"\nparams = { radiance = [0.5, 0.6, 0.7] }\n";

/// A scene: camera, film and the rest.
fn scene(rest: &str) -> String {
    format!("{CAMERA}[integrator]\nsamples = 4\n{rest}")
}

/// A square of the material `m` under the sky. The material's table begins on line 9.
fn square(material: &str) -> String {
    scene(&format!(
        "[materials.m]\n{material}\n[[meshes]]\nname = \"q\"\nshape = \"quad\"\nsize = 2\nmaterial = \"m\"\n{SKY}"
    ))
}

/// A mesh from a file under the sky.
fn mesh(file: &str, shader: &str) -> String {
    scene(&format!(
        "[materials.m]\nshader = \"{shader}\"\n[[meshes]]\nname = \"a\"\nfile = \"{file}\"\nmaterial = \"m\"\n{SKY}"
    ))
}

/// An ASCII PLY file.
fn ply(vertices: &[&str], faces: &[&str]) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n{}\n{}\n",
        vertices.len(),
        faces.len(),
        vertices.join("\n"),
        faces.join("\n")
    )
}

#[test]
fn unknown_and_unreadable_scenes_are_named() {
    let at = Folder::new("no_scene");
    fs::create_dir(at.0.join("dir")).expect("a folder");
    at.write("binary.toml", b"\xff\xfe");
    for args in [&["render", "SCENE", "-o", "p.exr"][..], &["plan", "SCENE"], &["plan", "SCENE", "--json"]] {
        let run = |scene| at.oslcl(&args.iter().map(|a| if *a == "SCENE" { scene } else { *a }).collect::<Vec<_>>());
        fails(&run("nowhere.toml"), 1, &["nowhere.toml: cannot read this scene", "No such file"]);
        fails(&run("dir"), 1, &["dir: cannot read this scene", "directory"]);
        fails(&run("binary.toml"), 1, &["binary.toml: cannot read this scene", "UTF-8"]);
    }
    assert_eq!(at.listing(), ["binary.toml", "dir"]);
}

#[test]
fn scene_files_are_checked() {
    let at = Folder::new("scene_file");
    at.refuses(&format!("{CAMERA}[materials.m\n"), &["s.toml:7:", "not valid TOML"]);
    at.refuses(&CAMERA.replace("width = 16", "width = 0"), &["s.toml:5:9: `film.width` must be", "1 to 65536, not 0"]);
    at.refuses(&scene(""), &["s.toml", "nothing to see"]);
    at.refuses(
        &square("shader = \"matte\"").replace("material = \"m\"", "material = \"n\""),
        &["s.toml:15:12", "no material named `n`"],
    );
    at.refuses(&square("shader = \"mate\""), &["s.toml:10:10", "`mate`", "did you mean `matte`?"]);
    at.refuses(&square("shader = \"gone.osl\""), &["s.toml:", "cannot read the shader `gone.osl`", "No such file"]);
    fails(&at.oslcl(&["plan", "s.toml"]), 1, &["s.toml:", "cannot read the shader `gone.osl`"]);
}

#[test]
fn meshes_are_checked() {
    let at = Folder::new("mesh");
    at.refuses(&mesh("gone.ply", "matte"), &["s.toml:", "cannot read the mesh `gone.ply`", "No such file"]);
    at.write("a.ply", ply(&["0 0 0", "nan 0 0", "0 1 0"], &["3 0 1 2"]));
    let said = ["a.ply:11: malformed PLY: `nan` is not a finite number in the line `nan 0 0`"];
    at.refuses(&mesh("a.ply", "matte"), &said);
    at.write("a.ply", ply(&["0 0 0", "0 0", "0 1 0"], &["3 0 1 2"]));
    at.refuses(&mesh("a.ply", "matte"), &["a.ply:11: malformed PLY: the line `0 0`"]);
    at.write("a.ply", "ply\nformat fancy 1.0\nend_header\n");
    at.refuses(&mesh("a.ply", "matte"), &["a.ply:2: malformed PLY", "`format fancy 1.0`"]);
    let text = ply(&["0 0 0", "0 0 0", "0 1 0"], &["3 0 1 2"]);
    let (header, _) = text.split_once("end_header\n").expect("it ends");
    let mut bytes = format!("{}end_header\n", header.replace("ascii", "binary_little_endian")).into_bytes();
    for number in [0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(f32::to_le_bytes(number));
    }
    at.write("truncated.ply", &bytes);
    at.refuses(&mesh("truncated.ply", "matte"), &["truncated.ply: the file is truncated", "`face`"]);
    bytes.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    at.write("a.ply", bytes);
    at.refuses(&mesh("a.ply", "matte"), &["a.ply: vertex 1 is not finite"]);
    at.write("a.ply", ply(&["0 0 0", "1 0 0", "0 1 0"], &["3 0 1 3"]));
    at.refuses(&mesh("a.ply", "matte"), &["a.ply: face 0 uses vertex 3, but there are 3"]);
    at.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    at.refuses(&mesh("a.obj", "matte"), &["a.obj:4: face 0 uses vertex 9, but there are 3"]);
}

#[test]
fn materials_are_checked() {
    let at = Folder::new("material");
    let unknown = square("shader = \"matte\"\nparams = { kd = 1.0 }");
    at.refuses(&unknown, &["s.toml: in material `m`", "error[E4001]", "no parameter `kd`", "its parameters: Cs"]);
    let text = square("shader = \"matte\"\nparams = { Cs = \"red\" }");
    at.refuses(&text, &["in material `m`", "matte.osl:4:11: error[E4002]", "`Cs` is color", "\"red\""]);
    at.write("broken.osl", "surface broken()\n{\n    Ci = diffuse(N)\n}\n");
    let broken =
        ["in material `m`", "broken.osl:4:1: error[E1001]: expected `;`", "}\n", "^", "broken.osl:3:19: after this"];
    at.refuses(&square("shader = \"broken.osl\""), &broken);
    fails(&at.oslcl(&["plan", "s.toml"]), 1, &broken);
    at.write("cycle.osl", "#include \"a.h\"\nsurface cycle() {}\n");
    at.write("a.h", "#include \"b.h\"\n");
    at.write("b.h", "#include \"a.h\"\n");
    at.refuses(
        &square("shader = \"cycle.osl\""),
        &["in material `m`", "error[E0002]", "includes itself: ", "a.h -> b.h"],
    );
    at.write("volume.osl", "volume smoke() { Ci = 0; }\n");
    at.refuses(&square("shader = \"volume.osl\""), &["s.toml: material `m`: `smoke` is a volume shader"]);
}

#[test]
fn osl_in_a_scene_has_the_lines_of_the_scene() {
    let at = Folder::new("inline");
    let long = square("osl = \"\"\"\nsurface m()\n{\n    Ci = difuse(N);\n}\n\"\"\"");
    at.refuses(&long, &["in material `m`", "s.toml:13:10: error[E2001]", "`difuse`", "did you mean `diffuse`?"]);
    let short = square("osl = 'surface m() { Ci = difuse(N); }'");
    at.refuses(&short, &["s.toml:10:27: error[E2001]"]);
    at.accepts(&square("osl = 'surface m() { Ci = diffuse(N); }'"));
}

#[test]
fn names_of_materials_may_have_any_character() {
    let at = Folder::new("names");
    let odd = r#""a\"b\n*/ \\ {é""#;
    let text = square("shader = \"matte\"");
    at.accepts(&text.replace("[materials.m]", &format!("[materials.{odd}]")).replace("\"m\"", odd));
}

#[test]
fn a_warning_is_shown_but_not_when_quiet() {
    let at = Folder::new("dark");
    at.refuses(&scene("[environment]\nshader = \"matte\"\n"), &["s.toml", "its environment is black", "background()"]);
    let lit = square("shader = \"emitter\"").replace(SKY, "[environment]\nshader = \"matte\"\n");
    let bright = at.accepts(&lit);
    assert!(bright.pixels.iter().any(|p| p[0] > 0.0));
    let run = at.oslcl(&["render", "s.toml", "-o", "p.exr"]);
    succeeds(&run);
    assert!(run.err.contains("warning: the environment is black: material `environment`"), "{}", run.err);
    let run = at.oslcl(&["plan", "s.toml"]);
    succeeds(&run);
    assert!(run.err.contains("warning: the environment is black"), "{}", run.err);
}

#[test]
fn outputs_are_checked_before_the_work() {
    let at = Folder::new("output");
    at.write("s.toml", square("shader = \"matte\""));
    at.write("file", "x");
    fs::create_dir(at.0.join("dir.exr")).expect("a folder");
    let cases = [
        ("p.jpg", &["p.jpg", ".exr or .png"][..]),
        ("p", &["p: ", ".exr or .png"]),
        ("nowhere/p.exr", &["nowhere/p.exr", "no folder nowhere"]),
        // A file where a folder is wanted: refused to everybody, root too.
        ("file/p.png", &["file/p.png", "no folder file"]),
        ("dir.exr", &["dir.exr", "folder"]),
    ];
    for (output, parts) in cases {
        fails(&at.oslcl(&["render", "s.toml", "-o", output]), 1, parts);
        // The output is looked at first: the work may be long.
        fails(&at.oslcl(&["render", "nowhere.toml", "-o", output]), 1, parts);
    }
    #[cfg(target_os = "linux")]
    fails(&at.oslcl(&["render", "s.toml", "-o", "/proc/p.exr"]), 1, &["/proc/p.exr: cannot write"]);
    assert_eq!(at.listing(), ["dir.exr", "file", "s.toml"]);
}

#[test]
fn devices_are_checked() {
    let at = Folder::new("device");
    at.write("s.toml", square("shader = \"matte\""));
    at.write("p.exr", "a good picture");
    fs::create_dir(at.0.join("vendors")).expect("a folder");
    let render = ["render", "s.toml", "-o", "p.exr"];
    let output = at.command(&render).env("OCL_ICD_VENDORS", at.0.join("vendors")).output();
    let run = finish(output.expect("oslcl starts"));
    fails(&run, 1, &["no OpenCL device found", "help: install a driver"]);
    for device in ["Voodoo", "99", ""] {
        let run = at.oslcl(&[&render[..], &["--device", device]].concat());
        fails(&run, 1, &["no OpenCL device matches", &format!("`{device}`"), "0: "]);
    }
    assert_eq!(at.read("p.exr"), b"a good picture");
    assert_eq!(at.listing(), ["p.exr", "s.toml", "vendors"]);
    succeeds(&at.oslcl(&[&render[..], &["--device", "0"]].concat()));
}

#[test]
fn a_picture_that_exceeds_the_memory_is_refused_at_once() {
    let at = Folder::new("memory");
    at.write("s.toml", square("shader = \"matte\""));
    at.write("p.exr", "a good picture");
    let start = Instant::now();
    // In 64 bits the film alone takes 64 GiB. Should a device have that much, the limit of 2^30 pixels is met instead.
    let memory = oslcl_runtime::device::list().expect("a device").iter().map(|d| d.memory).max().unwrap_or(0);
    let size = if memory < 40 << 30 { "32768x32768" } else { "32769x32769" };
    let run = at.oslcl(&["render", "s.toml", "-o", "p.exr", "--size", size, "--precision", "reference"]);
    if memory < 40 << 30 {
        // Whichever is met first, the device's memory or its largest buffer.
        if run.err.contains("out of memory") {
            fails(
                &run,
                1,
                &["is out of memory: buffer `film` needs 64.00 GiB", "help: use fewer triangles or a smaller picture"],
            );
        } else {
            fails(&run, 1, &["takes no buffer of", "`film` would have 64.00 GiB"]);
        }
    } else {
        fails(&run, 1, &["s.toml: a picture of 32769 x 32769 pixels is too large"]);
    }
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
    assert_eq!(at.read("p.exr"), b"a good picture");
    assert_eq!(at.listing(), ["p.exr", "s.toml"]);
}

#[test]
fn wrong_numbers_are_code_2() {
    let at = Folder::new("usage");
    at.write("s.toml", square("shader = \"matte\""));
    let cases = [
        ("--size", "0x3"),
        ("--size", "3"),
        ("--size", "70000x1"),
        ("--spp", "0"),
        ("--spp", "20000000"),
        ("--depth", "0"),
        ("--depth", "5000"),
        ("--time", "0"),
        ("--time", "nan"),
        ("--seed", "x"),
        ("--precision", "best"),
        ("--exposure", "nan"),
    ];
    for (option, value) in cases {
        let run = at.oslcl(&["render", "s.toml", "-o", "p.exr", option, value]);
        fails(&run, 2, &[option, &format!("'{value}'")]);
    }
    fails(&at.oslcl(&["render", "s.toml"]), 2, &["--output"]);
    assert_eq!(at.listing(), ["s.toml"]);
}

#[test]
fn options_override_the_scene() {
    let at = Folder::new("options");
    at.write("s.toml", square("shader = \"matte\""));
    let run =
        at.oslcl(&["render", "s.toml", "-o", "p.exr", "--size", "20x10", "--spp", "3", "--depth", "2", "--seed", "7"]);
    succeeds(&run);
    assert_eq!(run.out, "");
    for part in ["p.exr, 3 samples per pixel\n", "device ", "effects ", "prepare ", "render ", "rays "] {
        assert!(run.err.contains(part), "`{part}` is not in: {}", run.err);
    }
    let picture = at.picture("p.exr");
    assert_eq!((picture.width, picture.height), (20, 10));
    let attribute = |name: &str| {
        let found = picture.attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.as_str()).unwrap_or_default()
    };
    let found = ["samples", "seed", "max_depth", "precision"].map(|name| attribute(&format!("oslcl:{name}")));
    assert_eq!(found, ["3", "7", "2", "standard"]);
}

#[test]
fn pictures_of_both_kinds_and_every_precision_agree() {
    let at = Folder::new("kinds");
    at.write("s.toml", square("shader = \"matte\""));
    for precision in ["fast", "standard", "reference"] {
        let name = format!("{precision}.exr");
        succeeds(&at.oslcl(&["render", "s.toml", "-o", &name, "--precision", precision, "-q"]));
        let mean = film::compare::mean(&at.picture(&name));
        let reference = film::compare::mean(&at.picture("fast.exr"));
        for (a, b) in mean.iter().zip(reference) {
            assert!((a - b).abs() < 0.02 * b, "{precision}: {a} and {b}");
        }
    }
    succeeds(&at.oslcl(&["render", "s.toml", "-o", "p.png", "-q"]));
    assert!(at.read("p.png").starts_with(b"\x89PNG\r\n"));
    let run = at.oslcl(&["compare", "standard.exr", "standard.exr"]);
    succeeds(&run);
    assert!(run.out.contains("relative MSE  0.000000") && run.out.contains("FLIP          0.000000"), "{}", run.out);
}

#[test]
fn the_same_seed_gives_the_same_file() {
    let at = Folder::new("seed");
    at.write("s.toml", square("shader = \"matte\""));
    for (name, seed) in [("a.exr", "5"), ("b.exr", "5"), ("c.exr", "6")] {
        // Large enough for its file to be written by several threads.
        succeeds(&at.oslcl(&["render", "s.toml", "-o", name, "--size", "256x256", "--seed", seed, "-q"]));
    }
    assert!(at.read("a.exr") == at.read("b.exr"), "two files of one seed differ");
    assert_ne!(at.picture("a.exr").pixels, at.picture("c.exr").pixels);
}

#[test]
fn time_ends_a_render_with_a_good_picture() {
    let at = Folder::new("time");
    at.write("s.toml", square("shader = \"matte\""));
    let run = at.oslcl(&["render", "s.toml", "-o", "p.exr", "--spp", "10000000", "--time", "0.5"]);
    succeeds(&run);
    assert!(run.err.contains(" of 10000000, stopped by --time"), "{}", run.err);
    let picture = at.picture("p.exr");
    let (_, taken) = picture.attributes.iter().find(|(name, _)| name == "oslcl:samples").expect("it is noted");
    assert!(run.err.contains(&format!("p.exr, {taken} samples per pixel")), "{}", run.err);
    // The compiling of kernels does not count: a tiny picture takes many samples in half a second.
    assert!(taken.parse::<u32>().expect("a number") > 4, "{taken}");
    assert_eq!(at.listing(), ["p.exr", "s.toml"]);
}

#[test]
fn triangles_without_area_are_no_trouble() {
    let at = Folder::new("area");
    let vertices = ["0 0 0", "1 0 0", "2 0 0", "0 0 1"];
    at.write("none.ply", ply(&vertices, &["3 0 1 2", "3 0 0 0", "3 3 3 1"]));
    at.write("some.ply", ply(&vertices, &["3 0 1 2", "3 0 0 0", "3 0 1 3"]));
    at.write("glow.osl", "surface glow() { Ci = (1 + abs(P[0])) * emission(); }\n");
    for (file, shader) in [("none.ply", "matte"), ("none.ply", "emitter"), ("none.ply", "glow.osl")] {
        let picture = at.accepts(&mesh(file, shader));
        let sky = picture.pixels[0];
        assert!(sky[0] > 0.0 && picture.pixels.iter().all(|p| *p == sky), "{file} of {shader}");
    }
    for shader in ["matte", "emitter", "glow.osl"] {
        let picture = at.accepts(&mesh("some.ply", shader));
        assert!(picture.pixels.iter().flatten().all(|x| x.is_finite()), "{shader}");
        assert!(picture.pixels.iter().any(|p| *p != picture.pixels[0]), "{shader}");
    }
}

#[test]
fn comparisons_are_checked() {
    let at = Folder::new("compare");
    let picture =
        |width, height| Picture { width, height, pixels: vec![[1.0; 3]; width * height], ..Picture::default() };
    film::write(&at.0.join("a.exr"), &picture(4, 3), 0.0).expect("it can be written");
    film::write(&at.0.join("b.exr"), &picture(3, 4), 0.0).expect("it can be written");
    at.write("text.exr", "no picture");
    fails(&at.oslcl(&["compare", "a.exr", "nowhere.exr"]), 1, &["nowhere.exr: cannot read", "No such file"]);
    fails(&at.oslcl(&["compare", "a.exr", "text.exr"]), 1, &["text.exr: cannot read"]);
    fails(&at.oslcl(&["compare", "a.exr", "b.exr"]), 1, &["a.exr has 4 x 3 pixels", "b.exr has 3 x 4"]);
    fails(&at.oslcl(&["compare", "a.exr"]), 2, &["REFERENCE"]);
}

#[test]
fn plans_are_text_or_json() {
    let at = Folder::new("plan");
    at.write("s.toml", square("shader = \"matte\""));
    let run = at.oslcl(&["plan", "s.toml"]);
    succeeds(&run);
    for part in ["effect", "lobe_diffuse", "programs:", "bytes per path: "] {
        assert!(run.out.contains(part), "`{part}` is not in: {}", run.out);
    }
    let run = at.oslcl(&["plan", "s.toml", "--json"]);
    succeeds(&run);
    let json: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    assert!(json["bytes_per_path"].as_u64().is_some_and(|n| n > 0), "{json}");
    assert_eq!(at.listing(), ["s.toml"]);
}

#[test]
fn shaders_are_compared_with_themselves_in_f64() {
    let at = Folder::new("shade-compare");
    // A third is off by a part of an ulp in f32; an index computed in floats jumps.
    at.write("s.osl", "shader s(output float third = 0, output int k = 0) { third = (1 + u) / 3; k = 7; }");
    for with in ["f64", "host"] {
        let run = at.oslcl(&["shade", "s.osl", "--compare", with, "-g", "5", "3"]);
        succeeds(&run);
        let row = |name: &str, precision: &str| -> Vec<f64> {
            let line = run.out.lines().find(|l| l.starts_with(&format!("{name} ")) && l.contains(precision));
            let line = line.unwrap_or_else(|| panic!("no {name} {precision} in {}", run.out));
            line.split_whitespace().skip(2).take(4).map(|n| n.parse().expect("a number")).collect()
        };
        for precision in ["fast", "standard"] {
            let third = row("third", precision);
            assert!(third[0] > 0.0 && third[0] < 4.0 && third[2] < 1e-6, "{precision}: {third:?}");
            assert_eq!(row("k", precision), [0.0; 4], "{precision}");
        }
        assert_eq!(run.out.contains("reference  "), with == "f64", "{}", run.out);
        assert!(run.out.contains("points     5 x 3, u from 0 to 1, v from 0 to 1"), "{}", run.out);
    }
    let moved = at.oslcl(&["shade", "s.osl", "-g", "3", "1", "--domain", "2", "5", "0", "1"]);
    succeeds(&moved);
    let thirds: Vec<f64> =
        moved.out.lines().filter(|l| l.contains("third")).filter_map(|l| l.rsplit(' ').next()?.parse().ok()).collect();
    assert_eq!(thirds, [1.0, 1.5, 2.0], "{}", moved.out);
    fails(&at.oslcl(&["shade", "s.osl", "--domain", "0", "inf", "0", "1"]), 2, &["--domain takes finite numbers"]);
    fails(&at.oslcl(&["shade", "s.osl", "--compare", "f16"]), 2, &["f16", "f64", "host"]);
}

#[test]
fn choices_are_checked_and_change_what_they_should() {
    let at = Folder::new("choices");
    at.write("s.toml", square("shader = \"matte\""));
    for (args, parts) in [
        (&["--set", "samplr=sobol"][..], ["--set samplr=sobol", "did you mean `sampler`?"]),
        (&["--set", "sampler"], ["--set sampler", "NAME=VALUE"]),
        (&["--set", "environment_map=100"], ["cannot be `100`", "a power of two"]),
        (&["--set", "adaptive=2"], ["cannot be `2`", "a relative error from 0.0001 to 1"]),
        (&["--profile", "best"], ["--profile best", "draft, standard, reference"]),
    ] {
        let run = at.oslcl(&[&["render", "s.toml", "-o", "p.exr", "--spp", "1"][..], args].concat());
        fails(&run, 2, &parts);
    }
    let both = ["render", "s.toml", "-o", "p.exr", "--set", "adaptive=0.1", "--target-error", "0.1"];
    fails(&at.oslcl(&both), 2, &["--target-error", "--set adaptive", "choose one"]);
    let picture = |name: &str, args: &[&str]| {
        let out = format!("{name}.exr");
        succeeds(&at.oslcl(&[&["render", "s.toml", "-o", &out, "--spp", "4"][..], args].concat()));
        at.picture(&out).pixels
    };
    let plain = picture("plain", &[]);
    assert_eq!(picture("standard", &["--profile", "standard"]), plain);
    assert_ne!(picture("independent", &["--set", "sampler=independent"]), plain);
    assert_eq!(picture("last", &["--set", "sampler=independent", "--set", "sampler=sobol"]), plain);
    assert_ne!(picture("short", &["--set", "depth=1"]), plain);
    picture("draft", &["--profile", "draft"]);
    // The open wall of one colour has no noise: of 64 samples, 24.
    let run = at.oslcl(&["render", "s.toml", "-o", "ended.exr", "--spp", "64", "--set", "adaptive=0.1"]);
    succeeds(&run);
    for part in ["adaptive   ", "% of the samples saved", "an error below 0.1"] {
        assert!(run.out.contains(part) || run.err.contains(part), "{} {}", run.out, run.err);
    }
    picture("reference", &["--profile", "reference"]);
}

#[test]
fn a_study_says_what_each_choice_costs() {
    let at = Folder::new("study");
    at.write("s.toml", square("shader = \"matte\""));
    let args = ["bench", "accuracy", "s.toml", "-o", "out", "--spp", "4", "--seeds", "2", "--references", "refs"];
    let run = at.oslcl(&[&args[..], &["--reference-spp", "64"]].concat());
    succeeds(&run);
    for name in ["default", "sampler=independent", "precision=fast", "depth=2", "profile draft", "spp=16"] {
        assert!(run.out.contains(&format!("| {name} |")), "{name}: {}", run.out);
    }
    let csv = String::from_utf8(at.read("out/accuracy-s.csv")).expect("text");
    let mse = |name: &str| -> f64 {
        let line = csv.lines().find(|l| l.starts_with(&format!("{name},"))).expect("a row");
        line.split(',').nth(4).and_then(|n| n.parse().ok()).expect("a number")
    };
    assert!(mse("spp=16") < 0.5 * mse("default"), "{csv}");
    let page = String::from_utf8(at.read("out/accuracy-s.md")).expect("text");
    assert!(page.contains("oslcl bench accuracy s.toml --spp 4 --seeds 2 --reference-spp 64"), "{page}");
    for plot in ["out/accuracy-s-mse.svg", "out/accuracy-s-flip.svg"] {
        assert!(String::from_utf8(at.read(plot)).expect("text").contains("sampler=independent"), "{plot}");
    }
    // The reference is kept, and made again where a file is damaged.
    let kept = std::fs::read_dir(at.0.join("refs")).expect("a folder").flatten().next().expect("a reference").path();
    let before = std::fs::read(&kept).expect("a picture");
    std::fs::write(&kept, &before[..before.len() / 2]).expect("damaged");
    succeeds(&at.oslcl(&[&args[..], &["--reference-spp", "64"]].concat()));
    assert_eq!(std::fs::read(&kept).expect("a picture"), before);
    fails(&at.oslcl(&["bench", "accuracy", "none.toml"]), 1, &["none.toml"]);
    fails(&at.oslcl(&["bench", "accuracy", "s.toml", "--seeds", "1"]), 2, &["--seeds"]);
}

#[test]
fn a_target_error_is_reached_and_said() {
    let at = Folder::new("target");
    at.write("s.toml", square("shader = \"matte\""));
    let samples = |error: &str, sampler: &str| -> f64 {
        let sampler = format!("sampler={sampler}");
        let run = at.oslcl(&["render", "s.toml", "-o", "p.exr", "--target-error", error, "--set", &sampler]);
        succeeds(&run);
        let line = run.err.lines().find(|l| l.starts_with("error ")).unwrap_or_else(|| panic!("{}", run.err));
        let reached: f64 = line.split_whitespace().nth(1).and_then(|n| n.parse().ok()).expect("a number");
        assert!(reached <= error.parse().expect("a number"), "{line}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let at = words.iter().position(|w| *w == "samples").expect("samples");
        words[at - 1].parse().expect("a number")
    };
    let (coarse, fine) = (samples("0.016", "independent"), samples("0.004", "independent"));
    // A quarter of the error takes 16 times the independent samples, give or take the steps.
    assert!(fine / coarse > 8.0 && fine / coarse < 32.0, "{coarse} {fine}");
    // Even ones are better by more than half here.
    let even = samples("0.004", "sobol");
    assert!(even < 0.5 * fine, "{even} of {fine}");
    for wrong in ["0", "1", "nan", "x"] {
        fails(&at.oslcl(&["render", "s.toml", "-o", "p.exr", "--target-error", wrong]), 2, &["--target-error"]);
    }
    fails(&at.oslcl(&["render", "s.toml", "-o", "p.exr", "--target-error", "0.1", "--spp", "3"]), 2, &["--spp"]);
}
