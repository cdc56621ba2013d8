//! Runs `testrender` as scripts do: scenes in XML render, and what is wrong with them is told with its place.

use oslcl_runtime::film;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a run said.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

const SKY: &str = "shader sky(float Kb = 1) { Ci = Kb * background(); }";
const MATTE: &str = "surface matte(color Cs = 1) { Ci = Cs * diffuse(N); }";
const GLOW: &str = "surface glow(color Ce = 1) { Ci = Ce * emission(); }";
const SHOW: &str = "surface show() { Ci = color(u, v, 0) * emission(); }";

/// A folder of the test's own with the shaders above.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("testrender").join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder for the test");
    for (name, text) in [("sky", SKY), ("matte", MATTE), ("glow", GLOW), ("show", SHOW)] {
        fs::write(path.join(format!("{name}.osl")), text).expect("a shader");
    }
    path
}

fn testrender(at: &Path, args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
    let output = command.arg("testrender").args(args).current_dir(at).stdin(Stdio::null()).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the output is UTF-8");
    let run = Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
    assert!(!run.err.contains("panicked"), "{}", run.err);
    run
}

/// Renders a scene; the picture, and what was said.
fn render(test: &str, scene: &str, args: &[&str]) -> (film::Picture, Run) {
    let at = folder(test);
    fs::write(at.join("scene.xml"), scene).expect("a scene");
    let run = testrender(&at, &[args, &["scene.xml", "out.exr"]].concat());
    assert_eq!(run.code, Some(0), "{}", run.err);
    (film::read_exr(&at.join("out.exr")).expect("a picture"), run)
}

fn pixel(picture: &film::Picture, x: usize, y: usize) -> [f32; 3] {
    picture.pixels[y * picture.width + x]
}

fn close(found: [f32; 3], expected: [f32; 3], by: f32) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= by), "{found:?} is not {expected:?}");
}

#[test]
fn a_white_ball_in_a_grey_room_is_grey() {
    let scene = "<World>\n<Camera eye='0,0,10' look_at='0,0,0' fov='40'/>\n\
        <ShaderGroup>float Kb 0.5; shader sky s;</ShaderGroup><Background/>\n\
        <ShaderGroup commands='shader matte m;'/><Sphere center='0,0,0' radius='1'/>\n</World>";
    let (picture, run) =
        render("furnace", scene, &["-v", "-r", "24", "16", "-aa", "4", "-O2", "--llvm_opt", "3", "-t", "2"]);
    assert_eq!((picture.width, picture.height), (24, 16));
    for p in &picture.pixels {
        close(*p, [0.5; 3], 0.01);
    }
    assert!(run.out.starts_with("Rendered 24x16 image with 16 samples in "), "{}", run.out);
}

/// The picture of a quad as wide as the reference's camera sees: half a tangent of half the angle up and down.
#[test]
fn the_camera_and_the_quad_are_the_references() {
    let scene = "<World><Camera fov='90'/>\
        <ShaderGroup><Shader name='show' layer='l'/></ShaderGroup>\
        <Quad corner='-0.5,-0.5,-1' edge_x='1,0,0' edge_y='0,1,0' resolution='3'/></World>";
    let (picture, _) = render("quad", scene, &["--res", "8", "8", "--no-jitter"]);
    for (x, y) in [(0, 0), (7, 0), (0, 7), (5, 3)] {
        let [u, v] = [(x as f32 + 0.5) / 8.0, 1.0 - (y as f32 + 0.5) / 8.0];
        close(pixel(&picture, x, y), [u, v, 0.0], 2e-3);
    }
}

/// u runs around from -z by -x, v from the top down.
#[test]
fn the_sphere_is_the_references() {
    let scene = "<World><Camera eye='0,0,4' dir='0,0,-1' up='0 1 0' fov='90'/>\
        <ShaderGroup><Shader name='show' layer='l'/></ShaderGroup><Sphere center='0,0,0' radius='1'/></World>";
    let (picture, _) = render("sphere", scene, &["-r", "65", "65", "--no-jitter"]);
    close(pixel(&picture, 32, 32), [0.5, 0.5, 0.0], 5e-3);
    // Behind the middle lies u = 0 or 1; to the right of the picture is +x, so that u grows.
    let right = pixel(&picture, 37, 32);
    let down = pixel(&picture, 32, 37);
    assert!(right[0] > 0.52 && (right[1] - 0.5).abs() < 5e-3, "{right:?}");
    assert!(down[1] > 0.52 && (down[0] - 0.5).abs() < 5e-3, "{down:?}");
}

