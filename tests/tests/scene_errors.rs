//! What a bad scene says: each message as a user reads it, with `DIR` for the folder of the scene.

use oslcl_runtime::scene;
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

const CAMERA: &str = "[camera]\norigin = [0, -4, 0]\ntarget = [0, 0, 0]\n";

/// A folder that goes away.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("oslcl-scene-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).expect("a temporary folder");
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Writes `files`, loads the scene `text` and compares what it says.
fn check_with(files: &[(&str, &[u8])], text: &str, expect: &str) {
    let folder = Folder::new();
    for (name, bytes) in files {
        fs::write(folder.0.join(name), bytes).expect("a temporary file");
    }
    let path = folder.0.join("s.toml");
    fs::write(&path, text).expect("a temporary file");
    let said = match scene::load(&path) {
        Ok(_) => "no error".to_string(),
        Err(error) => error.to_string().replace(&folder.0.display().to_string(), "DIR"),
    };
    assert_eq!(said, expect, "scene:\n{text}");
}

fn check(text: &str, expect: &str) {
    check_with(&[], text, expect);
}

/// A scene with one mesh file.
fn check_mesh(name: &str, bytes: &[u8], expect: &str) {
    let text = format!(
        "{CAMERA}[materials.m]\nshader = \"matte\"\n[[meshes]]\nname = \"a\"\nfile = \"{name}\"\nmaterial = \"m\"\n"
    );
    check_with(&[(name, bytes)], &text, expect);
}

#[test]
fn files() {
    let said = scene::load(&PathBuf::from("no/such/scene.toml")).expect_err("it isn't there").to_string();
    assert_eq!(said, "no/such/scene.toml: cannot read this scene: No such file or directory (os error 2)");
    check(
        &format!("{CAMERA}[[meshes]]\nname = \"a\"\nfile = \"a.ply\"\n"),
        "DIR/s.toml:6:8: cannot read the mesh `DIR/a.ply`: No such file or directory (os error 2)",
    );
    check(
        &format!("{CAMERA}[[meshes]]\nname = \"a\"\nfile = \"a.stl\"\n"),
        "DIR/s.toml:6:8: `DIR/a.stl` is neither .ply nor .obj",
    );
    check(
        &format!("{CAMERA}[materials.m]\nshader = \"m.osl\"\n"),
        "DIR/s.toml:5:10: cannot read the shader `DIR/m.osl`: No such file or directory (os error 2)",
    );
}

#[test]
fn keys_and_types() {
    check("[film]\nwidth = 1\nheight = 1\n", "DIR/s.toml:1:1: `the scene` needs the key `camera`");
    check(
        &format!("{CAMERA}hfow = 40\n"),
        "DIR/s.toml:4:1: unknown key `hfow` in `camera`\n  help: did you mean `hfov`?",
    );
    check(&format!("{CAMERA}hfov = \"wide\"\n"), "DIR/s.toml:4:8: `camera.hfov` must be a number, not a string");
    check(
        "[camera]\norigin = [0, 1]\ntarget = [0, 0, 0]\n",
        "DIR/s.toml:2:10: `camera.origin` must be a list of 3 numbers, not a list of 2",
    );
    check(
        &format!("{CAMERA}[materials.m]\nshader = \"mate\"\n"),
        "DIR/s.toml:5:10: there is no shipped shader named `mate`\n  help: did you mean `matte`?",
    );
    check(
        &format!("{CAMERA}[materials.m]\nparams = {{ }}\n"),
        "DIR/s.toml:4:1: `materials.m` needs a `shader` (a shipped one or a file), `osl` (its text) or `group` (a shader \
         group's text)",
    );
}

#[test]
fn ranges() {
    check(
        &format!("{CAMERA}hfov = 180\n"),
        "DIR/s.toml:4:8: `camera.hfov` must be an angle between 0 and 180 degrees, not 180",
    );
    check(&format!("{CAMERA}hfov = nan\n"), "DIR/s.toml:4:8: `camera.hfov` must be a finite number, not nan");
    check(
        &format!("{CAMERA}[film]\nwidth = 0\nheight = 4\n"),
        "DIR/s.toml:5:9: `film.width` must be an integer from 1 to 65536, not 0",
    );
    check(
        &format!("{CAMERA}[integrator]\nsamples = 0\n"),
        "DIR/s.toml:5:11: `integrator.samples` must be an integer from 1 to 16777216, not 0",
    );
    check(
        &format!("{CAMERA}[integrator]\nsamples = 1.5\n"),
        "DIR/s.toml:5:11: `integrator.samples` must be an integer, not a float",
    );
    check(
        "[camera]\norigin = [1, 2, 3]\ntarget = [1, 2, 3]\n",
        "DIR/s.toml:1:1: the camera can't look: origin and target are the same point",
    );
    check(
        &format!("{CAMERA}up = [0, 2, 0]\n"),
        "DIR/s.toml:1:1: the camera can't look: `up` is parallel to the view direction",
    );
}

