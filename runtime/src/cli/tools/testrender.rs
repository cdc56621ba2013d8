//! `testrender`: renders an XML scene, with the options of the reference implementation's tool of that name.
//!
//! In: the command line. Out: a picture. The scene format stands in docs/testrender.md.

use super::super::{Error, render, terminal};
use super::options::{self, Item, Spec, Takes, spec};
use oslcl_runtime::choices::{Choices, LightChoice};
use oslcl_runtime::device::Device;
use oslcl_runtime::film::raster::{self, Depth, Raster};
use oslcl_runtime::film::{self, Picture};
use oslcl_runtime::render::Options;
use oslcl_runtime::scene::{self, Film, Filter, Integrator};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const TABLE: &[Spec] = &[
    spec(&["v"], Takes::Nothing, "Say what was done"),
    spec(&["r", "res"], Takes::Values(2), "XRES YRES: the picture's size [default: 640 480]"),
    spec(&["aa"], Takes::Values(1), "N: N x N samples a pixel [default: 1]"),
    spec(&["no-jitter"], Takes::Nothing, "Look through the middles of pixels only"),
    spec(&["path"], Takes::Values(1), "FOLDERS: where shaders lie, with colons between them [default: here]"),
    spec(&["options"], Takes::Values(1), "LIST: `name=value` with commas; searchpath:shader"),
    spec(&["texoptions"], Takes::Values(1), "LIST: `name=value` with commas; searchpath"),
    spec(&["runstats", "stats", "profile"], Takes::Nothing, "Print what took how long"),
    spec(&["device"], Takes::Values(1), "NAME: the OpenCL device, by number or part of its name"),
    spec(&["seed"], Takes::Values(1), "N: of the random numbers [default: 0]"),
    spec(&["help", "h"], Takes::Nothing, "Print this help"),
    spec(&["version"], Takes::Nothing, "Print the version"),
    // Settings of the reference implementation's own machinery: there is nothing here that they could set.
    spec(&["t", "iters", "llvm_opt", "optix_no_inline_thresh", "optix_force_inline_thresh"], Takes::Values(1), ""),
    spec(
        &[
            "O0",
            "O1",
            "O2",
            "debug",
            "debug2",
            "debugnan",
            "warmup",
            "optix_no_inline",
            "optix_no_inline_layer_funcs",
            "optix_no_merge_layer_funcs",
            "optix_no_inline_rend_lib",
            "optix_no_rend_lib_bitcode",
            "saveptx",
        ],
        Takes::Nothing,
        "",
    ),
    // What is asked for and cannot be had.
    spec(&["albedo"], Takes::Values(1), ""),
    spec(&["normals"], Takes::Nothing, ""),
    spec(&["geonormals"], Takes::Nothing, ""),
    spec(&["utangents"], Takes::Nothing, ""),
    spec(&["vtangents"], Takes::Nothing, ""),
    spec(&["uvs"], Takes::Nothing, ""),
    spec(&["optix"], Takes::Nothing, ""),
    spec(&["print-group-stats"], Takes::Nothing, ""),
];

/// What was asked for.
struct Job {
    scene: String,
    picture: PathBuf,
    film: Film,
    samples: u32,
    filter: Filter,
    shaders: Vec<PathBuf>,
    textures: Vec<PathBuf>,
    device: Option<String>,
    seed: u64,
    verbose: bool,
}