#[test]
fn groups_from_elements_parameters_and_options() {
    let scene = "<World><Option max_bounces='int 0'/>\
        <ShaderGroup is_light='yes'><Parameter Ce='color 0.25 0.5 1' other='float 3'/><Shader name='glow' layer='l'/></ShaderGroup>\
        <Quad corner='5,-5,-1' edge_x='-10,0,0' edge_y='0,10,0'/><Lamp watts='60'/></World>";
    let (picture, run) = render("elements", scene, &["-r", "4", "4"]);
    // The quad shows its back: both sides emit.
    close(pixel(&picture, 1, 2), [0.25, 0.5, 1.0], 1e-3);
    assert!(run.err.contains("scene.xml:1:"), "{}", run.err);
    assert!(run.err.contains("unknown element <Lamp> is left out"), "{}", run.err);
    assert!(run.err.contains("shader `glow` has no parameter `other`; its value is left out"), "{}", run.err);
}

#[test]
fn models_have_materials_by_name() {
    let at = folder("model");
    let obj = "v -9 -9 -1\nv 9 -9 -1\nv 9 9 -1\nv -9 9 -1\no left\nf 1 2 4\no right\nf 2 3 4\n";
    fs::create_dir_all(at.join("deep")).expect("a folder");
    fs::write(at.join("deep/two.obj"), obj).expect("a model");
    let scene = "<World><ShaderGroup name='left'>color Ce 1 0 0; shader glow l;</ShaderGroup>\
        <ShaderGroup>color Ce 0 1 0; shader glow l;</ShaderGroup><Model filename='two.obj'/></World>";
    fs::write(at.join("deep/scene.xml"), scene).expect("a scene");
    let run = testrender(&at, &["-r", "8", "8", "--path", ".:elsewhere", "deep/scene.xml", "out.exr"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let picture = film::read_exr(&at.join("out.exr")).expect("a picture");
    close(pixel(&picture, 1, 6), [1.0, 0.0, 0.0], 0.0);
    close(pixel(&picture, 6, 1), [0.0, 1.0, 0.0], 0.0);
}

#[test]
fn displacement_and_surface_share_a_name() {
    let at = folder("displacement");
    fs::write(at.join("push.osl"), "displacement push(float by = 1) { P += by * N; }").expect("a shader");
    let scene = "<World><Camera eye='0,0,10' fov='90'/><ShaderGroup name='a'>shader glow l;</ShaderGroup>\
        <ShaderGroup name='a' type='displacement'>float by 3; shader push l;</ShaderGroup>\
        <Sphere center='0,0,0' radius='1' resolution='16'/></World>";
    fs::write(at.join("scene.xml"), scene).expect("a scene");
    let run = testrender(&at, &["-r", "9", "9", "--no-jitter", "scene.xml", "out.exr"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    // A ball of radius 4 at distance 10 covers 0.436 of a picture from -0.5 to 0.5; one of radius 1 covers 0.1.
    let picture = film::read_exr(&at.join("out.exr")).expect("a picture");
    close(pixel(&picture, 1, 4), [1.0; 3], 0.0);
    close(pixel(&picture, 0, 4), [0.0; 3], 0.0);
}

/// A scene that is wrong: where and why.
#[test]
fn bad_scenes_are_refused_with_their_place() {
    let at = folder("bad");
    let group = "<ShaderGroup>shader matte m;</ShaderGroup>";
    let ball = "<Sphere center='0,0,0' radius='1'/>";
    let cases: &[(&str, &str)] = &[
        ("<World>\n<Camera>\n</World>", "scene.xml:3:1: not valid XML: expected 'Camera' tag, not 'World'"),
        ("", "scene.xml:1:1: not valid XML"),
        ("<Scene/>", "scene.xml:1:1: the outermost element must be <World>, not <Scene>"),
        ("<World/>", "scene.xml:1:1: there is no <ShaderGroup> in the scene"),
        ("<World>GROUP</World>", "there is no <Sphere>, <Quad> or <Model> in the scene"),
        ("<World>\n  BALL</World>", "scene.xml:2:3: <Sphere> stands before any <ShaderGroup>"),
        ("<World>\n<Background/></World>", "scene.xml:2:1: <Background> stands before any <ShaderGroup>"),
        ("<World>GROUP\n<Sphere radius='1'/></World>", "scene.xml:2:1: `<Sphere>` needs the key `center`"),
        (
            "<World>GROUP\n<Sphere center='0,0' radius='1'/></World>",
            "scene.xml:2:17: `center of <Sphere>` must be three numbers",
        ),
        ("<World>GROUP\n<Sphere center='0,0,nan' radius='1'/></World>", "must be finite numbers, not \"0,0,nan\""),
        (
            "<World>GROUP\n<Sphere center='0,0,0' radius='0'/></World>",
            "scene.xml:2:32: `radius of <Sphere>` must be greater than 0",
        ),
        ("<World>GROUP<Sphere center='0,0,0' radius='1' resolution='99999'/></World>", "a whole number from 2 to 4096"),
        ("<World>GROUP<Quad corner='0,0,0' edge_x='1,0,0'/></World>", "`<Quad>` needs the key `edge_y`"),
        ("<World>GROUP<Model filename='no.obj'/></World>", "scene.xml:1:50: cannot read the model `no.obj`"),
        ("<World>GROUP<Model/></World>", "`<Model>` needs the key `filename`"),
        (
            "<World>\n<Camera fov='200'/></World>",
            "scene.xml:2:14: `fov of <Camera>` must be an angle between 0 and 180 degrees",
        ),
        ("<World><Camera fov='wide'/></World>", "`fov of <Camera>` must be a number, not \"wide\""),
        ("<World>\n<Camera dir='0,1,0'/></World>", "scene.xml:2:1: the camera can't look"),
        ("<World><Option max_bounces='4'/></World>", "must be a whole number with its type, such as \"int 4\""),
        ("<World>\n<ShaderGroup/></World>", "scene.xml:2:1: <ShaderGroup> is empty"),
        ("<World><ShaderGroup><Shader name='a'/></ShaderGroup></World>", "`<Shader>` needs the key `layer`"),
        (
            "<World><ShaderGroup name='a'>shader matte m;</ShaderGroup><ShaderGroup name='a' type='volume'>shader matte m;</ShaderGroup></World>",
            "a group of type \"volume\" cannot be added",
        ),
        ("<World>\n<ShaderGroup>shader\n nothing l;</ShaderGroup>BALL</World>", "shader `nothing` is no shipped one"),
        (
            "<World>\n<ShaderGroup>\n  shade matte m;</ShaderGroup>BALL</World>",
            "scene.xml:3:3: shader group: `shade` is none of",
        ),
    ];
    for (scene, expected) in cases {
        fs::write(at.join("scene.xml"), scene.replace("GROUP", group).replace("BALL", ball)).expect("a scene");
        let run = testrender(&at, &["-r", "4", "4", "scene.xml", "out.exr"]);
        assert_eq!(run.code, Some(1), "{scene}: {}", run.err);
        assert!(run.err.contains(expected), "{scene}: {}", run.err);
        assert!(!at.join("out.exr").exists(), "{scene}");
    }
    let run = testrender(&at, &["missing.xml", "out.exr"]);
    assert!(run.code == Some(1) && run.err.contains("missing.xml: cannot read this scene"), "{}", run.err);
}

#[test]
fn bad_command_lines_are_refused() {
    let at = folder("words");
    let cases: &[(&[&str], &str)] = &[
        (&["--no-jiter", "a.xml", "b.exr"], "testrender: unknown option `--no-jiter`; did you mean `-no-jitter`?"),
        (&["-r", "4"], "option `-r` needs 2 values"),
        (&["-r", "0", "4", "a.xml", "b.exr"], "option `-r` takes whole numbers from 1 to 65536, not `0`"),
        (&["-aa", "x", "a.xml", "b.exr"], "option `-aa` takes whole numbers"),
        (
            &["-albedo", "1", "a.xml", "b.exr"],
            "option `-albedo` is one of the reference's tool that this one does not have",
        ),
        (&["-v"], "no scene was named"),
        (&["a.xml"], "no picture was named"),
        (&["a.xml", "b.exr", "c"], "`c` is one file too many"),
    ];
    for (args, expected) in cases {
        let run = testrender(&at, args);
        assert_eq!(run.code, Some(2), "{args:?}: {}", run.err);
        assert!(run.err.contains(expected), "{args:?}: {}", run.err);
    }
    let run = testrender(&at, &["a.xml", "b.gif"]);
    assert!(run.code == Some(1) && run.err.contains("must end in .exr or .png"), "{}", run.err);
    let help = testrender(&at, &["--help"]);
    assert!(
        help.code == Some(0)
            && help.out.contains("-aa")
            && help.out.contains("--no-jitter") | help.out.contains("-no-jitter")
    );
}
