//! `oslcl bench startup`: how long scenes take to their first ray: cold, warm, after an edit.
//!
//! Drivers remember programs within a process, so that every start is measured in a process of its own, which is this program
//! again with `--start`: it prints one line that [`Start`] reads. Our cache and those of PoCL's and NVIDIA's drivers lie in folders
//! of their own meanwhile.

use super::super::args::{StartArg, StartupArgs};
use super::super::{Error, cache, render, terminal};
use super::page::Page;
use oslcl_runtime::files;
use oslcl_runtime::render::Options;
use oslcl_runtime::scene::{ParamValue, Scene};
use oslcl_runtime::session::Session;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How a scene is started, and how the table calls it.
const ROWS: [(&str, StartArg, Caches); 6] = [
    ("cold", StartArg::Plain, Caches::Empty),
    ("warm", StartArg::Plain, Caches::Kept),
    ("warm, our cache alone", StartArg::Plain, Caches::OursAlone),
    ("warm, the driver's cache alone", StartArg::Plain, Caches::DriversAlone),
    ("one parameter changed", StartArg::Parameter, Caches::Kept),
    ("one material edited", StartArg::Edited, Caches::Kept),
];

/// What is left of earlier starts.
#[derive(Clone, Copy, PartialEq)]
enum Caches {
    Empty,
    Kept,
    OursAlone,
    DriversAlone,
}

/// Seconds of one start, and its programs.
#[derive(Clone, Serialize, Deserialize)]
struct Start {
    device: String,
    context: f64,
    load: f64,
    materials: f64,
    programs: f64,
    geometry: f64,
    built: u32,
    loaded: u32,
    shared: u32,
    /// In a session that stays: up to the first ray of the next render.
    slider: f64,
}

impl Start {
    /// From the start of the program to the first ray.
    fn total(&self) -> f64 {
        self.context + self.beyond()
    }

    /// The same without the driver's context.
    fn beyond(&self) -> f64 {
        self.load + self.materials + self.programs + self.geometry
    }
}

/// Measures, prints the table, writes Markdown.
pub fn run(args: &StartupArgs) -> Result<(), Error> {
    if let (Some(start), [scene]) = (args.start, args.scenes.as_slice()) {
        return one(args, scene, start);
    }
    let folder = Scratch::new()?;
    let page = Page {
        title: "Start-up",
        intro: "Written by `oslcl bench startup`, a section for each device. Seconds from the start of the program to the first ray, each \
                in a process of its own; *beyond* is without the driver's own context. A cold start has neither our cache nor the \
                driver's; a parameter is changed in the scene, a material is edited in its source, and then everything else comes from \
                the caches. *Slider*: the way to the first ray of the next render in a session that stays, which is all that an \
                interactive parameter costs."
            .to_owned(),
    };
    let (mut section, mut device) = (String::new(), String::new());
    for scene in &args.scenes {
        let mut table = String::from(
            "| start | total | beyond | context | scene | materials | programs | geometry | built | loaded | equal |\n\
             |---|---|---|---|---|---|---|---|---|---|---|\n",
        );
        let (mut about, mut left_out) = (String::new(), String::new());
        let read = render::load(scene)?;
        for (i, (name, start, caches)) in ROWS.iter().enumerate() {
            terminal::progress(&format!("{}: {name}", scene.display()));
            if let Err(why) = prepare(&mut read.clone(), *start) {
                let _ = writeln!(left_out, "\nNo row *{name}*: {why}.");
                continue;
            }
            let mut best: Option<Start> = None;
            // A cold start, or one after an edit, can be had once.
            let tries = if *start == StartArg::Plain && *caches != Caches::Empty { args.repeat } else { 1 };
            for _ in 0..tries {
                let found = spawn(args, scene, *start, *caches, &folder.0.join("caches"), i)?;
                if best.as_ref().is_none_or(|b| found.total() < b.total()) {
                    best = Some(found);
                }
            }
            let Some(s) = best else { continue };
            device.clone_from(&s.device);
            let _ = writeln!(
                table,
                "| {name} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {} | {} | {} |",
                s.total(),
                s.beyond(),
                s.context,
                s.load,
                s.materials,
                s.programs,
                s.geometry,
                s.built,
                s.loaded,
                s.shared
            );
            if *name == "warm" {
                let _ = write!(about, "slider {:.3} s; ", s.slider);
            }
        }
        terminal::progress("");
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        let text = format!("\n### {}\n\n{about}{cores} host threads.\n\n{table}{left_out}", scene.display());
        terminal::print(&format!("\n{device}\n{text}"))?;
        section.push_str(&text);
        std::fs::remove_dir_all(folder.0.join("caches")).map_err(|cause| failed(&folder.0, cause))?;
    }
    match &args.output {
        Some(path) => page.write(path, &device, &section),
        None => Ok(()),
    }
}

