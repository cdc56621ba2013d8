//! Shader groups: layers, connections, what is wrong with them.

use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Binding, Bound, Connection, Group, Hints, Layer, Master, NoIncludes, Options};
use std::sync::Arc;

/// Layers from their sources, named `a`, `b`, ... in order, and connections such as `a.x b.y`.
fn group(sources: &[&str], connections: &[&str]) -> Group {
    let mut group = Group::default();
    for (i, source) in sources.iter().enumerate() {
        let name = char::from(b'a' + i as u8).to_string();
        let options = Options { file_name: format!("{name}.osl"), ..Options::default() };
        let master = Master::new(source, &options, &NoIncludes).expect(source);
        group.layers.push(Layer { name, master: Arc::new(master), bindings: Vec::new() });
    }
    for line in connections {
        let (from, to) = line.split_once(' ').expect("two ends");
        let end = |text: &str| text.split_once('.').map(|(l, p)| (l.to_owned(), p.to_owned())).expect("layer.param");
        let ((from_layer, from), (to_layer, to)) = (end(from), end(to));
        group.connections.push(Connection { from_layer, from, to_layer, to });
    }
    group
}

fn value(group: &Group, output: &str) -> Vec<f64> {
    let globals = Globals { u: 0.25, v: 0.75, ..Globals::default() };
    let outputs = [output.to_owned()];
    match group.evaluate_all(&Options::default(), &outputs, &[globals]) {
        Ok(points) => points[0][0].1.clone(),
        Err(failure) => panic!("{failure}"),
    }
}

fn failure(group: &Group) -> String {
    match group.evaluate_all(&Options::default(), &["x".to_owned()], &[Globals::default()]) {
        Ok(values) => panic!("no error but {values:?}"),
        Err(failure) => failure.to_string(),
    }
}

const SOURCE: &str =
    "shader s(int i = 7, output float f = 0, output color c = 0, output int n = 0, output float fs[3] = {1, 2, 3},
    output matrix m = 0) { f = u; c = color(u, v, 0.5); n = i; m[1][2] = 5; }";

#[test]
fn values_cross_layers_and_convert() {
    let sink =
        "shader t(float f = -1, color c = -1, vector w = 0, float fs[3] = {0, 0, 0}, float open[] = {0}, matrix m = 1,
        output float r = 0, output vector rw = 0) { r = f + c[0] * 10 + fs[2] * 100; rw = w; }";
    let check = |wires: &[&str], output: &str, expected: &[f64]| {
        assert_eq!(value(&group(&[SOURCE, sink], wires), output), expected, "{wires:?}");
    };
    check(&[], "r", &[-11.0]);
    check(&["a.f b.f"], "r", &[-9.75]);
    check(&["a.n b.f"], "r", &[-3.0]);
    check(&["a.c b.c"], "b.r", &[1.5]);
    check(&["a.c b.w"], "rw", &[0.25, 0.75, 0.5]);
    check(&["a.f b.w"], "rw", &[0.25; 3]);
    check(&["a.n b.w"], "rw", &[7.0; 3]);
    check(&["a.c[1] b.f"], "r", &[-9.25]);
    check(&["a.m[1][2] b.f"], "r", &[-5.0]);
    check(&["a.f b.w[1]"], "rw", &[0.0, 0.25, 0.0]);
    check(&["a.fs b.fs"], "r", &[289.0]);
    check(&["a.fs[1] b.f"], "r", &[-8.0]);
    check(&["a.f b.fs[2]"], "r", &[14.0]);
    check(&["a.f b.f"], "a.f", &[0.25]);
    // Of several connections to one parameter the last holds.
    check(&["a.f b.f", "a.n b.f"], "r", &[-3.0]);
}

#[test]
fn values_are_bound_by_layer() {
    let mut group = group(&[SOURCE, "shader t(float f = 0, output float r = 0) { r = f; }"], &["a.n b.f"]);
    let bound = Bound { name: "i".into(), value: Binding::Int(3), hints: Hints::default() };
    group.layers[0].bindings.push(bound);
    assert_eq!(value(&group, "r"), [3.0]);
    let options = Options { bindings: vec![("a.i".into(), Binding::Int(4))], ..Options::default() };
    let points = group.evaluate_all(&options, &["r".to_owned()], &[Globals::default()]).expect("a value");
    assert_eq!(points[0][0].1, [4.0]);
}

#[test]
fn what_does_not_connect_is_said() {
    let sink = "shader t(int i = 0, string s = \"\", output float r = 0) { r = i; }";
    let check = |wires: &[&str], parts: &[&str]| {
        let text = failure(&group(&[SOURCE, sink], wires));
        for part in parts {
            assert!(text.contains(part), "{wires:?}: {text}");
        }
    };
    check(&["a.f b.i"], &["E4012", "float does not convert to int", "b.osl:1:14"]);
    check(&["a.f b.s"], &["float does not convert to string"]);
    check(&["a.fs b.i"], &["float[3] does not convert to int"]);
    check(&["a.fs[3] b.i"], &["index 3 is outside float[3]"]);
    check(&["a.f[0] b.i"], &["float has no elements"]);
    check(&["b.r a.i"], &["E4011", "not an earlier layer"]);
    check(&["aa.f b.i"], &["E4010", "no layer `aa`"]);
    check(&["a.ff b.i"], &["E4001", "no parameter `ff`", "did you mean"]);
    check(&["a.f[ b.i"], &["E4014"]);
    let mut twice = group(&[SOURCE, sink], &[]);
    twice.layers[1].name = "a".into();
    assert!(failure(&twice).contains("E4013"));
    assert!(failure(&Group::default()).contains("E4015"));
}
