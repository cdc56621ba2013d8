//! tests/reference/osl/special.txt: what the reference implementation printed for special arguments (special.osl beside it).
//!
//! Each line is compared but where a decision of ours, listed in [`decided`] or beside the case, differs.

use super::super::{call, call_with_outputs, ops};
use crate::ir::{BinaryOp, Const, Inst, Ty, UnaryOp, ValueId};
use std::f64::consts::PI;

const TEXT: &str = include_str!("../../../../tests/reference/osl/special.txt");

/// `vals` of special.osl.
const VALUES: [f32; 21] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    -2.0,
    1e-40,
    1e-20,
    1e20,
    1e30,
    -1e30,
    3.4e38,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1000.0,
    -1000.0,
    0.99999994,
    1.0000001,
];

/// `idx` of special.osl: which of them the functions of two arguments get.
const PAIRED: [usize; 10] = [0, 2, 3, 4, 5, 7, 10, 14, 15, 16];

fn numbers(c: &Const) -> Vec<f64> {
    match c {
        Const::Int(v) => vec![f64::from(*v)],
        Const::Float(v) => vec![*v],
        Const::Triple(v) => v.to_vec(),
        Const::Matrix(m) => m.to_vec(),
        _ => Vec::new(),
    }
}

fn evaluate(name: &str, ret: Ty, args: &[Const]) -> Const {
    let op = |op| ops::evaluate(&Inst::Binary(op, ValueId(0), ValueId(0)), ret, args);
    let value = match name {
        "neg" => ops::evaluate(&Inst::Unary(UnaryOp::Neg, ValueId(0)), ret, args),
        "int" => ops::evaluate(&Inst::Convert(ValueId(0)), Ty::Int, args),
        "div" => op(BinaryOp::Div),
        _ => call(name, ret, args),
    };
    value.unwrap_or_else(|| panic!("`{name}` has a value for {args:?}"))
}

fn float(name: &str, args: &[f64]) -> f64 {
    let args: Vec<Const> = args.iter().map(|x| Const::Float(*x)).collect();
    numbers(&evaluate(name, Ty::Float, &args))[0]
}

fn parse(word: &str) -> f64 {
    word.trim_start_matches('-').strip_prefix("nan").map_or_else(|| word.parse().expect("a number"), |_| f64::NAN)
}

/// Equal to the reference's accuracy: its elementary functions are fast approximations.
fn close(ours: f64, theirs: f64) -> bool {
    (ours.is_nan() && theirs.is_nan()) || ours == theirs || (ours - theirs).abs() <= 1e-5 * theirs.abs() + 2e-6
}

fn same(line: &str, ours: &[f64], theirs: &[f64]) {
    assert_eq!(ours.len(), theirs.len(), "{line}: ours {ours:?}");
    assert!(ours.iter().zip(theirs).all(|(a, b)| close(*a, *b)), "{line}: ours {ours:?}");
}

/// What we decided to differ in: our value, checked; `None` where the reference's value holds.
fn decided(name: &str, args: &[f64], theirs: f64) -> Option<fn(f64) -> bool> {
    let x = args[0];
    let finite = args.iter().all(|x| x.is_finite());
    let nan = args.iter().any(|x| x.is_nan());
    let anything: fn(f64) -> bool = |_| true;
    match name {
        // Exact far away; NaN for infinities.
        "sin" | "cos" | "tan" if !finite => Some(f64::is_nan),
        "sin" | "cos" | "tan" if x.abs() > 1e5 => Some(f64::is_finite),
        // NaN in, NaN out.
        "asin" | "acos" | "tanh" | "atan2" if nan => Some(f64::is_nan),
        "cbrt" if !finite => Some(|ours| !ours.is_finite()),
        // Sums of squares and products beyond float's range: f64 holds them.
        "hypot" | "degrees" if finite && theirs.is_infinite() => Some(f64::is_finite),
        // Right for any quotient: fmod(a, inf) = a, fmod(inf, b) = NaN, fmod(1e20, 1) = 0.
        "fmod" if !finite => Some(anything),
        "fmod" if x.abs() > 1e16 => Some(|ours| ours == 0.0),
        // The reference's polynomial is 7e-5 off.
        "asin" if x == 0.5 => Some(|ours| (ours - PI / 6.0).abs() < 1e-15),
        "asin" if x == -0.5 => Some(|ours| (ours + PI / 6.0).abs() < 1e-15),
        "acos" if x == 0.5 => Some(|ours| (ours - PI / 3.0).abs() < 1e-15),
        "acos" if x == -0.5 => Some(|ours| (ours - PI * 2.0 / 3.0).abs() < 1e-15),
        "asin" | "acos" if x > 0.9999999 && x < 1.0 => Some(|ours| (ours - 0.00034527).abs() < 1e-8 || ours > 1.57),
        _ => None,
    }
}

