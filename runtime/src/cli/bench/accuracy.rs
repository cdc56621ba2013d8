//! `oslcl bench accuracy`: what each choice between accuracy and time costs and buys, on any scene.

use super::super::args::AccuracyArgs;
use super::super::{Error, cache, render, terminal};
use oslcl_runtime::cache::default_root;
use oslcl_runtime::files::{self, Output};
use oslcl_runtime::measure::{Estimate, pareto, plot};
use oslcl_runtime::scene::{Film, Scene};
use oslcl_runtime::study::{self, Effort, Row, Study};
use std::fmt::Write;

/// Measures, prints the table, writes Markdown, CSV and plots.
pub fn run(args: &AccuracyArgs) -> Result<(), Error> {
    let mut scene = render::load(&args.scene)?;
    if let Some((width, height)) = args.size {
        scene.film = Film { width, height };
    }
    let samples = args.spp.unwrap_or(scene.integrator.samples);
    let effort = Effort {
        samples,
        seeds: args.seeds,
        reference_samples: args.reference_spp.unwrap_or_else(|| samples.saturating_mul(64)),
        references: args.references.clone().unwrap_or_else(|| default_root().join("references")),
    };
    std::fs::create_dir_all(&args.output)
        .map_err(|cause| files::Error { path: args.output.clone(), cause: cause.into() })?;
    let device = cache::device(args.device.as_deref(), &args.cache)?;
    let study = study::run(&scene, &device, &effort, &mut |what| terminal::progress(what));
    terminal::progress("");
    let study = study.map_err(|error| match error {
        study::StudyError::Render { variation, cause } => {
            terminal::say(&format!("in {variation}:\n"));
            render::say(&args.scene, *cause)
        }
        study::StudyError::Film(error) => error.into(),
        other => Error::Usage(other.to_string()),
    })?;
    let title = args.scene.file_stem().map_or_else(|| "scene".to_owned(), |s| s.to_string_lossy().into_owned());
    let fronts = Fronts::of(&study);
    let table = table(&study, &fronts);
    let at = |extension: &str| args.output.join(format!("accuracy-{title}{extension}"));
    let mut outputs = vec![
        Output { path: at(".md"), bytes: page(&title, &scene, args, &effort, &study, &table).into_bytes() },
        Output { path: at(".csv"), bytes: csv(&study, &fronts).into_bytes() },
    ];
    for (extension, name, error, front) in [
        ("-mse.svg", "relative MSE", (|r: &Row| r.measured.mse) as fn(&Row) -> Estimate, &fronts.mse),
        ("-flip.svg", "FLIP", |r: &Row| r.measured.flip, &fronts.flip),
    ] {
        let points: Vec<plot::Point> = study
            .rows
            .iter()
            .zip(front)
            .map(|(row, on_front)| plot::Point {
                name: row.variation.name.clone(),
                time: row.measured.seconds,
                error: error(row),
                on_front: *on_front,
            })
            .collect();
        match plot::svg(&format!("{title} on {}", study.device), name, &points) {
            Ok(text) => outputs.push(Output { path: at(extension), bytes: text.into_bytes() }),
            Err(why) => terminal::say(&format!("warning: no plot of {name}: {why}\n")),
        }
    }
    files::replace(&outputs)?;
    terminal::print(&table)
}

/// Who is not beaten in time and error.
struct Fronts {
    mse: Vec<bool>,
    flip: Vec<bool>,
}

impl Fronts {
    fn of(study: &Study) -> Fronts {
        let front = |error: fn(&Row) -> f64| {
            let points: Vec<(f64, f64)> = study.rows.iter().map(|r| (r.measured.seconds.value, error(r))).collect();
            pareto(&points)
        };
        Fronts { mse: front(|r| r.measured.mse.value), flip: front(|r| r.measured.flip.value) }
    }
}

/// A value with its confidence.
fn with_range(e: &Estimate) -> String {
    if e.within.is_finite() { format!("{:.3e} ± {:.0e}", e.value, e.within) } else { format!("{:.3e}", e.value) }
}

