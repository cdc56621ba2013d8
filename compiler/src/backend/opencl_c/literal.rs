//! Constants as OpenCL C text.
//!
//! Floats are printed with the digits that give the same f64 back, without suffix: the working precision rounds them
//! (kernels/real.h). A `real` never looks like an int.

use crate::backend::string_id;
use crate::ir::Const;

/// A real: `0.1`, `1.0`, `1e20`, `-INFINITY`, `NAN`.
pub(super) fn real(v: f64) -> String {
    if v.is_nan() {
        return "NAN".to_owned();
    }
    if v.is_infinite() {
        return if v > 0.0 { "INFINITY" } else { "-INFINITY" }.to_owned();
    }
    // Rust's `{:?}` is the shortest text that reads back as the same value, with `.0` or an exponent.
    format!("{v:?}")
}

/// An int; C has no literal for the smallest.
pub(super) fn int(v: i32) -> String {
    if v == i32::MIN { "(-2147483647 - 1)".to_owned() } else { v.to_string() }
}

/// `(real3)(0.8)` or `(real3)(1.0, 0.5, 0.0)`.
pub(super) fn triple(v: &[f64; 3]) -> String {
    let [x, y, z] = v.map(real);
    if v[0].to_bits() == v[1].to_bits() && v[0].to_bits() == v[2].to_bits() {
        format!("(real3)({x})")
    } else {
        format!("(real3)({x}, {y}, {z})")
    }
}

/// `identity`-like matrices are rare enough to be spelt out.
pub(super) fn matrix(v: &[f64; 16]) -> String {
    format!("make_mat4({})", v.map(real).join(", "))
}

/// The id of a string, with the string beside it where a comment can hold it.
pub(super) fn string(text: &str) -> String {
    let id = int(string_id(text) as i32);
    let harmless = |c: char| c.is_ascii_alphanumeric() || " _-.:".contains(c);
    if text.is_empty() || text.len() > 40 || !text.chars().all(harmless) {
        return id;
    }
    format!("{id} /* {text} */")
}

/// Any constant but an array.
pub(super) fn constant(c: &Const) -> String {
    match c {
        Const::Int(v) => int(*v),
        Const::Float(v) => real(*v),
        Const::Triple(v) => triple(v),
        Const::Matrix(v) => matrix(v),
        Const::Str(s) => string(s),
        Const::Array(_) => "0".to_owned(),
    }
}

/// The reals or ints that a constant is made of, for tables.
pub(super) fn parts(c: &Const) -> Vec<String> {
    match c {
        Const::Triple(v) => v.map(real).to_vec(),
        Const::Matrix(v) => v.map(real).to_vec(),
        other => vec![constant(other)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_read_back_and_never_look_like_ints() {
        for v in [0.0, -0.0, 1.0, -1.0, 0.1, 1e16, 1e300, 5e-324, f64::MAX, 16777217.0, 1.0 / 3.0] {
            let text = real(v);
            assert_eq!(text.parse::<f64>().expect("a number").to_bits(), v.to_bits(), "{text}");
            assert!(text.contains(['.', 'e']), "{text}");
        }
        assert_eq!(real(1.0), "1.0");
        assert_eq!(real(f64::NEG_INFINITY), "-INFINITY");
        assert_eq!(real(f64::NAN), "NAN");
    }

    #[test]
    fn ints_and_strings() {
        assert_eq!(int(i32::MIN), "(-2147483647 - 1)");
        assert_eq!(int(-7), "-7");
        assert_eq!(string(""), "0");
        assert_eq!(string("ggx"), format!("{} /* ggx */", string_id("ggx") as i32));
        assert!(!string("a*/b").contains('*'));
        assert_eq!(triple(&[0.5; 3]), "(real3)(0.5)");
        assert_eq!(triple(&[0.0, -0.0, 0.0]), "(real3)(0.0, -0.0, 0.0)");
    }
}
