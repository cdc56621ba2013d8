//! The scenes that ship load, and say what they should; the pictures on disk are read and written whole.

use oslcl_runtime::film::{self, Picture, compare};
use oslcl_runtime::scene::{self, ParamValue};
use std::path::{Path, PathBuf};

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

fn load(path: &str) -> scene::Scene {
    let scene = scene::load(&project(path)).unwrap_or_else(|error| panic!("{error}"));
    scene.check().unwrap_or_else(|error| panic!("{error}"));
    scene
}

#[test]
fn reference_scenes() {
    let room = load("tests/scenes/r1.toml");
    assert_eq!((room.instances.len(), room.materials.len(), room.environment), (8, 4, None));
    assert_eq!((room.integrator.max_depth, room.integrator.roulette_from), (8, None));
    let lamp = room.meshes.iter().find(|mesh| mesh.name == "lightquad").expect("it is listed");
    let [a, b, c] = lamp.triangles[0].map(|i| lamp.positions[i as usize]);
    assert!((b - a).cross(c - a).z < 0.0, "the lamp shines down");
    assert_eq!(lamp.uvs.len(), 4);
    let balls = load("tests/scenes/r2.toml");
    assert_eq!((balls.instances.len(), balls.integrator.max_depth), (7, 12));
    assert_eq!(balls.meshes[1].triangles.len(), 20164);
    assert_eq!(balls.meshes[1].normals.len(), 10084);
    let sky = &balls.materials[balls.environment.expect("it has a sky").0 as usize];
    assert_eq!(sky.params, [("radiance".to_string(), ParamValue::Floats(vec![0.35, 0.4, 0.5]))]);
}

#[test]
fn gallery_shows_every_surface_that_ships() {
    let gallery = load("scenes/gallery.toml");
    // One of them is no surface, the other needs a picture.
    for name in scene::names().filter(|name| !["flat_sky", "textured"].contains(name)) {
        let source = scene::shipped(name).expect("it is listed");
        assert!(gallery.materials.iter().any(|material| material.source == source), "{name} is not shown");
    }
}

#[test]
fn the_manual_has_a_scene_that_loads() {
    let page = std::fs::read_to_string(project("docs/scene.md")).expect("the page is there");
    let (_, rest) = page.split_once("```toml complete\n").expect("the example is marked");
    let (example, _) = rest.split_once("```").expect("the example ends");
    let scene = scene::parse(example, Path::new("docs/example.toml")).unwrap_or_else(|error| panic!("{error}"));
    scene.check().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.instances.len(), 5);
}

#[test]
fn reference_pictures_have_their_means() {
    for (name, expect) in [("R1", [0.264706_f64, 0.172545, 0.049511]), ("R2", [0.287749, 0.308169, 0.349970])] {
        let read = |path: String| film::read_exr(&project(&path)).unwrap_or_else(|error| panic!("{error}"));
        let picture = read(format!("tests/reference/{name}.exr"));
        for (found, expect) in compare::mean(&picture).iter().zip(expect) {
            // The files' own means: the note that came with R2 has its red 1e-4 darker.
            assert!((found - expect).abs() < 1e-5, "{name}: {found} is not {expect}");
        }
        assert_eq!(read(format!("tests/reference/{name}_stderr.exr")).pixels.len(), picture.pixels.len());
    }
}

#[test]
fn pictures_are_replaced_whole() {
    let folder = std::env::temp_dir().join(format!("oslcl-film-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let pixels = (0..40 * 33).map(|i| [i as f32, 0.5, -1e-9]).collect();
    let attributes = vec![("samples".to_string(), "64".to_string())];
    let picture = Picture { width: 40, height: 33, pixels, alpha: Vec::new(), attributes };
    let (exr, png) = (folder.join("a.exr"), folder.join("a.png"));
    for path in [&exr, &png] {
        film::check_output(path).expect("the folder is writable");
        film::write(path, &picture, 0.0).expect("it can be written");
    }
    let back = film::read_exr(&exr).expect("it was written");
    assert_eq!(back, picture);
    assert_eq!(compare::relative_mse(&back, &picture), Some(0.0));
    assert_eq!(compare::worst_tile(&back, &picture).expect("same size").error, 0.0);
    let broken = Picture { width: 41, ..picture };
    assert!(film::write(&exr, &broken, 0.0).is_err());
    assert_eq!(film::read_exr(&exr).expect("the good file stays"), back);
    let mut left: Vec<_> =
        std::fs::read_dir(&folder).expect("it is there").map(|f| f.expect("a file").file_name()).collect();
    left.sort();
    assert_eq!(left, ["a.exr", "a.png"]);
    let said = |path: &Path| {
        film::check_output(path).expect_err("it is wrong").to_string().replace(&folder.display().to_string(), "DIR")
    };
    assert_eq!(said(&folder.join("a.jpg")), "DIR/a.jpg: a picture's name must end in .exr or .png");
    assert_eq!(said(&folder.join("no/a.png")), "DIR/no/a.png: there is no folder DIR/no");
    std::fs::remove_dir_all(&folder).expect("it is ours");
}