/// The table, the best buy first.
fn table(study: &Study, fronts: &Fronts) -> String {
    let target = study.rows.first().map_or(0.0, |r| r.measured.mse.value);
    let own = |r: &Row| r.measured.seconds_to(target);
    let default_time = study.rows.first().and_then(own).unwrap_or(f64::NAN);
    let mut order: Vec<usize> = (0..study.rows.len()).collect();
    let time = |i: usize| own(&study.rows[i]).unwrap_or(f64::INFINITY);
    order.sort_by(|a, b| time(*a).total_cmp(&time(*b)));
    let mut out = String::from(
        "| variation | time to equal error | seconds | relative MSE | bias (RMS) | FLIP | on the front |\n|---|---|---|---|---|---|---|\n",
    );
    for i in order {
        let row = &study.rows[i];
        let m = &row.measured;
        let equal = own(row).map_or_else(|| "never".to_owned(), |t| format!("{:.2} x", t / default_time));
        let bias =
            if m.is_biased() { format!("{:.1e}", m.squared_bias.max(0.0).sqrt()) } else { "none seen".to_owned() };
        let front = match (fronts.mse[i], fronts.flip[i]) {
            (true, true) => "MSE, FLIP",
            (true, false) => "MSE",
            (false, true) => "FLIP",
            (false, false) => "",
        };
        let _ = writeln!(
            out,
            "| {} | {equal} | {:.3} ± {:.3} | {} | {bias} | {} | {front} |",
            row.variation.name,
            m.seconds.value,
            m.seconds.within,
            with_range(&m.mse),
            with_range(&m.flip)
        );
    }
    out
}

/// The whole report.
fn page(title: &str, scene: &Scene, args: &AccuracyArgs, effort: &Effort, study: &Study, table: &str) -> String {
    let mut command = format!(
        "oslcl bench accuracy {} --spp {} --seeds {} --reference-spp {}",
        args.scene.display(),
        effort.samples,
        effort.seeds,
        effort.reference_samples
    );
    if args.size.is_some() {
        let _ = write!(command, " --size {}x{}", scene.film.width, scene.film.height);
    }
    let arithmetic = if study.reference_is_double { "f64" } else { "f32, the device has no f64" };
    let repaired: u64 = study.rows.iter().map(|r| r.repaired).sum();
    format!(
        "# What accuracy costs: {title}\n\n\
         On {}, {} x {} pixels, by\n\n    {command}\n\n\
         Each row is the default ({} samples per pixel) but for what it names, rendered with {} seeds in turns; ± is half a 95 % \
         confidence interval over the seeds. The reference is the same scene in {arithmetic}, with profile `reference` and {} \
         samples per pixel; its own relative MSE is {:.1e}, and is taken off. *Time to equal error*: how long it takes to reach \
         the default's relative MSE, as variance falls with the samples and bias stays, in times of the default. Rows on a front \
         are beaten by no other in both time and error. {repaired} values were not finite and had to be repaired.\n\n\
         ![error against time](accuracy-{title}-mse.svg)\n\n{table}\n\
         FLIP, what a person sees of the error:\n\n![FLIP against time](accuracy-{title}-flip.svg)\n",
        study.device,
        scene.film.width,
        scene.film.height,
        effort.samples,
        effort.seeds,
        effort.reference_samples,
        study.reference_error,
    )
}

fn csv(study: &Study, fronts: &Fronts) -> String {
    let mut out = String::from(
        "variation,samples,seconds,seconds_within,relative_mse,relative_mse_within,variance,squared_bias,bias_noise,flip,\
         flip_within,front_mse,front_flip,repaired\n",
    );
    for (i, row) in study.rows.iter().enumerate() {
        let m = &row.measured;
        let _ = writeln!(
            out,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            row.variation.name,
            row.variation.samples,
            m.seconds.value,
            m.seconds.within,
            m.mse.value,
            m.mse.within,
            m.variance,
            m.squared_bias,
            m.bias_noise,
            m.flip.value,
            m.flip.within,
            fronts.mse[i],
            fronts.flip[i],
            row.repaired
        );
    }
    out
}