fn check(line: &str, name: &str, args: &[f64], theirs: f64) {
    let ours = float(name, args);
    match decided(name, args, theirs) {
        Some(holds) => assert!(holds(ours), "{line}: ours {ours}, against our own decision"),
        None => same(line, &[ours], &[theirs]),
    }
}

fn lines() -> impl Iterator<Item = &'static str> {
    TEXT.lines()
}

#[test]
fn functions_of_one_argument() {
    let mut values = VALUES.iter();
    let mut x = f64::NAN;
    for line in lines().take_while(|l| !l.starts_with("div ")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words[0] == "sin" {
            x = f64::from(*values.next().expect("a value per block"));
        }
        let theirs = parse(words[2]);
        match words[0] {
            "isnan" => {
                let ours = ["isnan", "isinf", "isfinite"].map(|n| float(n, &[x]));
                same(line, &ours, &[parse(words[2]), parse(words[4]), parse(words[6])]);
            }
            "normalize" => {
                let ours = numbers(&evaluate("normalize", Ty::Triple, &[Const::Triple([x, x, 0.0])]));
                let theirs: Vec<f64> = words[2..].iter().map(|w| parse(w)).collect();
                if x.is_finite() && x != 0.0 {
                    // Every vector but zero has a direction; the reference gives up on small and large ones.
                    same(line, &ours, &[x.signum() * 0.5_f64.sqrt(), x.signum() * 0.5_f64.sqrt(), 0.0]);
                } else if x.is_finite() {
                    same(line, &ours, &theirs);
                }
            }
            "smoothstep01" => same(line, &[float("smoothstep", &[0.0, 1.0, x])], &[theirs]),
            "smoothstep11" => same(line, &[float("smoothstep", &[1.0, 1.0, x])], &[theirs]),
            "linearstep" => same(line, &[float("linearstep", &[0.0, 1.0, x])], &[theirs]),
            name => check(line, name, &[x], theirs),
        }
    }
    assert!(values.next().is_none());
}

#[test]
fn functions_of_two_arguments() {
    let pair_lines = lines().skip_while(|l| !l.starts_with("div ")).take_while(|l| !l.starts_with("idiv0"));
    let mut pairs = PAIRED.iter().flat_map(|a| PAIRED.iter().map(move |b| [VALUES[*a], VALUES[*b]]));
    let mut args = [f64::NAN; 2];
    let mut count = 0;
    for line in pair_lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words[0] == "div" {
            args = pairs.next().expect("a pair per block").map(f64::from);
        }
        check(line, words[0], &args, parse(words[3]));
        count += 1;
    }
    assert_eq!(count, 1000);
}

/// The numbers of the line that starts with `prefix`, behind it; words that are no numbers are left out.
fn after(prefix: &str) -> (String, Vec<f64>) {
    let line = lines().find(|l| l.starts_with(prefix)).unwrap_or_else(|| panic!("a line starts with `{prefix}`"));
    let numbers = line[prefix.len()..].split_whitespace().filter_map(|w| w.parse().ok()).collect();
    (line.to_owned(), numbers)
}

fn f32s<const N: usize>(v: [f32; N]) -> [f64; N] {
    v.map(f64::from)
}

