//! The host library against the values of the reference implementation, and runs of whole shaders.

mod special;

use super::{Globals, fold_call};
use crate::builtins::find;
use crate::ir::{Const, Ty};
use crate::{Master, NoIncludes, Options};

fn evaluate(source: &str, outputs: &[&str]) -> Result<Vec<Vec<f64>>, String> {
    let master = Master::new(source, &Options::default(), &NoIncludes).map_err(|e| e.to_string())?;
    let globals = Globals { u: 0.5, v: 0.25, n: [0.0, 0.0, 1.0], ..Globals::default() };
    let names: Vec<String> = outputs.iter().map(|o| (*o).to_owned()).collect();
    let values = master.evaluate(&Options::default(), &names, &globals).map_err(|e| e.to_string())?;
    Ok(values.into_iter().map(|(_, reals)| reals).collect())
}

#[test]
fn outputs_and_weights() {
    let source = "surface s(output float a[2] = {0, 0}, output int n = 0, output matrix m = 2) {
        for (int i = 0; i < 3; ++i) { n += i; if (u + i > 2) break; a[i] = i + v; }
        m[0][3] = u;
        Ci = u * diffuse(N) + color(1, 0, v) * emission();
    }";
    let values = evaluate(source, &["a", "n", "m", "Ci"]).expect("it runs");
    assert_eq!(values[0], [0.25, 1.25]);
    assert_eq!(values[1], [3.0]);
    assert_eq!(values[2][..5], [2.0, 0.0, 0.0, 0.5, 0.0]);
    assert_eq!(values[3], [1.5, 0.5, 0.75]);
}

#[test]
fn an_endless_loop_is_an_error() {
    let source = "shader s(output float x = 0) { while (u < 1) x += u; }";
    let error = evaluate(source, &["x"]).expect_err("it never ends");
    assert!(error.contains("`s` does not end within"), "{error}");
}

#[test]
fn an_unknown_output_is_an_error() {
    let error = evaluate("shader s(output string t = \"\") { t = \"a\"; }", &["t"]).expect_err("no number");
    assert!(error.contains("`t`"), "{error}");
}

#[test]
fn calls_fold() {
    let fold = |name: &str, ret, args: &[Const]| fold_call(find(name).expect("a row"), ret, args);
    let number = Const::Float;
    assert_eq!(fold("sqrt", Ty::Float, &[number(-1.0)]), Some(number(0.0)));
    assert_eq!(
        fold("pow", Ty::Triple, &[Const::Triple([2.0, 3.0, 0.0]), number(2.0)]),
        Some(Const::Triple([4.0, 9.0, 0.0]))
    );
    assert_eq!(fold("min", Ty::Int, &[Const::Int(3), Const::Int(-2)]), Some(Const::Int(-2)));
    let knots = Const::Array([0.0, 0.0, 1.0, 1.0].map(Const::Float).to_vec());
    assert_eq!(fold("spline_linear", Ty::Float, &[number(0.25), knots]), Some(number(0.25)));
    // Not finite, or not of the arguments alone: left to the device.
    assert_eq!(fold("sin", Ty::Float, &[number(f64::INFINITY)]), None);
    assert_eq!(fold("hypot", Ty::Float, &[number(1e38), number(1e39)]), None);
    assert_eq!(fold("surfacearea", Ty::Float, &[]), None);
    assert_eq!(fold("Dx", Ty::Float, &[number(1.0)]), None);
}
