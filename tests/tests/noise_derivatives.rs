//! The noises' partial derivatives (kernels/osl/noise_*_d.h): the same values as the plain forms, slopes as differences of
//! those values say in double precision, and single precision near double precision.

use oslcl_runtime::assemble;
use oslcl_runtime::device::{Arg, Device, Program};
use std::fmt::Write;

/// A form of noise: its function without `_d`, its result's code, and how its arguments read the kernel's x[8].
struct Form {
    name: String,
    triple: bool,
    /// Arguments from an array of coordinates `c` (four, then four periods).
    arguments: &'static str,
    /// Number of coordinates.
    count: usize,
}

fn forms() -> Vec<Form> {
    let mut out = Vec::new();
    let plain = [
        ("f", "C[0]", 1),
        ("ff", "C[0], C[1]", 2),
        ("v", "(real3)(C[0], C[1], C[2])", 3),
        ("vf", "(real3)(C[0], C[1], C[2]), C[3]", 4),
    ];
    let periodic = [
        ("ff", "C[0], 3", 1),
        ("ffff", "C[0], C[1], 3, 5", 2),
        ("vv", "(real3)(C[0], C[1], C[2]), (real3)(2, 3, 4)", 3),
        ("vfvf", "(real3)(C[0], C[1], C[2]), C[3], (real3)(2, 3, 4), 7", 4),
    ];
    for (row, kinds, shapes) in [
        ("noise", &["perlin", "uperlin", "simplex", "usimplex"][..], plain),
        ("pnoise", &["perlin", "uperlin"][..], periodic),
    ] {
        for kind in kinds {
            for triple in [false, true] {
                let result = if triple { "v" } else { "f" };
                for (code, arguments, count) in shapes {
                    let name = format!("osl_{row}_{kind}_{result}_{code}");
                    out.push(Form { name, triple, arguments, count });
                }
            }
        }
    }
    out
}

/// Reals per form: the plain value, the value beside the slopes, four slopes, four differences, three components each.
const WIDTH: usize = 30;

fn program(forms: &[Form]) -> String {
    let mut body = String::new();
    for form in forms {
        let ty = if form.triple { "real3" } else { "real" };
        let read = |c: &str| form.arguments.replace('C', c);
        let slopes: Vec<String> = (0..form.count).map(|k| format!("&d[{k}]")).collect();
        let _ = write!(
            body,
            "    {{\n        {ty} d[4] = {{0, 0, 0, 0}};\n        {ty} value = {}({});\n        {ty} with = {}_d({}, {});\n        \
             PUT(value); PUT(with);\n        for (int k = 0; k < 4; ++k) PUT(d[k]);\n        \
             for (int k = 0; k < 4; ++k) {{\n            real high[4], low[4];\n            \
             for (int j = 0; j < 4; ++j) high[j] = low[j] = c[j];\n            high[k] += STEP;\n            \
             low[k] -= STEP;\n            PUT(({}({}) - {}({})) / (high[k] - low[k]));\n        }}\n    }}\n",
            form.name,
            read("c"),
            form.name,
            read("c"),
            slopes.join(", "),
            form.name,
            read("high"),
            form.name,
            read("low"),
        );
    }
    format!(
        "#include \"osl/noise_perlin_d.h\"\n#include \"osl/noise_simplex_d.h\"\n#define STEP 1e-5\n\
         static inline void put(__global real *out, int *at, real3 v) {{\n    out[*at] = v.x;\n    out[*at + 1] = v.y;\n    \
         out[*at + 2] = v.z;\n    *at += 3;\n}}\n#define PUT(v) put(out, &at, (real3)(v))\n\
         __kernel void slopes(__global const real *coordinates, __global real *out)\n{{\n    \
         const size_t i = get_global_id(0);\n    real c[4];\n    for (int k = 0; k < 4; ++k) c[k] = coordinates[4 * i + k];\n    \
         out += i * {};\n    int at = 0;\n{body}}}\n",
        WIDTH * forms.len()
    )
}

fn run(device: &Device, forms: &[Form], points: &[[f32; 4]], double: bool) -> Vec<f64> {
    let text = assemble::assemble("slopes.cl", &program(forms)).expect("the kernel's headers");
    let options = if double { "-cl-std=CL1.2 -D OSLCL_F64" } else { "-cl-std=CL1.2 -cl-single-precision-constant" };
    let program = Program::build(device, "slopes", &text, options).unwrap_or_else(|e| panic!("{e}"));
    let kernel = program.kernel(device, "slopes").expect("the kernel");
    let count = points.len() * WIDTH * forms.len();
    let coordinates: Vec<f32> = points.iter().flatten().copied().collect();
    if double {
        let wide: Vec<f64> = coordinates.iter().map(|x| f64::from(*x)).collect();
        let input = device.upload("coordinates", &wide).expect("memory");
        let out = device.buffer("out", 8 * count as u64).expect("memory");
        kernel.launch(device, &[Arg::Buffer(&input), Arg::Buffer(&out)], points.len(), 1).expect("a launch");
        device.read(&out, count).expect("the results")
    } else {
        let input = device.upload("coordinates", &coordinates).expect("memory");
        let out = device.buffer("out", 4 * count as u64).expect("memory");
        kernel.launch(device, &[Arg::Buffer(&input), Arg::Buffer(&out)], points.len(), 1).expect("a launch");
        device.read::<f32>(&out, count).expect("the results").into_iter().map(f64::from).collect()
    }
}

#[test]
fn slopes_are_those_of_the_values() {
    let device = Device::open(None).expect("a device");
    let forms = forms();
    // Away from lattice cells' borders, where the second derivative jumps.
    let mut state = 1_u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let cell = (state >> 28) as f32 - 8.0;
        cell + 0.05 + 0.9 * ((state >> 8) & 0xfffff) as f32 / 1_048_576.0
    };
    let points: Vec<[f32; 4]> = (0..200).map(|_| std::array::from_fn(|_| number())).collect();
    let single = run(&device, &forms, &points, false);
    let double = if device.info.double { run(&device, &forms, &points, true) } else { Vec::new() };
    let mut wrong = Vec::new();
    for (precision, values) in [("f32", &single), ("f64", &double)] {
        for (at, record) in values.chunks(WIDTH).enumerate() {
            let form = &forms[at % forms.len()];
            for k in 0..3 {
                let tolerance = if precision == "f32" { 1e-6 } else { 1e-14 };
                if (record[k] - record[3 + k]).abs() > tolerance {
                    wrong.push(format!("{precision} {}: value {} or {}", form.name, record[k], record[3 + k]));
                }
            }
        }
    }
    for (at, (wide, narrow)) in double.chunks(WIDTH).zip(single.chunks(WIDTH)).enumerate() {
        let form = &forms[at % forms.len()];
        for k in 0..3 * form.count {
            let (slope, difference, in_single) = (wide[6 + k], wide[18 + k], narrow[6 + k]);
            if (slope - difference).abs() > 1e-6 || (slope - in_single).abs() > 2e-4 {
                let point = points[at / forms.len()];
                wrong.push(format!(
                    "{} at {point:?}, number {k}: slope {slope}, difference {difference}, in f32 {in_single}",
                    form.name
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{} differ, first {:#?}", wrong.len(), &wrong[..wrong.len().min(12)]);
}
