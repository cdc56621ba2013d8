//! The SPIR-V back end as its callers see it: when it writes, what the artifact says of it, what it refuses.
//!
//! Validity and results of modules are the matter of tests/tests/spirv.rs, which has the tools and devices.

use oslcl_compiler::artifact::Artifact;
use oslcl_compiler::{Entry, NoIncludes, Options, compile};

fn artifact(source: &str, entry: Entry) -> Result<Artifact, Vec<&'static str>> {
    let options = Options { entry, spirv: true, ..Options::default() };
    match compile(source, &options, &NoIncludes) {
        Ok(output) => Ok(output.artifact),
        Err(failure) => Err(failure.diagnostics.iter().map(|d| d.code).collect()),
    }
}

const CHALK: &str = "surface chalk(color Cs = 0.5) { Ci = Cs * sin(u) * diffuse(N); }";

#[test]
fn it_is_written_when_asked_for() {
    let plain = compile(CHALK, &Options::default(), &NoIncludes).expect("compiles").artifact;
    assert_eq!(plain.spirv, None);
    let first = artifact(CHALK, Entry::Material).expect("compiles");
    let second = artifact(CHALK, Entry::Material).expect("compiles");
    assert_eq!(first, second, "the same source, the same words");
    // All else is as without it.
    assert_eq!(Artifact { spirv: None, ..first.clone() }, plain);
    assert_eq!(first.to_json(), plain.to_json());
    let spirv = first.spirv.expect("asked for");
    assert_eq!((spirv.single[0], spirv.double[0]), (0x0723_0203, 0x0723_0203));
    assert_eq!(spirv.single[1], 0x0001_0000, "SPIR-V 1.0");
    assert!(spirv.double.len() > spirv.single.len(), "64-bit constants are longer");
}

#[test]
fn the_bridge_has_what_the_module_calls_and_the_entry() {
    let artifact = artifact(CHALK, Entry::Material).expect("compiles");
    let spirv = artifact.spirv.expect("asked for");
    let bytes: Vec<u8> = spirv.single.iter().flat_map(|w| w.to_le_bytes()).collect();
    let names = String::from_utf8_lossy(&bytes).into_owned();
    let entry = &artifact.entry;
    for function in ["u", "osl_sin_f_f", "nothing", "lobe0"] {
        let name = format!("{entry}_{function}");
        assert!(names.contains(&name), "the module imports {name}");
        assert!(spirv.bridge.contains(&format!("{name}(")), "the bridge has {name}:\n{}", spirv.bridge);
    }
    assert!(spirv.bridge.contains(&format!("void {entry}_il(uchar *sg, real pick, uchar *out);")));
    assert!(spirv.bridge.contains(&format!("void {entry}(const ShaderGlobals *sg, real pick, ShadeResult *out)")));
    assert_eq!(spirv.includes.last().map(String::as_str), Some("bsdf/pick.h"), "lobes' headers come last");
    for include in &spirv.includes {
        assert!(spirv.bridge.contains(&format!("#include \"{include}\"")));
    }
}

#[test]
fn calls_with_too_many_arguments_are_refused_with_their_place() {
    let numbers: String = (0..300).map(|i| format!(", u + {i}")).collect();
    let formats = "%g ".repeat(300);
    let source = format!("shader many(output float f = 0) {{\n    printf(\"{formats}\"{numbers});\n    f = u;\n}}");
    let options = Options { entry: Entry::Grid(vec!["f".into()]), ..Options::default() };
    assert!(compile(&source, &options, &NoIncludes).is_ok(), "OpenCL C takes it");
    let failure = compile(&source, &Options { spirv: true, ..options }, &NoIncludes).expect_err("SPIR-V does not");
    let text = failure.to_string();
    assert!(text.contains("E4301") && text.contains(":2:"), "{text}");
}

#[test]
fn long_arrays_of_constants() {
    let numbers: Vec<String> = (0..70_000).map(|i| format!("{i}.5")).collect();
    let shader = |rest: &str| {
        format!(
            "shader s(output float f = 0) {{ float t[70000] = {{ {} }}; {rest} f = t[(int)(u * 70000)]; }}",
            numbers.join(", ")
        )
    };
    let grid = || Entry::Grid(vec!["f".into()]);
    // A table is written in parts; a variable cannot be.
    assert!(artifact(&shader(""), grid()).is_ok());
    assert_eq!(artifact(&shader("t[(int)(v * 9)] = u;"), grid()), Err(vec!["E4302"]));
}
