//! `oslcl render`: a scene to a picture, with a progress bar and a summary.

use super::args::RenderArgs;
use super::{Error, cache, choices, report, terminal};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use oslcl_runtime::adaptive::Outcome;
use oslcl_runtime::choices::PathState;
use oslcl_runtime::film;
use oslcl_runtime::materials;
use oslcl_runtime::programs::{self, Tally};
use oslcl_runtime::render::{self, Options, Progress, Summary};
use oslcl_runtime::roads;
use oslcl_runtime::scene::{self, Film, Scene};
use oslcl_runtime::shade::Kind;
use oslcl_runtime::target::{self, Reached};
use oslcl_runtime::told::Messages;
use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

/// Most texts of materials that are shown.
const MAX_TOLD: usize = 100;

/// Steps of the progress bar.
const STEPS: u64 = 1000;

/// Loads, renders, writes.
pub fn run(args: &RenderArgs) -> Result<(), Error> {
    // Better to hear of it now than after the work.
    film::check_output(&args.output)?;
    let choices = choices::of(&args.choices)?;
    if args.target_error.is_some() && choices.adaptive.is_some() {
        return Err(Error::Usage(
            "`--target-error` takes as many samples of all pixels, `--set adaptive` different ones: choose one; \
             adaptive=ERROR with a large --spp stops as well"
                .to_owned(),
        ));
    }
    let mut scene = load(&args.scene)?;
    choices.apply(&mut scene.integrator);
    override_by(&mut scene, args);
    let device = cache::device(args.device.as_deref(), &args.cache)?;
    let time_limit = args.time.map(Duration::from_secs_f64);
    let options = Options { choices, road: args.road.into(), time_limit };
    let bar = progress_bar(args.quiet);
    let result = match args.target_error {
        None => {
            let rendered = render::render(&scene, &device, &options, &mut |p| show(&bar, p));
            rendered.map(|(picture, summary)| (picture, summary, None))
        }
        Some(error) => {
            let rendered = target::render(&scene, &device, &options, error, &mut |done, error, next| {
                bar.set_message(if done == 0 {
                    format!("first {next} samples per pixel")
                } else {
                    format!("error {error:.4} at {done} samples per pixel, now to {next}")
                });
            });
            rendered.map(|(picture, summary, reached)| (picture, summary, Some(reached)))
        }
    };
    bar.finish_and_clear();
    let (picture, summary, reached) = result.map_err(|error| say(&args.scene, error))?;
    scene.integrator.samples = reached.map_or(scene.integrator.samples, |r| r.samples);
    film::write(&args.output, &picture, args.exposure as f32)?;
    if !args.quiet {
        for warning in &summary.warnings {
            terminal::say(warning);
        }
        cache::complain(&device);
        terminal::say(&told(&summary.messages));
        terminal::say(&describe(args, &scene, &summary));
        if let (Some(reached), Some(wanted)) = (reached, args.target_error) {
            terminal::say(&picked(&reached, wanted));
        }
    }
    Ok(())
}

/// What a target error came to.
fn picked(r: &Reached, wanted: f64) -> String {
    let (first, samples) = r.pilot;
    let missed = if r.error > wanted { ", which no number of samples that can be taken reaches" } else { "" };
    format!(
        "error      {:.5} for {wanted}{missed}: {} samples per pixel were picked, after an error of {first:.5} at {samples}\n",
        r.error, r.samples
    )
}

/// What ending pixels early came to.
fn adapted(a: &Outcome) -> String {
    let (tiles, reached) = a.tiles;
    let (least, most, mean) = a.samples;
    format!(
        "adaptive   {:.1} % of the samples saved: {least} to {most} a pixel, {mean:.1} in the mean; {reached} of {tiles} tiles have \
         an error below {}\n",
        100.0 * a.saved,
        a.threshold
    )
}

/// Reads a scene.
pub fn load(path: &Path) -> Result<Scene, Error> {
    Ok(scene::load(path)?)
}

/// A material's diagnostics are shown as the compiler's always are. What is wrong with a device is no matter of the scene's.
pub fn say(scene: &Path, error: render::Error) -> Error {
    match error {
        render::Error::Material(materials::Error::Compile { material, failure }) => {
            terminal::say(&format!("{}: in material `{material}`:\n", scene.display()));
            report::report(&failure)
        }
        // It has its place in the scene's file.
        render::Error::Material(cause @ materials::Error::Package { .. }) => Error::Material(cause),
        render::Error::Device(cause)
        | render::Error::Program(programs::Error::Device(cause) | programs::Error::Road(roads::Error::Device(cause))) => {
            Error::Device(cause)
        }
        render::Error::Program(programs::Error::Road(cause)) => Error::Road(cause),
        cause => Error::Render { scene: scene.to_owned(), cause: Box::new(cause) },
    }
}

