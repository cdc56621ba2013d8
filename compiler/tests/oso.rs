//! OSL to `.oso` and back means the same; what is no `.oso` is an error with a place.

mod common;

use common::{Beside, corpus, name, shaders, text};
use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Failure, Master, Options, Oso, OsoOptions, to_oso};
use proptest::prelude::*;
use proptest::sample::Index;
use std::path::Path;
use std::sync::LazyLock;

fn options(name: &str) -> Options {
    Options { file_name: name.to_owned(), ..Options::default() }
}

fn oso(name: &str, text: &str) -> Result<Oso, Failure> {
    to_oso(text, &options(name), &OsoOptions::default(), &Beside(corpus()))
}

/// A few points where every global has a value of its own.
fn points() -> Vec<Globals> {
    (0..4)
        .map(|k| {
            let x = 0.21 + 0.37 * f64::from(k);
            Globals {
                p: [x, 0.3 - x, 1.5 * x],
                i: [0.1, -0.7 * x, -0.6],
                n: [0.0, 0.6, 0.8],
                ng: [0.6, 0.0, 0.8],
                u: 0.25 * f64::from(k),
                v: 0.9 - 0.2 * f64::from(k),
                dpdu: [1.0, 0.2, x],
                dpdv: [0.0, 1.1, -x],
                time: 0.5 * x,
                dtime: 0.1,
                ..Globals::default()
            }
        })
        .collect()
}

/// The values of all outputs and of `Ci`.
fn values(master: &Master) -> Result<Vec<f64>, Failure> {
    let outputs = master.info().params.iter().filter(|p| p.output && p.fields.is_empty());
    let number = |ty: &str| !ty.starts_with("string") && !ty.starts_with("closure");
    let mut names: Vec<String> = outputs.filter(|p| number(&p.ty)).map(|p| p.name.clone()).collect();
    names.push("Ci".to_owned());
    let points = master.evaluate_all(&Options::default(), &names, &points())?;
    Ok(points.into_iter().flatten().flat_map(|(_, v)| v).collect())
}

fn first_line(failure: &Failure) -> String {
    failure.to_string().lines().next().unwrap_or_default().to_owned()
}

/// What differs between a shader and its way through `.oso`; `None` when nothing does.
fn differs(name: &str, source: &str) -> Option<String> {
    let direct = Master::new(source, &options(name), &Beside(corpus()));
    let written = match oso(name, source) {
        Ok(written) => written,
        Err(_) if direct.is_err() => return None,
        Err(failure) => return Some(format!("not written: {}", first_line(&failure))),
    };
    let through = Master::from_oso(&written.text, &options("through.oso"));
    let (direct, through) = match (direct, through) {
        (Ok(a), Ok(b)) => (a, b),
        // What is not supported is so both ways.
        (Err(_), Err(_)) => return None,
        (Ok(_), Err(failure)) => return Some(format!("not read: {}\n{}", first_line(&failure), written.text)),
        (Err(failure), Ok(_)) => return Some(format!("read, but as OSL: {}", first_line(&failure))),
    };
    let mut ours = through.info().clone();
    ours.params.iter_mut().for_each(|p| p.resolved = direct.info().params[0].resolved);
    let mut theirs = direct.info().clone();
    theirs.params.iter_mut().for_each(|p| p.resolved = direct.info().params[0].resolved);
    if ours != theirs {
        return Some(format!("the reflection differs:\n{ours:#?}\n{theirs:#?}"));
    }
    match (values(&direct), values(&through)) {
        (Ok(a), Ok(b)) => {
            let near = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan() || (a - b).abs() <= 1e-9 * a.abs().max(1.0);
            let bad = a.iter().zip(&b).position(|(a, b)| !near(*a, *b));
            let bad = if a.len() == b.len() { bad? } else { 0 };
            Some(format!("value {bad}: {:?} and {:?}\n{}", a.get(bad), b.get(bad), written.text))
        }
        (Err(_), Err(_)) => None,
        (Ok(_), Err(failure)) => Some(format!("fails only through .oso: {failure}\n{}", written.text)),
        (Err(failure), Ok(_)) => Some(format!("fails only directly: {failure}")),
    }
}