/// Starts a scene in this process, and says how long it took.
fn one(args: &StartupArgs, path: &Path, start: StartArg) -> Result<(), Error> {
    let timer = Instant::now();
    let mut scene = render::load(path)?;
    prepare(&mut scene, start).map_err(|why| Error::Usage(format!("{}: {why}", path.display())))?;
    scene.integrator.samples = 1;
    let load = timer.elapsed();
    let timer = Instant::now();
    let device = cache::device(args.device.as_deref(), &args.cache)?;
    let context = timer.elapsed();
    let made = Session::new(&scene, &device, &Options::default());
    let rendered = made.and_then(|mut session| {
        let (_, first) = session.render(&mut |_| {})?;
        let timer = Instant::now();
        let (_, again) = session.render(&mut |_| {})?;
        Ok((first, timer.elapsed().saturating_sub(again.render_time)))
    });
    let (summary, slider) = rendered.map_err(|e| render::say(path, e))?;
    let seconds = |d: Duration| d.as_secs_f64();
    let out = Start {
        device: summary.device,
        context: seconds(context),
        load: seconds(load),
        materials: seconds(summary.compile_time),
        programs: seconds(summary.build_time),
        geometry: seconds(summary.geometry_time),
        built: summary.programs.built,
        loaded: summary.programs.loaded,
        shared: summary.programs.shared,
        slider: seconds(slider),
    };
    let text = serde_json::to_string(&out).map_err(|e| Error::Usage(e.to_string()))?;
    terminal::print(&format!("{text}\n"))
}

/// Changes a scene as a start wants it; what it lacks for that.
fn prepare(scene: &mut Scene, start: StartArg) -> Result<(), &'static str> {
    match start {
        StartArg::Plain => Ok(()),
        StartArg::Parameter if change_parameter(scene) => Ok(()),
        StartArg::Parameter => Err("the scene sets no parameter of a material to a float, which could be changed"),
        StartArg::Edited if edit(scene) => Ok(()),
        StartArg::Edited => Err("the scene has no material with a source of its own, which could be edited"),
    }
}

/// Changes the first number that the scene gives to a material, if any.
fn change_parameter(scene: &mut Scene) -> bool {
    let params = scene.materials.iter_mut().flat_map(|m| &mut m.params);
    for (_, value) in params {
        match value {
            ParamValue::Float(x) => *x *= 0.875,
            ParamValue::Floats(all) if !all.is_empty() => all[0] = 0.875 * all[0] + 0.001,
            _ => continue,
        }
        return true;
    }
    false
}

/// Adds a statement to the first material's shader that changes what it computes, if there is one.
fn edit(scene: &mut Scene) -> bool {
    let material = scene.materials.iter_mut().find(|m| !m.group && m.source.contains('}'));
    if let Some(material) = material
        && let Some(end) = material.source.rfind('}')
    {
        material.source.insert_str(end, "Ci = 0.875 * Ci;\n");
        return true;
    }
    false
}

fn spawn(
    args: &StartupArgs,
    scene: &Path,
    start: StartArg,
    caches: Caches,
    folder: &Path,
    number: usize,
) -> Result<Start, Error> {
    let refuse = |cause: String| Error::Usage(format!("{}: the start does not succeed: {cause}", scene.display()));
    let program = std::env::current_exe().map_err(|e| refuse(e.to_string()))?;
    let fresh = folder.join(format!("empty{number}"));
    let ours = if caches == Caches::DriversAlone { fresh.join("ours") } else { folder.join("ours") };
    let drivers = if caches == Caches::OursAlone { fresh.join("driver") } else { folder.join("driver") };
    // With a row that is repeated only the first try would find an empty one.
    let _ = std::fs::remove_dir_all(&fresh);
    for place in [&ours, &drivers] {
        std::fs::create_dir_all(place).map_err(|cause| failed(place, cause))?;
    }
    let mut command = Command::new(program);
    command.args(["bench", "startup"]).arg(scene).arg("--cache-dir").arg(&ours);
    command.args(["--start", start.name()]);
    if let Some(device) = &args.device {
        command.args(["--device", device]);
    }
    command.env("POCL_CACHE_DIR", &drivers).env_remove("POCL_KERNEL_CACHE");
    command.env("CUDA_CACHE_PATH", &drivers).env_remove("CUDA_CACHE_DISABLE");
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output().map_err(|e| refuse(e.to_string()))?;
    if !output.status.success() {
        return Err(refuse(output.status.to_string()));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(text.trim()).map_err(|e| refuse(format!("it says {text:?}: {e}")))
}

fn failed(path: &Path, cause: std::io::Error) -> Error {
    files::Error { path: path.to_owned(), cause: cause.into() }.into()
}

/// A folder that goes with its owner.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Scratch, Error> {
        let path = std::env::temp_dir().join(format!("oslcl-startup-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|cause| failed(&path, cause))?;
        Ok(Scratch(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What can't be removed stays: temporary folders are swept.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_scene_lacks_for_a_row_is_said() {
        let scene = |params: &str| {
            let text = format!(
                "[camera]\norigin = [0, -4, 0]\ntarget = [0, 0, 0]\n[materials.m]\nosl = \"surface m(float k = 1) {{ Ci = \
                 k * emission(); }}\"\n{params}[[meshes]]\nname = \"q\"\nshape = \"quad\"\nsize = 1\nmaterial = \"m\"\n"
            );
            oslcl_runtime::scene::parse(&text, Path::new("s.toml")).expect("a scene")
        };
        let with = scene("params = { k = 0.5 }\n");
        let mut changed = with.clone();
        assert_eq!(prepare(&mut changed, StartArg::Parameter), Ok(()));
        assert_ne!(changed.materials[0].params, with.materials[0].params);
        let why = prepare(&mut scene(""), StartArg::Parameter).expect_err("nothing to change");
        assert!(why.starts_with("the scene sets no parameter"), "{why}");
        assert_eq!(prepare(&mut scene(""), StartArg::Edited), Ok(()));
        let mut empty = scene("");
        empty.materials[0].source.clear();
        assert!(prepare(&mut empty, StartArg::Edited).is_err());
    }
}
