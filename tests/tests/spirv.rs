//! SPIR-V: every shader's modules are valid, and compute what OpenCL C computes.
//!
//! In: the corpus, the calls of every built-in, a scene; spirv-val, and a device that takes SPIR-V, itself or by LLVM's tools. Out:
//! pass or fail; what is missing on this machine is said on one line. differential.rs holds SPIR-V to the interpreter.
//!
//! Tolerance between the roads: none, as long as neither contracts `a * b + c` to one rounding. OpenCL C allows that within an
//! expression, whose parts are instructions of their own in SPIR-V; with it, values may differ as far as differential.rs lets
//! them differ from the interpreter.

mod functions;

use functions::sources;
use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Entry, Master, NoIncludes, Options};
use oslcl_runtime::device::Device;
use oslcl_runtime::film::compare::mean;
use oslcl_runtime::precision as shade_precision;
use oslcl_runtime::render;
use oslcl_runtime::roads::{self, Road};
use oslcl_runtime::scene::{self, Film};
use oslcl_runtime::shade::{self, Grid};
use oslcl_runtime::textures::Library;
use oslcl_tests::grid::{self, Case, Precision};
use oslcl_tests::points::{self, Reach};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};

/// Shaders per program.
const GROUP: usize = 16;

/// The `.osl` files, in order of their names: label and text.
fn files() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut out = Vec::new();
    for folder in FOLDERS {
        let mut paths: Vec<PathBuf> =
            std::fs::read_dir(root.join(folder)).expect("a folder of shaders").flatten().map(|e| e.path()).collect();
        paths.sort();
        for path in paths.iter().filter(|p| p.extension().is_some_and(|e| e == "osl")) {
            let name = format!("{folder}/{}", path.file_name().unwrap_or_default().to_string_lossy());
            out.push((name, std::fs::read_to_string(path).expect("a readable shader")));
        }
    }
    out
}

/// Everything that compiles: the corpus, the shipped materials.
const FOLDERS: [&str; 4] = ["tests/corpus", "tests/corpus/run", "tests/corpus/textures", "shaders-osl"];

/// What spirv-val says of a module; `None` when it has nothing to say.
fn complaint(words: &[u32]) -> Option<String> {
    let mut child = Command::new("spirv-val")
        .args(["--target-env", "opencl1.2", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("spirv-val starts");
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_ne_bytes()).collect();
    child.stdin.take().expect("a pipe").write_all(&bytes).expect("spirv-val reads");
    let output = child.wait_with_output().expect("spirv-val ends");
    let said = [output.stdout, output.stderr].concat();
    (!output.status.success()).then(|| String::from_utf8_lossy(&said).into_owned())
}

/// Names of a shader's output parameters that are numbers.
fn numeric_outputs(master: &Master) -> Vec<String> {
    oslcl_runtime::shade::default_outputs(master.info())
}

#[test]
fn every_module_is_valid() {
    if Command::new("spirv-val").arg("--version").output().is_err() {
        println!("skipped: this machine has no spirv-val");
        return;
    }
    let library = Arc::new(Library::default());
    let mut problems = Vec::new();
    let mut modules = 0;
    for (label, text) in files() {
        let textures = Some(library.access());
        let options = Options { file_name: label.clone(), spirv: true, textures, ..Options::default() };
        let master = Master::new(&text, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        for entry in [Entry::Material, Entry::Grid(numeric_outputs(&master))] {
            let artifact = master.instance(&Options { entry: entry.clone(), ..options.clone() });
            let artifact = artifact.unwrap_or_else(|e| panic!("{e}")).artifact;
            let spirv = artifact.spirv.expect("it was asked for");
            for words in [&spirv.single, &spirv.double] {
                modules += 1;
                if let Some(said) = complaint(words) {
                    problems.push(format!("{label} as {entry:?}: {said}"));
                }
            }
        }
    }
    println!("{modules} modules");
    assert!(modules > 400, "only {modules} modules");
    assert!(problems.is_empty(), "{} invalid modules\n{}", problems.len(), problems.join("\n"));
}

/// A device that takes SPIR-V by some road.
fn device() -> Option<Device> {
    let Ok(device) = Device::open(None) else {
        println!("skipped: this machine has no OpenCL device");
        return None;
    };
    match roads::check(&device, Road::Spirv) {
        Ok(()) => Some(device),
        Err(missing) => {
            println!("skipped: {missing}");
            None
        }
    }
}

/// How many representable numbers lie between two.
fn ulps(a: f64, b: f64, precision: Precision) -> u64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0;
    }
    if a.is_nan() || b.is_nan() {
        return u64::MAX;
    }
    let ordered = |bits: i64, sign: i64| if bits < 0 { sign - bits } else { bits };
    let place = |x: f64| match precision {
        Precision::Single => ordered(i64::from((x as f32).to_bits() as i32), i64::from(i32::MIN)),
        Precision::Double => ordered(x.to_bits() as i64, i64::MIN),
    };
    place(a).abs_diff(place(b))
}

