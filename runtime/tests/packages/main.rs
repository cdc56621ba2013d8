//! Packages of compiled shaders as users meet them: the same pictures as from OSL with no compiler at work, what may still be
//! set, and what is refused.

mod open;

use oslcl_compiler::artifact::ABI_VERSION;
use oslcl_runtime::package::{Package, file};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A folder of the test's own.
struct Place(PathBuf);

struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Run {
    fn succeeds(self) -> Run {
        assert_eq!(self.code, Some(0), "out: {}\nerr: {}", self.out, self.err);
        self
    }

    /// It ends with this code and says all of this.
    fn fails(self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, Some(code), "out: {}\nerr: {}", self.out, self.err);
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is not in: {}", self.err);
        }
    }
}

impl Place {
    fn new(test: &str) -> Place {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packages").join(test);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder for the test");
        Place(path)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.0.join(name), text).expect("a file for the test");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn oslcl(&self, args: &[&str]) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
        // Equal programs of several runs are built once.
        let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packages").join("programs");
        command.current_dir(&self.0).args(args).stdin(Stdio::null()).env("OSLCL_CACHE_DIR", kept);
        let output = command.output().expect("oslcl starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the output is UTF-8");
        let run = Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
        assert!(!run.err.contains("panicked"), "{}", run.err);
        run
    }

    /// Compiles files to a package.
    fn pack(&self, to: &str, args: &[&str]) -> Run {
        self.oslcl(&[&["compile", "-o", to], args].concat()).succeeds()
    }

    /// The picture's file, byte for byte, and what was said.
    fn render(&self, scene: &str, more: &[&str]) -> (Vec<u8>, String) {
        self.write("scene.toml", scene);
        let run = self.oslcl(&[&["render", "scene.toml", "-o", "out.exr"], more].concat()).succeeds();
        (self.read("out.exr"), run.err)
    }

    /// Rendering fails, with all of this said.
    fn refuses(&self, scene: &str, more: &[&str], parts: &[&str]) {
        self.write("scene.toml", scene);
        self.oslcl(&[&["render", "scene.toml", "-o", "none.exr"], more].concat()).fails(1, parts);
        assert!(!self.0.join("none.exr").exists());
    }
}

fn shipped() -> Vec<&'static str> {
    oslcl_runtime::scene::names().collect()
}

/// Camera, film, integrator.
const HEAD: &str = "[camera]\norigin = [0, -9, 0]\ntarget = [0, 0, 0]\n[film]\nwidth = 32\nheight = 16\n\
                    [integrator]\nsamples = 2\nmax_depth = 3\n";

/// A ball with a material whose table this is, under a flat sky.
fn ball(material: &str) -> String {
    format!(
        "{HEAD}[environment]\nshader = \"flat_sky\"\n[materials.m]\n{material}\n\
         [[meshes]]\nname = \"ball\"\nshape = \"sphere\"\nsize = 4\nsegments = [24, 12]\nmaterial = \"m\"\n"
    )
}

/// A ball of each shipped material; `named` is how the scene names a shader.
fn all_materials(named: impl Fn(&str) -> String) -> String {
    let mut out = format!("{HEAD}[environment]\nshader = \"{}\"\n", named("sky"));
    for (i, name) in shipped().into_iter().enumerate() {
        let (x, z) = ((i % 6) as f64 - 2.5, (i / 6) as f64 - 1.0);
        out.push_str(&format!(
            "[materials.{name}]\nshader = \"{}\"\n[[meshes]]\nname = \"{name}\"\nshape = \"sphere\"\n\
             segments = [24, 12]\nmaterial = \"{name}\"\ntransform = {{ translate = [{x}, 0, {z}] }}\n",
            named(name)
        ));
    }
    out
}

