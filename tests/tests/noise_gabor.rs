//! Gabor noise as a kernel function: filtered by a pixel's footprint as the reference filters (gabor.exr), its slopes as
//! differences of its values say, and its random numbers the same in both precisions.

use oslcl_runtime::assemble;
use oslcl_runtime::device::{Arg, Device, Program};
use oslcl_runtime::film::read_exr;
use std::path::PathBuf;

/// Reals per point: value, three slopes, three differences of values; triple and periodic value.
const WIDTH: usize = 13;

/// One set of options; x y z of the points, then the footprint along x and y.
fn run(device: &Device, options: &str, points: &[[f64; 9]], double: bool) -> Vec<f64> {
    let text = format!(
        "#include \"osl/noise_gabor.h\"\n#define AT(q) (q), dx, dy, {options}\n\
         __kernel void gabor(__global const real *points, __global real *out)\n{{\n    \
         const size_t i = get_global_id(0);\n    points += 9 * i;\n    out += {WIDTH} * i;\n    \
         real3 p = vload3(0, points), dx = vload3(1, points), dy = vload3(2, points);\n    real a, b, c;\n    \
         out[0] = osl_noise_gabor_f_vvvivffi_d(AT(p), &a, &b, &c);\n    out[1] = a;\n    out[2] = b;\n    out[3] = c;\n    \
         const real h = 1e-5;\n    real3 step[3] = {{(real3)(h, 0, 0), (real3)(0, h, 0), (real3)(0, 0, h)}};\n    \
         for (int k = 0; k < 3; ++k)\n        out[4 + k] = (osl_noise_gabor_f_vvvivffi(AT(p + step[k])) -\n                      \
         osl_noise_gabor_f_vvvivffi(AT(p - step[k]))) / (2 * h);\n    \
         vstore3(osl_noise_gabor_v_vvvivffi(AT(p)), 0, out + 7);\n    \
         vstore3(osl_pnoise_gabor_v_vvvvivffi(p, dx, dy, (real3)(2, 3, 4), {options}), 0, out + 10);\n}}\n"
    );
    let text = assemble::assemble("gabor.cl", &text).expect("the kernel's headers");
    let flags = if double { "-cl-std=CL1.2 -D OSLCL_F64" } else { "-cl-std=CL1.2 -cl-single-precision-constant" };
    let program = Program::build(device, "gabor", &text, flags).unwrap_or_else(|e| panic!("{e}"));
    let kernel = program.kernel(device, "gabor").expect("the kernel");
    let numbers: Vec<f64> = points.iter().flatten().copied().collect();
    let count = WIDTH * points.len();
    let local = if points.len().is_multiple_of(64) { 64 } else { 1 };
    if double {
        let input = device.upload("points", &numbers).expect("memory");
        let out = device.buffer("out", 8 * count as u64).expect("memory");
        kernel.launch(device, &[Arg::Buffer(&input), Arg::Buffer(&out)], points.len(), local).expect("a launch");
        device.read(&out, count).expect("the results")
    } else {
        let narrow: Vec<f32> = numbers.iter().map(|x| *x as f32).collect();
        let input = device.upload("points", &narrow).expect("memory");
        let out = device.buffer("out", 4 * count as u64).expect("memory");
        kernel.launch(device, &[Arg::Buffer(&input), Arg::Buffer(&out)], points.len(), local).expect("a launch");
        device.read::<f32>(&out, count).expect("the results").into_iter().map(f64::from).collect()
    }
}

const PLAIN: &str = "0, (real3)(1, 0, 0), 1, 16, 1";

fn filtered_picture(device: &Device) {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("reference/osl/gabor.exr");
    let picture = read_exr(&file).expect("a picture");
    let n = 256;
    let per_pixel = f64::from(10.0_f32 * (1.0_f32 / 255.0));
    let points: Vec<[f64; 9]> = (0..n * n)
        .map(|i| {
            let at = |k: u32| f64::from(10.0_f32 * (k as f32 / 255.0));
            [at(i % n), at(i / n), 10.0, per_pixel, 0.0, 0.0, 0.0, per_pixel, 0.0]
        })
        .collect();
    let values = run(device, PLAIN, &points, false);
    let errors = picture.pixels.iter().zip(values.chunks(WIDTH)).map(|(pixel, record)| {
        let error = (f64::from(pixel[0]) - (0.5 + 0.25 * record[0])).abs();
        if error.is_nan() { f64::INFINITY } else { error }
    });
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    let beyond = errors.iter().filter(|e| **e > 1e-5).count();
    let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
    assert!(beyond == 0, "{beyond} pixels beyond 1e-5; the median is {median:e}, the worst {worst:e}");
}

fn slopes(device: &Device) {
    let mut state = 7_u32;
    let mut number = |size: f64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(((f64::from(state >> 8) / 8_388_608.0 - 1.0) * size) as f32)
    };
    let points: Vec<[f64; 9]> =
        (0..64).map(|_| std::array::from_fn(|k| number(if k < 3 { 10.0 } else { 0.4 }))).collect();
    for options in [
        PLAIN,
        "1, (real3)(1, 0.3, -0.5), 2, 8, 1",
        "2, (real3)(0.5, 1, 0), 0.5, 32, 0",
        "0, (real3)(1, 0, 0), 1, 16, 0",
    ] {
        let double = run(device, options, &points, true);
        let single = run(device, options, &points, false);
        let mut far = 0;
        for (at, (wide, narrow)) in double.chunks(WIDTH).zip(single.chunks(WIDTH)).enumerate() {
            for k in 1..4 {
                let (slope, difference) = (wide[k], wide[k + 3]);
                let close = (slope - difference).abs() <= 1e-5 * (1.0 + slope.abs());
                // A difference over the edge of a kernel is no slope.
                far += usize::from(!close);
            }
            assert_eq!(wide[0], wide[7], "the first of three values is the single one");
            for k in [0, 8, 9, 10, 11, 12] {
                assert!((wide[k] - narrow[k]).abs() < 2e-4, "{options}, {:?}: {wide:?} and {narrow:?}", points[at]);
            }
        }
        assert!(far <= 4, "{options}: {far} slopes are not those of the values");
    }
}

#[test]
fn gabor_noise() {
    let device = Device::open(None).expect("a device");
    filtered_picture(&device);
    if device.info.double {
        slopes(&device);
    } else {
        eprintln!("skipped: the device has no 64-bit floats");
    }
}
