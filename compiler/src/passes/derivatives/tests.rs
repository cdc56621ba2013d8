use super::derivatives;
use crate::builtins::{self, Lowering, TABLE, derivative, sig};
use crate::check;
use crate::ir::{Shader, print, verify};
use crate::source::SourceMap;
use crate::types::Base;
use crate::{lower, parse, passes, preprocess};

fn shader(source: &str) -> Shader {
    let mut sources = SourceMap::default();
    let options = preprocess::Options::default();
    let pre = preprocess::preprocess("test.osl", source, &options, &crate::NoIncludes, &mut sources)
        .unwrap_or_else(|e| panic!("{e:?}"));
    let file = parse::parse(&pre).unwrap_or_else(|e| panic!("{e:?}"));
    let checked = check::check(&file).unwrap_or_else(|e| panic!("{e:?}"));
    lower::lower(&checked).unwrap_or_else(|e| panic!("{e:?}"))
}

/// Names of the companions that the pass makes.
fn companions(source: &str) -> Vec<String> {
    let mut s = shader(source);
    passes::fold(&mut s).unwrap_or_else(|e| panic!("{e:?}"));
    let before = s.locals.len();
    assert!(derivatives(&mut s));
    verify(&s).unwrap_or_else(|e| panic!("{e}\n{}", print(&s)));
    s.locals[before..].iter().map(|l| l.name.clone()).collect()
}

#[test]
fn every_row_of_numbers_has_its_derivatives_stated() {
    let reaches_ir = |l: Lowering| {
        use Lowering::*;
        matches!(l, Componentwise | Direct | State | Internal | InternalState)
    };
    let real = |base: Base| base == Base::Float || base.is_triple();
    let mut missing = Vec::new();
    for row in TABLE.iter().filter(|r| reaches_ir(r.lowering)) {
        let Some(id) = builtins::find(row.name) else { continue };
        let gives = |o: &sig::Overload| {
            real(o.ret.base) || o.formals.iter().any(|f| f.output && f.ty.is_some_and(|t| real(t.base)))
        };
        if sig::overloads(id).iter().any(gives) && derivative::of(row.name).is_none() {
            missing.push(row.name);
        }
    }
    assert!(missing.is_empty(), "builtins/derivative.rs says nothing of {missing:?}");
}

#[test]
fn a_shader_without_uses_stays_as_it_is() {
    let mut s = shader("surface s(float k = 2) { float x = u * k; Ci = noise(P * x) * diffuse(N); }");
    let before = print(&s);
    assert!(!derivatives(&mut s));
    assert_eq!(print(&s), before);
}

#[test]
fn only_what_a_use_reaches_has_companions() {
    let source = "surface s(output float o = 0, output float other = 0) {
        float a = u;
        float b = v;
        if (b > 0.5) a = b * 2;
        float c = sin(P[0]);
        if (c > 0.5) c = 2 * N[1];
        other = c + a;
        o = Dx(a);
    }";
    assert_eq!(companions(source), ["a.dx", "a.dy", "dudx", "dudy", "dvdx", "dvdy"]);
}

#[test]
fn what_can_only_be_zero_has_none() {
    let source = "surface s(output float o = 0) {
        float a = 1;
        if (u > 0.5) a = N[0] * floor(u) + int(v);
        o = Dx(a) + filterwidth(a);
    }";
    assert_eq!(companions(source), [""; 0]);
}