#[test]
fn all_shipped_materials_give_the_same_bits() {
    let at = Place::new("shipped");
    let said = at.pack("all.oslpak", &shipped()).out;
    assert!(said.starts_with("all.oslpak: 16 shaders"), "{said}");
    let (by_osl, _) = at.render(&all_materials(|name| name.to_owned()), &[]);
    let (by_package, err) = at.render(&all_materials(|name| format!("all.oslpak:{name}")), &[]);
    assert!(by_osl == by_package, "the pictures differ");
    assert!(err.contains("0 compiled, 17 from packages"), "{err}");
    // The programs are the same to the letter.
    assert!(err.contains(" 0 built"), "{err}");
    // In 64 bits, too.
    let one = |shader: &str| ball(&format!("shader = \"{shader}\""));
    let (by_osl, _) = at.render(&one("marble"), &["--precision", "reference"]);
    let (by_package, _) = at.render(&one("all.oslpak:marble"), &["--precision", "reference"]);
    assert!(by_osl == by_package, "the pictures differ in 64 bits");
    at.oslcl(&["plan", "scene.toml"]).succeeds();
}

#[test]
fn spirv_comes_from_the_package() {
    let at = Place::new("spirv");
    at.pack("all.oslpak", &["plastic"]);
    at.write("scene.toml", ball("shader = \"plastic\""));
    let run = at.oslcl(&["render", "scene.toml", "-o", "out.exr", "--road", "spirv"]);
    if run.code != Some(0) {
        // No SPIR-V here: that is what both have to say.
        at.write("scene.toml", ball("shader = \"all.oslpak\""));
        let packed = at.oslcl(&["render", "scene.toml", "-o", "out.exr", "--road", "spirv"]);
        assert_eq!((packed.code, packed.err), (run.code, run.err));
        return;
    }
    let by_osl = at.read("out.exr");
    let (by_package, _) = at.render(&ball("shader = \"all.oslpak\""), &["--road", "spirv"]);
    assert!(by_osl == by_package, "the pictures differ");
}

#[test]
fn what_has_no_spirv_says_why_and_goes_as_opencl_c() {
    let at = Place::new("no-spirv");
    // More arguments than a function of SPIR-V can have.
    let values = vec!["u"; 300].join(", ");
    let format = "%g ".repeat(300);
    at.write(
        "long.osl",
        format!("surface long_one() {{ if (u < -1) printf(\"{format}\", {values}); Ci = diffuse(N); }}"),
    );
    let err = at.pack("long.oslpak", &["long.osl"]).err;
    assert!(err.contains("OpenCL C alone, no SPIR-V: "), "{err}");
    let info = at.oslcl(&["info", "long.oslpak"]).succeeds().out;
    assert!(info.contains("SPIR-V     no: "), "{info}");
    let scene = ball("shader = \"long.oslpak\"");
    at.render(&scene, &[]);
    at.refuses(&scene, &["--road", "spirv"], &["scene.toml:13:10: material `m`", "`long_one` has no SPIR-V", "--road"]);
}

