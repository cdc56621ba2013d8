//! Parameters that a package leaves open: scenes set them, sessions change them, and no compiler runs for that.

use crate::{GAIN, Place, ball};
use oslcl_runtime::device::Device;
use oslcl_runtime::render;
use oslcl_runtime::scene::{self, Material, MaterialId, ParamValue};
use oslcl_runtime::session::Session;
use std::sync::atomic::{AtomicU64, Ordering};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

#[test]
fn open_parameters_are_the_scenes() {
    let at = Place::new("open");
    at.write("gain.osl", GAIN);
    at.write("declared.osl", "surface declared(float Kd = 0.5 [[ int interactive = 1 ]]) { Ci = Kd * diffuse(N); }");
    at.pack("gain.oslpak", &["gain.osl", "declared.osl", "--interactive", "gain:Kd", "--interactive", "Cs"]);
    let info = at.oslcl(&["info", "gain.oslpak"]).succeeds().out;
    assert_eq!(info.matches("(interactive)").count(), 3, "{info}");
    let with = |params: &str| ball(&format!("shader = \"gain.oslpak:gain\"\nparams = {{ {params} }}"));
    let mut pictures = Vec::new();
    for kd in [0.25, 0.5, 1.0] {
        let params = format!("Kd = {kd}, Cs = [1, 0.5, 0.25]");
        let (picture, err) = at.render(&with(&params), &[]);
        assert!(err.contains("1 compiled, 1 from packages"), "{err}");
        // What the device is given is the same whatever the value.
        assert!(kd == 0.25 || err.contains(" 0 built"), "{err}");
        let pixels = oslcl_runtime::film::read_exr(&at.0.join("out.exr")).expect("a picture").pixels;
        at.render(&ball(&format!("shader = \"gain.osl\"\nparams = {{ {params} }}")), &[]);
        let baked = oslcl_runtime::film::read_exr(&at.0.join("out.exr")).expect("a picture").pixels;
        for (a, b) in pixels.iter().zip(&baked) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 1e-5 * b[c].abs()), "Kd = {kd}: {a:?}, compiled {b:?}");
        }
        pictures.push(picture);
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2], "values change nothing");
    // What is not set has its default.
    let (default, _) = at.render(&with("Cs = [1, 0.5, 0.25]"), &[]);
    assert!(default == pictures[1], "a default is not the default");
    at.refuses(&with("Kd = [1, 2]"), &[], &["scene.toml:14:17", "does not fit parameter `Kd`", "float"]);
    at.refuses(&with("n = 3"), &[], &["parameter `n`", "value 2", "--interactive n"]);
    at.refuses(&with("Kd = 1"), &["--without", "interactive"], &["`--without interactive`", "Kd, Cs"]);
    // Strings have the same ids everywhere.
    at.write(
        "says.osl",
        "surface says(string mode = \"a\") { if (mode == \"other\") printf(\"in mode %s\\n\", mode); Ci = 0; }",
    );
    at.pack("says.oslpak", &["says.osl", "--interactive", "mode"]);
    let says = |params: &str| at.render(&ball(&format!("shader = \"says.oslpak\"\nparams = {{ {params} }}")), &[]).1;
    assert!(says("mode = \"other\"").contains("material `m`: in mode other ("));
    assert!(!says("mode = \"a\"").contains("in mode"));
    // Two names that only a scene tells are not compared with each other.
    at.write(
        "asks.osl",
        "surface asks(string n = \"a\") { color c = 0; setmessage(n, color(1)); getmessage(n, c); Ci = c * emission(); }",
    );
    at.pack("asks.oslpak", &["asks.osl"]);
    at.oslcl(&["compile", "asks.osl", "-o", "asks.oslpak", "--interactive", "n"])
        .fails(1, &["E3003", "message's name", "left open: n"]);
    // Around the scene, too.
    at.pack("sky.oslpak", &["flat_sky", "--interactive", "radiance"]);
    let sky = |radiance: f64| {
        let scene = ball("shader = \"matte\"").replace(
            "shader = \"flat_sky\"",
            &format!("shader = \"sky.oslpak\"\nparams = {{ radiance = {radiance} }}"),
        );
        at.render(&scene, &[]);
        oslcl_runtime::film::read_exr(&at.0.join("out.exr")).expect("a picture").pixels[0]
    };
    assert_eq!((sky(0.25), sky(2.0)), ([0.25; 3], [2.0; 3]));
    // `*`: all that are no strings.
    at.pack("all.oslpak", &["gain.osl", "--interactive", "*"]);
    let info = at.oslcl(&["info", "all.oslpak"]).succeeds().out;
    assert_eq!(info.matches("(interactive)").count(), 4, "{info}");
    at.render(&ball("shader = \"all.oslpak\"\nparams = { n = 3, half_of = 2 }"), &[]);
    // Names of texture files have to be known.
    at.oslcl(&["compile", "-o", "x.oslpak", "textured", "--interactive", "file"])
        .fails(1, &["E3003", "a texture's file name", "these parameters are left open: file"]);
    let wrong = |args: &[&str], parts: &[&str]| {
        at.oslcl(&[&["compile", "-o", "x.oslpak", "gain.osl", "declared.osl"], args].concat()).fails(2, parts);
        assert!(!at.0.join("x.oslpak").exists());
    };
    wrong(
        &["--interactive", "halfof"],
        &["--interactive halfof", "no shader of the package", "did you mean `half_of`?"],
    );
    wrong(&["--interactive", "gian:Kd"], &["no shader of the package is called `gian`", "`gain`?"]);
    wrong(&["--interactive", "declared:Cs"], &["`declared` has no parameter `Cs`"]);
    wrong(&["-p", "Kd=1"], &["--param Kd=1", "SHADER:Kd=1"]);
    wrong(&["-p", "none:Kd=1"], &["no shader of the package is called `none`"]);
    at.oslcl(&["compile", "gain.osl", "--interactive", "Kd"]).fails(2, &["--interactive", "NAME.oslpak"]);
}

