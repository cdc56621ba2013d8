//! Shader groups: layers, connections, what is wrong with them.

use oslcl_compiler::interp::Globals;
use oslcl_compiler::ir::Const;
use oslcl_compiler::types::{Base, Type};
use oslcl_compiler::{
    Binding, Bound, Connection, Entry, Group, Hints, Layer, Lazy, Master, NoIncludes, Options, ParseError, Userdata,
};
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
    check(&["a.ff b.i"], &["E4001", "no parameter `ff`", "its parameters: i, f, c"]);
    check(&["a.f[ b.i"], &["E4014"]);
    let mut twice = group(&[SOURCE, sink], &[]);
    twice.layers[1].name = "a".into();
    assert!(failure(&twice).contains("E4013"));
    assert!(failure(&Group::default()).contains("E4015"));
}

/// The code of a grid function with this output.
fn code(group: &Group, output: &str) -> String {
    let options = Options { entry: Entry::Grid(vec![output.to_owned()]), ..Options::default() };
    match group.instance(&options) {
        Ok(done) => done.artifact.code,
        Err(failure) => panic!("{failure}"),
    }
}

#[test]
fn layers_run_where_they_are_needed() {
    let source = "shader s(output float f = 0) { f = sin(u) + 3; }";
    let check = |sink: &str, expected: f64, parts: &[&str]| {
        let group = group(&[source, sink], &["a.f b.f"]);
        let found = value(&group, "r")[0];
        assert!((found - expected).abs() < 1e-6, "{sink}: {found}");
        let code = code(&group, "r");
        let mut rest = code.as_str();
        for part in parts {
            let at = rest.find(part).unwrap_or_else(|| panic!("no `{part}` in order in\n{code}"));
            rest = &rest[at + part.len()..];
        }
    };
    let f = 0.25f64.sin() + 3.0;
    check("shader t(float f = 1, output float r = 0) { r = f; }", f, &["osl_sin"]);
    // Nobody needs it.
    check("shader t(float f = 1, output float r = 0) { r = v; }", 0.75, &["sg->v"]);
    assert!(
        !code(&group(&[source, "shader t(float f = 1, output float r = 0) { r = v; }"], &["a.f b.f"]), "r")
            .contains("sin")
    );
    // One branch needs it; both do; a loop does; what is before a branch does.
    check("shader t(float f = 1, output float r = 0) { if (v > 0.5) r = f; }", f, &["if (", "osl_sin"]);
    check("shader t(float f = 1, output float r = 0) { if (v > 0.5) r = f; else r = f * 2; }", f, &["osl_sin", "if ("]);
    check(
        "shader t(float f = 1, output float r = 0) { int n = int(v * 4); for (int i = 0; i < n; i++) r += f; }",
        3.0 * f,
        &["osl_sin", "for ("],
    );
    check("shader t(float f = 1, output float r = f * 2) { if (v > 0.5) r += f; }", 3.0 * f, &["osl_sin", "if ("]);
    // A parameter that the layer changes itself keeps what it was changed to.
    check(
        "shader t(output float f = 1, output float r = 0) { if (v > 0.5) { f += 1; r = f; } }",
        f + 1.0,
        &["osl_sin"],
    );
}

#[test]
fn chains_of_layers() {
    let first = "shader s(output float f = 0) { f = u; }";
    let middle = "shader m(float i = 0, output float f = 0) { f = i * 2; }";
    let last = "shader t(float f = 1, float g = 1, output float r = 0) { r = f + g; }";
    let group = group(&[first, middle, middle, last], &["a.f b.i", "b.f c.i", "c.f d.f", "b.f d.g"]);
    assert_eq!(value(&group, "r"), [1.5]);
    assert_eq!(value(&group, "b.f"), [0.5]);
    // A connected output that its layer does not touch is passed on.
    let passing = "shader p(output float f = 3) { }";
    let group =
        self::group(&[first, passing, "shader t(float f = 1, output float r = 0) { r = f; }"], &["a.f b.f", "b.f c.f"]);
    assert_eq!(value(&group, "r"), [0.25]);
    assert_eq!(value(&group, "b.f"), [0.25]);
}