#[test]
fn files_that_are_none_are_refused() {
    let at = Place::new("damage");
    at.pack("good.oslpak", &["plastic", "glass"]);
    let good = at.read("good.oslpak");
    let refused = |bytes: &[u8]| {
        let package = Package::from_bytes(Path::new("x.oslpak"), bytes);
        package.map(|p| p.names().count()).expect_err("it is refused").to_string()
    };
    assert_eq!(Package::from_bytes(Path::new("x.oslpak"), &good).map(|p| p.names().count()).expect("good"), 2);
    for length in [1, 7, 8, 20, 55, 56, 57, 100, good.len() / 2, good.len() - 1] {
        let text = refused(&good[..length]);
        assert!(text.contains("cut off") && text.contains(&format!("has {length} bytes")), "{length}: {text}");
    }
    for at in (0..good.len()).step_by(97).chain([good.len() - 1]) {
        let mut wrong = good.clone();
        wrong[at] ^= 0x10;
        let text = refused(&wrong);
        assert!(at < file::HEADER || text.contains("its checksum does not fit"), "{at}: {text}");
    }
    assert!(refused(&[&good[..], b"more"].concat()).contains("4 bytes stand behind its end"));
    assert!(refused(b"").contains("it is empty"));
    assert!(refused(b"surface x() {}").contains("it begins with \"surface \""));
    // As another interface's compiler would have written it.
    let other = refused(&file::seal(ABI_VERSION - 1, &good[file::HEADER..]));
    let wanted = format!("made for interface {}; this oslcl reads {ABI_VERSION}: compile it again", ABI_VERSION - 1);
    assert!(other.contains(&wanted), "{other}");
    // Whole, but not what we write.
    for contents in [&b""[..], b"12345678", &[0; 8], &[0xff; 64], &[7, 0, 0, 0, 0, 0, 0, 0, 0x9f, 0x9f, 0x9f]] {
        let text = refused(&file::seal(ABI_VERSION, contents));
        assert!(text.contains("is not understood"), "{text}");
    }
    // Changed by someone who knows the checksum: other values, or an error; no panic.
    let contents = &good[file::HEADER..];
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let (mut read, mut refused_shaders) = (0, 0);
    for _ in 0..3000 {
        let mut wrong = contents.to_vec();
        for _ in 0..1 + random(3) {
            // Most of it is code; what gives it its shape stands in the front.
            let at = if random(2) == 0 { random(wrong.len()) } else { random(600) };
            wrong[at] = random(256) as u8;
        }
        let Ok(package) = Package::from_bytes(Path::new("x.oslpak"), &file::seal(ABI_VERSION, &wrong)) else {
            continue;
        };
        let names: Vec<String> = package.names().map(str::to_owned).collect();
        for name in names {
            match package.shader(Some(&name)) {
                Ok(_) => read += 1,
                Err(_) => refused_shaders += 1,
            }
        }
    }
    assert!(read > 100 && refused_shaders > 100, "{read} read, {refused_shaders} refused");
    // Where users meet it.
    at.write("cut.oslpak", &good[..good.len() - 10]);
    let place = "scene.toml:13:10: material `m`: the package `cut.oslpak` is cut off";
    at.refuses(&ball("shader = \"cut.oslpak:plastic\""), &[], &[place]);
    at.refuses(&ball("shader = \"nowhere.oslpak\""), &[], &["scene.toml:13:10", "cannot read", "nowhere.oslpak"]);
    at.oslcl(&["check", "good.oslpak", "good.oslpak:glass"]).succeeds();
    at.oslcl(&["check", "good.oslpak:wood"]).fails(1, &["no shader `wood`"]);
    for verb in ["info", "shade", "compile", "check"] {
        at.oslcl(&[verb, "cut.oslpak:plastic"]).fails(1, &["`cut.oslpak` is cut off"]);
    }
}

#[test]
fn shaders_are_found_by_name() {
    let at = Place::new("names");
    at.pack("two.oslpak", &["plastic", "glass"]);
    let place = "scene.toml:13:10: material `m`: the package `two.oslpak` has";
    at.refuses(
        &ball("shader = \"two.oslpak:plastik\""),
        &[],
        &[place, "no shader `plastik`", "did you mean `plastic`?"],
    );
    at.refuses(&ball("shader = \"two.oslpak:wood\""), &[], &[place, "no shader `wood`", "it has plastic, glass"]);
    at.refuses(&ball("shader = \"two.oslpak\""), &[], &[place, "2 shaders", "`two.oslpak:plastic`"]);
    // One shader twice, under names of its own.
    let args = ["red=plastic", "green=plastic", "-p", "red:Cs=1,0,0", "-p", "green:Cs=0,1,0"];
    at.pack("named.oslpak", &args);
    let picture = |scene: &str| at.render(&ball(scene), &[]).0;
    assert!(picture("shader = \"named.oslpak:red\"") == picture("shader = \"plastic\"\nparams = { Cs = [1, 0, 0] }"));
    assert!(picture("shader = \"named.oslpak:green\"") == picture("shader = \"plastic\"\nparams = { Cs = [0, 1, 0] }"));
    let info = at.oslcl(&["info", "named.oslpak"]).succeeds().out;
    assert!(info.contains("red: surface plastic") && info.contains("(compiled as [0, 1, 0])"), "{info}");
    // Nothing in it hangs on when it is made.
    at.pack("again.oslpak", &args);
    assert!(at.read("named.oslpak") == at.read("again.oslpak"));
    // A package has each name once, and every file has to compile.
    at.write("other.osl", "surface glass() { Ci = diffuse(N); }");
    at.oslcl(&["compile", "-o", "x.oslpak", "glass", "other.osl"])
        .fails(2, &["`glass` and `other.osl`", "each name once"]);
    at.write("broken.osl", "surface broken() { Ci = nothing; }");
    at.oslcl(&["compile", "-o", "x.oslpak", "broken.osl", "glass"]).fails(1, &["broken.osl:1:", "nothing"]);
    assert!(!at.0.join("x.oslpak").exists());
}