fn check_folder(folder: &Path) -> usize {
    let mut failures = Vec::new();
    let files = shaders(folder);
    for path in &files {
        if let Some(what) = differs(&name(path), &text(path)) {
            failures.push(format!("{}: {what}", name(path)));
        }
    }
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), files.len(), failures.join("\n\n"));
    files.len()
}

#[test]
fn the_corpus_means_the_same_through_oso() {
    let mut count = check_folder(&corpus());
    for folder in ["run", "builtins", "errors"] {
        let folder = corpus().join(folder);
        if folder.is_dir() {
            count += check_folder(&folder);
        }
    }
    assert!(count > 50, "only {count} shaders were found");
}

#[test]
fn shipped_materials_mean_the_same_through_oso() {
    assert!(check_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-osl")) > 5);
}

/// The corpus as `.oso` texts.
static WRITTEN: LazyLock<Vec<String>> = LazyLock::new(|| {
    let files = [corpus().join("run"), corpus()].map(|f| shaders(&f)).concat();
    files.iter().filter_map(|p| oso(&name(p), &text(p)).ok()).map(|o| o.text).collect()
});

/// A damage: where, where else, and which kind.
type Damage = (Index, Index, u8);

/// Damages lines, words and bytes.
fn damaged(text: &str, damages: &[Damage]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for (at, other, kind) in damages {
        if lines.is_empty() {
            break;
        }
        let (i, j) = (at.index(lines.len()), other.index(lines.len()));
        match kind {
            0 => {
                lines.remove(i);
            }
            1 => lines.insert(i, lines[j].clone()),
            2 => lines.swap(i, j),
            3 => lines.truncate(i.max(j)),
            // Words of one line go into another: types, symbols, jump targets, operations.
            _ => {
                let theirs: Vec<&str> = lines[j].split_inclusive([' ', '\t', ',', '{', '"']).collect();
                let mut ours: Vec<&str> = lines[i].split_inclusive([' ', '\t', ',', '{', '"']).collect();
                if ours.is_empty() || theirs.is_empty() {
                    continue;
                }
                let (a, b) = (other.index(ours.len()), at.index(theirs.len()));
                match kind {
                    4 => ours[a] = theirs[b],
                    5 => ours.insert(a, theirs[b]),
                    _ => {
                        ours.remove(a);
                    }
                }
                lines[i] = ours.concat();
            }
        }
    }
    lines.join("\n")
}

/// Reads and, if that goes well, compiles; errors have a place in the text.
fn survives(text: &str) {
    match Master::from_oso(text, &options("damaged.oso")) {
        Err(failure) => {
            assert!(!failure.diagnostics.is_empty(), "an error that says nothing:\n{text}");
            for d in &failure.diagnostics {
                assert!(!d.labels.is_empty(), "an error without a place: {}\n{text}", d.message);
            }
        }
        // What is wrong with a shader that was read may depend on its parameters' values: that is the back half's to say.
        Ok(master) => {
            let _ = master.instance(&Options::default());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_are_errors_with_a_place(
        which in any::<Index>(),
        damages in prop::collection::vec((any::<Index>(), any::<Index>(), 0u8..7), 1..4),
    ) {
        survives(&damaged(which.get::<String>(&WRITTEN), &damages));
    }

    #[test]
    fn any_text_behind_the_first_line_is_an_error_or_a_shader(rest in "(.|\n){0,200}") {
        survives(&format!("OpenShadingLanguage 1.00\n{rest}"));
    }
}

#[test]
fn what_is_wrong_with_a_file_is_said_where_it_stands() {
    let head = "OpenShadingLanguage 1.00\nshader test\n";
    let cases: [(&str, u32, &str); 16] = [
        ("shader test() {}", 1, "this is no .oso file"),
        ("OpenShadingLanguage 2.00\nshader test\n", 1, "version 2"),
        ("OpenShadingLanguage 1.00\nshader\n", 2, "kind and name"),
        (&format!("{head}param float a 0\n"), 4, "cut off"),
        (&format!("{head}param half a 0\n"), 3, "`half` is no type"),
        (&format!("{head}param float a 0 0\n"), 3, "no room for 2 values"),
        (&format!("{head}param float a \"x\"\n"), 3, "does not fit float"),
        (&format!("{head}param float a 0\nparam float a 0\n"), 4, "two symbols are called `a`"),
        (&format!("{head}const string s \"x\n"), 3, "never closed"),
        (&format!("{head}global float P\ncode ___main___\n\tend\n"), 3, "there is no shader global `float P`"),
        (&format!("{head}code ___main___\n\tassign x y\n\tend\n"), 4, "there is no symbol `x`"),
        (&format!("{head}temp float x\ncode ___main___\n\tblahblah x x\n\tend\n"), 5, "`blahblah` is not known"),
        (&format!("{head}temp float x\ncode ___main___\n\tsqr x x\n\tend\n"), 5, "`sqr` is not known"),
        (&format!("{head}temp string x\ncode ___main___\n\tsin x x\n\tend\n"), 5, "does not take (string, string)"),
        (&format!("{head}temp int x\ncode ___main___\n\tif x 7 9\n\tend\n"), 5, "jump target"),
        (&format!("{head}temp int x\ncode ___main___\n\tbreak\n\tend\n"), 5, "outside of a loop"),
    ];
    for (text, line, part) in cases {
        let failure = Master::from_oso(text, &options("bad.oso")).expect_err(text);
        let d = &failure.diagnostics[0];
        assert!(d.message.contains(part), "`{part}` is not in `{}`\n{text}", d.message);
        assert_eq!(failure.sources.locate(d.labels[0].span).line, line, "{}\n{text}", d.message);
    }
}

/// A file as older compilers write it, with what ours does not write: labels, weights of closures, operations of other
/// names, code of struct fields.
#[test]
fn files_of_other_compilers_are_read() {
    let text = "OpenShadingLanguage 1.00\n# Compiled by oslc 1.10.9\n# options: -q\nsurface old\t%meta{string,help,\"a \\\"b\\\"\"}\n\
        param\tstruct tone\tt\t\t%meta{string,label,\"T\"} %read{0,1} %write{2147483647,-1} %struct{\"tone\"} \
        %structfields{tint,gain} %structfieldtypes{\"cf\"} %structnfields{2}\n\
        param\tcolor\tt.tint\t0.5 0.25 1\t%read{0,1} %write{2147483647,-1} %mystruct{t} %mystructfield{0}\n\
        param\tfloat\tt.gain\t0\t%read{0,1} %write{0,0} %mystruct{t} %mystructfield{1} %initexpr\n\
        param\tfloat[]\tweights\t1 2 3\t%read{0,1} %write{2147483647,-1}\n\
        oparam\tvector\tout\t0 0 0\t%read{0,1} %write{0,1} %derivs\n\
        oparam\tint\tcount\t0\t%read{0,1} %write{0,1}\n\
        global\tnormal\tN\t%read{0,1} %write{2147483647,-1}\nglobal\tfloat\tu\t%read{0,0} %write{2147483647,-1}\n\
        global\tclosure color\tCi\t%read{0,1} %write{0,1}\nlocal\tvector\t___345_v\t%read{0,1} %write{0,1}\n\
        temp\tclosure color\t$tmp1\t%read{0,1} %write{0,1}\ntemp\tint\t$tmp2\ntemp\tfloat\t$tmp3\n\
        const\tfloat\t$const1\t2\t%read{0,1} %write{2147483647,-1}\nconst\tstring\t$const2\t\"diffuse\"\n\
        const\tint\t$const3\t0\nconst\tint\t$const4\t3\nconst\tint\t$const5\t1\nconst\tstring\t$const6\t\"common\"\n\
        const\tstring\t$const7\t\"f\"\nconst\tfloat\t$const8\t1\n\
        code t.gain\n\tmul\t\tt.gain u $const1 \t%filename{\"old.osl\"} %line{3} %argrw{\"wrr\"}\n\
        code ___main___\n# old.osl:7\n#     for (int i = 0; i < 3; ++i)\n\
        1:\tassign\t\tcount $const3 \t%argrw{\"wr\"}\n\
        \tfor\t\t$tmp2 4 5 7 8 \t%argrw{\"r\"}\n\tassign\t\tcount $const3 \t%argrw{\"wr\"}\n\
        \tlt\t\t$tmp2 count $const4 \t%argrw{\"wrr\"}\n\tneg\t\t___345_v N \t%argrw{\"wr\"}\n\
        \taref\t\t$tmp3 weights count \t%argrw{\"wrr\"}\n\tadd\t\tcount count $const5 \t%argrw{\"wrr\"}\n\
        \tfunctioncall\t$const7 12 \t%argrw{\"r\"}\n\tif\t\tcount 11 11\n\treturn\n\tassign\t\t$tmp3 $const3\n\
        \ttransformv\tout $const6 ___345_v \t%argrw{\"wrr\"}\n\tmul\t\tout out $tmp3 \t%argrw{\"wrr\"}\n\
        \tmul\t\tout out t.gain\n\
        \tclosure\t\t$tmp1 t.tint $const2 N \t%argrw{\"wrrr\"}\n\tmul\t\tCi $tmp1 $const8 \t%argrw{\"wrr\"}\n\tend\n";
    let master = Master::from_oso(text, &options("old.oso")).unwrap_or_else(|f| panic!("{f}"));
    let info = master.info();
    assert_eq!(info.params[0].fields.len(), 2);
    assert_eq!(info.params[1].ty, "float[]");
    assert_eq!(info.metadata[0].value, Some(oslcl_compiler::reflect::Value::Str("a \"b\"".into())));
    let at = Globals { n: [0.0, 0.0, 1.0], u: 0.25, ..Globals::default() };
    let names = ["out".to_owned(), "count".to_owned()];
    let values = master.evaluate(&Options::default(), &names, &at).unwrap_or_else(|f| panic!("{f}"));
    assert_eq!(values[1].1, [3.0]);
    // -N times the last weight, 3, times t.gain, 2 u.
    assert_eq!(values[0].1, [0.0, 0.0, -1.5]);
    let output = master.instance(&Options::default()).unwrap_or_else(|f| panic!("{f}"));
    assert_eq!(output.artifact.lobes, ["diffuse"]);
}

#[test]
fn a_closure_that_nothing_maps_is_told_of() {
    let source = std::fs::read_to_string(corpus().join("closure_vendor.osl")).expect("a shader of the corpus");
    let written = oso("closure_vendor.osl", &source).unwrap_or_else(|e| panic!("{e}"));
    let master = Master::from_oso(&written.text, &options("vendor.oso")).unwrap_or_else(|e| panic!("{e}"));
    let output = master.instance(&Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let unmapped: Vec<_> = output.warnings.iter().filter(|d| d.code == "W2009").collect();
    let [only] = unmapped[..] else { panic!("{:?}", output.warnings) };
    assert!(only.message.contains("`acme_shimmer`"), "{}", only.message);
}

/// Functions that call each other twice double the code with each level.
#[test]
fn a_shader_that_grows_without_bound_is_refused() {
    let mut source = "void f0(output float x) { x = x * 2 + sin(x); }\n".to_owned();
    for i in 0..24 {
        source += &format!("void f{}(output float x) {{ f{i}(x); f{i}(x); }}\n", i + 1);
    }
    source += "shader grows(output float f = 0) { f24(f); }";
    let failure = oso("grows.osl", &source).expect_err("too large");
    assert_eq!(failure.diagnostics[0].code, "E5003");
}