#[test]
fn globals_are_shared() {
    let writes = "displacement s(output float f = 0) { P = 7; f = 1; }";
    let reads = "surface t(float f = 0, output float r = 0) { r = f + P[0]; }";
    let mut group = group(&[writes, reads], &["a.f b.f"]);
    assert_eq!(value(&group, "r"), [8.0]);
    // Nobody pulls it: it does not run, unless all layers shall.
    group.connections.clear();
    assert_eq!(value(&group, "r"), [0.0]);
    let lazy = Lazy { globals: false, ..Lazy::default() };
    let options = Options { lazy, ..Options::default() };
    let points = group.evaluate_all(&options, &["r".into()], &[Globals::default()]).expect("values");
    assert_eq!(points[0][0].1, [7.0]);
}

#[test]
fn a_layer_that_traces_runs_unasked_when_told_to() {
    // Whether it ran shows by what it writes to a global.
    let traces = "shader s(output int x = 0) { x = trace(P, N); if (x >= 0) P = 7; }";
    let folded_away = "shader s(output int x = 0) { if (0) x = trace(P, N); P = 7; }";
    let reads = "shader t(int x = 0, output float r = 0) { if (u == 99.5) r = x; r += P[0]; }";
    for (first, lazy_traces, wanted) in [(traces, true, 0.0), (traces, false, 7.0), (folded_away, false, 0.0)] {
        let group = group(&[first, reads], &["a.x b.x"]);
        let options = Options { lazy: Lazy { traces: lazy_traces, ..Lazy::default() }, ..Options::default() };
        let points = group.evaluate_all(&options, &["r".into()], &[Globals::default()]).expect("values");
        assert_eq!(points[0][0].1, [wanted], "{first}, lazy: {lazy_traces}");
    }
}