const GAIN: &str = "surface gain(float Kd = 0.5, color Cs = color(0.1, 0.5, 0.9), string mode = \"a\", int n = 2, \
                    float half_of = Kd / 2) { Ci = Kd * Cs * (mode == \"a\" ? 1.0 : 0.5) * n * half_of * diffuse(N); }";

#[test]
fn baked_parameters_keep_their_values() {
    let at = Place::new("baked");
    at.write("gain.osl", GAIN);
    at.pack("gain.oslpak", &["gain.osl", "-p", "Kd=0.75"]);
    let with = |params: &str| ball(&format!("shader = \"gain.oslpak\"\nparams = {{ {params} }}"));
    // The same values are no contradiction, however they are written.
    let (packed, _) = at.render(&with("Kd = 0.75, Cs = [0.1, 0.5, 0.9], mode = \"a\", n = 2.0"), &[]);
    let (plain, _) = at.render(&ball("shader = \"gain.osl\"\nparams = { Kd = 0.75 }"), &[]);
    assert!(packed == plain, "the pictures differ");
    let place = "scene.toml:14:17: material `m`: parameter `Kd`";
    at.refuses(
        &with("Kd = 0.5"),
        &[],
        &[place, "value 0.75", "can't be given another", "--interactive Kd", "--param Kd="],
    );
    at.refuses(&with("Cs = 1"), &[], &["parameter `Cs`", "[0.1, 0.5, 0.9]"]);
    at.refuses(&with("mode = \"b\""), &[], &["parameter `mode`", "\"a\""]);
    at.refuses(&with("half_of = 0.5"), &[], &["parameter `half_of`", "in the package's code"]);
    at.refuses(&with("halfof = 0.5"), &[], &["scene.toml:14:21", "no parameter `halfof`", "did you mean `half_of`?"]);
    at.refuses(&with("x = 0.5"), &[], &["no parameter `x`", "it has Kd, Cs, mode, n, half_of"]);
    at.refuses(&with("Kd = \"high\""), &[], &["does not fit parameter `Kd`", "of type float"]);
    let info = at.oslcl(&["info", "gain.oslpak:gain"]).succeeds().out;
    assert!(info.contains("float Kd = 0.5 (compiled as 0.75)"), "{info}");
}

#[test]
fn a_package_has_room_for_many() {
    let at = Place::new("many");
    let names: Vec<String> = (0..200).map(|i| format!("shade{i}.osl")).collect();
    for (i, name) in names.iter().enumerate() {
        at.write(name, format!("surface shade{i}() {{ Ci = {}.0 / 200 * diffuse(N); }}", i + 1));
    }
    let files: Vec<&str> = names.iter().map(String::as_str).collect();
    assert!(at.pack("many.oslpak", &files).out.starts_with("many.oslpak: 200 shaders"));
    let info = at.oslcl(&["info", "many.oslpak"]).succeeds().out;
    assert!(info.contains("\nsurface shade0\n") && info.contains("\nsurface shade199\n"), "{info}");
    for i in [0, 101, 199] {
        let (packed, _) = at.render(&ball(&format!("shader = \"many.oslpak:shade{i}\"")), &[]);
        let (plain, _) = at.render(&ball(&format!("shader = \"shade{i}.osl\"")), &[]);
        assert!(packed == plain, "{i}");
    }
}

