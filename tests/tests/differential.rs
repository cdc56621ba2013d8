//! Every built-in function, and whole shaders, on the device against the interpreter: as OpenCL C, and as SPIR-V where the device
//! takes it.
//!
//! Tolerance. Single precision: 2e-5 relative plus 2e-6 absolute; double precision: 1e-10 relative plus 1e-12 absolute. The
//! absolute part is times the largest argument where functions add up several of them ([`Reach::Narrow`]).
//! Where a value is beyond it, the shader may be ill-conditioned there (a step, a cancellation): then it must lie within
//! what arguments changed by an ulp or so give.

mod functions;

use functions::sources;
use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Options, Values};
use oslcl_runtime::device::Device;
use oslcl_runtime::roads::{self, Road};
use oslcl_tests::grid::{self, Case, Precision};
use oslcl_tests::points::{self, Reach};
use std::path::PathBuf;
use std::sync::Mutex;

/// Shaders per program: building takes longer than linearly.
const GROUP: usize = 16;

fn tolerance(precision: Precision) -> (f64, f64) {
    match precision {
        Precision::Single => (2e-5, 2e-6),
        Precision::Double => (1e-10, 1e-12),
    }
}

fn close(ours: f64, device: f64, (relative, absolute): (f64, f64), precision: Precision) -> bool {
    if ours.is_nan() || (precision == Precision::Single && ours.abs() >= f64::from(f32::MAX)) {
        return !device.is_finite() || device.abs() >= 3.4e38;
    }
    ours == device || (ours - device).abs() <= relative * ours.abs() + absolute
}

/// The point with each argument changed a little, by a factor of its own.
fn nudged(g: &Globals, by: f64, turn: u32) -> Globals {
    let mut state = turn.wrapping_mul(0x9e37_79b9) | 1;
    let mut factor = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        1.0 + by * (f64::from(state >> 8) / 8_388_608.0 - 1.0)
    };
    let mut triple = |v: [f64; 3]| v.map(|x| x * factor());
    Globals {
        p: triple(g.p),
        i: triple(g.i),
        n: triple(g.n),
        ng: triple(g.ng),
        dpdu: triple(g.dpdu),
        dpdv: triple(g.dpdv),
        ps: triple(g.ps),
        dpdtime: triple(g.dpdtime),
        dp: g.dp.map(&mut triple),
        di: g.di.map(&mut triple),
        dps: g.dps.map(&mut triple),
        du: g.du.map(|x| x * factor()),
        dv: g.dv.map(|x| x * factor()),
        u: g.u * factor(),
        v: g.v * factor(),
        time: g.time * factor(),
        dtime: g.dtime * factor(),
        ..g.clone()
    }
}

/// The outputs of a case at all points: name and reals.
fn expected(case: &Case, points: &[Globals]) -> Vec<Values> {
    case.master
        .evaluate_all(&case.options, &case.outputs, points)
        .unwrap_or_else(|e| panic!("{}: the interpreter: {e}", case.label))
}

/// The largest number among a point's arguments, at least 1.
fn scale(g: &Globals) -> f64 {
    let triples = [g.p, g.i, g.n, g.ng, g.dpdu, g.dpdv, g.ps, g.dpdtime];
    let numbers = triples.iter().flatten().chain([&g.u, &g.v, &g.time, &g.dtime]);
    numbers.fold(1.0, |a, b| a.max(b.abs()))
}

/// Compares one case; what differs, in words.
fn compare(
    case: &Case,
    (precision, reach): (Precision, Reach),
    points: &[Globals],
    device: &[&[f64]],
    out: &mut Vec<String>,
) -> (usize, usize) {
    let (mut strict, mut lenient) = (0, 0);
    let step = if precision == Precision::Single { 4e-7 } else { 1e-14 };
    for ((point, device), ours) in points.iter().zip(device).zip(expected(case, points)) {
        let mut at = 0;
        let (relative, absolute) = tolerance(precision);
        let limits = (relative, if reach == Reach::Narrow { absolute * scale(point) } else { absolute });
        let mut around: Option<Vec<Values>> = None;
        for (o, (name, reals)) in ours.iter().enumerate() {
            for (k, value) in reals.iter().enumerate() {
                let found = device[at];
                at += 1;
                if close(*value, found, limits, precision) {
                    strict += 1;
                    continue;
                }
                let around = around.get_or_insert_with(|| {
                    let near: Vec<Globals> = (0..24).map(|turn| nudged(point, step, turn)).collect();
                    expected(case, &near)
                });
                let values = || around.iter().map(|p| p[o].1[k]).chain([*value]);
                let (low, high) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
                let slack = 2.0 * (high - low);
                let irregular = values().any(|v| v.is_nan()) && found.is_nan();
                if irregular || (found >= low - slack && found <= high + slack && slack > 0.0) {
                    lenient += 1;
                    continue;
                }
                if out.len() < 60 {
                    let args = format!(
                        "P {:?} I {:?} N {:?} u {} v {} time {} dtime {}",
                        point.p, point.i, point.n, point.u, point.v, point.time, point.dtime
                    );
                    out.push(format!(
                        "{precision:?} {}.{name}[{k}]: the interpreter {value}, the device {found}; {args}",
                        case.label
                    ));
                } else {
                    return (strict, lenient);
                }
            }
        }
    }
    (strict, lenient)
}