#[test]
fn integers() {
    let m = i32::MIN;
    let op = |op, a, b| {
        let args = [Const::Int(a), Const::Int(b)];
        numbers(&ops::evaluate(&Inst::Binary(op, ValueId(0), ValueId(0)), Ty::Int, &args).expect("an int"))[0]
    };
    use BinaryOp::*;
    let cases = [
        ("idiv0 ", op(Div, 1, 0)),
        ("imod0 ", op(Mod, 1, 0)),
        ("idivneg ", op(Div, -7, 2)),
        ("imodneg ", op(Mod, -7, 3)),
        ("imod() ", numbers(&evaluate("mod", Ty::Int, &[Const::Int(-7), Const::Int(3)]))[0]),
        ("shl33 ", op(Shl, 1, 3)),
        ("shrneg ", op(Shr, -16, 2)),
    ];
    for (prefix, ours) in cases {
        let (line, theirs) = after(prefix);
        same(&line, &[ours], &theirs);
    }
    // Wraps; the reference traps.
    assert_eq!(op(Div, m, -1), f64::from(m));
    assert_eq!(op(Mod, m, -1), 0.0);
    let (line, theirs) = after("hash ");
    let words: [&[Const]; 4] = [
        &[Const::Int(1)],
        &[Const::Float(0.5)],
        &[Const::Float(0.5), Const::Float(0.25)],
        &[Const::Triple(f32s([0.1, 0.2, 0.3]))],
    ];
    // hash("abc") is not supported yet.
    let ours: Vec<f64> = words.iter().map(|args| numbers(&evaluate("hash_value", Ty::Int, args))[0]).collect();
    same(&line, &ours, &theirs[..4]);
}

#[test]
fn vectors_and_matrices() {
    let zero = Const::Matrix([0.0; 16]);
    let (line, theirs) = after("invert singular ");
    same(&line, &ops::matrix_inverse(&[0.0; 16]), &theirs);
    let (line, theirs) = after("det0 ");
    same(&line, &numbers(&evaluate("determinant", Ty::Float, &[zero])), &theirs);
    let (line, theirs) = after("length0 ");
    same(&line, &numbers(&evaluate("length", Ty::Float, &[Const::Triple([0.0; 3])])), &theirs);
    let unit = |v| evaluate("normalize", Ty::Triple, &[Const::Triple(v)]);
    let up = Const::Triple([0.0, 1.0, 0.0]);
    let (line, theirs) = after("refract tir ");
    let tir = evaluate("refract", Ty::Triple, &[unit([1.0, -0.1, 0.0]), up.clone(), Const::Float(1.5)]);
    same(&line, &numbers(&tir), &theirs);
    let (line, theirs) = after("reflect ");
    let reflected = evaluate("reflect", Ty::Triple, &[Const::Triple([1.0, -1.0, 0.0]), up.clone()]);
    same(&line, &numbers(&reflected), &theirs);
    let fresnel: Vec<&str> = lines().filter(|l| l.starts_with("fresnel ")).collect();
    for (line, (i, eta)) in fresnel.iter().zip([([1.0, -0.1, 0.0], 1.5), ([1.0, -1.0, 0.0], 1.0 / 1.5)]) {
        let values = call_with_outputs("fresnel", &[unit(i), up.clone(), Const::Float(eta)]).expect("known");
        let ours: Vec<f64> = values.iter().flat_map(numbers).collect();
        let theirs: Vec<f64> = line.split_whitespace().skip(1).map(parse).collect();
        same(line, &ours, &theirs);
    }
}

#[test]
fn colours() {
    let c = Const::Triple(f32s([0.2, 0.5, 0.7]));
    for space in ["hsv", "hsl", "YIQ", "XYZ", "xyY"] {
        let (line, theirs) = after(&format!("to {space} "));
        let lower = space.to_lowercase();
        let mut ours = numbers(&evaluate(&format!("rgb_to_{lower}"), Ty::Triple, std::slice::from_ref(&c)));
        ours.extend(numbers(&evaluate(&format!("{lower}_to_rgb"), Ty::Triple, std::slice::from_ref(&c))));
        same(&line, &ours, &theirs);
    }
    let (line, theirs) = after("luminance ");
    same(&line, &numbers(&evaluate("luminance_rec709", Ty::Float, &[c])), &theirs);
    let spectral = |name: &str, at: &[f64]| -> Vec<f64> {
        at.iter().flat_map(|x| numbers(&evaluate(name, Ty::Triple, &[Const::Float(*x)]))).collect()
    };
    let (line, theirs) = after("wavelength ");
    same(&line, &spectral("wavelength_color_rec709", &[400.0, 580.0]), &theirs);
    let (line, theirs) = after("blackbody ");
    let ours = spectral("blackbody_rec709", &[800.0, 3000.0, 20000.0]);
    for (ours, theirs) in ours.iter().zip(theirs) {
        assert!((ours - theirs).abs() <= 2e-5 * theirs + 1e-6, "{line}: ours {ours}, theirs {theirs}");
    }
}

