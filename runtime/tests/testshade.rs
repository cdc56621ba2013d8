//! Runs `testshade` as scripts do: what it prints, stores and says at run time.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// An empty folder of the test's own, with these shaders.
fn folder(test: &str, shaders: &[(&str, &str)]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("testshade").join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder for the test");
    for (name, text) in shaders {
        fs::write(path.join(format!("{name}.osl")), text).expect("a shader");
    }
    path
}

/// Standard output and standard error of a run that succeeds.
fn testshade(at: &Path, args: &[&str]) -> (String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
    let output = command.current_dir(at).arg("testshade").args(args).stdin(Stdio::null()).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the output is UTF-8");
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert_eq!(output.status.code(), Some(0), "{out}\n{err}");
    (out, err)
}

const RANGE: &str = "struct pair { float f[2]; };\n\
shader range(output float Cout = 0)\n{\n\
    int a[3] = { 1, 2, 3 };\n    vector V = vector(4, 5, 6);\n    matrix M = 7;\n    pair p;\n    p.f[0] = 8; p.f[1] = 9;\n\
    for (int i = 2; i < 4; ++i)\n        printf(\"%d %g\\n\", a[i],\n               V[i]);\n\
    M[int(u) + 4][0] = 1;\n    printf(\"%g\\n\", p.f[-1 - int(u)]);\n}\n";

#[test]
fn indices_out_of_range_are_reported_and_clamped() {
    let at = folder("range", &[("range", RANGE)]);
    let (out, err) = testshade(&at, &["--groupname", "g", "-layer", "top", "range"]);
    assert_eq!(out, "3 6\n3 6\n8\n\n");
    let said =
        |what: &str, line: u32| format!("ERROR: Index {what}: range.osl:{line} (group g, layer 0 top, shader range)\n");
    let all = [("[3] out of range a[0..2]", 10), ("[3] out of range V[0..2]", 11)];
    let more = [("[4] out of range M[0..3]", 12), ("[-1] out of range p.f[0..1]", 13)];
    assert_eq!(err, all.iter().chain(&more).map(|(what, line)| said(what, *line)).collect::<String>());
    // Who does not want to know does not pay for it.
    let (out, err) = testshade(&at, &["--options", "range_checking=0", "range"]);
    assert_eq!((out.as_str(), err.as_str()), ("3 6\n3 6\n8\n\n", ""));
}

const OPEN: &str = "float last(float f[]) { return f[arraylength(f) - 1 + int(u)]; }\n\
shader open(float a[] = { 1 }, output float Cout = 0)\n{\n    printf(\"%g %g\\n\", last(a), a[2]);\n}\n";

#[test]
fn indices_of_unsized_parameters_are_held_against_what_is_bound() {
    let at = folder("open", &[("open", OPEN)]);
    let (out, err) = testshade(&at, &["-param:type=float[3]", "a", "5,6,7", "open"]);
    assert_eq!((out.as_str(), err.as_str()), ("7 7\n\n", ""));
    let (out, err) = testshade(&at, &["open"]);
    assert_eq!(out, "1 1\n\n");
    assert_eq!(
        err,
        "ERROR: Index [2] out of range a[0..0]: open.osl:4 (group unnamed_group_1, layer 0 open_0, shader open)\n"
    );
}

const RAYS: &str = "shader rays(output float Cout = 0)\n{\n    int glossy = raytype(\"glossy\");\n\
    printf(\"%d %d %d\\n\", glossy, raytype(\"camera\"), isconstant(glossy));\n}\n";

#[test]
fn ray_types_can_be_known_before_a_shader_is_compiled() {
    let at = folder("rays", &[("rays", RAYS)]);
    assert_eq!(testshade(&at, &["--raytype", "glossy", "rays"]).0, "1 0 0\n\n");
    assert_eq!(testshade(&at, &["--raytype", "glossy", "--raytype_opt", "rays"]).0, "1 0 1\n\n");
    // The host runs the same, and what takes how long is told on demand only.
    assert_eq!(testshade(&at, &["--raytype", "glossy", "--host", "rays"]).0, "1 0 0\n\n");
    let (out, _) = testshade(&at, &["--raytype", "glossy", "--host", "--runstats", "rays"]);
    assert!(out.starts_with("1 0 0\n\nRun on the host"), "{out}");
}

