//! Runs a shader over a grid of points, without a scene.
//!
//! In: a master, parameter values, which outputs, the [`Grid`]. Out: a [`Plane`] of numbers per output, and what the shader says
//! by `printf` and the like as [`Message`]s. It must not know files.
//!
//! ```no_run
//! use oslcl_compiler::{Master, NoIncludes, Options};
//! use oslcl_runtime::{device::Device, precision::Precision, shade};
//!
//! let options = Options::default();
//! let source = "shader ramp(output color Cout = 0) { Cout = color(u, v, 0); }";
//! let master = Master::new(source, &options, &NoIncludes)?;
//! let artifact = shade::compile(&master, &options, &shade::default_outputs(master.info()))?;
//! let grid = shade::Grid::new(4, 4);
//! let shaded = shade::run(&Device::open(None)?, &artifact, grid, Precision::Standard)?;
//! assert_eq!(shaded.planes[0].point(3, 0), [1.0, 0.0, 0.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::assemble;
use crate::choices::Choices;
use crate::device::{self, Arg, Buffer, Device, Program};
use crate::materials;
use crate::preamble;
use crate::precision::Precision;
use crate::textures::{self, Library, Packed};
use crate::{points, programs, roads};
use oslcl_compiler::reflect::ShaderInfo;
use oslcl_compiler::{Artifact, Entry, Failure, Globals, Group, HostRun, Master, Options};
use std::time::Instant;

pub use crate::grid::Grid;
pub use crate::supplies::{Given, PointData, Supplies};
pub use oslcl_compiler::messages::{Kind, Message};

/// Work-items of a group.
const GROUP: usize = 64;

/// Most reals that a launch writes: bounds the device memory, whatever the grid.
const MAX_LAUNCH_REALS: u64 = 1 << 23;

/// Words of the first buffer for messages; one that overflows is made as large as it has to be.
pub(crate) const RECORD_WORDS: u32 = 1 << 16;

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

/// What a shader does on a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shaded {
    /// The outputs, in the order asked for.
    pub planes: Vec<Plane>,
    /// What the shader said: by points, row by row, then in the order of the program.
    pub messages: Vec<Message>,
    /// Texture files that are missing, each with the shader and the cause.
    pub warnings: Vec<String>,
}