#[test]
fn groups_come_from_packages() {
    let at = Place::new("groups");
    let group = "param float scale 6; shader stripes pattern;\nparam float Kd 0.8; shader painted base;\n\
                 connect pattern.Cout base.Cs;\n";
    at.write("net.oslgroup", group);
    at.write(
        "stripes.osl",
        "shader stripes(float scale = 5, output color Cout = 0) { Cout = color(mod(floor(scale * v), 2), 0.5, 0.2); }",
    );
    at.write(
        "painted.osl",
        "surface painted(color Cs = 1, float Kd = 0.5, float gain = 1) { Ci = Kd * gain * Cs * diffuse(N); }",
    );
    at.pack("baked.oslpak", &["net.oslgroup", "-p", "net:gain=0.75"]);
    at.pack("open.oslpak", &["net.oslgroup", "--interactive", "pattern.scale", "--interactive", "net:gain"]);
    let by_text = |params: &str| ball(&format!("group = \"\"\"\n{group}\"\"\"\nparams = {{ {params} }}"));
    let by = |package: &str, params: &str| ball(&format!("shader = \"{package}:net\"\nparams = {{ {params} }}"));
    let (plain, _) = at.render(&by_text("gain = 0.75"), &[]);
    let (packed, _) = at.render(&by("baked.oslpak", "gain = 0.75, 'base.Kd' = 0.8, 'pattern.scale' = 6"), &[]);
    assert!(plain == packed, "the pictures differ");
    let pixels = |scene: &str| {
        at.render(scene, &[]);
        oslcl_runtime::film::read_exr(&at.0.join("out.exr")).expect("a picture").pixels
    };
    let values = "gain = 0.5, 'pattern.scale' = 3";
    for (a, b) in pixels(&by("open.oslpak", values)).iter().zip(&pixels(&by_text(values))) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 1e-5 * b[c].abs()), "{a:?}, compiled {b:?}");
    }
    at.refuses(
        &by("baked.oslpak", "Kd = 0.5"),
        &[],
        &["parameter `Kd` of shader `net`", "value 0.8", "--interactive Kd"],
    );
    at.refuses(&by("baked.oslpak", "'pattern.scale' = 5"), &[], &["parameter `pattern.scale`", "value 6"]);
    at.refuses(&by("baked.oslpak", "'pattern.sale' = 5"), &[], &["no parameter `pattern.sale`", "`pattern.scale`?"]);
    let info = at.oslcl(&["info", "open.oslpak"]).succeeds().out;
    assert!(
        info.contains("layers     pattern, base") && info.contains("float pattern.scale, float base.gain"),
        "{info}"
    );
    let wrong = at.oslcl(&["compile", "-o", "x.oslpak", "net.oslgroup", "--interactive", "base.Cs"]);
    wrong.fails(2, &["`base.Cs` of shader `net` can't be interactive: a connection gives its value"]);
    at.write("net.oslgroup", "shader nowhere layer;");
    at.oslcl(&["compile", "-o", "x.oslpak", "net.oslgroup"]).fails(1, &["shader `nowhere`"]);
    at.write("net.oslgroup", "shader stripes a; connect a b;");
    at.oslcl(&["compile", "-o", "x.oslpak", "net.oslgroup"]).fails(1, &["net.oslgroup:1:", "shader group"]);
}

#[test]
fn displacement_comes_from_packages() {
    let at = Place::new("displacement");
    at.write("bumps.osl", "displacement bumps(float height = 0.2) { P += height * sin(20 * P[2]) * N; }");
    at.pack("open.oslpak", &["bumps.osl", "plastic", "--interactive", "bumps:height"]);
    at.pack("baked.oslpak", &["bumps.osl", "-p", "bumps:height=0.3"]);
    let scene = |bumps: &str, params: &str| {
        ball(&format!("shader = \"plastic\"\ndisplacement = \"b\"\n[materials.b]\nshader = \"{bumps}\"\n{params}"))
    };
    let height = "params = { height = 0.3 }";
    let (plain, _) = at.render(&scene("bumps.osl", height), &[]);
    let (baked, err) = at.render(&scene("baked.oslpak", height), &[]);
    assert!(plain == baked, "the pictures differ");
    assert!(err.contains("2 compiled, 1 from packages"), "{err}");
    let (open, _) = at.render(&scene("open.oslpak:bumps", height), &[]);
    let (default, _) = at.render(&scene("open.oslpak:bumps", ""), &[]);
    assert!(open != default, "the height changes nothing");
    // Of no kind: light is scattered and vertices are moved by it.
    at.write("any.osl", "shader any() { P += 0.1 * sin(20 * P[2]) * N; }");
    at.pack("any.oslpak", &["any.osl"]);
    let (plain, _) = at.render(&scene("any.osl", ""), &[]);
    let (packed, _) = at.render(&scene("any.oslpak", ""), &[]);
    assert!(plain == packed, "the pictures differ");
    // Each for what it is.
    at.refuses(&scene("open.oslpak:plastic", ""), &[], &["`plastic` is a surface shader", "displacement"]);
    at.refuses(&ball("shader = \"baked.oslpak\""), &[], &["`bumps` is a displacement shader", "surface"]);
}

