//! Runs shaders over points on a device: many shaders in one kernel, since building costs more than running.
//!
//! In: shaders and points. Out: the outputs of each shader at each point, as the device computes them. It must not know
//! what they should be.

use oslcl_compiler::interp::Globals;
use oslcl_compiler::{Entry, Failure, Master, NoIncludes, Options};
use oslcl_runtime::assemble;
use oslcl_runtime::device::{self, Arg, Device};
use oslcl_runtime::roads::{self, Road};
use std::fmt::Write;

/// What the kernels compute in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floats.
    Single,
    /// 64-bit floats.
    Double,
}

impl Precision {
    fn options(self) -> &'static str {
        match self {
            Precision::Single => "-cl-std=CL1.2 -cl-single-precision-constant",
            Precision::Double => "-cl-std=CL1.2 -D OSLCL_F64",
        }
    }
}

/// A shader and the outputs that are asked of it.
pub struct Case {
    /// For messages.
    pub label: String,
    /// The shader after the front half.
    pub master: Master,
    /// Bindings; the entry is set here.
    pub options: Options,
    /// Names of output parameters, or `Ci`.
    pub outputs: Vec<String>,
}

impl Case {
    /// Reads a shader and takes all outputs whose type is numbers; `Ci` too when it is a surface.
    pub fn new(label: &str, source: &str, options: Options) -> Result<Case, Failure> {
        let options = Options { file_name: format!("{label}.osl"), ..options };
        let master = Master::new(source, &options, &NoIncludes)?;
        let mut outputs: Vec<String> =
            master.info().params.iter().filter(|p| p.output).map(|p| p.name.clone()).collect();
        if master.info().kind == "surface" {
            outputs.push("Ci".to_owned());
        }
        let options = Options { entry: Entry::Grid(outputs.clone()), ..options };
        Ok(Case { label: label.to_owned(), master, options, outputs })
    }
}