/// Why there are no values.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// No program comes out.
    #[error(transparent)]
    Road(#[from] roads::Error),
    /// The generated code includes an unknown header.
    #[error(transparent)]
    Assemble(#[from] assemble::Error),
    /// What came back as messages is none.
    #[error(transparent)]
    Messages(#[from] oslcl_compiler::messages::Damaged),
    /// The point clouds can't be held.
    #[error(transparent)]
    Points(#[from] points::Error),
    /// The textures can't be held.
    #[error(transparent)]
    Textures(#[from] textures::Error),
    /// There are no outputs or no points.
    #[error("nothing to shade: the grid or the list of outputs is empty")]
    Empty,
    /// The host has no memory for the values.
    #[error("not enough memory for {width} x {height} points of {reals} numbers\n  help: use a smaller grid")]
    TooLarge {
        /// Points across.
        width: u32,
        /// Points down.
        height: u32,
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

/// Builds the artifact of [`compile`] for the device and runs it over the grid. Textures are looked for where the names of
/// their files say.
pub fn run(device: &Device, artifact: &Artifact, grid: Grid, precision: Precision) -> Result<Shaded, Error> {
    run_with(device, artifact, grid, precision, &Library::default())
}

/// As [`run`], with the textures of a library; it is the one that the options of [`compile`] should have, too.
pub fn run_with(
    device: &Device,
    artifact: &Artifact,
    grid: Grid,
    precision: Precision,
    library: &Library,
) -> Result<Shaded, Error> {
    run_supplied(device, artifact, grid, precision, library, &Supplies::default())
}

/// As [`run_with`], with userdata and values of interactive parameters; the userdata is the one that the options of [`compile`]
/// had. Nothing is compiled anew for other values of interactive parameters: a driver's cache has the program.
pub fn run_supplied(
    device: &Device,
    artifact: &Artifact,
    grid: Grid,
    precision: Precision,
    library: &Library,
    supplies: &Supplies,
) -> Result<Shaded, Error> {
    Ok(run_timed(device, artifact, grid, precision, library, supplies, 1)?.0)
}

/// As [`run_supplied`], `repeats` times; also the seconds that the fastest took on the device, transfers aside.
pub fn run_timed(
    device: &Device,
    artifact: &Artifact,
    grid: Grid,
    precision: Precision,
    library: &Library,
    supplies: &Supplies,
    repeats: u32,
) -> Result<(Shaded, f64), Error> {
    if let Some(needs) = Choices::from(precision).needs_double().filter(|_| !device.info.double) {
        return Err(device::Error::NoDouble { device: device.info.name.clone(), needs }.into());
    }
    let clouds = points::pack(library.points(), artifact.point_clouds.iter().map(String::as_str))?;
    let packed = textures::pack(library, artifact.textures.iter().map(|t| t.file.as_str()))?;
    let _span = tracing::debug_span!("shade", shader = artifact.name).entered();
    let program = build(device, artifact, precision, supplies)?;
    let run = if precision.is_double() { launch::<f64> } else { launch::<f32> };
    let mut shaded = Shaded::default();
    let mut fastest = f64::INFINITY;
    for _ in 0..repeats.max(1) {
        shaded = Shaded { planes: planes(artifact, grid)?, ..Shaded::default() };
        let seconds = run(device, &program, artifact, grid, (&packed, &clouds), supplies, &mut shaded)?;
        fastest = fastest.min(seconds);
    }
    shaded.warnings.extend(materials::missing(library, artifact));
    Ok((shaded, fastest))
}

/// Runs a shader over the grid on the host, in f64: the way for shaders that need strings which a device cannot build.
/// `outputs` as for [`compile`].
pub fn run_on_host(master: &Master, options: &Options, outputs: &[String], grid: Grid) -> Result<Shaded, HostError> {
    on_host(grid, |count, point| master.run_on_host(options, outputs, count, point))
}

/// As [`run_on_host`], for a group.
pub fn run_group_on_host(
    group: &Group,
    options: &Options,
    outputs: &[String],
    grid: Grid,
) -> Result<Shaded, HostError> {
    on_host(grid, |count, point| group.run_on_host(options, outputs, count, point))
}

/// Whether a shader that [`compile`] refuses may still run on the host: all that is wrong is that no device can do it.
pub fn needs_host(failure: &Failure) -> bool {
    let mut errors = failure.diagnostics.iter().filter(|d| d.is_error()).peekable();
    errors.peek().is_some() && errors.all(|d| d.code == "E3001")
}

/// Why there are no values from the host.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// The shader does not compile, or does what nobody carries out.
    #[error(transparent)]
    Compile(#[from] Failure),
    /// There are no outputs or no points, or too many.
    #[error(transparent)]
    Grid(#[from] Error),
}

fn on_host(
    grid: Grid,
    run: impl FnOnce(u32, &(dyn Fn(u32) -> Globals + Sync)) -> Result<HostRun, Failure>,
) -> Result<Shaded, HostError> {
    let count = grid.width.checked_mul(grid.height).ok_or(Error::TooLarge {
        width: grid.width,
        height: grid.height,
        reals: 1,
    })?;
    if count == 0 {
        return Err(Error::Empty.into());
    }
    let run = run(count, &|i| grid.globals(i % grid.width, i / grid.width))?;
    let planes = run.outputs.into_iter().zip(run.data).map(|(output, data)| Plane {
        name: output.name,
        ty: output.ty,
        grid,
        channels: output.reals,
        data,
    });
    Ok(Shaded { planes: planes.collect(), messages: run.messages, ..Shaded::default() })
}

/// Empty planes with room for all values.
fn planes(artifact: &Artifact, grid: Grid) -> Result<Vec<Plane>, Error> {
    let reals: u64 = artifact.outputs.iter().map(|o| u64::from(o.reals)).sum();
    let points = u64::from(grid.width) * u64::from(grid.height);
    if points == 0 || (reals == 0 && artifact.sites.is_empty()) {
        return Err(Error::Empty);
    }
    let mut planes = Vec::new();
    for output in &artifact.outputs {
        let mut data: Vec<f64> = Vec::new();
        let room = points.checked_mul(u64::from(output.reals)).and_then(|n| usize::try_from(n).ok());
        if room.is_none_or(|n| data.try_reserve_exact(n).is_err()) {
            return Err(Error::TooLarge { width: grid.width, height: grid.height, reals });
        }
        planes.push(Plane { name: output.name.clone(), ty: output.ty.clone(), grid, channels: output.reals, data });
    }
    Ok(planes)
}

/// Builds the program that [`run_supplied`] runs.
pub fn build(
    device: &Device,
    artifact: &Artifact,
    precision: Precision,
    supplies: &Supplies,
) -> Result<Program, Error> {
    let text = program(artifact, supplies)?;
    let module = roads::module(artifact, precision);
    Ok(programs::build_one(device, &artifact.name, &text, precision.build_options(), module.as_slice())?)
}

/// The shader's text with the kernel behind it.
fn program(artifact: &Artifact, supplies: &Supplies) -> Result<String, Error> {
    let reals: u32 = artifact.outputs.iter().map(|o| o.reals).sum();
    let text = format!(
        "{}{}{}\n#define SHADE_ENTRY {}\n#define SHADE_REALS {reals}\n#include \"stages/shade.cl\"\n",
        preamble::text(artifact),
        preamble::code(artifact),
        supplies.code(artifact),
        artifact.entry
    );
    Ok(assemble::assemble(&format!("{}.cl", artifact.entry), &text)?)
}

/// A float of the device that the host can read.
pub(crate) trait Real: device::Plain + Into<f64> {
    /// Rounds to the nearest.
    fn from_f64(v: f64) -> Self;

    /// The number of which the first four bytes are an int's.
    fn from_int(v: i32) -> Self;
}

impl Real for f32 {
    fn from_f64(v: f64) -> f32 {
        v as f32
    }

    fn from_int(v: i32) -> f32 {
        f32::from_bits(v as u32)
    }
}

impl Real for f64 {
    fn from_f64(v: f64) -> f64 {
        v
    }

    fn from_int(v: i32) -> f64 {
        // In the order of the host's bytes, which is the device's.
        let [a, b, c, d] = v.to_ne_bytes();
        f64::from_ne_bytes([a, b, c, d, 0, 0, 0, 0])
    }
}

/// Slots as the device's numbers; of each whether it is an int.
pub(crate) fn numbers<T: Real>(slots: &[(f64, bool)]) -> Vec<T> {
    slots.iter().map(|(v, int)| if *int { T::from_int(*v as i32) } else { T::from_f64(*v) }).collect()
}

/// Numbers of the host as the device's.
fn upload<T: Real>(device: &Device, name: &'static str, values: &[f64]) -> Result<device::Buffer, device::Error> {
    device.upload(name, &values.iter().map(|v| T::from_f64(*v)).collect::<Vec<T>>())
}

/// The buffer that a kernel's messages go to (kernels/osl/records.h).
pub(crate) struct Records {
    pub buffer: Buffer,
    words: u32,
}

impl Records {
    pub fn new(device: &Device, words: u32) -> Result<Records, device::Error> {
        let buffer = device.buffer("shade messages", (u64::from(words) + 2) * 4)?;
        Ok(Records { buffer, words })
    }

    /// To be called before each launch.
    pub fn reset(&mut self, device: &Device) -> Result<(), device::Error> {
        device.write(&mut self.buffer, &[0, self.words])
    }

    /// As much of the last launch's records as there is room for, and how many words were lost.
    pub fn take_what_fits(&self, device: &Device) -> Result<(Vec<u32>, u64), device::Error> {
        let used = device.read::<u32>(&self.buffer, 1)?[0];
        let words: Vec<u32> = device.read(&self.buffer, used.min(self.words) as usize + 2)?;
        Ok((words[2..].to_vec(), u64::from(used.saturating_sub(self.words))))
    }

    /// The words of the last launch's records; when there was no room for all of them, makes room and gives none.
    pub fn take(&mut self, device: &Device) -> Result<Option<Vec<u32>>, device::Error> {
        let used = device.read::<u32>(&self.buffer, 1)?[0];
        if used > self.words {
            *self = Records::new(device, used.checked_next_power_of_two().unwrap_or(used))?;
            return Ok(None);
        }
        let words: Vec<u32> = device.read(&self.buffer, used as usize + 2)?;
        Ok(Some(words[2..].to_vec()))
    }
}

/// Runs the kernel over bands of rows and sorts what it stores into the planes; the seconds that the kernel ran.
fn launch<T: Real>(
    device: &Device,
    program: &Program,
    artifact: &Artifact,
    grid: Grid,
    (packed, clouds): (&Packed, &points::Packed),
    supplies: &Supplies,
    shaded: &mut Shaded,
) -> Result<f64, Error> {
    let kernel = program.kernel(device, "shade")?;
    let (width, height) = (u64::from(grid.width), u64::from(grid.height));
    let reals: u64 = shaded.planes.iter().map(|p| u64::from(p.channels)).sum();
    // A shader without outputs still says something.
    let band = (MAX_LAUNCH_REALS / (width * reals.max(1))).clamp(1, height);
    let spaces = upload::<T>(device, "spaces", &grid.spaces())?;
    let patch = upload::<T>(device, "patch", &grid.patch().map(f64::from))?;
    let outputs = device.buffer("shade outputs", band * width * reals.max(1) * size_of::<T>() as u64)?;
    let mut records = if artifact.sites.is_empty() { None } else { Some(Records::new(device, RECORD_WORDS)?) };
    let strings = supplies.strings();
    let decoder = artifact.decoder(packed.messages.iter().chain(&strings).chain(&clouds.strings));
    let interactive: Vec<T> = numbers(&supplies.interactive(artifact));
    let interactive = match interactive.is_empty() {
        true => None,
        false => Some(device.upload("interactive parameters", &interactive)?),
    };
    let textures = match artifact.textures.is_empty() {
        true => None,
        false => Some(device.upload("textures", &packed.words)?),
    };
    let clouds = match artifact.point_clouds.is_empty() {
        true => None,
        false => Some(device.upload("point clouds", &clouds.words)?),
    };
    let mut row = 0;
    let mut seconds = 0.0;
    while row < height {
        let count = band.min(height - row) * width;
        if let Some(records) = &mut records {
            records.reset(device)?;
        }
        let mut args = vec![
            Arg::U32(row as u32),
            Arg::U32(count as u32),
            Arg::U32(grid.width),
            Arg::U32(grid.height),
            Arg::U32(grid.flags()),
            Arg::U32(grid.raytype),
            Arg::Buffer(&patch),
            Arg::Buffer(&spaces),
            Arg::Buffer(&outputs),
        ];
        args.extend(records.iter().map(|r| Arg::Buffer(&r.buffer)));
        args.extend(textures.iter().map(Arg::Buffer));
        args.extend(interactive.iter().chain(&clouds).map(Arg::Buffer));
        device.finish()?;
        let start = Instant::now();
        kernel.launch(device, &args, (count as usize).next_multiple_of(GROUP), GROUP)?;
        device.finish()?;
        seconds += start.elapsed().as_secs_f64();
        if let Some(records) = &mut records {
            match records.take(device)? {
                Some(words) => shaded.messages.extend(decoder.messages(&words)?),
                // The band is shaded again, with room for all that it says.
                None => continue,
            }
        }
        let values: Vec<T> = device.read(&outputs, (count * reals) as usize)?;
        for point in values.chunks_exact(reals.max(1) as usize) {
            let mut rest = point;
            for plane in &mut shaded.planes {
                let (mine, others) = rest.split_at(plane.channels as usize);
                plane.data.extend(mine.iter().map(|v| (*v).into()));
                rest = others;
            }
        }
        row += band;
    }
    Ok(seconds)
}
