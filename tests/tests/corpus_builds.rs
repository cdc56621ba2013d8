//! Every shader of the corpus, of shaders-osl/ and of the reference set yields OpenCL C that an OpenCL compiler takes.
//!
//! In: the `.osl` files; the first OpenCL device. Out: pass or fail. Several shaders share one program to save time; when
//! one does not build, its group is built again shader by shader, so that the message names the culprits.

use oslcl_compiler::{Entry, Failure, Master, NoIncludes, Options, Output};
use oslcl_runtime::assemble::assemble;
use oslcl_runtime::device::{self, Device, Program};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Build options of the single and of the double precision.
const F32: &str = "-cl-std=CL1.2 -cl-single-precision-constant";
const F64: &str = "-cl-std=CL1.2 -D OSLCL_F64";

/// Shaders per program.
const GROUP: usize = 20;

/// The shader of the project's first goal, verbatim.
const MATTE: &str = r#"surface
matte [[ string description = "Lambertian diffuse material" ]]
(float Kd = 1 [[float UImin = 0, float UIsoftmax = 1 ]],
color Cs = 1 [[float UImin = 0, float UImax = 1 ]],
string texname = "diffuse.tex" [[int texture_slot = 1]] )
{
    Ci = Kd * Cs * noise(5.0 * P) * diffuse (N);
}
"#;

/// A shader's text and where it is from.
struct Source {
    name: String,
    text: String,
}

/// Compiled code for the device, with what to call it in messages.
struct Code {
    name: String,
    code: String,
    lobes: Vec<String>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The `.osl` files of a folder, in order of their names.
fn folder(path: &str) -> Vec<Source> {
    let folder = root().join(path);
    let mut out: Vec<Source> = fs::read_dir(&folder)
        .expect("a folder of shaders")
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.extension().is_some_and(|e| e == "osl"))
        .map(|p| Source {
            name: format!("{path}/{}", p.file_name().unwrap_or_default().to_string_lossy()),
            text: fs::read_to_string(&p).expect("a readable shader"),
        })
        .collect();
    out.sort_by(|a, b| a.name.cmp(&b.name));
    out
}

fn all() -> Vec<Source> {
    let mut out = folder("tests/corpus");
    out.extend(folder("shaders-osl"));
    out.push(Source { name: "matte".into(), text: MATTE.into() });
    out
}

/// A shader as a material and, where it has outputs that are no closures, as a grid function of all of them.
fn compile(source: &Source) -> Result<Vec<Code>, Failure> {
    let options = Options { file_name: source.name.clone(), ..Options::default() };
    let master = Master::new(&source.text, &options, &NoIncludes)?;
    let code = |what: &str, output: Output| Code {
        name: format!("{} as {what}", source.name),
        code: output.artifact.code,
        lobes: output.artifact.lobes,
    };
    let mut out = vec![code("material", master.instance(&options)?)];
    let mut outputs: Vec<String> = Vec::new();
    for p in master.info().params.iter().filter(|p| p.output && !p.ty.starts_with("closure")) {
        if p.fields.is_empty() {
            outputs.push(p.name.clone());
        }
        outputs.extend(p.fields.iter().map(|f| format!("{}.{}", p.name, f.name)));
    }
    if !out[0].lobes.is_empty() {
        outputs.push("Ci".into());
    }
    if !outputs.is_empty() {
        out.push(code("grid", master.instance(&Options { entry: Entry::Grid(outputs), ..options })?));
    }
    Ok(out)
}

fn build(device: &Device, group: &[Code], options: &str) -> Result<(), String> {
    let says = group.iter().any(|c| c.code.contains("osl/records.h"));
    let lobes: BTreeSet<&String> = group.iter().flat_map(|c| &c.lobes).collect();
    let mut text: String = lobes.iter().map(|l| format!("#define HAS_LOBE_{}\n", l.to_uppercase())).collect();
    // Costs nothing where no shader reads derivatives.
    text.insert_str(0, "#define HAS_DERIVATIVES\n");
    if says {
        text.insert_str(0, "#define HAS_MESSAGES\n");
    }
    if group.iter().any(|c| c.code.contains("\"osl/texture") || c.code.contains("\"osl/environment.h")) {
        text.insert_str(0, "#define HAS_TEXTURES\n#define HAS_TEXTURE_CUBIC\n#define HAS_TEXTURE_CLOSEST\n");
    }
    for one in group {
        text.push_str(&one.code);
        text.push('\n');
    }
    let text = assemble("corpus.cl", &text).map_err(|e| e.to_string())?;
    Program::build(device, "corpus", &text, options).map(|_| ()).map_err(|e| e.to_string())
}

#[test]
fn every_shader_builds_in_both_precisions() {
    let mut problems = Vec::new();
    let mut codes = Vec::new();
    for source in all() {
        match compile(&source) {
            Ok(more) => codes.extend(more),
            Err(failure) => problems.push(failure.to_string()),
        }
    }
    if device::list().is_err() {
        println!("skipped: this machine has no OpenCL device");
    } else {
        let device = Device::open(Some("0")).expect("the first device opens");
        let mut runs = vec![F32];
        if device.info.double {
            runs.push(F64);
        }
        for group in codes.chunks(GROUP) {
            for options in &runs {
                if build(&device, group, options).is_ok() {
                    continue;
                }
                for one in group {
                    if let Err(e) = build(&device, std::slice::from_ref(one), options) {
                        problems.push(format!("{} ({options}): {e}\n{}", one.name, one.code));
                    }
                }
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n----\n"));
}