/// Why a grid did not run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A shader does not compile.
    #[error("{label}: {failure}")]
    Compile {
        /// The case.
        label: String,
        /// What the compiler says.
        failure: Failure,
    },
    /// Kernel text that does not assemble.
    #[error(transparent)]
    Assemble(#[from] assemble::Error),
    /// No program comes out.
    #[error(transparent)]
    Road(#[from] roads::Error),
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
}

/// The reals of one point in the points' buffer.
const RECORD: usize = 54;

/// One point as the kernel reads it.
fn record(g: &Globals) -> Vec<f64> {
    let mut r = Vec::with_capacity(RECORD);
    for v in [g.p, g.i, g.n, g.ng, g.dpdu, g.dpdv, g.ps, g.dpdtime] {
        r.extend(v);
    }
    r.extend([g.u, g.v, g.time, g.dtime, g.surfacearea, f64::from(u8::from(g.backfacing)), f64::from(g.raytype)]);
    for pair in [g.dp, g.di, g.dps] {
        r.extend(pair.into_iter().flatten());
    }
    r.extend(g.du.into_iter().chain(g.dv).chain([f64::from(u8::from(g.flip_handedness))]));
    r
}

/// A program.
struct Written {
    text: String,
    /// Reals that a point's outputs take.
    width: usize,
    modules: Vec<Vec<u32>>,
}

/// The program's text, and what it is linked with.
fn text(cases: &[Case], (road, precision): (Road, Precision)) -> Result<Written, Error> {
    let mut text = String::new();
    let mut calls = String::new();
    let mut width = 0;
    let mut modules = Vec::new();
    for case in cases {
        let options = Options { spirv: road == Road::Spirv, ..case.options.clone() };
        let compiled = case.master.instance(&options);
        let output = compiled.map_err(|failure| Error::Compile { label: case.label.clone(), failure })?;
        let artifact = output.artifact;
        match artifact.spirv {
            None => text.push_str(&artifact.code),
            Some(spirv) => {
                text.push_str(&spirv.bridge);
                modules.push(if precision == Precision::Double { spirv.double } else { spirv.single });
            }
        }
        let _ = writeln!(calls, "    {}(&sg, values + {width});", artifact.entry);
        width += artifact.outputs.iter().map(|o| o.reals as usize).sum::<usize>();
    }
    let says = text.contains("osl/records.h");
    let messages = if says { "#define HAS_MESSAGES\n" } else { "" };
    // Derivatives cost nothing where no shader reads them.
    let mut text = format!("{messages}#define HAS_DERIVATIVES\n#include \"globals.h\"\n{text}");
    let fields = ["P", "I", "N", "Ng", "dPdu", "dPdv", "Ps", "dPdtime"];
    let mut load = String::new();
    for (k, field) in fields.iter().enumerate() {
        let _ = writeln!(load, "    sg.{field} = load_real3(p, {k});");
    }
    for (k, field) in ["u", "v", "time", "dtime", "surfacearea"].iter().enumerate() {
        let _ = writeln!(load, "    sg.{field} = p[{}];", 24 + k);
    }
    let _ = writeln!(load, "    sg.point = (uint)i;");
    for (k, field) in ["dPdx", "dPdy", "dIdx", "dIdy", "dPsdx", "dPsdy"].iter().enumerate() {
        let _ = writeln!(load, "    sg.{field} = (real3)(p[{0}], p[{0} + 1], p[{0} + 2]);", 31 + 3 * k);
    }
    for (k, field) in ["dudx", "dudy", "dvdx", "dvdy"].iter().enumerate() {
        let _ = writeln!(load, "    sg.{field} = p[{}];", 49 + k);
    }
    let _ = writeln!(load, "    sg.flip_handedness = (int)p[53];");
    if says {
        // What is said is for other tests: here nobody listens.
        let _ = writeln!(load, "    sg.records = 0;");
    }
    let _ = write!(
        text,
        "__kernel void grid(__global const real *points, __global const real *spaces, __global real *out)\n{{\n    \
         const size_t i = get_global_id(0);\n    __global const real *p = points + i * {RECORD};\n    ShaderGlobals sg;\n\
         {load}    sg.backfacing = (int)p[29];\n    sg.raytype = (int)p[30];\n    sg.object_space = spaces;\n    \
         sg.shader_space = spaces + 32;\n    sg.camera_space = spaces + 64;\n    sg.other_spaces = 0;\n    real values[{width}];\n{calls}    \
         for (int k = 0; k < {width}; k++) out[i * {width} + k] = values[k];\n}}\n"
    );
    Ok(Written { text: assemble::assemble("grid.cl", &text)?, width, modules })
}

/// Runs all shaders at all points, in one program. The spaces are those of the first point. Per point, the reals of all
/// cases one behind the other.
pub fn run(device: &Device, precision: Precision, cases: &[Case], points: &[Globals]) -> Result<Vec<Vec<f64>>, Error> {
    run_by((Road::OpenClC, ""), device, precision, cases, points)
}

/// What stands in front of a text whose sums and products are each rounded on their own: OpenCL C lets a compiler round
/// `a * b + c` once.
pub const UNCONTRACTED: &str = "#pragma OPENCL FP_CONTRACT OFF\n";

/// As [`run`], by a road of one's choice, with some text in front.
pub fn run_by(
    (road, front): (Road, &str),
    device: &Device,
    precision: Precision,
    cases: &[Case],
    points: &[Globals],
) -> Result<Vec<Vec<f64>>, Error> {
    let Written { text, width, modules } = text(cases, (road, precision))?;
    let modules: Vec<&[u32]> = modules.iter().map(Vec::as_slice).collect();
    let program = roads::build(device, "grid", &format!("{front}{text}"), precision.options(), &modules)?;
    let kernel = program.kernel(device, "grid")?;
    let records: Vec<f64> = points.iter().flat_map(record).collect();
    let first = points.first().cloned().unwrap_or_default();
    let spaces = [first.object_space, first.shader_space, first.camera_space].map(|s| [s.to_common, s.from_common]);
    let spaces: Vec<f64> = spaces.into_iter().flatten().flatten().collect();
    let count = width * points.len();
    let local = if points.len().is_multiple_of(64) { 64 } else { 1 };
    let values: Vec<f64> = match precision {
        Precision::Double => {
            let (a, b) = (device.upload("points", &records)?, device.upload("spaces", &spaces)?);
            let out = device.buffer("out", 8 * count as u64)?;
            kernel.launch(device, &[Arg::Buffer(&a), Arg::Buffer(&b), Arg::Buffer(&out)], points.len(), local)?;
            device.read(&out, count)?
        }
        Precision::Single => {
            let narrow = |v: &[f64]| v.iter().map(|x| *x as f32).collect::<Vec<f32>>();
            let (a, b) = (device.upload("points", &narrow(&records))?, device.upload("spaces", &narrow(&spaces))?);
            let out = device.buffer("out", 4 * count as u64)?;
            kernel.launch(device, &[Arg::Buffer(&a), Arg::Buffer(&b), Arg::Buffer(&out)], points.len(), local)?;
            device.read::<f32>(&out, count)?.into_iter().map(f64::from).collect()
        }
    };
    Ok(values.chunks(width.max(1)).map(<[f64]>::to_vec).collect())
}