#[test]
fn without_a_scene_rays_meet_what_testshade_pretends() {
    let asks = "shader s(output float h = 0, output float d = 0, output vector n = 0, output string g = \"\") {
        int hit = 4; float far = 9; normal m = 2; h = trace(point(0, 0, 1), vector(0, 0, 1));
        h += 10 * getmessage(\"trace\", \"hit\", hit) + 100 * hit;
        d = getmessage(\"trace\", \"hitdist\", far) + 10 * far;
        getmessage(\"trace\", \"N\", m); n = m; getmessage(\"trace\", \"geom:name\", g); }";
    let group = group(&[asks], &[]);
    let names = ["h", "d", "n"].map(str::to_owned);
    let at = |u: f64| Globals { u, v: 0.25, ..Globals::default() };
    let points = group.evaluate_all(&Options::default(), &names, &[at(0.75), at(0.25)]).expect("values");
    let values = |i: usize| points[i].iter().map(|(_, v)| v.clone()).collect::<Vec<_>>();
    assert_eq!(values(0), [vec![111.0], vec![6.0], vec![0.75, 0.25, 0.25]]);
    assert_eq!(values(1), [vec![0.0], vec![90.0], vec![2.0; 3]]);
}

#[test]
fn entry_layers_run_instead_of_the_last() {
    let first = "shader s(output float f = 1) { f = 2; }";
    let last = "shader t(output float r = 3) { r = 4; }";
    let mut group = group(&[first, last], &[]);
    group.entry_layers = vec!["a".into()];
    assert_eq!(value(&group, "a.f"), [2.0]);
    assert_eq!(value(&group, "b.r"), [0.0]);
    group.entry_layers = vec!["x".into()];
    assert!(failure(&group).contains("E4010"));
}

#[test]
fn structs_and_arrays_connect() {
    let source = "struct S { float x; color c; float a[2]; };
        shader s(output S s = {0, 0, {0, 0}}, output float open[5] = {1, 2, 3, 4, 5}) { s.x = u; s.c = v; s.a[1] = 9; }";
    let sink = "struct S { float x; color k; float a[2]; };
        shader t(S s = {1, 2, {3, 4}}, float fs[] = {7}, output float r = 0, output int n = 0)
        { r = s.x + s.k[0] * 10 + s.a[1] * 100; n = arraylength(fs); for (int i = 0; i < n; i++) r += fs[i] * 1000; }";
    let check = |wires: &[&str], r: f64, n: f64| {
        let group = group(&[source, sink], wires);
        assert_eq!(value(&group, "r"), [r], "{wires:?}");
        assert_eq!(value(&group, "n"), [n], "{wires:?}");
    };
    check(&[], 421.0 + 7000.0, 1.0);
    check(&["a.s b.s"], 907.75 + 7000.0, 1.0);
    check(&["a.s.x b.s.x"], 420.25 + 7000.0, 1.0);
    check(&["a.s.a[1] b.s.x"], 429.0 + 7000.0, 1.0);
    check(&["a.open b.fs"], 421.0 + 15000.0, 5.0);
    check(&["a.open[2] b.s.k[0]"], 431.0 + 7000.0, 1.0);
    let error = failure(&group(&[source, sink], &["a.open b.s"]));
    assert!(error.contains("E4012"), "{error}");
}

#[test]
fn fields_of_a_struct_keep_the_default_that_was_computed_for_all() {
    let source = "struct S { float x; float y; }; S make() { S s = {3, 4}; return s; }
        shader s(S s = make(), output float r = 0) { r = s.x * 10 + s.y; }";
    let mut group = group(&[source], &[]);
    assert_eq!(value(&group, "r"), [34.0]);
    group.layers[0].bindings.push(Bound { name: "s.x".into(), value: Binding::Int(5), hints: Hints::default() });
    assert_eq!(value(&group, "r"), [54.0]);
}

#[test]
fn unsized_parameters_take_the_length_of_their_value() {
    let source = "float sum(float a[]) { float s = 0; for (int i = 0; i < arraylength(a); i++) s += a[i]; return s; }
        shader s(float a[] = {1}, color c[] = {2, 3}, output float r = 0, output int n = 0) {
            r = sum(a) + c[0][1]; n = arraylength(c); }";
    let mut group = group(&[source], &[]);
    assert_eq!((value(&group, "r"), value(&group, "n")), (vec![3.0], vec![2.0]));
    let bound = |name: &str, values: &[f64]| Bound {
        name: name.into(),
        value: Binding::Floats(values.to_vec()),
        hints: Hints::default(),
    };
    group.layers[0].bindings.push(bound("a", &[1.0, 2.0, 3.0]));
    group.layers[0].bindings.push(bound("c", &[0.0, 5.0, 0.0]));
    assert_eq!((value(&group, "r"), value(&group, "n")), (vec![11.0], vec![1.0]));
}

#[test]
fn isconnected_and_isconstant() {
    let source = "struct S { float x; float y; };
        int ask(S s) { return isconnected(s); }
        shader s(float k = 2, float f = 0, output float g = 0, S s = {0, 0}, output float r[6] = {0, 0, 0, 0, 0, 0}) {
            g = 1;
            r[0] = isconnected(f); r[1] = isconnected(g); r[2] = ask(s); r[3] = isconnected(s.y);
            r[4] = isconstant(k * 2); r[5] = isconstant(u * 2); }";
    let upstream = "struct S { float x; float y; }; shader u(output S s = {0, 0}, output float f = 0) { f = u; }";
    let downstream = "shader d(float f = 0, output float q = 0) { q = f; }";
    let alone = group(&[source], &[]);
    assert_eq!(value(&alone, "r"), [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let all = group(&[upstream, source, downstream], &["a.f b.f", "a.s b.s", "b.g c.f"]);
    assert_eq!(value(&all, "b.r"), [1.0, 2.0, 1.0, 1.0, 1.0, 0.0]);
    // An output that is asked for is connected downstream.
    let asks = "shader s(output float g = 0) { g = isconnected(g); }";
    assert_eq!(value(&group(&[asks], &[]), "g"), [2.0]);
}

#[test]
fn closures_cross_layers() {
    let one = "shader s(output closure color c = 0) { c = u * diffuse(N); }";
    let two = "shader b(closure color i[2] = {0}) { for (int k = 0; k < 2; k++) Ci += i[k]; }";
    let both = "shader c(closure color x = 0, closure color y = 0, output closure color o[2] = {x, y}) { }";
    let group = group(&[one, one, both, two], &["a.c c.x", "b.c c.y", "c.o d.i"]);
    assert_eq!(value(&group, "Ci"), [0.5; 3]);
    let single = self::group(&[one, "surface t(closure color k = 0) { Ci = k * 4; }"], &["a.c b.k"]);
    assert_eq!(value(&single, "Ci"), [1.0; 3]);
    let direct = self::group(&[one, two], &["a.c b.i[1]"]);
    assert_eq!(value(&direct, "Ci"), [0.25; 3]);
}

#[test]
fn userdata_replaces_defaults_where_it_is() {
    let source = "shader s(float s = 1 [[ int lockgeom = 0 ]], color Cd = u [[ int lockgeom = 0 ]], float locked = 5,
        output vector n = 2 [[ int lockgeom = 0 ]], output float r = 0) { r = s + Cd[0] * 10 + locked * 100; }";
    let group = group(&[source], &[]);
    let data = |name: &str, base: Base, sometimes: bool| Userdata {
        name: name.into(),
        ty: Type::scalar(base),
        sometimes,
        same_as: None,
    };
    let userdata = vec![
        data("s", Base::Float, false),
        data("Cd", Base::Vector, true),
        data("locked", Base::Float, false),
        data("n", Base::Int, true),
    ];
    let options = Options { userdata: Some(userdata), ..Options::default() };
    let globals = Globals { u: 0.5, userdata: vec![("s".into(), Const::Float(3.0))], ..Globals::default() };
    let with = Globals { userdata: vec![("Cd".into(), Const::Triple([7.0; 3]))], ..globals.clone() };
    let points = group.evaluate_all(&options, &["r".into(), "n".into()], &[globals.clone(), with]).expect("values");
    assert_eq!(points[0][0].1, [508.0]);
    assert_eq!(points[0][1].1, [2.0; 3]);
    assert_eq!(points[1][0].1, [570.0]);
    let points = group.evaluate_all(&Options::default(), &["r".into()], &[globals]).expect("values");
    assert_eq!(points[0][0].1, [506.0]);
    let options = Options { entry: Entry::Grid(vec!["r".into()]), ..options };
    let inputs = group.instance(&options).expect("an artifact").artifact.inputs;
    let found: Vec<_> = inputs.userdata.iter().map(|s| (s.name.as_str(), s.ty.as_str(), s.offset, s.has)).collect();
    assert_eq!(found, [("s", "float", 0, None), ("Cd", "color", 1, Some(4))]);
    assert_eq!(inputs.userdata_slots, 5);
}

#[test]
fn interactive_parameters_are_read_at_run_time() {
    let source =
        "shader s(float f = 1 [[ int interactive = 1 ]], float g = u [[ int interactive = 1 ]], float plain = 2,
        output float r = 0) { r = f + g * 10 + plain * 100; }";
    let mut group = group(&[source], &[]);
    let live = Options { interactive: true, ..Options::default() };
    let globals = Globals { u: 0.5, ..Globals::default() };
    let set = |list: &[(&str, f64)]| Globals {
        interactive: list.iter().map(|(n, v)| (n.to_string(), Const::Float(*v))).collect(),
        ..globals.clone()
    };
    let points = [set(&[]), set(&[("a.f", 3.0)]), set(&[("a.g", 4.0), ("a.plain", 9.0)])];
    let found = group.evaluate_all(&live, &["r".into()], &points).expect("values");
    let found: Vec<f64> = found.iter().map(|p| p[0].1[0]).collect();
    assert_eq!(found, [206.0, 208.0, 241.0]);
    let hints = Hints { interactive: true, ..Hints::default() };
    group.layers[0].bindings.push(Bound { name: "plain".into(), value: Binding::Int(3), hints });
    let found = group.evaluate_all(&live, &["r".into()], &points).expect("values");
    let found: Vec<f64> = found.iter().map(|p| p[0].1[0]).collect();
    assert_eq!(found, [306.0, 308.0, 941.0]);
    let options = Options { entry: Entry::Grid(vec!["r".into()]), ..live };
    let inputs = group.instance(&options).expect("an artifact").artifact.inputs;
    let slots: Vec<_> =
        inputs.interactive.iter().map(|s| (s.name.as_str(), s.offset, s.has, s.default.clone())).collect();
    assert_eq!(slots, [("a.f", 0, None, vec![1.0]), ("a.g", 1, Some(2), vec![]), ("a.plain", 3, None, vec![3.0])]);
}

#[test]
fn a_parameter_may_refuse_connections() {
    let sink = "shader t(float f = 1 [[ int allowconnect = 0 ]], output float r = 0) { r = f; }";
    let error = failure(&group(&[SOURCE, sink], &["a.f b.f"]));
    assert!(error.contains("E4016") && error.contains("allowconnect"), "{error}");
}

/// Reads a group's text whose shaders all are `shader any(float x = 0, string s = "", output float y = 0)`.
fn read(text: &str) -> Result<Group, String> {
    let mut find = |name: &str| match name {
        "missing" => Err("it is missing".to_owned()),
        _ => {
            let source = format!("shader {name}(float x = 0, string s = \"\", output float y = 0) {{ y = x; }}");
            Ok(Arc::new(Master::new(&source, &Options::default(), &NoIncludes).expect("a shader")))
        }
    };
    Group::parse("g", text, &mut find).map_err(|e| match e {
        ParseError::Text(e) => e.to_string(),
        ParseError::Shader { name, line, cause } => format!("{line}: `{name}`: {cause}"),
    })
}

#[test]
fn the_text_of_a_group() {
    let group = read(
        "param float Kd 0.8 [[ int lockgeom = 0, int interactive=1 ]];\n# note; ignored\nparam color Cs 1 0.5;
         param string s \"a;\\\"b\\n\"; int[3] i 1 2; param float [] open 1 2 3; param string[2] t x;
         param color[] cs 1 2 3 4;\nshader matte layer1, shader plain;; connect layer1.y plain_1.x[0]",
    )
    .expect("a group");
    let names: Vec<&str> = group.layers.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["layer1", "plain_1"]);
    let values: Vec<(&str, &Binding)> = group.layers[0].bindings.iter().map(|b| (b.name.as_str(), &b.value)).collect();
    let floats = |v: &[f64]| Binding::Floats(v.to_vec());
    assert_eq!(
        values,
        [
            ("Kd", &Binding::Float(0.8)),
            ("Cs", &floats(&[1.0, 0.5, 0.0])),
            ("s", &Binding::Str("a;\"b\n".into())),
            ("i", &floats(&[1.0, 2.0, 0.0])),
            ("open", &floats(&[1.0, 2.0, 3.0])),
            ("t", &Binding::Strs(vec!["x".into(), String::new()])),
            ("cs", &floats(&[1.0, 2.0, 3.0, 4.0, 0.0, 0.0])),
        ]
    );
    let hints = Hints { lockgeom: Some(false), interpolated: false, interactive: true };
    assert_eq!(group.layers[0].bindings[0].hints, hints);
    assert_eq!(group.connections[0].to, "x[0]");
    let again = read(&group.text()).expect("the same group");
    assert_eq!(again.text(), group.text());
    assert_eq!(again.layers[0].bindings, group.layers[0].bindings);
}

#[test]
fn what_is_wrong_with_a_text_is_said_with_its_place() {
    for (text, part) in [
        ("", "1:1: there is no `shader`"),
        ("shader a b;\nconect b.x b.y;", "2:1: `conect` is none of"),
        ("shader a b; connect a.b c.d;", "1:21: there is no layer `a`"),
        ("shader a b; connect b c.d;", "1:21: `b` is no `LAYER.PARAMETER`"),
        ("shader a b c;", "1:12: expected `;` after `shader`, found `c`"),
        ("shader;", "1:7: expected the shader's name, found `;`"),
        ("param float x 1 2; shader a b;", "takes 1 values, not 2"),
        ("param float x y; shader a b;", "1:15: parameter `x`: `y` is no number"),
        ("param int x 1.5; shader a b;", "is no int"),
        ("param flaot x 1; shader a b;", "did you mean `float`?"),
        ("param float[0] x 1; shader a b;", "is no array type"),
        ("param float[99999999999] x 1; shader a b;", "is no array type"),
        ("param string x \"y; shader a b;", "closing quote"),
        ("param float x 1 [[ int lockgeom ]]; shader a b;", "is no hint"),
        ("param float x 1 [[ ; shader a b;", "`[[` without `]]`"),
        ("shader a b; param int x 1;", "belongs to no shader"),
        ("\nshader missing b;", "2: `missing`: it is missing"),
        ("\"shader\" a b;", "found the string"),
    ] {
        let error = read(text).expect_err(text);
        assert!(error.contains(part), "{text}: {error}");
    }
}

#[test]
fn userdata_may_be_a_global() {
    let source = "shader s(float s = 1 [[ int lockgeom = 0 ]], output float r = 0) { r = s * 2; }";
    let data =
        Userdata { name: "s".into(), ty: Type::scalar(Base::Float), sometimes: false, same_as: Some("u".into()) };
    let options = Options { userdata: Some(vec![data]), ..Options::default() };
    let points = [Globals { u: 0.25, ..Globals::default() }];
    let found = group(&[source], &[]).evaluate_all(&options, &["r".into()], &points).expect("values");
    assert_eq!(found[0][0].1, [0.5]);
}
