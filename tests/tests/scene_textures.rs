//! Textures in renders: on surfaces, in environments, in displacement, missing ones.

use oslcl_runtime::film::Picture;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::scene::{self, Scene};
use oslcl_tests::{pictures, scenes};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// PoCL finds no device while another thread asks for one.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder for the pictures of one test, with those of `pictures` and one that is red on the left, blue on the right.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(folder.join("maps")).expect("a folder for pictures");
    pictures::write(&folder.join("maps"));
    let halves =
        image::ImageBuffer::from_fn(64, 64, |x, _| image::Rgb(if x < 32 { [204u8, 0, 51] } else { [51, 0, 204] }));
    halves.save(folder.join("maps/halves.png")).expect("a picture is written");
    folder
}

/// A wall that fills the picture, in an environment of radiance 1.
const WALL: &str = r#"
textures = ["maps"]
[camera]
origin = [0, 0, 5]
target = [0, 0, 0]
up = [0, 1, 0]
hfov = 22.6
[film]
width = 16
height = 16
[integrator]
samples = 16
max_depth = 4
[environment]
shader = "flat_sky"
[[meshes]]
name = "wall"
shape = "quad"
size = [2, 2]
material = "wall"
"#;

fn load(folder: &Path, text: &str) -> Scene {
    scene::parse(text, &folder.join("scene.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn pixel(picture: &Picture, x: usize, y: usize) -> [f32; 3] {
    picture.pixels[y * picture.width + x]
}

fn near(found: [f32; 3], wanted: [f32; 3], limit: f32) {
    let close = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= limit);
    assert!(close, "{found:?} is not {wanted:?}");
}

#[test]
fn a_surface_has_the_colours_of_its_texture() {
    let _alone = alone();
    let folder = folder("textured");
    for precision in [Precision::Standard, Precision::Reference] {
        let text = format!("{WALL}[materials.wall]\nshader = \"textured\"\nparams = {{ file = \"halves.png\" }}\n");
        let (picture, summary) = scenes::render(&load(&folder, &text), precision);
        assert!(summary.warnings.is_empty(), "{:?}", summary.warnings);
        // A flat wall sees nothing but the sky: it has the radiance of its albedo.
        near(pixel(&picture, 3, 8), [0.8, 0.0, 0.2], 2e-3);
        near(pixel(&picture, 12, 8), [0.2, 0.0, 0.8], 2e-3);
    }
}

#[test]
fn tiles_lie_where_their_numbers_say() {
    let _alone = alone();
    let folder = folder("tiles");
    let text = format!(
        "{WALL}[materials.wall]\nosl = '''surface s() {{ Ci = (color)texture(\"set.<UDIM>.png\", 2 * u, 2 * v, \
         \"missingcolor\", color(0.5)) * diffuse(N); }}'''\n"
    );
    let (picture, _) = scenes::render(&load(&folder, &text), Precision::Standard);
    let at = |x, y| pixel(&picture, x, y);
    let (lower, upper) = (12, 3);
    assert!(at(3, lower)[0] > 3.0 * at(3, lower)[2], "1001 is red: {:?}", at(3, lower));
    assert!(at(12, lower)[1] > 3.0 * at(12, lower)[0], "1002 is green: {:?}", at(12, lower));
    assert!(at(3, upper)[2] > 3.0 * at(3, upper)[0], "1011 is blue: {:?}", at(3, upper));
    near(at(12, upper), [0.5; 3], 2e-3);
}

#[test]
fn an_environment_can_be_a_map() {
    let _alone = alone();
    let folder = folder("map");
    let text = WALL.replace(
        "shader = \"flat_sky\"",
        "osl = '''surface s() { Ci = (color)environment(\"halves.png\", I) * background(); }'''",
    ) + "[materials.wall]\nshader = \"matte\"\nparams = { Cs = [0, 0, 0] }\n";
    let mut scene = load(&folder, &text);
    scene.instances.clear();
    // The seam of the map lies behind: y is up, and what is left of -z is the right half.
    scene.camera.target = scene.camera.origin + scene::DVec3::new(1.0, 0.0, 0.0);
    let (side, _) = scenes::render(&scene, Precision::Standard);
    scene.camera.target = scene.camera.origin - scene::DVec3::new(1.0, 0.0, 0.0);
    let (other, _) = scenes::render(&scene, Precision::Standard);
    let (a, b) = (pixel(&side, 8, 8), pixel(&other, 8, 8));
    near(a, [0.8, 0.0, 0.2], 2e-2);
    near(b, [0.2, 0.0, 0.8], 2e-2);
}

#[test]
fn a_missing_texture_is_black_and_told() {
    let _alone = alone();
    let folder = folder("missing");
    let text = format!("{WALL}[materials.wall]\nshader = \"textured\"\nparams = {{ file = \"lost.png\" }}\n");
    let (picture, summary) = scenes::render(&load(&folder, &text), Precision::Standard);
    near(pixel(&picture, 3, 8), [0.0; 3], 0.0);
    let [warning] = &summary.warnings[..] else { panic!("{:?}", summary.warnings) };
    for part in ["material `wall`", "`lost.png`", "shader `textured`", "No such file"] {
        assert!(warning.contains(part), "{warning}");
    }
}

#[test]
fn displacement_reads_textures() {
    let _alone = alone();
    let folder = folder("displaced");
    let text = format!(
        "{WALL}[materials.wall]\nosl = '''surface s() {{ Ci = P[2] * emission(); }}'''\ndisplacement = \"up\"\n\
         [materials.up]\nosl = '''displacement d() {{ P += (float)texture(\"halves.png\", 0.25, 0.5) * N; }}'''\n"
    )
    .replace("[environment]\nshader = \"flat_sky\"\n", "");
    let (picture, _) = scenes::render(&load(&folder, &text), Precision::Standard);
    near(pixel(&picture, 8, 8), [0.8; 3], 2e-3);
}