#[test]
fn attributes_and_data_of_vertices_are_the_scenes() {
    let at = Place::new("scene-data");
    at.write(
        "asks.osl",
        "surface asks(color Cd = color(1, 0, 1) [[ int lockgeom = 0 ]], float s = 0 [[ int lockgeom = 0 ]]) {\
         float wear = 0.25; int found = getattribute(\"wear\", wear); int size[2]; getattribute(\"camera:resolution\", size);\
         string team = \"\"; getattribute(\"team\", team);\
         Ci = Cd * wear * (found ? 1.0 : 0.5) * (size[0] / 64.0) * (team == \"red\" ? 1.0 : 0.25) * (1 + s) * diffuse(N); }",
    );
    at.pack("asks.oslpak", &["asks.osl"]);
    // Vertices with colours, and what has none.
    at.write(
        "tri.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n\
         property float v\nproperty float red\nproperty float green\nproperty float blue\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n-3 0 -3 0 0 1 0 0\n3 0 -3 1 0 0 1 0\n0 0 3 0 1 0 0 1\n3 0 1 2\n",
    );
    let scene = |shader: &str, top: &str, ball: &str| {
        format!(
            "{top}\n{HEAD}[environment]\nshader = \"flat_sky\"\n[materials.m]\nshader = \"{shader}\"\n\
             [[meshes]]\nname = \"tri\"\nfile = \"tri.ply\"\nmaterial = \"m\"\n{ball}\n"
        )
    };
    let sphere = "[[meshes]]\nname = \"ball\"\nshape = \"sphere\"\nsize = 2\nsegments = [24, 12]\nmaterial = \"m\"\n\
                  attributes = { wear = 2 }\ntransform = { translate = [0, -2, 0] }";
    for (top, more) in [
        ("", ""),
        ("attributes = { wear = 0.75 }", ""),
        ("attributes = { wear = 0.75, team = \"red\" }", sphere),
        ("attributes = { team = \"blue\" }", sphere),
    ] {
        let picture = |shader: &str| {
            at.render(&scene(shader, top, more), &[]);
            oslcl_runtime::film::read_exr(&at.0.join("out.exr")).expect("a picture").pixels
        };
        let (plain, packed) = (picture("asks.osl"), picture("asks.oslpak"));
        for (a, b) in packed.iter().zip(&plain) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 1e-5 * b[c].abs().max(1e-3)), "{top}: {a:?}, compiled {b:?}");
        }
    }
    // A mesh without coordinates: `s` would have its default.
    at.write("bare.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                          element face 1\nproperty list uchar int vertex_indices\nend_header\n-3 0 -3\n3 0 -3\n0 0 3\n3 0 1 2\n");
    let bare = scene("asks.oslpak", "", "").replace("tri.ply", "bare.ply");
    at.refuses(&bare, &[], &["material `m`", "parameter `s`", "texture coordinate", "mesh `tri` has none"]);
    // What only a scene that is known could answer.
    at.write("names.osl", "surface names() { float x = 1; getattribute(\"lamp\", \"x\", x); Ci = x * diffuse(N); }");
    at.oslcl(&["compile", "-o", "x.oslpak", "names.osl"]).fails(1, &["names.osl:1:", "attribute of a named object"]);
    // Around the scene there are no objects.
    at.write("around.osl", "surface around() { float x = 0.5; getattribute(\"x\", x); Ci = x * background(); }");
    at.pack("around.oslpak", &["around.osl"]);
    let around = |top: &str, shader: &str| format!("{top}\n{HEAD}[environment]\nshader = \"{shader}\"\n");
    let (plain, _) = at.render(&around("", "around.osl"), &[]);
    let (packed, _) = at.render(&around("", "around.oslpak"), &[]);
    assert!(plain.len() > 100 && packed.len() > 100);
    at.refuses(&around("attributes = { x = 2 }", "around.oslpak"), &[], &["`around` asks for the attribute `x`"]);
}