fn override_by(scene: &mut Scene, args: &RenderArgs) {
    if let Some((width, height)) = args.size {
        scene.film = Film { width, height };
    }
    let integrator = &mut scene.integrator;
    integrator.samples = args.spp.unwrap_or(integrator.samples);
    integrator.max_depth = args.depth.unwrap_or(integrator.max_depth);
    integrator.seed = args.seed.unwrap_or(integrator.seed);
}

fn progress_bar(quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    // A template that is wrong would show in the first render of whoever changed it.
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {msg}  {eta} left") {
        bar.set_style(style);
    }
    // The first picture of a scene may wait for its programs a good while.
    bar.set_message("preparing");
    bar.tick();
    bar
}

fn show(bar: &ProgressBar, p: &Progress) {
    if bar.is_hidden() {
        return;
    }
    match p {
        Progress::Building(step) => {
            bar.set_position(u64::from(step.done) * STEPS / u64::from(step.total.max(1)));
            bar.set_message(format!("{} of {} programs", step.done, step.total));
            // Between two of them nothing else would draw it.
            bar.tick();
        }
        Progress::Rendering { counts, total, elapsed } => {
            bar.set_position(counts.samples * STEPS / total.max(&1));
            bar.set_message(format!(
                "{:.1} of {:.1} Msamples, {:.2} Mrays/s",
                counts.samples as f64 / 1e6,
                *total as f64 / 1e6,
                rays_per_second(counts, *elapsed) / 1e6
            ));
        }
    }
}

fn rays_per_second(counts: &oslcl_runtime::wavefront::Counts, time: Duration) -> f64 {
    (counts.rays + counts.shadow_rays) as f64 / time.as_secs_f64().max(1e-9)
}

/// What the materials printed: each text once.
pub fn told(messages: &Messages) -> String {
    let mut out = String::new();
    for told in messages.told.iter().take(MAX_TOLD) {
        let kind = match &told.kind {
            Kind::Print => String::new(),
            Kind::Error => "ERROR: ".to_owned(),
            Kind::Warning => "WARNING: ".to_owned(),
            Kind::File(name) | Kind::Cloud(name) => format!("{name}: "),
        };
        let times = if told.count == 1 { String::new() } else { format!(" ({} times)", told.count) };
        let _ = writeln!(out, "material `{}`: {kind}{}{times}", told.material, told.text.trim_end());
    }
    if messages.told.len() > MAX_TOLD {
        let _ = writeln!(out, "and {} other texts", messages.told.len() - MAX_TOLD);
    }
    if messages.lost_bytes > 0 {
        let _ = writeln!(out, "no room for more: {} KiB of messages were lost", messages.lost_bytes.div_ceil(1024));
    }
    out
}

fn describe(args: &RenderArgs, scene: &Scene, s: &Summary) -> String {
    let mut out = String::new();
    let effects: Vec<&str> = s.plan.decisions.iter().filter(|d| d.is_on()).map(|d| d.effect.name()).collect();
    let seconds = s.render_time.as_secs_f64();
    let wanted = scene.integrator.samples;
    let in_time = s.samples == wanted || s.adaptive.is_some_and(|a| a.tiles.0 == a.tiles.1);
    let stopped = if in_time { String::new() } else { format!(" of {wanted}, stopped by --time") };
    let _ = writeln!(out, "picture    {}, {} samples per pixel{stopped}", args.output.display(), s.samples);
    if let Some(outcome) = &s.adaptive {
        out.push_str(&adapted(outcome));
    }
    let _ = writeln!(out, "device     {}", s.device);
    let _ = writeln!(out, "effects    {}", effects.join(", "));
    let _ = writeln!(
        out,
        "prepare    {:.2} s: materials {:.2}, programs {:.2}, geometry {:.2}",
        (s.compile_time + s.build_time + s.geometry_time).as_secs_f64(),
        s.compile_time.as_secs_f64(),
        s.build_time.as_secs_f64(),
        s.geometry_time.as_secs_f64()
    );
    if s.shaders.1 > 0 {
        let _ = writeln!(out, "shaders    {} compiled, {} from packages", s.shaders.0, s.shaders.1);
    }
    let Tally { built, loaded, shared } = s.programs;
    let _ = writeln!(out, "programs   {built} built, {loaded} from the cache, {shared} equal to others");
    let _ = writeln!(
        out,
        "render     {seconds:.2} s: {:.2} Msamples/s, {:.2} Mrays/s",
        s.counts.samples as f64 / seconds.max(1e-9) / 1e6,
        rays_per_second(&s.counts, s.render_time) / 1e6
    );
    let _ = writeln!(out, "rays       {} along paths, {} to lights", s.counts.rays, s.counts.shadow_rays);
    let clamped = match s.plan.choices.path_state {
        PathState::Float => String::new(),
        PathState::Half => format!(", {} values clamped to 16 bits", s.counts.clamped),
    };
    let _ = writeln!(
        out,
        "state      {} bytes per path, {} values repaired, {} paths dropped{clamped}",
        s.bytes_per_path, s.counts.repaired, s.counts.dropped
    );
    out
}