#[test]
fn splines() {
    let knots = |v: &[f64]| Const::Array(v.iter().map(|x| Const::Float(*x)).collect());
    let ks = knots(&[0.0, 1.0, 4.0, 2.0, -1.0, 3.0, 5.0]);
    for basis in ["catmull-rom", "bezier", "bspline", "hermite", "linear", "constant"] {
        let (line, theirs) = after(&format!("spline {basis} "));
        let row = format!("spline_{}", basis.replace('-', ""));
        let at = |x: f32| numbers(&evaluate(&row, Ty::Float, &[Const::Float(x.into()), ks.clone()]))[0];
        same(&line, &[at(0.3), at(-1.0), at(2.0)], &theirs);
    }
    let kn = knots(&[0.0, 0.0, 1.0, 2.0, 4.0, 4.0]);
    for (prefix, row) in [("splineinverse ", "splineinverse_linear"), ("splineinverse cr ", "splineinverse_catmullrom")]
    {
        let (line, theirs) = after(prefix);
        let ours = numbers(&evaluate(row, Ty::Float, &[Const::Float(2.5), kn.clone()]));
        same(&line, &ours, &theirs);
    }
}

#[test]
fn noises() {
    let points: [(&str, [f32; 3]); 5] = [
        ("point(0.1,0.2,0.3)", [0.1, 0.2, 0.3]),
        ("point(-3.7,12.5,0.25)", [-3.7, 12.5, 0.25]),
        ("point(1234.5,-987.25,55.125)", [1234.5, -987.25, 55.125]),
        ("point(1e6,2e6,3e6)", [1e6, 2e6, 3e6]),
        ("point(1e9,0,0)", [1e9, 0.0, 0.0]),
    ];
    for kind in ["perlin", "uperlin", "cell", "hash", "simplex", "usimplex"] {
        let row = format!("noise_{kind}");
        let simplex = kind.ends_with("simplex");
        for (text, p) in points {
            let (line, theirs) = after(&format!("noise {kind} {text} "));
            // The reference's simplex noise loses its digits there and ends at 0 (kernels/osl/noise_simplex.h).
            if simplex && p[0] > 1e3 {
                continue;
            }
            let p = Const::Triple(f32s(p));
            let mut ours = numbers(&evaluate(&row, Ty::Float, std::slice::from_ref(&p)));
            ours.extend(numbers(&evaluate(&row, Ty::Triple, &[p])));
            same(&line, &ours, &theirs);
        }
        let number = |x: f32| Const::Float(x.into());
        let p = Const::Triple(f32s([0.1, 0.2, 0.3]));
        let lists: [&[Const]; 4] =
            [&[number(1.3)], &[number(-2.7)], &[number(1.3), number(4.7)], &[p.clone(), number(0.4)]];
        let (line, theirs) = after(&format!("noise1 {kind} "));
        let ours: Vec<f64> = lists.iter().map(|args| numbers(&evaluate(&row, Ty::Float, args))[0]).collect();
        same(&line, &ours, &theirs);
        // Periodic cell noise follows the specification, not the reference (kernels/osl/noise_cell.h).
        if simplex || kind == "cell" {
            continue;
        }
        let (line, theirs) = after(&format!("pnoise {kind} "));
        let period = Const::Triple([2.0, 3.0, 4.0]);
        let at = |p: [f32; 3]| {
            numbers(&evaluate(&format!("p{row}"), Ty::Float, &[Const::Triple(f32s(p)), period.clone()]))[0]
        };
        same(&line, &[at([0.1, 0.2, 0.3]), at([5.1, -7.2, 0.3])], &theirs);
    }
}