#[test]
fn facts_about_textures_must_hold() {
    let at = Place::new("facts");
    let picture = |name: &str, width: usize| {
        let picture = oslcl_runtime::film::Picture {
            width,
            height: 4,
            pixels: vec![[0.25, 0.5, 0.75]; width * 4],
            alpha: Vec::new(),
            attributes: Vec::new(),
        };
        oslcl_runtime::film::write(&at.0.join(name), &picture, 0.0).expect("a texture");
    };
    picture("t.exr", 8);
    at.write(
        "wide.osl",
        "surface wide(string file = \"t.exr\") { int size[2]; gettextureinfo(file, \"resolution\", size);\
         Ci = size[0] / 16.0 * (color)texture(file, u, v) * diffuse(N); }",
    );
    at.pack("wide.oslpak", &["wide.osl"]);
    let (plain, _) = at.render(&ball("shader = \"wide.osl\""), &[]);
    let scene = ball("shader = \"wide.oslpak\"");
    let (packed, _) = at.render(&scene, &[]);
    assert!(plain == packed, "the pictures differ");
    picture("t.exr", 16);
    at.refuses(
        &scene,
        &[],
        &["shader `wide`", "`resolution` of texture `t.exr` was 8 4", "is 16 4", "compile the package again"],
    );
}

#[test]
fn points_without_a_scene_are_shaded() {
    let at = Place::new("points");
    at.write(
        "ramp.osl",
        "shader ramp(float gain = 2 [[ int interactive = 1 ]], float bias = 0.5, output color Cout = 0, output int id = 0) {\
         int size[2]; getattribute(\"camera:resolution\", size); Cout = color(u, v, bias) * gain; id = size[0]; }",
    );
    at.pack("ramp.oslpak", &["ramp.osl"]);
    let both = |more: &[&str]| {
        let [plain, packed] = ["ramp.osl", "ramp.oslpak:ramp"]
            .map(|shader| at.oslcl(&[&["shade", shader, "-g", "5", "3"], more].concat()).succeeds().out);
        assert_eq!(plain, packed, "{more:?}");
        plain
    };
    assert!(both(&[]).contains("id 5"));
    assert_ne!(both(&["-p", "gain=3"]), both(&[]));
    at.oslcl(&["shade", "ramp.oslpak", "-p", "bias=1"]).fails(1, &["parameter `bias`", "value 0.5"]);
    at.oslcl(&["shade", "ramp.oslpak", "-o", "gain=x.exr"]).fails(2, &["does not store `gain`", "Cout, id"]);
    at.oslcl(&["shade", "ramp.oslpak", "--compare", "host"]).fails(2, &["--compare f64"]);
}

#[test]
fn packages_are_shown_and_taken_apart() {
    let at = Place::new("apart");
    at.pack("all.oslpak", &["plastic", "marble"]);
    let json = at.oslcl(&["info", "all.oslpak", "--json"]).succeeds().out;
    let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    assert_eq!((&json["format"], &json["abi_version"]), (&file::FORMAT.into(), &ABI_VERSION.into()));
    assert_eq!(json["oslcl"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["shaders"][0]["artifact"]["lobes"], serde_json::json!(["diffuse", "microfacet"]));
    assert_eq!(json["shaders"][1]["artifact"]["name"], "marble");
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl/marble.osl"), at.0.join("marble.osl"))
        .expect("a shipped shader");
    at.oslcl(&["compile", "marble.osl", "-o", "direct", "--emit", "opencl,spirv,json"]).succeeds();
    at.oslcl(&["compile", "all.oslpak:marble", "-o", "apart", "--emit", "opencl,spirv,json"]).succeeds();
    for name in ["marble.cl", "marble.spv", "marble.spv.cl", "marble.json"] {
        assert!(at.read(&format!("direct/{name}")) == at.read(&format!("apart/{name}")), "{name} differs");
    }
    at.oslcl(&["compile", "all.oslpak", "-o", "both"]).succeeds();
    assert!(at.0.join("both/plastic.cl").exists() && at.0.join("both/marble.cl").exists());
    at.oslcl(&["compile", "all.oslpak", "--emit", "ir"]).fails(2, &["which a package does not have"]);
    at.oslcl(&["compile", "all.oslpak", "marble.osl"]).fails(2, &["all.oslpak", "alone"]);
    at.oslcl(&["compile", "all.oslpak", "-p", "x=1"]).fails(2, &["too late"]);
}