/// PoCL finds no device while another thread asks for one.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// The two roads on one device.
fn compare(precision: Precision, cases: &[Case], points: &[Globals]) {
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let Some(device) = device() else { return };
    if precision == Precision::Double && !device.info.double {
        println!("skipped: the device has no 64-bit floats");
        return;
    }
    let mut problems = Vec::new();
    let mut same = 0u64;
    for group in cases.chunks(GROUP) {
        let run = |road| {
            grid::run_by((road, grid::UNCONTRACTED), &device, precision, group, points)
                .unwrap_or_else(|e| panic!("{e}"))
        };
        let (opencl, spirv) = (run(Road::OpenClC), run(Road::Spirv));
        for (point, (a, b)) in opencl.iter().zip(&spirv).enumerate() {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                match ulps(*a, *b, precision) {
                    0 => same += 1,
                    n => {
                        let label = owner(group, k);
                        problems.push(format!("{label} at point {point}: OpenCL C {a}, SPIR-V {b}: {n} ulp"));
                    }
                }
            }
        }
    }
    println!("{same} values are the same to the bit, {} not", problems.len());
    assert!(same > 0, "nothing was compared");
    problems.truncate(60);
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// Which shader stores number `k`.
fn owner(group: &[Case], k: usize) -> String {
    let mut from = 0;
    for case in group {
        let artifact = case.master.instance(&case.options).expect("it ran").artifact;
        for output in &artifact.outputs {
            let to = from + output.reals as usize;
            if k < to {
                return format!("{}.{}[{}]", case.label, output.name, k - from);
            }
            from = to;
        }
    }
    String::new()
}

fn of_functions(componentwise: bool) -> Vec<Case> {
    let case = |(label, source): &(String, String)| {
        Case::new(label, source, Options::default()).unwrap_or_else(|e| panic!("{label}: {e}\n{source}"))
    };
    sources(componentwise).iter().map(case).collect()
}

/// The shaders of files that run on bare points; and those that need more of a renderer: textures, inputs, lobes, messages.
fn of_files() -> (Vec<Case>, Vec<Case>) {
    let (mut plain, mut others) = (Vec::new(), Vec::new());
    let library = Arc::new(Library::default());
    for (label, text) in files() {
        let options = Options { file_name: label.clone(), ..Options::default() };
        let master = Master::new(&text, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let outputs = numeric_outputs(&master);
        let options = Options { entry: Entry::Grid(outputs.clone()), textures: Some(library.access()), ..options };
        let artifact = master.instance(&options).unwrap_or_else(|e| panic!("{e}")).artifact;
        let slots = artifact.inputs.userdata_slots + artifact.inputs.interactive_slots;
        let bare = artifact.textures.is_empty() && artifact.lobes.is_empty() && artifact.sites.is_empty() && slots == 0;
        let case = Case { label, master, options, outputs };
        if bare { plain.push(case) } else { others.push(case) }
    }
    (plain, others)
}

#[test]
fn shaders_in_single_precision() {
    compare(Precision::Single, &of_files().0, &points::grid(8));
}

#[test]
fn shaders_in_double_precision() {
    compare(Precision::Double, &of_files().0, &points::grid(8));
}

#[test]
fn shaders_that_need_more() {
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let Some(device) = device() else { return };
    let mut problems = Vec::new();
    let mut count = 0;
    let library = Library::default();
    for case in of_files().1 {
        let run = |spirv| {
            let options = Options { spirv, ..case.options.clone() };
            let compiled = shade::compile(&case.master, &options, &case.outputs);
            let mut artifact = compiled.unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(artifact.spirv.is_some(), spirv);
            let text = artifact.spirv.as_mut().map_or(&mut artifact.code, |s| &mut s.bridge);
            text.insert_str(0, grid::UNCONTRACTED);
            shade::run_with(&device, &artifact, Grid::new(7, 5), shade_precision::Precision::Standard, &library)
        };
        match (run(false), run(true)) {
            (Ok(a), Ok(b)) => {
                count += 1;
                if a.messages != b.messages {
                    problems.push(format!("{}: {:?} is not {:?}", case.label, a.messages, b.messages));
                }
                for (a, b) in a.planes.iter().zip(&b.planes) {
                    let differs = |(a, b): &(&f64, &f64)| ulps(**a, **b, Precision::Single) > 0;
                    if let Some((x, y)) = a.data.iter().zip(&b.data).find(differs) {
                        problems.push(format!("{}.{}: OpenCL C {x}, SPIR-V {y}", case.label, a.name));
                    }
                }
            }
            (Err(e), _) | (_, Err(e)) => problems.push(format!("{}: {e}", case.label)),
        }
    }
    println!("{count} shaders");
    assert!(count > 10, "only {count} shaders");
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn functions_in_single_precision() {
    compare(Precision::Single, &of_functions(true), &points::pools(16, 16, Reach::Wide));
    compare(Precision::Single, &of_functions(false), &points::pools(16, 16, Reach::Narrow));
}

#[test]
fn a_scene_looks_the_same() {
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let Some(device) = device() else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/r1.toml");
    let mut scene = scene::load(&path).expect("a scene");
    scene.film = Film { width: 64, height: 48 };
    scene.integrator.samples = 8;
    let picture = |road| {
        let options = render::Options { road, ..render::Options::default() };
        render::render(&scene, &device, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{e}")).0
    };
    let (opencl, spirv) = (picture(Road::OpenClC), picture(Road::Spirv));
    let differing = opencl.pixels.iter().zip(&spirv.pixels).filter(|(a, b)| a != b).count();
    println!("{differing} of {} pixels differ", opencl.pixels.len());
    // A contracted sum may turn a path another way now and then; the mean stays.
    let (a, b) = (mean(&opencl), mean(&spirv));
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= 1e-4 * a.abs(), "the means are {a} and {b}");
    }
    assert!(10 * differing < opencl.pixels.len(), "{differing} pixels differ");
}
