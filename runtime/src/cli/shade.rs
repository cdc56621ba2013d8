//! `oslcl shade`: runs a shader over a grid of points; prints its outputs or writes them to pictures.

use super::args::{PrecisionArg, RoadArg, ShadeArgs};
use super::sources::{self, Folders};
use super::{Error, cache, package, params, report, shade_compare, terminal};
use oslcl_compiler::Options;
use oslcl_runtime::files;
use oslcl_runtime::film::raster::{self, Depth, Raster};
use oslcl_runtime::package::Shader;
use oslcl_runtime::points;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::roads::Road;
use oslcl_runtime::shade::{self, Grid, HostError, Kind, Message, Plane, Shaded, Supplies};
use oslcl_runtime::textures::{self, Library};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl From<RoadArg> for Road {
    fn from(arg: RoadArg) -> Road {
        match arg {
            RoadArg::Opencl => Road::OpenClC,
            RoadArg::Spirv => Road::Spirv,
        }
    }
}

impl From<PrecisionArg> for Precision {
    fn from(arg: PrecisionArg) -> Precision {
        match arg {
            PrecisionArg::Fast => Precision::Fast,
            PrecisionArg::Standard => Precision::Standard,
            PrecisionArg::Reference => Precision::Reference,
        }
    }
}

/// Compiles, runs, prints or writes.
pub fn run(args: &ShadeArgs) -> Result<(), Error> {
    let wanted: Vec<(String, PathBuf)> = args.output.iter().map(|text| output(text)).collect::<Result<_, _>>()?;
    if let Some((file, name)) = package::named(&args.shader) {
        return of_package(args, wanted, &package::shader(&file, name.as_deref())?);
    }
    let source = sources::read_or_shipped(&args.shader)?;
    let options = sources::options(&source, &args.source)?;
    let options = Options { spaces: oslcl_runtime::grid::SPACES.map(str::to_owned).into(), ..options };
    let master = report::master(&source.text, &options, &Folders::new(&args.source))?;
    let search = args.textures.clone();
    let library = Arc::new(Library::new(textures::Settings { search, ..textures::Settings::default() }));
    let bindings = params::bindings(&args.param, master.info())?;
    let spirv = Road::from(args.road) == Road::Spirv;
    let options = Options { bindings, textures: Some(library.access()), spirv, ..options };
    let mut outputs: Vec<String> = Vec::new();
    for (name, _) in &wanted {
        if !outputs.contains(name) {
            outputs.push(name.clone());
        }
    }
    if outputs.is_empty() {
        outputs = shade::default_outputs(master.info());
    }
    let grid = grid(args)?;
    let options = Options { attributes: grid.attributes(), documents: Some(sources::documents()), ..options };
    let artifact = match shade::compile(&master, &options, &outputs) {
        Ok(artifact) => artifact,
        Err(failure) => {
            // What no device can do is done here, if it can be done at all.
            let on_host = shade::needs_host(&failure).then(|| shade::run_on_host(&master, &options, &outputs, grid));
            let Some(Ok(shaded)) = on_host.filter(|_| args.compare.is_none()) else {
                return Err(report::report(&failure));
            };
            return deliver(&shaded, wanted, Precision::Reference);
        }
    };
    let device = cache::device(args.device.as_deref(), &args.cache)?;
    if let Some(with) = args.compare {
        let host = || shade::run_on_host(&master, &options, &outputs, grid).map_err(host_error);
        return shade_compare::run(&device, &artifact, grid, &library, &Supplies::default(), with, host);
    }
    let precision = args.precision.into();
    let shaded = shade::run_with(&device, &artifact, grid, precision, &library)?;
    cache::complain(&device);
    deliver(&shaded, wanted, precision)
}

/// Runs a shader that came compiled.
fn of_package(args: &ShadeArgs, wanted: Vec<(String, PathBuf)>, shader: &Shader) -> Result<(), Error> {
    let grid = grid(args)?;
    let search = args.textures.clone();
    let library = Library::new(textures::Settings { search, ..textures::Settings::default() });
    let values = params::bindings(&args.param, shader.info())?;
    let (artifact, supplies) = shader.at_points(&values, &grid, args.road.into(), &library)?;
    if let Some((name, _)) = wanted.iter().find(|(name, _)| artifact.outputs.iter().all(|o| o.name != *name)) {
        let known: Vec<&str> = artifact.outputs.iter().map(|o| o.name.as_str()).collect();
        return Err(Error::Usage(format!(
            "shader `{}` of the package does not store `{name}`\n  help: it stores {}",
            shader.name,
            known.join(", ")
        )));
    }
    let device = cache::device(args.device.as_deref(), &args.cache)?;
    if let Some(with) = args.compare {
        let host = || {
            Err(Error::Usage("--compare host runs a source, which a package does not have: --compare f64".to_owned()))
        };
        return shade_compare::run(&device, &artifact, grid, &library, &supplies, with, host);
    }
    let precision = args.precision.into();
    let shaded = shade::run_supplied(&device, &artifact, grid, precision, &library, &supplies)?;
    cache::complain(&device);
    deliver(&shaded, wanted, precision)
}

