//! `oslcl plan`: which effects a scene needs, who asked for them, what they add; with `--measure` what they cost.
//!
//! In: a scene. Out: a table ([`text`]) or JSON, which has all that the table can have.

mod text;

use super::args::PlanArgs;
use super::{Error, cache, choices, render, terminal};
use oslcl_runtime::choices::Choices;
use oslcl_runtime::explain::{self, Added, Change, Settings, Timing};
use oslcl_runtime::plan::{Asker, Decision, Effect, Plan};
use oslcl_runtime::render::Options;
use oslcl_runtime::scene::{Film, Scene};
use serde_json::{Value, json};

/// All that is known of a plan.
struct Findings {
    plan: Plan,
    added: Vec<Added>,
    measured: Option<Measured>,
    warnings: Vec<String>,
}

/// What `--measure` finds.
struct Measured {
    device: String,
    /// Seconds of a sample as planned, by run.
    planned: Vec<f64>,
    timings: Vec<Timing>,
}

impl Findings {
    fn added(&self, effect: Effect) -> Option<&Added> {
        self.added.iter().find(|a| a.effect == effect)
    }

    fn timing(&self, effect: Effect) -> Option<&Timing> {
        self.measured.as_ref()?.timings.iter().find(|t| t.effect == effect)
    }
}

/// Plans and prints; no device is needed but to measure. `verbose`: the table leaves nothing out.
pub fn run(args: &PlanArgs, verbose: bool) -> Result<(), Error> {
    let choices = choices::of(&args.choices)?;
    let mut scene = render::load(&args.scene)?;
    choices.apply(&mut scene.integrator);
    let say = |error| render::say(&args.scene, error);
    let (plan, compiled) = oslcl_runtime::render::explained_plan(&scene, &choices).map_err(say)?;
    for warning in &compiled.warnings {
        terminal::say(warning);
    }
    let failed = |e: oslcl_runtime::assemble::Error| Error::Usage(format!("the kernels can't be put together: {e}"));
    let added = explain::added(&scene, &plan, &compiled).map_err(failed)?;
    let measured = if args.measure { Some(measure(args, scene, choices, verbose)?) } else { None };
    let findings = Findings { plan, added, measured, warnings: compiled.warnings };
    terminal::print(&if args.json { json(&findings) } else { text::table(&findings, verbose) })
}

/// Measures on a device. What off effects would cost is nobody's usual question, and takes long.
fn measure(args: &PlanArgs, mut scene: Scene, choices: Choices, verbose: bool) -> Result<Measured, Error> {
    let device = cache::device(args.device.as_deref(), &args.cache)?;
    if let Some((width, height)) = args.size {
        scene.film = Film { width, height };
    }
    scene.integrator.samples = args.spp;
    let settings = Settings { runs: args.runs, forced: verbose };
    let options = Options { choices, ..Options::default() };
    let mut watch = |what: &str| terminal::progress(&format!("measuring: {what}"));
    let found = explain::measure(&scene, &device, &options, settings, &mut watch);
    terminal::progress("");
    cache::complain(&device);
    let (planned, timings) = found.map_err(|error| render::say(&args.scene, error))?;
    Ok(Measured { device: device.info.name.clone(), planned, timings })
}

fn json(findings: &Findings) -> String {
    let plan = &findings.plan;
    let effects: Vec<Value> = plan.decisions.iter().map(|d| effect(findings, d)).collect();
    let programs: Vec<Value> = plan
        .programs
        .iter()
        .map(|p| {
            json!({
                "program": p.label,
                "kernels": p.stages.iter().map(|s| s.name()).collect::<Vec<_>>(),
                "macros": p.macros,
            })
        })
        .collect();
    let mut all = json!({
        "effects": effects,
        "programs": programs,
        "bytes_per_path": plan.layout.bytes_per_path(plan.choices.precision.real_bytes()),
        "warnings": findings.warnings.iter().map(|w| w.trim_end()).collect::<Vec<_>>(),
    });
    if let Some(measured) = &findings.measured {
        all["measured"] = json!({ "device": measured.device, "seconds_per_sample": measured.planned });
    }
    format!("{all:#}\n")
}

fn effect(findings: &Findings, d: &Decision) -> Value {
    let added = findings.added(d.effect);
    let kernels = |a: &Added| -> Vec<Value> {
        let kernel = |k: &explain::Kernel| json!({ "program": k.program, "kernel": k.stage.name(), "alone": k.alone });
        a.kernels.iter().map(kernel).collect()
    };
    let mut out = json!({
        "effect": d.effect.name(),
        "text": d.effect.text(),
        "on": d.is_on(),
        "forced": d.forced,
        "left_out": d.removed,
        "asked_by": d.asked_by.iter().map(asker).collect::<Vec<_>>(),
        "macro": d.effect.macro_name(),
        "macros": added.map_or(Vec::new(), |a| a.macros.clone()),
        "kernels": added.map_or(Vec::new(), kernels),
        "bytes_per_path": added.map_or(0, |a| a.bytes_per_path),
        "buffers": added.map_or(Vec::new(), |a| a.buffers.clone()),
    });
    if let Some(warning) = d.warning() {
        out["warning"] = json!(warning.trim_end());
    }
    if let Some(timing) = findings.timing(d.effect) {
        out["measured"] = self::timing(d.effect, timing);
    }
    out
}

fn timing(effect: Effect, timing: &Timing) -> Value {
    let change = if timing.change == Change::Without { "without" } else { "forced" };
    let also: Vec<&str> = timing.also.iter().map(|e| e.name()).collect();
    match &timing.cost {
        Ok(cost) => {
            let (seconds, least, most) = cost.seconds(timing.change);
            let is_wrong = cost.difference > 0.0 && timing.change == Change::Without && !effect.keeps_mean();
            json!({
                "change": change,
                "also": also,
                "seconds_per_sample": seconds,
                "least": least,
                "most": most,
                "planned": cost.planned,
                "other": cost.other,
                "difference": cost.difference,
                "wrong": is_wrong.then(|| effect.missed()),
            })
        }
        Err(cause) => json!({ "change": change, "error": cause }),
    }
}

fn asker(asker: &Asker) -> Value {
    let places: Vec<Value> = asker
        .shader
        .iter()
        .map(|place| {
            let deciders: Vec<Value> = place
                .deciders
                .iter()
                .map(|d| {
                    json!({
                        "parameter": d.param,
                        "value": d.value,
                        "off_at": d.off_at,
                        "file": d.file,
                        "line": d.line,
                        "set_by_scene": d.set,
                    })
                })
                .collect();
            json!({ "file": place.file, "line": place.line, "controlled_by": deciders })
        })
        .collect();
    let at = asker.at.as_ref().filter(|at| at.line > 0);
    json!({
        "who": asker.who(),
        "why": asker.why,
        "file": at.map(|at| at.file.display().to_string()),
        "line": at.map(|at| at.line),
        "shader": places,
    })
}
