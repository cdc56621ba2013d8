//! Textures: lookups on the device against those on the host, answers of gettextureinfo, and files that are missing.
//!
//! Tolerance: 1e-4 in single precision, 1e-9 in double, absolute and relative. A lookup chooses numbers of samples and levels
//! of detail by comparisons; where rounding decides one of them otherwise, the value may differ: such points are counted, and
//! must be few.

use oslcl_compiler::{Master, NoIncludes, Options, Values};
use oslcl_runtime::device::Device;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::shade::{self, Grid, Shaded};
use oslcl_runtime::textures::{Library, Settings};
use oslcl_tests::pictures;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

/// Points each way: their coordinates are exact in binary.
const SIDE: u32 = 32;

/// The folder with the pictures.
fn folder() -> PathBuf {
    static WRITTEN: OnceLock<PathBuf> = OnceLock::new();
    let folder = WRITTEN.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("textures");
        std::fs::create_dir_all(&folder).expect("a folder for pictures");
        pictures::write(&folder);
        folder
    });
    folder.clone()
}

fn library(automip: bool) -> Arc<Library> {
    Arc::new(Library::new(Settings { search: vec![folder()], automip }))
}

fn grid() -> Grid {
    Grid { center: true, ..Grid::new(SIDE, SIDE) }
}

/// A shader, its settings, its outputs, the library that it looks textures up in.
struct Case {
    master: Master,
    options: Options,
    outputs: Vec<String>,
    library: Arc<Library>,
}

impl Case {
    fn new(source: &str, automip: bool) -> Case {
        let library = library(automip);
        let options = Options { textures: Some(library.access()), ..Options::default() };
        let master = Master::new(source, &options, &NoIncludes).unwrap_or_else(|e| panic!("{e}"));
        let outputs = shade::default_outputs(master.info());
        Case { master, options, outputs, library }
    }

    fn corpus(name: &str, automip: bool) -> Case {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/textures").join(format!("{name}.osl"));
        Case::new(&std::fs::read_to_string(path).expect("a shader"), automip)
    }

    fn device(&self, precision: Precision) -> Shaded {
        self.device_on(precision, grid())
    }

    fn device_on(&self, precision: Precision, grid: Grid) -> Shaded {
        // PoCL finds no device while another thread asks for one.
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
        let device = Device::open(None).expect("a device");
        let artifact = shade::compile(&self.master, &self.options, &self.outputs).unwrap_or_else(|e| panic!("{e}"));
        shade::run_with(&device, &artifact, grid, precision, &self.library).unwrap_or_else(|e| panic!("{e}"))
    }