const DATA: &str = "shader data(output float Cout = 0)\n{\n    float f = -1; color c = -1; int i = -1; string s = \"none\";\n\
    int found = getattribute(\"f\", f) + 2 * getattribute(\"c\", c) + 4 * getattribute(\"i\", i);\n\
    found += 8 * getattribute(\"s\", s) + 16 * getattribute(\"f\", i);\n\
    printf(\"%g %g %d %s %d\\n\", f, c, i, s, found);\n}\n";

#[test]
fn getattribute_falls_back_to_userdata() {
    let at = folder("data", &[("data", DATA)]);
    let (out, _) = testshade(
        &at,
        &[
            "--userdata:type=float",
            "f",
            "42",
            "--userdata:type=color",
            "c",
            "1,2,3",
            "--userdata",
            "i",
            "7",
            "--userdata",
            "s",
            "text",
            "data",
        ],
    );
    // A float is read as an int, too; the reference's testshade takes data of another type for none.
    assert_eq!(out, "42 1 2 3 42 text 31\n\n");
    let (out, _) = testshade(&at, &["data"]);
    assert_eq!(out, "-1 -1 -1 -1 -1 none 0\n\n");
}

#[test]
fn integers_in_pictures_are_parts_of_the_largest() {
    let at = folder("ints", &[("ints", "shader ints(output int i = 0) { i = u > 0.5 ? 1073741824 : -1; }")]);
    for depth in ["float", "int"] {
        let args = ["-g", "2", "1", "-o", "i", "i.tif", "-od", "float", "ints"];
        let args = if depth == "int" { [&args[..5], &["i.tif", "ints"]].concat() } else { args.to_vec() };
        testshade(&at, &args);
        // What is stored is read back by shaders.
        let look = "shader look(output color c = 0) { for (int x = 0; x < 2; ++x)\n\
            printf(\"%.3f\\n\", float(texture(\"i.tif\", 0.25 + 0.5 * x, 0.5, \"interp\", \"closest\"))); }";
        fs::write(at.join("look.osl"), look).expect("a shader");
        assert_eq!(testshade(&at, &["look"]).0, "-0.000\n0.500\n\n", "{depth}");
    }
}

const PRINTS: &str = "closure color glow(float strength) [[ int builtin = 1 ]];\nshader prints()\n{\n\
    closure color all = reflection(N) + 0.5 * microfacet(\"ggx\", N, 0.25, 1.5, 0) + reflection(N, 2);\n\
    printf(\"%s\\n%s\\n\", all, 0.5 * glow(3));\n}\n";