/// Runs the tool.
pub fn run(words: &[String]) -> Result<ExitCode, Error> {
    let items = options::read(words, TABLE).map_err(usage)?;
    let has = |name: &str| items.iter().any(|i| i.name == name);
    if has("version") {
        terminal::print(concat!("testrender (oslcl ", env!("CARGO_PKG_VERSION"), ")\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    if has("help") || words.is_empty() {
        let head = "testrender -- render a scene\nUsage:  testrender [options] scene.xml picture\n";
        terminal::print(&format!("{head}{}", options::help(TABLE)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let job = job(&items)?;
    // Better to hear of it now than after the work.
    check_output(&job.picture)?;
    render_job(&job)?;
    Ok(ExitCode::SUCCESS)
}

fn usage(message: String) -> Error {
    Error::Usage(format!("testrender: {message}"))
}

fn job(items: &[Item]) -> Result<Job, Error> {
    const REFUSED: [&str; 8] =
        ["albedo", "normals", "geonormals", "utangents", "vtangents", "uvs", "optix", "print-group-stats"];
    let mut plain = Vec::new();
    let mut job = Job {
        scene: String::new(),
        picture: PathBuf::new(),
        film: Film { width: 640, height: 480 },
        samples: 1,
        filter: Filter::Tent,
        shaders: Vec::new(),
        textures: Vec::new(),
        device: None,
        seed: 0,
        verbose: false,
    };
    let folders = |list: &str| list.split(':').filter(|p| !p.is_empty()).map(PathBuf::from).collect::<Vec<_>>();
    for item in items {
        let whole = |index: usize, least: u64, most: u64| {
            let text = &item.values[index];
            let fits = text.parse::<u64>().ok().filter(|n| (least..=most).contains(n));
            let message =
                || format!("option `-{}` takes whole numbers from {least} to {most}, not `{text}`", item.name);
            fits.ok_or_else(|| usage(message()))
        };
        match item.name {
            "" => plain.push(item.value()),
            "v" | "runstats" => job.verbose = true,
            "r" => {
                let side = |index| whole(index, 1, u64::from(Film::LARGEST)).map(|n| n as u32);
                job.film = Film { width: side(0)?, height: side(1)? };
            }
            "aa" => {
                let n = whole(0, 1, 4096)? as u32;
                job.samples = n * n;
            }
            "no-jitter" => job.filter = Filter::Middle,
            "path" => job.shaders = folders(item.value()),
            "options" => {
                if let Some(list) = setting(item.value(), "searchpath:shader") {
                    job.shaders = folders(&list);
                }
            }
            "texoptions" => {
                if let Some(list) = setting(item.value(), "searchpath") {
                    job.textures = folders(&list);
                }
            }
            "device" => job.device = Some(item.value().to_owned()),
            "seed" => job.seed = whole(0, 0, u64::MAX)?,
            name if REFUSED.contains(&name) => {
                return Err(usage(format!(
                    "option `-{name}` is one of the reference's tool that this one does not have"
                )));
            }
            _ => {}
        }
    }
    match plain[..] {
        [scene, picture] => (job.scene, job.picture) = (scene.to_owned(), PathBuf::from(picture)),
        [] => return Err(usage("no scene was named: testrender [options] scene.xml picture".to_owned())),
        [_] => return Err(usage("no picture was named: testrender [options] scene.xml picture".to_owned())),
        [_, _, third, ..] => return Err(usage(format!("`{third}` is one file too many"))),
    }
    if job.shaders.is_empty() {
        job.shaders.push(PathBuf::new());
    }
    Ok(job)
}

/// A value of a list `name=value` with commas between, in quotes or without.
fn setting(list: &str, name: &str) -> Option<String> {
    let mut pairs = list.split(',').filter_map(|pair| pair.split_once('='));
    pairs.find(|(n, _)| n.trim() == name).map(|(_, value)| value.trim().trim_matches('"').to_owned())
}

fn check_output(path: &Path) -> Result<(), Error> {
    if is_tiff(path) {
        return Ok(());
    }
    Ok(film::check_output(path)?)
}

fn is_tiff(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tif") || e.eq_ignore_ascii_case("tiff"))
}

fn render_job(job: &Job) -> Result<(), Error> {
    let integrator = Integrator {
        samples: job.samples,
        max_depth: Integrator::DEEPEST,
        // The reference's paths may end from the fifth bounce on.
        roulette_from: Some(6),
        seed: job.seed,
    };
    let path = Path::new(&job.scene);
    let loaded = match job.scene.trim_start().starts_with('<') {
        true => scene::xml::parse(&job.scene, Path::new("<scene>"), job.film, integrator)?,
        false => scene::xml::load(path, job.film, integrator)?,
    };
    for warning in &loaded.warnings {
        terminal::say(&format!("{warning}\n"));
    }
    let mut scene = loaded.scene;
    scene.filter = job.filter;
    scene.shaders = job.shaders.clone();
    scene.textures.splice(0..0, job.textures.iter().cloned());
    let device = Device::open(job.device.as_deref())?;
    let choices =
        Choices { lights: LightChoice::Uniform, environment_map: loaded.environment_columns, ..Choices::default() };
    let options = Options { choices, ..Options::default() };
    let rendered = oslcl_runtime::render::render(&scene, &device, &options, &mut |_| {});
    let (picture, summary) = rendered.map_err(|error| render::say(path, error))?;
    write(&job.picture, &picture)?;
    for warning in &summary.warnings {
        terminal::say(warning);
    }
    terminal::say(&render::told(&summary.messages));
    if job.verbose {
        let Film { width, height } = job.film;
        terminal::print(&format!(
            "Rendered {width}x{height} image with {} samples in {:.2} s, after {:.2} s of preparation, on {}\n",
            summary.samples,
            summary.render_time.as_secs_f64(),
            (summary.compile_time + summary.build_time + summary.geometry_time).as_secs_f64(),
            summary.device
        ))?;
    }
    Ok(())
}

/// The format is that of the file's name; half floats where it has any, as the reference's tool writes them.
fn write(path: &Path, picture: &Picture) -> Result<(), Error> {
    let png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if png || !picture.alpha.is_empty() {
        return Ok(film::write(path, picture, 0.0)?);
    }
    let data = picture.pixels.iter().flatten().copied().collect();
    let raster = Raster { width: picture.width, height: picture.height, channels: 3, data };
    Ok(raster::write(path, &raster, Depth::Half)?)
}
