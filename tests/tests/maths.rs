//! The elementary functions of kernels/maths.h and maths_fast.h against the host's, on the first device: the errors that their heads
//! and docs/accuracy.md state. `cargo test --test maths -- --nocapture` prints what is measured.

use oslcl_runtime::assemble::assemble;
use oslcl_runtime::device::{Arg, Device, Program};
use oslcl_runtime::precision::Precision;

const POINTS: usize = 1 << 18;

/// What the error of a result is measured by.
type Scale = fn(x: f64, y: f64, exact: f64) -> f64;

struct Case {
    name: &'static str,
    call: &'static str,
    exact: fn(f64, f64) -> f64,
    /// From two numbers in [0, 1) to arguments.
    domain: fn(f64, f64) -> (f64, f64),
    /// What `fast` may be off by.
    fast: Scale,
    /// What `standard` may, in units in the last place; and beside them.
    standard: (f64, f64),
}

/// Evenly in the logarithm, between 2^-a and 2^a, of either sign.
fn spread(u: f64, a: f64) -> f64 {
    let v = 2.0 * u - 1.0;
    let turned = (v.abs() * 2.0 - 1.0) * a;
    turned.exp2().copysign(v)
}

fn cases() -> Vec<Case> {
    let log: fn(f64, f64) -> (f64, f64) =
        |u, v| (if v < 0.5 { 1.0 + spread(u, 18.0).clamp(-0.5, 1.0) } else { spread(u, 120.0).abs() }, 0.0);
    let log_error: Scale = |_, _, exact| 1.5e-6 * exact.abs() + 3e-7;
    let angle: fn(f64, f64) -> (f64, f64) = |u, v| (spread(u, if v < 0.9 { 16.0 } else { 100.0 }), 0.0);
    let power: Scale = |_, _, exact| exact.abs() * (3.5e-6 + 1.2e-7 * exact.abs().log2().abs());
    vec![
        Case {
            name: "sin",
            call: "m_sin(x)",
            exact: |x, _| x.sin(),
            domain: angle,
            fast: |_, _, _| 1.3e-6,
            standard: (3.0, 1e-14),
        },
        Case {
            name: "cos",
            call: "m_cos(x)",
            exact: |x, _| x.cos(),
            domain: angle,
            fast: |_, _, _| 1.3e-6,
            standard: (3.0, 1e-14),
        },
        Case {
            name: "tan",
            call: "m_tan(x)",
            exact: |x, _| x.tan(),
            domain: |u, v| (spread(u, 10.0) + 0.0 * v, 0.0),
            fast: |_, _, exact| 3e-6 * (1.0 + exact * exact),
            standard: (4.0, 1e-14),
        },
        Case {
            name: "atan",
            call: "m_atan(x)",
            exact: |x, _| x.atan(),
            domain: |u, _| (spread(u, 20.0), 0.0),
            fast: |_, _, _| 3e-6,
            standard: (2.0, 0.0),
        },
        Case {
            name: "atan2",
            call: "m_atan2(x, y)",
            exact: |x, y| x.atan2(y),
            domain: |u, v| (spread(u, 20.0), spread(v, 20.0)),
            fast: |_, _, _| 3.5e-6,
            standard: (2.5, 0.0),
        },
        Case {
            name: "exp",
            call: "m_exp(x)",
            exact: |x, _| x.exp(),
            domain: |u, _| (173.0 * u - 86.0, 0.0),
            fast: power,
            standard: (1.5, 0.0),
        },
        Case {
            name: "exp2",
            call: "m_exp2(x)",
            exact: |x, _| x.exp2(),
            domain: |u, _| (251.0 * u - 125.0, 0.0),
            fast: power,
            standard: (1.5, 0.0),
        },
        Case {
            name: "log",
            call: "m_log(x)",
            exact: |x, _| x.ln(),
            domain: log,
            fast: log_error,
            standard: (1.5, 0.0),
        },
        Case {
            name: "log2",
            call: "m_log2(x)",
            exact: |x, _| x.log2(),
            domain: log,
            fast: log_error,
            standard: (1.5, 0.0),
        },
        Case {
            name: "log10",
            call: "m_log10(x)",
            exact: |x, _| x.log10(),
            domain: log,
            fast: log_error,
            standard: (1.5, 0.0),
        },
        Case {
            name: "powr",
            call: "m_powr(x, y)",
            exact: f64::powf,
            domain: |u, v| {
                let x = spread(u, 20.0).abs();
                // The result within 2^-120 .. 2^120.
                (x, (2.0 * v - 1.0) * (120.0 / x.log2().abs()).min(30.0))
            },
            fast: |_, y, exact| exact.abs() * (4e-6 + 1.5e-6 * exact.log2().abs() + 3e-7 * y.abs()),
            standard: (4.0, 0.0),
        },
    ]
}