    fn host(&self) -> Vec<Values> {
        let points: Vec<_> = (0..SIDE * SIDE).map(|i| grid().globals(i % SIDE, i / SIDE)).collect();
        self.master.evaluate_all(&self.options, &self.outputs, &points).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Compares all outputs at all points.
    fn compare(&self, precision: Precision) {
        let (device, host) = (self.device(precision), self.host());
        let limit = if precision.is_double() { 1e-9 } else { 1e-4 };
        for (o, plane) in device.planes.iter().enumerate() {
            let mut wrong = Vec::new();
            let mut spread = (f64::MAX, f64::MIN);
            for (i, values) in host.iter().enumerate() {
                let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
                for (found, wanted) in plane.point(x, y).iter().zip(&values[o].1) {
                    spread = (spread.0.min(*wanted), spread.1.max(*wanted));
                    let off = (found - wanted).abs();
                    if off.is_nan() || off > limit * wanted.abs().max(1.0) {
                        wrong.push(format!("{x} {y}: the host {wanted}, the device {found}"));
                    }
                }
            }
            let few = if precision.is_double() { 0 } else { SIDE as usize * SIDE as usize / 100 };
            assert!(
                wrong.len() <= few,
                "{precision:?} {}: {} differ: {:#?}",
                plane.name,
                wrong.len(),
                &wrong[..8.min(wrong.len())]
            );
            assert!(spread.1 > spread.0 || plane.ty == "int", "{}: always {}", plane.name, spread.0);
        }
    }
}

#[test]
fn planes_in_single_precision() {
    Case::corpus("plane", false).compare(Precision::Standard);
}

#[test]
fn planes_in_double_precision() {
    Case::corpus("plane", true).compare(Precision::Reference);
}

#[test]
fn other_lookups_in_single_precision() {
    Case::corpus("others", true).compare(Precision::Standard);
}

#[test]
fn other_lookups_in_double_precision() {
    Case::corpus("others", false).compare(Precision::Reference);
}

#[test]
fn derivatives_in_single_precision() {
    Case::corpus("derivatives", true).compare(Precision::Standard);
}

#[test]
fn derivatives_in_double_precision() {
    Case::corpus("derivatives", false).compare(Precision::Reference);
}

/// A derivative of a lookup is what its neighbours differ by.
#[test]
fn derivatives_are_differences() {
    let source = "shader s(output float c = 0, output float dx = 0, output float dy = 0) { c = texture(\"mip.tif\", u, v, 0, 0, 0, 0, \
                  \"wrap\", \"clamp\"); float d = texture(\"mip.tif\", u, v, 1, 0, 0, 1, \"width\", 0, \"wrap\", \"clamp\"); \
                  dx = Dx(d); dy = Dy(d); }";
    let case = Case::new(source, false);
    let fine = Grid { center: true, ..Grid::new(512, 512) };
    let shaded = case.device_on(Precision::Reference, fine);
    let at = |o: usize, x: u32, y: u32| shaded.planes[o].point(x, y)[0];
    for (x, y) in [(100, 100), (17, 300), (400, 31), (255, 256)] {
        let step = 2.0 / 512.0;
        let differences = [(at(0, x + 1, y) - at(0, x - 1, y)) / step, (at(0, x, y + 1) - at(0, x, y - 1)) / step];
        for (k, difference) in differences.into_iter().enumerate() {
            let slope = at(k + 1, x, y);
            assert!((slope - difference).abs() < 0.02 * difference.abs().max(1.0), "{slope} {difference}");
        }
    }
}

/// The numbers of an output at a point.
fn output(case: &Case, shaded: &Shaded, name: &str, x: u32, y: u32) -> Vec<f64> {
    let place = case.outputs.iter().position(|o| o == name).expect("an output");
    shaded.planes[place].point(x, y).to_vec()
}

#[test]
fn information_is_known_at_compile_time() {
    let case = Case::corpus("info", true);
    let shaded = case.device(Precision::Standard);
    let host = case.host();
    for (o, plane) in shaded.planes.iter().enumerate() {
        for (i, values) in host.iter().enumerate() {
            let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
            let close = plane.point(x, y).iter().zip(&values[o].1).all(|(a, b)| (a - b).abs() <= 1e-6);
            assert!(close, "{} at {x} {y}: {:?} {:?}", plane.name, plane.point(x, y), values[o].1);
        }
    }
    let at = |name: &str, x: u32, y: u32| output(&case, &shaded, name, x, y);
    assert_eq!(at("found", 0, 0), [1., 1., 1., 0., 1., 1., 1., 0.]);
    assert_eq!(at("size", 0, 0), [16., 16.]);
    assert_eq!(at("size3", 0, 0), [16., 16., 1.]);
    assert_eq!((at("channels", 0, 0), at("exists", 0, 0), at("lost", 0, 0)), (vec![3.], vec![1.], vec![0.]));
    assert_eq!(at("camera", 0, 0), (0..16).map(|i| f64::from(i) / 4.0).collect::<Vec<_>>());
    assert_eq!((at("data", 0, 0), at("display", 0, 0)), (vec![3., 2., 10., 5.], vec![0., 0., 15., 11.]));
    assert_eq!((at("texts", 0, 0), at("parts", 0, 0)), (vec![7.], vec![2.]));
    let last = SIDE - 1;
    assert_eq!([at("chosen", 0, 0), at("chosen", 0, last), at("chosen", last, last)], [[5.], [4.], [1.]]);
    assert_eq!([at("tile_size", 0, 0), at("tile_size", last, 0)], [[8., 8.], [4., 4.]]);
    assert_eq!([at("tile_found", 0, 0), at("tile_found", last, last)], [[1.], [0.]]);
    // Nothing is left to look up.
    let artifact = shade::compile(&case.master, &case.options, &case.outputs).unwrap_or_else(|e| panic!("{e}"));
    assert!(artifact.textures.is_empty() && !artifact.code.contains("texture"), "{}", artifact.code);
}

#[test]
fn missing_files_are_black_and_said_once() {
    let case = Case::new(
        "shader s(output color c = 1) { c = texture(\"lost.png\", u, v) + texture(\"lost.png\", v, u); }",
        false,
    );
    let shaded = case.device(Precision::Standard);
    assert_eq!(output(&case, &shaded, "c", 3, 3), [0.0; 3]);
    let [warning] = &shaded.warnings[..] else { panic!("{:?}", shaded.warnings) };
    assert!(
        warning.contains("`lost.png`") && warning.contains("shader `s`") && warning.contains("No such file"),
        "{warning}"
    );
}

#[test]
fn a_name_that_the_shader_makes_up_is_refused() {
    let source = "shader s(output color c = 1) { for (int i = 0; i < (int)(9 * u); i++) c += texture(format(\"%d.png\", i), u, v); }";
    let case = Case::new(source, false);
    let failure = shade::compile(&case.master, &case.options, &case.outputs).expect_err("a name that is not known");
    assert!(failure.to_string().contains("E3"), "{failure}");
}

#[test]
fn broken_files_are_told_from_missing_ones() {
    std::fs::write(folder().join("broken.png"), b"not a picture").expect("a file");
    let cut = std::fs::read(folder().join("mip.tif")).expect("a picture");
    std::fs::write(folder().join("cut.tif"), &cut[..cut.len() / 2]).expect("a file");
    let library = library(true);
    for name in ["broken.png", "cut.tif"] {
        let complaint = library.complaint(name).expect("a complaint");
        assert!(complaint.contains(name) && !complaint.contains("No such file"), "{complaint}");
    }
}