#[test]
fn names_and_transforms() {
    let matte =
        format!("{CAMERA}[materials.clay]\nshader = \"matte\"\n[[meshes]]\nname = \"ball\"\nshape = \"sphere\"\n");
    check(&matte, "DIR/s.toml:6:1: `ball` has no material\n  help: give the mesh or the instance a `material`");
    check(
        &format!("{matte}material = \"cley\"\n"),
        "DIR/s.toml:9:12: there is no material named `cley`\n  help: did you mean `clay`?",
    );
    check(
        &format!("{matte}place = false\n[[instances]]\nmesh = \"bell\"\n"),
        "DIR/s.toml:11:8: there is no mesh named `bell`\n  help: did you mean `ball`?",
    );
    check(
        &format!("{matte}material = \"clay\"\ntransform = {{ scale = [1, 0, 1] }}\n"),
        "DIR/s.toml:10:13: the transform of `meshes[0]` is singular: it flattens the object, and has no inverse",
    );
    check(
        &format!("{matte}material = \"clay\"\n[[meshes]]\nname = \"ball\"\nshape = \"cube\"\n"),
        "DIR/s.toml:11:8: there are two meshes named `ball`",
    );
}

#[test]
fn ply() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let good = format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    check_mesh("a.ply", good.as_bytes(), "no error");
    let index = good.replace("3 0 1 2", "3 0 1 3");
    check_mesh("a.ply", index.as_bytes(), "DIR/a.ply: face 0 uses vertex 3, but there are 3, from 0");
    let mut nan = header.replace("ascii", "binary_little_endian").into_bytes();
    for number in [0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 1.0, 0.0] {
        nan.extend(f32::to_le_bytes(number));
    }
    nan.push(3);
    for index in [0, 1, 2] {
        nan.extend(i32::to_le_bytes(index));
    }
    check_mesh("a.ply", &nan, "DIR/a.ply: vertex 1 is not finite: (NaN, 0, 0)");
    let none = header.replace("face 1", "face 0") + "0 0 0\n1 0 0\n0 1 0\n";
    check_mesh("a.ply", none.as_bytes(), "DIR/a.ply: the mesh has no triangles");
    let two = good.replace("3 0 1 2", "2 0 1");
    check_mesh("a.ply", two.as_bytes(), "DIR/a.ply: malformed PLY: face 0 has 2 vertices");
    let no_z = good.replace("property float z\n", "");
    check_mesh("a.ply", no_z.as_bytes(), "DIR/a.ply: malformed PLY: element `vertex` has no x, y and z");
    let binary = header.replace("ascii", "binary_little_endian");
    check_mesh(
        "a.ply",
        binary.as_bytes(),
        "DIR/a.ply: the file is truncated: it ends within element `vertex` with 3 entries",
    );
}

#[test]
fn obj() {
    check_mesh("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "no error");
    check_mesh(
        "a.obj",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4\n",
        "DIR/a.obj:4: face 0 uses vertex 4, but there are 3, from 1",
    );
    check_mesh("a.obj", b"v 0 0 0\n", "DIR/a.obj: the mesh has no triangles");
    check_mesh("a.obj", b"v 0 0 0\nv inf 0 0\nv 1 1 0\nf 1 2 3\n", "DIR/a.obj: vertex 1 is not finite: (inf, 0, 0)");
    let text = format!("{CAMERA}[[meshes]]\nname = \"a\"\nfile = \"a.obj\"\n");
    let file: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3\n";
    check_with(
        &[("a.obj", file)],
        &text,
        "DIR/a.mtl: cannot read this material library: No such file or directory (os error 2)",
    );
    check_with(&[("a.obj", file), ("a.mtl", &b"newmtl red\nKd 1 0 0\n"[..])], &text, "no error");
}