/// Counts the compiler's spans.
struct Watch(AtomicU64);

static WATCH: Watch = Watch(AtomicU64::new(0));

impl Subscriber for &'static Watch {
    fn enabled(&self, data: &Metadata<'_>) -> bool {
        data.is_span() && data.target().starts_with("oslcl_compiler")
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1 + self.0.fetch_add(1, Ordering::Relaxed))
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, _: &Event<'_>) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

/// All that happens in this process is here: other tests run the command.
#[test]
fn no_compiler_runs_and_sessions_change_what_is_open() {
    let at = Place::new("session");
    at.write("gain.osl", GAIN);
    at.pack("all.oslpak", &["gain.osl", "flat_sky", "--interactive", "gain:Kd"]);
    tracing::subscriber::set_global_default(&WATCH).expect("nobody else watches this process");
    let scene = |shader: &str, sky: &str| {
        let text = ball(&format!("shader = \"{shader}\"\ninteractive = [\"Kd\"]")).replace("flat_sky", sky);
        scene::parse(&text, &at.0.join("scene.toml")).expect("a scene")
    };
    let packed = scene("all.oslpak:gain", "all.oslpak:flat_sky");
    let device = Device::open(None).expect("a device");
    let options = render::Options::default();
    let ball = MaterialId(packed.materials.iter().position(|m| m.name == "m").expect("it is there") as u32);
    let pictures = |scene: &scene::Scene| {
        let mut session = Session::new(scene, &device, &options).expect("it is made ready");
        [0.25, 0.5].map(|kd| {
            session.set(ball, "Kd", &ParamValue::Float(kd)).expect("it is open");
            let (picture, summary) = session.render(&mut |_| {}).expect("it renders");
            (picture.pixels, summary.shaders)
        })
    };
    let from_package = pictures(&packed);
    let (picture, summary) = render::render(&packed, &device, &options, &mut |_| {}).expect("it renders");
    assert_eq!(summary.shaders, (0, 2));
    assert!(picture.pixels == from_package[1].0, "0.5 is the default");
    assert_eq!(WATCH.0.load(Ordering::Relaxed), 0, "something was compiled");
    let from_osl = pictures(&scene("gain.osl", "flat_sky"));
    assert!(WATCH.0.load(Ordering::Relaxed) > 0, "nobody watches the compiler");
    assert_eq!((from_package[0].1, from_osl[0].1), ((0, 2), (2, 0)));
    for (packed, plain) in from_package.iter().zip(&from_osl) {
        assert!(packed.0 == plain.0, "the pictures differ");
    }
    assert!(from_package[0].0 != from_package[1].0, "the value changes nothing");
    // What is built into the code can't change.
    let mut session = Session::new(&packed, &device, &options).expect("it is made ready");
    let refused = session.set(ball, "n", &ParamValue::Int(3)).expect_err("it is built in").to_string();
    assert!(refused.contains("`n` is no interactive parameter; these are: Kd"), "{refused}");
    let mut wrong = packed.clone();
    wrong.materials[ball.0 as usize].interactive = vec!["n".to_owned()];
    let refused = Session::new(&wrong, &device, &options).err().expect("it is built in").to_string();
    assert!(
        refused.contains("`n` of shader `gain` can't be interactive") && refused.contains("--interactive n"),
        "{refused}"
    );
    // As programs name packages.
    let mut built = packed.clone();
    let mine = Material::from_package("m", &at.0.join("all.oslpak"), Some("gain")).with("Kd", ParamValue::Float(0.25));
    built.materials[ball.0 as usize] = mine;
    let (picture, _) = render::render(&built, &device, &options, &mut |_| {}).expect("it renders");
    assert!(picture.pixels == from_package[0].0, "the pictures differ");
}
