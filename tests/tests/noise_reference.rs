//! Noise on the device against pictures of OSL's reference implementation (tests/reference/osl).

use oslcl_compiler::Options;
use oslcl_runtime::device::Device;
use oslcl_runtime::film::read_exr;
use oslcl_tests::grid::{self, Case, Precision};
use oslcl_tests::points;
use std::path::PathBuf;

/// Shaders and their pictures.
const NAMES: [&str; 7] = ["nz_perlin", "nz_uperlin", "nz_cell", "nz_hash", "nz_simplex", "nz_usimplex", "gabor_aniso"];

#[test]
fn noise_agrees_with_the_reference() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("reference/osl");
    let mut cases = Vec::new();
    for kind in NAMES {
        let source = std::fs::read_to_string(folder.join(format!("{kind}.osl"))).expect("a shader");
        let mut case = Case::new(kind, &source, Options::default()).unwrap_or_else(|e| panic!("{e}"));
        case.outputs = vec!["Cout".to_owned()];
        case.options.entry = oslcl_compiler::Entry::Grid(case.outputs.clone());
        cases.push(case);
    }
    let n = 256;
    let points: Vec<_> = (0..n * n).map(|i| points::plane((i % n) as f32 / 255.0, (i / n) as f32 / 255.0)).collect();
    let device = Device::open(None).expect("a device");
    let values = grid::run(&device, Precision::Single, &cases, &points).unwrap_or_else(|e| panic!("{e}"));
    for (index, kind) in NAMES.iter().enumerate() {
        let picture = read_exr(&folder.join(format!("{kind}.exr"))).expect("a picture");
        assert_eq!((picture.width, picture.height), (n, n));
        let mut worst: f64 = 0.0;
        let mut beyond = 0;
        for (pixel, value) in picture.pixels.iter().zip(&values) {
            let ours = &value[3 * index..3 * index + 3];
            let error = pixel.iter().zip(ours).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
            worst = worst.max(error);
            beyond += usize::from(error.is_nan() || error > 1e-5);
        }
        assert!(beyond == 0, "{kind}: {beyond} of {} pixels differ by more than 1e-5, the worst by {worst}", n * n);
    }
}
