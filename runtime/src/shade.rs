//! Runs a shader over a grid of points, without a scene.
//!
//! In: a master, parameter values, which outputs, the grid. Out: a [`Plane`] of numbers per output. The points are those of
//! OSL's testshade: u and v run from 0 to 1 over the grid (0.5 where it is one point wide), P = (u, v, 1),
//! N = Ng = (0, 0, 1), dPdu and dPdv along x and y, I = (0, 0, -1); all spaces are common space. It must not know files.
//!
//! ```no_run
//! use oslcl_compiler::{Master, NoIncludes, Options};
//! use oslcl_runtime::{device::Device, precision::Precision, shade};
//!
//! let options = Options::default();
//! let source = "shader ramp(output color Cout = 0) { Cout = color(u, v, 0); }";
//! let master = Master::new(source, &options, &NoIncludes)?;
//! let artifact = shade::compile(&master, &options, &shade::default_outputs(master.info()))?;
//! let grid = shade::Grid { width: 4, height: 4 };
//! let planes = shade::run(&Device::open(None)?, &artifact, grid, Precision::Standard)?;
//! assert_eq!(planes[0].point(3, 0), [1.0, 0.0, 0.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::assemble;
use crate::device::{self, Arg, Device, Program};
use crate::precision::Precision;
use oslcl_compiler::reflect::ShaderInfo;
use oslcl_compiler::{Artifact, Entry, Failure, Master, Options};

/// Work-items of a group.
const GROUP: usize = 64;

/// Most reals that a launch writes: bounds the device memory, whatever the grid.
const MAX_LAUNCH_REALS: u64 = 1 << 23;

/// Points of a grid, across and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Across, at least 1.
    pub width: u32,
    /// Down, at least 1.
    pub height: u32,
}

/// The values of one output.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// The output's name.
    pub name: String,
    /// Its type in OSL's words, such as `color` or `float[4]`.
    pub ty: String,
    /// Points.
    pub grid: Grid,
    /// Numbers per point: elements in order, triples as 3, matrices as 16 row by row.
    pub channels: u32,
    /// All numbers; a point's stand together, points run along u first, then along v.
    pub data: Vec<f64>,
}

impl Plane {
    /// The numbers of the point in column `x`, row `y`; empty outside the grid.
    pub fn point(&self, x: u32, y: u32) -> &[f64] {
        let (x, y, n) = (x as usize, y as usize, self.channels as usize);
        if x >= self.grid.width as usize {
            return &[];
        }
        let start = (y * self.grid.width as usize + x) * n;
        self.data.get(start..start + n).unwrap_or(&[])
    }
}

/// Why there are no values.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// The generated code includes an unknown header.
    #[error(transparent)]
    Assemble(#[from] assemble::Error),
    /// There are no outputs or no points.
    #[error("nothing to shade: the grid or the list of outputs is empty")]
    Empty,
    /// The host has no memory for the values.
    #[error("not enough memory for {} x {} points of {reals} numbers\n  help: use a smaller grid", grid.width, grid.height)]
    TooLarge {
        /// The points.
        grid: Grid,
        /// Numbers per point.
        reals: u64,
    },
}

/// The outputs to show when nobody asks for particular ones: all that are numbers, else `Ci`. Structs by their fields.
pub fn default_outputs(info: &ShaderInfo) -> Vec<String> {
    let numeric = |ty: &str| {
        let base = ty.split('[').next().unwrap_or(ty);
        matches!(base, "int" | "float" | "color" | "point" | "vector" | "normal" | "matrix")
    };
    let mut out = Vec::new();
    for param in info.params.iter().filter(|p| p.output) {
        if numeric(&param.ty) {
            out.push(param.name.clone());
        } else if !param.ty.contains('[') {
            let fields = param.fields.iter().filter(|f| numeric(&f.ty));
            out.extend(fields.map(|f| format!("{}.{}", param.name, f.name)));
        }
    }
    if out.is_empty() {
        out.push("Ci".to_owned());
    }
    out
}

/// Binds the options' parameters and writes the function that [`run`] takes. `outputs` are flattened names of output
/// parameters, or `Ci`: the sum of all closures' weights.
pub fn compile(master: &Master, options: &Options, outputs: &[String]) -> Result<Artifact, Failure> {
    let options = Options { entry: Entry::Grid(outputs.to_vec()), ..options.clone() };
    Ok(master.instance(&options)?.artifact)
}

