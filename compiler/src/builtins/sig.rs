//! Reads the signature strings of the tables into types, once.

use super::{CLOSURES, TABLE};
use crate::types::{Base, Extent, Type};
use std::collections::HashMap;
use std::sync::LazyLock;

/// A formal parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Formal {
    /// Its type; `None`: anything ("any"), an array of anything when `any_array`.
    pub ty: Option<Type>,
    /// For `any[]`.
    pub any_array: bool,
    /// Written by the function.
    pub output: bool,
}

/// A token that a closure call may give a value for.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The token.
    pub token: &'static str,
    /// Its value's type: int or float.
    pub ty: Type,
    /// The value when the call says nothing.
    pub default: f64,
}

/// One overload after `T`, `triple` and `ptype` are spelt out.
#[derive(Clone, Debug, PartialEq)]
pub struct Overload {
    /// Result.
    pub ret: Type,
    /// Formal parameters.
    pub formals: Vec<Formal>,
    /// Any further arguments may follow.
    pub variadic: bool,
}

static OVERLOADS: LazyLock<Vec<Vec<Overload>>> =
    LazyLock::new(|| TABLE.iter().map(|row| row.overloads.iter().flat_map(|s| expand(s)).collect()).collect());

static BY_NAME: LazyLock<HashMap<&'static str, super::FuncId>> =
    LazyLock::new(|| TABLE.iter().enumerate().map(|(i, row)| (row.name, super::FuncId(i as u16))).collect());

static CLOSURE_FORMALS: LazyLock<Vec<Vec<Formal>>> = LazyLock::new(|| {
    CLOSURES
        .iter()
        .map(|row| row.args.split(',').filter(|a| !a.is_empty()).map(|a| formal(a, None)).collect())
        .collect()
});

static CLOSURE_KEYS: LazyLock<Vec<Vec<Key>>> =
    LazyLock::new(|| CLOSURES.iter().map(|row| row.keys.split(',').filter_map(key).collect()).collect());

/// `TYPE TOKEN=DEFAULT`. The table test makes sure that nothing else stands here.
fn key(text: &'static str) -> Option<Key> {
    let (ty, rest) = text.split_once(' ')?;
    let (token, default) = rest.split_once('=')?;
    Some(Key { token, ty: formal(ty, None).ty?, default: default.parse().ok()? })
}

/// The tokens of a closure; in the IR their values follow the formal arguments.
pub fn closure_keys(id: super::ClosureId) -> &'static [Key] {
    &CLOSURE_KEYS[id.0 as usize]
}

/// Number of arguments of a closure in the IR: the formal ones and the tokens' values.
pub fn closure_arity(id: super::ClosureId) -> usize {
    closure_formals(id).len() + closure_keys(id).len()
}

/// The overloads of a row, in order of preference.
pub fn overloads(id: super::FuncId) -> &'static [Overload] {
    &OVERLOADS[id.0 as usize]
}

/// The row with this name.
pub fn by_name(name: &str) -> Option<super::FuncId> {
    BY_NAME.get(name).copied()
}

/// The formal arguments of a closure.
pub fn closure_formals(id: super::ClosureId) -> &'static [Formal] {
    &CLOSURE_FORMALS[id.0 as usize]
}

/// Spells out the type variables of a signature such as `T(T,float)`.
fn expand(signature: &str) -> Vec<Overload> {
    use Base::{Color, Float, Normal, Point, Vector};
    let words: Vec<&str> = signature.split(['(', ')', ',', '[', ']', ' ']).collect();
    let choices: &[Option<Base>] = if words.contains(&"T") {
        &[Some(Float), Some(Color), Some(Point), Some(Vector), Some(Normal)]
    } else if words.contains(&"triple") {
        &[Some(Color), Some(Point), Some(Vector), Some(Normal)]
    } else if words.contains(&"ptype") {
        &[Some(Point), Some(Vector), Some(Normal)]
    } else {
        &[None]
    };
    choices.iter().map(|choice| parse(signature, *choice)).collect()
}

fn parse(signature: &str, variable: Option<Base>) -> Overload {
    let (ret, args) = signature.trim_end_matches(')').split_once('(').unwrap_or((signature, ""));
    let mut formals = Vec::new();
    let mut variadic = false;
    for arg in args.split(',').filter(|a| !a.is_empty()) {
        if arg == "..." {
            variadic = true;
        } else {
            formals.push(formal(arg, variable));
        }
    }
    Overload { ret: formal(ret, variable).ty.unwrap_or(Type::VOID), formals, variadic }
}

fn formal(text: &str, variable: Option<Base>) -> Formal {
    let (text, output) = match text.strip_prefix("out ") {
        Some(rest) => (rest, true),
        None => (text, false),
    };
    let (name, extent) = match text.strip_suffix("[]") {
        Some(name) => (name, Extent::Unsized),
        None => (text, Extent::Scalar),
    };
    let base = match name {
        "any" => return Formal { ty: None, any_array: extent == Extent::Unsized, output },
        "void" => Base::Void,
        "int" => Base::Int,
        "float" => Base::Float,
        "color" => Base::Color,
        "point" => Base::Point,
        "vector" => Base::Vector,
        "normal" => Base::Normal,
        "matrix" => Base::Matrix,
        "string" => Base::String,
        "closure color" => Base::Closure,
        // T, triple, ptype. The table test makes sure that nothing else stands here.
        _ => variable.unwrap_or(Base::Void),
    };
    Formal { ty: Some(Type { base, extent }), any_array: false, output }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn type_variables_are_spelt_out() {
        let sin = overloads(by_name("sin").expect("sin is a built-in"));
        assert_eq!(sin.len(), 5);
        assert!(sin.iter().all(|o| Some(o.ret) == o.formals[0].ty));
        let fresnel = overloads(by_name("fresnel").expect("fresnel is a built-in"));
        assert_eq!(fresnel[1].formals.iter().filter(|f| f.output).count(), 4);
    }

    #[test]
    fn every_signature_has_known_types() {
        for (i, row) in TABLE.iter().enumerate() {
            for o in overloads(crate::builtins::FuncId(i as u16)) {
                let voids = o.formals.iter().filter(|f| f.ty.is_some_and(|t| t.base == Base::Void)).count();
                assert_eq!(voids, 0, "{}: a formal's type is misspelt", row.name);
            }
        }
        for (i, row) in CLOSURES.iter().enumerate() {
            for f in closure_formals(crate::builtins::ClosureId(i as u16)) {
                assert!(f.ty.is_some_and(|t| t.base != Base::Void), "{}", row.name);
            }
            let keys = closure_keys(crate::builtins::ClosureId(i as u16));
            assert_eq!(keys.len(), row.keys.split(',').filter(|k| !k.is_empty()).count(), "{}", row.name);
            assert!(keys.iter().all(|k| matches!(k.ty.base, Base::Int | Base::Float)), "{}", row.name);
            let tint = row.tint.and_then(|t| closure_formals(crate::builtins::ClosureId(i as u16)).get(usize::from(t)));
            assert!(
                row.tint.is_none() || tint.is_some_and(|f| f.ty == Some(Type::scalar(Base::Color))),
                "{}",
                row.name
            );
        }
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<_> = TABLE.iter().map(|r| r.name).collect();
        names.sort_unstable();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