/// The points asked for.
fn grid(args: &ShadeArgs) -> Result<Grid, Error> {
    let (width, height) = match (args.grid.as_slice(), args.compare) {
        (&[width, height], _) => (width, height),
        (_, None) => (1, 1),
        // u and v are the same numbers in 32 and in 64 bits.
        (_, Some(_)) => (257, 257),
    };
    // clap gives exactly four numbers.
    let &[u0, u1, v0, v1] = args.domain.as_slice() else {
        return Err(Error::Usage("--domain takes four numbers".to_owned()));
    };
    if !args.domain.iter().all(|x| x.is_finite()) {
        return Err(Error::Usage("--domain takes finite numbers".to_owned()));
    }
    Ok(Grid { scale_uv: [u1 - u0, v1 - v0], offset_uv: [u0, v0], ..Grid::new(width, height) })
}

pub(super) fn host_error(error: HostError) -> Error {
    match error {
        HostError::Compile(failure) => report::report(&failure),
        HostError::Grid(error) => error.into(),
    }
}

/// Prints what was said; prints the outputs, or writes those wanted to pictures.
fn deliver(shaded: &Shaded, wanted: Vec<(String, PathBuf)>, precision: Precision) -> Result<(), Error> {
    for warning in &shaded.warnings {
        terminal::say(&format!("warning: {warning}\n"));
    }
    terminal::print_with(|out| say(out, &shaded.messages))?;
    points::write(&shaded.messages)?;
    let planes = &shaded.planes;
    if wanted.is_empty() {
        return terminal::print_with(|out| print(out, planes, precision));
    }
    let mut pictures = Vec::new();
    for (name, path) in wanted {
        let Some(plane) = planes.iter().find(|p| p.name == name) else { continue };
        let raster = Raster {
            width: plane.grid.width as usize,
            height: plane.grid.height as usize,
            channels: plane.channels as usize,
            data: plane.data.iter().map(|v| *v as f32).collect(),
        };
        pictures.push(raster::encode(&path, &raster, Depth::Float)?);
    }
    Ok(files::replace(&pictures)?)
}

/// `PARAM=FILE`.
fn output(text: &str) -> Result<(String, PathBuf), Error> {
    let wrong = |why: &str| Error::Usage(format!("`--output {text}`: {why}"));
    let (name, file) = match text.split_once('=') {
        Some((name, file)) if !name.is_empty() && !file.is_empty() => (name, file),
        _ => return Err(wrong("expected PARAM=FILE, such as --output Cout=out.exr")),
    };
    if !Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return Err(wrong("the file's name has to end in .exr"));
    }
    Ok((name.to_owned(), PathBuf::from(file)))
}

/// What the shader said, as OSL's testshade shows it; `fprintf` with the file's name in front.
fn say(out: &mut dyn Write, messages: &[Message]) -> io::Result<()> {
    for message in messages {
        match &message.kind {
            Kind::Print => write!(out, "{}", message.text)?,
            Kind::Error => writeln!(out, "ERROR: {}", message.text)?,
            Kind::Warning => writeln!(out, "WARNING: {}", message.text)?,
            Kind::File(name) => write!(out, "{name}:{}", message.text)?,
            Kind::Cloud(_) => {}
        }
    }
    Ok(())
}

/// One line per output; on grids of several points one line per point and output, column and row first.
fn print(out: &mut dyn Write, planes: &[Plane], precision: Precision) -> io::Result<()> {
    let Some(first) = planes.first() else { return Ok(()) };
    let many = first.grid.width > 1 || first.grid.height > 1;
    for y in 0..first.grid.height {
        for x in 0..first.grid.width {
            for plane in planes {
                if many {
                    write!(out, "{x} {y} ")?;
                }
                write!(out, "{}", plane.name)?;
                for v in plane.point(x, y) {
                    if precision.is_double() || plane.ty.starts_with("int") {
                        write!(out, " {v}")?;
                    } else {
                        write!(out, " {}", *v as f32)?;
                    }
                }
                writeln!(out)?;
            }
        }
    }
    Ok(())
}