/// Builds the artifact of [`compile`] for the device and runs it over the grid. The planes come in the order of the outputs.
pub fn run(device: &Device, artifact: &Artifact, grid: Grid, precision: Precision) -> Result<Vec<Plane>, Error> {
    if precision.is_double() && !device.info.double {
        return Err(device::Error::NoDouble { device: device.info.name.clone() }.into());
    }
    let mut planes = planes(artifact, grid)?;
    let _span = tracing::debug_span!("shade", shader = artifact.name).entered();
    let program = Program::build(device, &artifact.name, &program(artifact)?, precision.build_options())?;
    if precision.is_double() {
        launch::<f64>(device, &program, grid, &mut planes)?;
    } else {
        launch::<f32>(device, &program, grid, &mut planes)?;
    }
    Ok(planes)
}

/// Empty planes with room for all values.
fn planes(artifact: &Artifact, grid: Grid) -> Result<Vec<Plane>, Error> {
    let reals: u64 = artifact.outputs.iter().map(|o| u64::from(o.reals)).sum();
    let points = u64::from(grid.width) * u64::from(grid.height);
    if reals == 0 || points == 0 {
        return Err(Error::Empty);
    }
    let mut planes = Vec::new();
    for output in &artifact.outputs {
        let mut data: Vec<f64> = Vec::new();
        let room = points.checked_mul(u64::from(output.reals)).and_then(|n| usize::try_from(n).ok());
        if room.is_none_or(|n| data.try_reserve_exact(n).is_err()) {
            return Err(Error::TooLarge { grid, reals });
        }
        planes.push(Plane { name: output.name.clone(), ty: output.ty.clone(), grid, channels: output.reals, data });
    }
    Ok(planes)
}

/// The shader's text with the kernel behind it.
fn program(artifact: &Artifact) -> Result<String, Error> {
    let reals: u32 = artifact.outputs.iter().map(|o| o.reals).sum();
    let lobes: String = artifact.lobes.iter().map(|l| format!("#define HAS_LOBE_{}\n", l.to_uppercase())).collect();
    let text = format!(
        "{lobes}{}\n#define SHADE_ENTRY {}\n#define SHADE_REALS {reals}\n#include \"stages/shade.cl\"\n",
        artifact.code, artifact.entry
    );
    Ok(assemble::assemble(&format!("{}.cl", artifact.entry), &text)?)
}

/// A float of the device that the host can read.
trait Real: device::Plain + From<f32> + Into<f64> {}
impl Real for f32 {}
impl Real for f64 {}

/// To common space and back, where all spaces are the same (ShaderGlobals in kernels/globals.h).
fn identity<T: Real>() -> Vec<T> {
    (0..32).map(|i| T::from(if i % 16 % 5 == 0 { 1.0 } else { 0.0 })).collect()
}

/// Runs the kernel over bands of rows and sorts what it stores into the planes.
fn launch<T: Real>(device: &Device, program: &Program, grid: Grid, planes: &mut [Plane]) -> Result<(), Error> {
    let kernel = program.kernel(device, "shade")?;
    let (width, height) = (u64::from(grid.width), u64::from(grid.height));
    let reals: u64 = planes.iter().map(|p| u64::from(p.channels)).sum();
    let band = (MAX_LAUNCH_REALS / (width * reals)).clamp(1, height);
    let spaces = device.upload("spaces", &identity::<T>())?;
    let outputs = device.buffer("shade outputs", band * width * reals * size_of::<T>() as u64)?;
    let mut row = 0;
    while row < height {
        let count = band.min(height - row) * width;
        let args = [
            Arg::U32(row as u32),
            Arg::U32(count as u32),
            Arg::U32(grid.width),
            Arg::U32(grid.height),
            Arg::Buffer(&spaces),
            Arg::Buffer(&outputs),
        ];
        kernel.launch(device, &args, (count as usize).next_multiple_of(GROUP), GROUP)?;
        let values: Vec<T> = device.read(&outputs, (count * reals) as usize)?;
        for point in values.chunks_exact(reals as usize) {
            let mut rest = point;
            for plane in planes.iter_mut() {
                let (mine, others) = rest.split_at(plane.channels as usize);
                plane.data.extend(mine.iter().map(|v| (*v).into()));
                rest = others;
            }
        }
        row += band;
    }
    Ok(())
}