#[test]
fn closures_are_printed_with_all_their_arguments() {
    let at = folder("prints", &[("prints", PRINTS)]);
    let (out, err) = testshade(&at, &["prints"]);
    let n = "(0, 0, 1)";
    let terms = [
        format!("(1, 1, 1) * reflection ({n}, 0)"),
        format!("(0.5, 0.5, 0.5) * microfacet (\"ggx\", {n}, (0, 0, 0), 0.25, 0.25, 1.5, 0)"),
        format!("(1, 1, 1) * reflection ({n}, 2)"),
    ];
    assert_eq!(out, format!("{}\n(0.5, 0.5, 0.5) * glow (3)\n\n", terms.join("\n\t+ ")));
    assert!(err.contains("[W2009]"), "{err}");
    // The compiler of .oso files does not say that nobody knows the closure: another renderer may.
    let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
    let output = command.current_dir(&at).args(["oslc", "prints.osl"]).output().expect("it starts");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

const NOT_FINITE: &str = "shader not_finite(output float Cout = 0)\n{\n    float big = 1e30 * (u + 1);\n    big *= big;\n\
    float less = big - big;\n    color c = color(1, less, 2);\n    c[2] = -big;\n    c = color(u, v, 0);\n    Cout = c[1];\n}\n";

#[test]
fn numbers_that_are_none_are_reported() {
    let at = folder("not_finite", &[("not_finite", NOT_FINITE)]);
    let (_, err) = testshade(&at, &["-g", "2", "2", "--debugnan", "-o", "Cout", "null", "not_finite"]);
    let said = |what: &str, line: u32, op: &str| format!("ERROR: Detected {what} at not_finite.osl:{line} (op {op})\n");
    let all = [
        said("inf value in big", 4, "mul"),
        said("nan value in less", 5, "sub"),
        said("nan value in c", 6, "color"),
        said("-inf value in c", 7, "neg"),
    ];
    assert_eq!(err, all.concat());
    // Who does not want to know does not pay for it.
    let (_, err) = testshade(&at, &["-g", "2", "2", "-o", "Cout", "null", "not_finite"]);
    assert_eq!(err, "");
}

const ENDS: &str = "float stop(float x, float limit) { if (x > limit) exit(); return x; }\n\
shader ends(output float before = 2, float late = 9 + stop(u, 0.5) [[ int lockgeom = 0 ]], output float behind = late)\n\
{\n    printf(\"%g\\n\", late);\n    before = 3;\n}\n";

#[test]
fn a_default_that_ends_the_shader_does_so_only_where_it_runs() {
    let at = folder("ends", &[("ends", ENDS)]);
    let outputs = ["-o", "before", "null", "-o", "behind", "null", "--print"];
    let (out, _) = testshade(&at, &[&["-g", "2", "1"], &outputs[..], &["ends"]].concat());
    assert!(out.contains("Pixel (0, 0):\n  before : 3\n  behind : 9\n"), "{out}");
    assert!(out.contains("Pixel (1, 0):\n  before : 2\n  behind : 0\n9\n"), "{out}");
    for given in [["-param", "late", "4"], ["--userdata:type=float", "late", "4"]] {
        let (out, _) = testshade(&at, &[&given, &["-g", "2", "1"], &outputs[..], &["ends"]].concat());
        assert!(out.contains("Pixel (1, 0):\n  before : 3\n  behind : 4\n4\n4\n"), "{given:?}: {out}");
    }
    // By way of the compiled form, too.
    let oslcl = env!("CARGO_BIN_EXE_oslcl");
    let compiled = Command::new(oslcl).current_dir(&at).args(["oslc", "-q", "ends.osl"]).status().expect("it starts");
    assert!(compiled.success());
    fs::remove_file(at.join("ends.osl")).expect("it is there");
    let (out, _) = testshade(&at, &[&["-g", "2", "1"], &outputs[..], &["ends"]].concat());
    assert!(out.contains("Pixel (1, 0):\n  before : 2\n  behind : 0\n9\n"), "{out}");
}

const RENUMBERED: &str = "#line 50 \"elsewhere.osl\"\nshader renumbered(output float Cout = 0)\n{\n    float a[2] = { 1, 2 };\n\
    Cout = a[int(u * 0) + 4];\n}\n";

#[test]
fn what_is_said_at_run_time_follows_line_directives() {
    let at = folder("renumbered", &[("renumbered", RENUMBERED)]);
    let said = "ERROR: Index [4] out of range a[0..1]: elsewhere.osl:53 (group unnamed_group_1, layer 0 renumbered_0, \
                shader renumbered)\n";
    assert_eq!(testshade(&at, &["-o", "Cout", "null", "renumbered"]).1, said);
    let oslcl = env!("CARGO_BIN_EXE_oslcl");
    let compiled = Command::new(oslcl).current_dir(&at).args(["oslc", "-q", "renumbered.osl"]).status();
    assert!(compiled.expect("it starts").success());
    fs::remove_file(at.join("renumbered.osl")).expect("it is there");
    assert_eq!(testshade(&at, &["-o", "Cout", "null", "renumbered"]).1, said);
}

const UNASSIGNED: &str = "struct pair { float a; color b; };\n\
shader unassigned(output float Cout = 0)\n{\n    int i;\n    color c;\n    c[1] = 1;\n    Cout = c[1];\n    Cout += c[2];\n\
    float list[3];\n    list[1] = 2;\n    Cout += list[1];\n    Cout += list[int(u) + 2];\n    pair p;\n    p.a = 1;\n    Cout += p.a;\n\
    Cout += p.b[0];\n    float once;\n    if (u > 0.2) once = 1;\n    Cout += once;\n    matrix m;\n    m[1][2] = 1;\n    Cout += m[1][2];\n\
    Cout += m[2][1];\n    Cout += i;\n    float later;\n    later = u;\n    Cout += later;\n}\n";

#[test]
fn variables_that_are_read_too_early_are_reported() {
    let at = folder("unassigned", &[("unassigned", UNASSIGNED)]);
    let (_, err) = testshade(&at, &["--debuguninit", "-o", "Cout", "null", "unassigned"]);
    let said = |what: &str, line: u32| {
        format!(
            "ERROR: Detected possible use of uninitialized value in {what} at unassigned.osl:{line} (group unnamed_group_1, layer 0 \
             unassigned_0, shader unassigned)\n"
        )
    };
    let all = [("color c", 8), ("float[3] list", 12), ("color p.b", 16), ("matrix m", 23), ("int i", 24)];
    assert_eq!(err, all.iter().map(|(what, line)| said(what, *line)).collect::<String>());
    let (_, err) = testshade(&at, &["--debuguninit", "-g", "2", "1", "-o", "Cout", "null", "unassigned"]);
    assert!(err.contains(&said("float once", 19)), "{err}");
    let (_, err) = testshade(&at, &["-o", "Cout", "null", "unassigned"]);
    assert_eq!(err, "");
    // By way of the compiled form, where variables have other names and no place of their own.
    let oslcl = env!("CARGO_BIN_EXE_oslcl");
    let compiled = Command::new(oslcl).current_dir(&at).args(["oslc", "-q", "unassigned.osl"]).status();
    assert!(compiled.expect("it starts").success());
    fs::remove_file(at.join("unassigned.osl")).expect("it is there");
    let (_, err) = testshade(&at, &["--debuguninit", "-o", "Cout", "null", "unassigned"]);
    assert_eq!(err, all.iter().map(|(what, line)| said(what, *line)).collect::<String>());
}

/// Standard error of a run that fails.
fn refused(at: &Path, args: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_oslcl"));
    let output = command.current_dir(at).arg("testshade").args(args).stdin(Stdio::null()).output().expect("it starts");
    assert_ne!(output.status.code(), Some(0), "{args:?}");
    String::from_utf8(output.stderr).expect("the output is UTF-8")
}

#[test]
fn values_that_change_belong_to_a_parameter() {
    let text = "shader test(float k = 1 [[ int interactive = 1 ]], int i = 0)\n{\n    printf(\"%g %d\\n\", k, i);\n}\n";
    let at = folder("reparam", &[("test", text)]);
    let (out, err) =
        testshade(&at, &["--iparam", "i", "4", "-layer", "L", "test", "-iters", "2", "-reparam", "L", "k", "7"]);
    assert_eq!((out.as_str(), err.as_str()), ("1 4\n7 4\n\n", ""));
    for (layer, name, value, said) in [
        ("A", "k", "7", "the group has no layer `A`"),
        ("L", "kk", "7", "layer `L` has no parameter `kk`"),
        ("L", "k", "abc", "parameter `k` of layer `L` is float, which `abc` is not"),
    ] {
        let err = refused(&at, &["-layer", "L", "test", "-iters", "2", "-reparam", layer, name, value]);
        assert!(err.contains(said), "{err}");
    }
}

#[test]
fn attributes_convert() {
    let text = "shader test()\n{\n    int i; color c; float two[2]; vector w; float f;\n\
        int n = getattribute(\"camera:fov\", i) + getattribute(\"camera:fov\", c) + getattribute(\"camera:fov\", two);\n\
        n += getattribute(\"camera:shutter\", w) + getattribute(\"camera:resolution\", 1, f);\n\
        printf(\"%d: %d %g %g %g %g\\n\", n, i, c, two, w, f);\n}\n";
    let at = folder("attributes", &[("test", text)]);
    let (out, err) = testshade(&at, &["test"]);
    assert_eq!((out.as_str(), err.as_str()), ("5: 90 90 90 90 90 90 0 1 0 1\n\n", ""));
}
