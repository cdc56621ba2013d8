//! `testshade`: runs a shader or a group of shaders over a grid of points, as the reference implementation's tool of that name.
//!
//! In: the command line. Out: what the shaders print, the values of outputs as text or as pictures. It prints what the
//! reference's tool prints, in its order, so that scripts that read one can read the other.

mod args;
mod build;
mod said;
mod supplies;

use super::super::shade::host_error;
use super::super::{Error, report, sources, terminal};
use args::Args;
use build::{Built, Shaders};
use oslcl_compiler::attributes::RAY_TYPES;
use oslcl_compiler::{Artifact, Group, Options};
use oslcl_runtime::device::Device;
use oslcl_runtime::film::raster::{self, Depth, Raster};
use oslcl_runtime::precision::Precision;
use oslcl_runtime::shade::{self, Grid, Plane, Shaded, Supplies};
use oslcl_runtime::textures::{self, Library};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

/// Runs the tool.
pub fn run(words: &[String]) -> Result<ExitCode, Error> {
    let args = args::parse(words).map_err(|e| Error::Usage(format!("testshade: {e}")))?;
    if args.version {
        terminal::print(concat!("testshade (oslcl ", env!("CARGO_PKG_VERSION"), ")\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    if args.help || words.is_empty() {
        terminal::print(&args::help())?;
        return Ok(ExitCode::SUCCESS);
    }
    let built = build::build(&args, &Shaders::new(&args))?;
    let group = &built.group;
    for step in &args.setup {
        if let args::Setup::Connect([from_layer, from, to_layer, to]) = step {
            terminal::print(&format!("Connect {from_layer}.{from} to {to_layer}.{to}\n"))?;
        }
    }
    if !args.entries.is_empty() {
        let index = |name: &String| group.layers.iter().position(|l| l.name == *name).map_or(-1, |i| i as i64);
        let list: Vec<String> = args.entries.iter().map(|name| format!(" {name}({})", index(name))).collect();
        terminal::print(&format!("Entry layers:{}\n", list.concat()))?;
    }
    if args.verbose || args.query {
        terminal::print(&describe(&args, group))?;
    }
    if !args.outputs.is_empty() {
        terminal::print("\n")?;
    }
    let outputs = outputs(&args, group)?;
    shade(&args, &built, &outputs)?;
    if args.outputs.is_empty() || matches!(args.outputs.as_slice(), [(_, file)] if file == "null") {
        terminal::print("\n")?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The group as text, and its layers; with `--oslquery` their parameters too.
fn describe(args: &Args, group: &Group) -> String {
    let mut out = format!("Shader group:\n---\n{}\n---\n\n", group.text());
    // The reference's tool makes an empty group before it reads a whole one.
    let number = if args.setup.iter().any(|s| matches!(s, args::Setup::Group(_))) { 2 } else { 1 };
    let name = args.group_name.clone().unwrap_or_else(|| format!("unnamed_group_{number}"));
    let _ = writeln!(out, "Shader group \"{name}\" layers are:");
    for layer in &group.layers {
        let _ = writeln!(out, "    {}", layer.name);
        if args.query {
            for param in &layer.master.info().params {
                let output = if param.output { "output " } else { "" };
                let _ = writeln!(out, "\t{output}{} {}", param.ty, param.name);
            }
        }
    }
    out.push('\n');
    out
}

/// The outputs that some layer has, of those asked for: the name and the file. Others are passed over without a word, as in
/// the reference's tool.
fn outputs(args: &Args, group: &Group) -> Result<Vec<(String, String)>, Error> {
    let mut found = Vec::new();
    let cout = [("Cout".to_owned(), "null".to_owned())];
    let asked = if args.outputs.is_empty() { &cout[..] } else { &args.outputs };
    for (name, file) in asked {
        let (layer, param) = name.split_once('.').unwrap_or(("", name));
        let has = |l: &&oslcl_compiler::Layer| {
            (layer.is_empty() || l.name == layer)
                && l.master.info().params.iter().any(|p| p.output && p.name == param && !p.ty.starts_with("string"))
        };
        if group.layers.iter().rev().any(|l| has(&l)) {
            if file != "null" {
                terminal::print(&format!("Output {name} to {file}\n"))?;
            }
            found.push((name.clone(), file.clone()));
        }
    }
    Ok(found)
}

/// Compiles and runs the group, prints and writes.
fn shade(args: &Args, built: &Built, outputs: &[(String, String)]) -> Result<(), Error> {
    let names: Vec<String> = outputs.iter().map(|(name, _)| name.clone()).collect();
    let library = Arc::new(Library::new(textures(args)));
    let entry = oslcl_compiler::Entry::Grid(names);
    let mut supplies = supplies::of(args);
    let grid = grid(args);
    let options = Options {
        entry,
        textures: Some(library.access()),
        attributes: supplies::attributes(args, grid.attributes()),
        documents: Some(sources::documents()),
        userdata: Some(supplies.declared()),
        interactive: true,
        userdata_is_connected: args.userdata_isconnected,
        lazy: supplies::lazy(args),
        ray_types: args.raytype_known.then(|| raytype(args)),
        ..Options::default()
    };
    let mut times = Times { start: Instant::now(), list: Vec::new() };
    if args.host {
        let asked: Vec<String> = outputs.iter().map(|(name, _)| name.clone()).collect();
        let shaded = shade::run_group_on_host(&built.group, &options, &asked, grid).map_err(host_error)?;
        times.add("Run on the host");
        deliver(args, shaded, outputs)?;
        return times.show(args);
    }
    let output = match built.group.instance(&options) {
        Ok(output) => output,
        Err(failure) => {
            // What no device can do is done here, if it can be done at all.
            let asked: Vec<String> = outputs.iter().map(|(name, _)| name.clone()).collect();
            let run = || shade::run_group_on_host(&built.group, &options, &asked, grid);
            let Some(Ok(shaded)) = shade::needs_host(&failure).then(run) else { return Err(report::report(&failure)) };
            times.add("Run on the host");
            deliver(args, shaded, outputs)?;
            return times.show(args);
        }
    };
    times.add("Compile");
    if args.verbose {
        report::show(&output.sources, &output.warnings);
    }
    if args.debug {
        let artifact = &output.artifact;
        let mut globals = artifact.globals.clone();
        globals.extend(artifact.state.backfacing.then_some("backfacing"));
        globals.extend(artifact.state.flip_handedness.then_some("flipHandedness"));
        terminal::print(&format!("Need {} globals:  {}\n", globals.len(), globals.join(" ")))?;
    }
    if outputs.is_empty() && output.artifact.sites.is_empty() {
        return Ok(());
    }
    let device = Device::open(args.device.as_deref())?;
    times.add("Open the device");
    for iteration in 0..args.iterations {
        if iteration == 1 {
            supplies.interactive.extend(supplies::later(built));
        }
        once(args, &output.artifact, outputs, &device, &library, &supplies)?;
        times.add("Build, run, deliver");
    }
    times.show(args)
}

/// What took how long, for `--runstats`.
struct Times {
    start: Instant,
    list: Vec<(&'static str, f64)>,
}

impl Times {
    /// What was done since the last call; the same again is added to it.
    fn add(&mut self, what: &'static str) {
        let seconds = self.start.elapsed().as_secs_f64();
        self.start = Instant::now();
        match self.list.last_mut().filter(|(last, _)| *last == what) {
            Some((_, sum)) => *sum += seconds,
            None => self.list.push((what, seconds)),
        }
    }

    fn show(&self, args: &Args) -> Result<(), Error> {
        if !args.statistics {
            return Ok(());
        }
        let lines: Vec<String> = self.list.iter().map(|(what, s)| format!("{what:<20} {s:.3} s\n")).collect();
        terminal::print(&format!("\n{}", lines.concat()))
    }
}

/// Runs a compiled group, prints and writes.
fn once(
    args: &Args,
    artifact: &Artifact,
    outputs: &[(String, String)],
    device: &Device,
    library: &Library,
    supplies: &Supplies,
) -> Result<(), Error> {
    let shaded = shade::run_supplied(device, artifact, grid(args), Precision::Standard, library, supplies)?;
    deliver(args, shaded, outputs)
}

/// Prints what was said and the values, or writes pictures.
fn deliver(args: &Args, shaded: Shaded, outputs: &[(String, String)]) -> Result<(), Error> {
    for warning in &shaded.warnings {
        terminal::say(&format!("WARNING: {warning}\n"));
    }
    let planes = shaded.planes;
    if args.print {
        terminal::print(&values(&planes))?;
    }
    said::say(args, &shaded.messages)?;
    if args.print {
        return Ok(());
    }
    for (plane, (_, file)) in planes.iter().zip(outputs).filter(|(_, (_, file))| file != "null") {
        let whole = plane.ty.starts_with("int");
        let depth = args.depth.unwrap_or(if whole { Depth::Int } else { Depth::Float });
        raster::write(Path::new(file), &picture(plane, whole), depth)?;
    }
    Ok(())
}

/// The rays' type, as a bit. As in the reference's tool, an unknown type is none.
fn raytype(args: &Args) -> u32 {
    RAY_TYPES.iter().find(|(name, _)| *name == args.raytype).map_or(0, |(_, bit)| *bit)
}

/// Where textures are and how they are read: `searchpath:texture` of `--options`, `searchpath` and `automip` of `--texoptions`.
fn textures(args: &Args) -> textures::Settings {
    let folders = args.option("searchpath:texture").or_else(|| args.option("searchpath")).unwrap_or("");
    let search = folders.split([':', ';', ',']).filter(|f| !f.is_empty()).map(PathBuf::from).collect();
    textures::Settings { search, automip: args.option("automip") != Some("0") }
}

/// The points.
fn grid(args: &Args) -> Grid {
    let [width, height] = args.grid;
    let [vary_pdxdy, vary_udxdy, vary_vdxdy] = args.vary;
    Grid {
        center: args.center,
        vary_pdxdy,
        vary_udxdy,
        vary_vdxdy,
        scale_uv: args.scale.map(|x| x as f32),
        offset_uv: args.offset.map(|x| x as f32),
        raytype: raytype(args),
        ..Grid::new(width, height)
    }
}

/// The values of all outputs, point by point.
fn values(planes: &[Plane]) -> String {
    let mut out = String::new();
    let Some(grid) = planes.first().map(|p| p.grid) else { return out };
    for y in 0..grid.height {
        for x in 0..grid.width {
            let _ = writeln!(out, "Pixel ({x}, {y}):");
            for plane in planes {
                let name = plane.name.split('.').next_back().unwrap_or(&plane.name);
                let _ = write!(out, "  {name} :");
                for value in plane.point(x, y) {
                    let _ = write!(out, " {value}");
                }
                out.push('\n');
            }
        }
    }
    out
}

/// An output as a picture; integers (`whole`) as parts of the largest one, whatever they are stored as, as by the reference's tool.
fn picture(plane: &Plane, whole: bool) -> Raster {
    let largest = if whole { f64::from(i32::MAX) } else { 1.0 };
    Raster {
        width: plane.grid.width as usize,
        height: plane.grid.height as usize,
        channels: plane.channels as usize,
        data: plane.data.iter().map(|v| (*v / largest) as f32).collect(),
    }
}