fn check(precision: Precision, reach: Reach, cases: &[Case], points: &[Globals]) {
    // PoCL finds no device while another thread asks for one.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let device = Device::open(None).expect("a device");
    if precision == Precision::Double && !device.info.double {
        eprintln!("skipped: the device has no 64-bit floats");
        return;
    }
    let mut wrong = Vec::new();
    let (mut strict, mut lenient) = (0, 0);
    let mut roads = vec![Road::OpenClC];
    match roads::check(&device, Road::Spirv) {
        Ok(()) => roads.push(Road::Spirv),
        Err(cause) => println!("skipped: SPIR-V: {cause}"),
    }
    for (group, road) in cases.chunks(GROUP).flat_map(|g| roads.iter().map(move |r| (g, *r))) {
        let run = grid::run_by((road, ""), &device, precision, group, points);
        let values = run.unwrap_or_else(|e| panic!("{e}"));
        let mut from = 0;
        for case in group {
            let width: usize = expected(case, &points[..1])[0].iter().map(|(_, r)| r.len()).sum();
            let part: Vec<&[f64]> = values.iter().map(|v| &v[from..from + width]).collect();
            from += width;
            let before = wrong.len();
            let counts = compare(case, (precision, reach), points, &part, &mut wrong);
            strict += counts.0;
            lenient += counts.1;
            wrong.truncate(before + 4);
        }
    }
    // Ill-conditioned points are the exception, or the test would hold nothing.
    assert!(50 * lenient < strict, "{lenient} values needed leniency, {strict} did not");
    assert!(wrong.is_empty(), "{} differences, the first of each shader:\n{}", wrong.len(), wrong.join("\n"));
}

fn function_cases(componentwise: bool) -> Vec<Case> {
    sources(componentwise)
        .iter()
        .map(|(label, source)| {
            Case::new(label, source, Options::default()).unwrap_or_else(|e| panic!("{label}: {e}\n{source}"))
        })
        .collect()
}

fn corpus() -> Vec<Case> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus/run");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).expect("the corpus").flatten().map(|e| e.path()).collect();
    files.sort();
    let mut cases = Vec::new();
    for file in files.iter().filter(|f| f.extension().is_some_and(|e| e == "osl")) {
        let label = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let source = std::fs::read_to_string(file).expect("a shader");
        cases.push(Case::new(&label, &source, Options::default()).unwrap_or_else(|e| panic!("{e}")));
    }
    cases
}

#[test]
fn every_function_is_called() {
    use oslcl_compiler::builtins::{Lowering, TABLE};
    let mut text: String = sources(true).into_iter().chain(sources(false)).map(|(_, source)| source).collect();
    // tests/textures.rs runs the second folder.
    for folder in ["corpus/run", "corpus/textures"] {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(folder).expect("the corpus").flatten() {
            text.push_str(&std::fs::read_to_string(entry.path()).expect("a shader"));
        }
    }
    let hidden = [
        Lowering::Internal,
        Lowering::InternalState,
        Lowering::InternalEffect,
        Lowering::InternalHost,
        Lowering::Host,
        Lowering::NotYet,
    ];
    let called = |name: &str| [" ", "(", "+"].iter().any(|before| text.contains(&format!("{before}{name}(")));
    let missing: Vec<&str> =
        TABLE.iter().filter(|r| !hidden.contains(&r.lowering) && !called(r.name)).map(|r| r.name).collect();
    assert!(missing.is_empty(), "no test calls {missing:?}");
}

#[test]
fn functions_of_components_in_single_precision() {
    check(Precision::Single, Reach::Wide, &function_cases(true), &points::pools(48, 48, Reach::Wide));
}

#[test]
fn functions_of_components_in_double_precision() {
    check(Precision::Double, Reach::Wide, &function_cases(true), &points::pools(48, 48, Reach::Wide));
}

#[test]
fn other_functions_in_single_precision() {
    check(Precision::Single, Reach::Narrow, &function_cases(false), &points::pools(48, 48, Reach::Narrow));
}

#[test]
fn other_functions_in_double_precision() {
    check(Precision::Double, Reach::Narrow, &function_cases(false), &points::pools(48, 48, Reach::Narrow));
}

#[test]
fn shaders_in_single_precision() {
    check(Precision::Single, Reach::Narrow, &corpus(), &points::grid(8));
}

#[test]
fn shaders_in_double_precision() {
    check(Precision::Double, Reach::Narrow, &corpus(), &points::grid(8));
}