/// The values that a device computes, of arguments as it gets them.
fn run(device: &Device, case: &Case, precision: Precision) -> Vec<(f64, f64, f64)> {
    let text = format!(
        "#include \"maths.h\"\n__kernel void run(__global const float *in, __global float *out)\n{{\n    const size_t i = get_global_id(0);\n    \
         const float x = in[2 * i], y = in[2 * i + 1];\n    out[i] = {};\n}}\n",
        case.call
    );
    let text = assemble("maths.cl", &text).expect("the headers are there");
    let program =
        Program::build(device, "maths.cl", &text, precision.build_options()).unwrap_or_else(|e| panic!("{e}"));
    // Additive recurrences of the golden ratio's kind cover the square evenly.
    let arguments: Vec<f32> = (0..POINTS)
        .flat_map(|i| {
            let at = |step: f64| (0.5 + step * i as f64).fract();
            let (x, y) = (case.domain)(at(0.7548776662466927), at(0.5698402909980532));
            [x as f32, y as f32]
        })
        .collect();
    let input = device.upload("arguments", &arguments).expect("room");
    let output = device.buffer("values", 4 * POINTS as u64).expect("room");
    let kernel = program.kernel(device, "run").expect("the kernel");
    kernel.launch(device, &[Arg::Buffer(&input), Arg::Buffer(&output)], POINTS, 64).expect("it runs");
    let values: Vec<f32> = device.read(&output, POINTS).expect("values");
    let pairs = arguments.chunks(2).zip(values);
    pairs.map(|(a, v)| (f64::from(a[0]), f64::from(a[1]), f64::from(v))).collect()
}

/// The distance from one 32-bit float of this size to the next.
fn ulp(x: f64) -> f64 {
    let x = (x as f32).abs().max(f32::MIN_POSITIVE);
    f64::from(f32::from_bits(x.to_bits() + 1) - x)
}

#[test]
fn elementary_functions_are_as_exact_as_they_say() {
    let device = Device::open(None).expect("an OpenCL device");
    let mut failures = Vec::new();
    for case in cases() {
        for precision in [Precision::Standard, Precision::Fast] {
            let mut worst = (0.0, 0.0, 0.0);
            for (x, y, value) in run(&device, &case, precision) {
                let exact = (case.exact)(x, y);
                let allowed = match precision {
                    Precision::Fast => (case.fast)(x, y, exact),
                    _ => case.standard.0 * ulp(exact) + case.standard.1,
                };
                let part = (value - exact).abs() / allowed;
                // NaN is the worst.
                if part > worst.0 || part.is_nan() {
                    worst = (part, x, y);
                }
            }
            let (part, x, y) = worst;
            println!("{:<26}{precision:?}: {:.0} % of what is allowed, at {x:e}, {y:e}", case.name, 100.0 * part);
            if part > 1.0 || part.is_nan() {
                failures.push(format!("{} in {precision:?} at {x:e}, {y:e}: {part} of what is allowed", case.name));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
