//! `oslcl plan`: which effects a scene needs, who asked for them, what they add.

use super::args::PlanArgs;
use super::{Error, choices, render, terminal};
use oslcl_runtime::plan::Plan;
use oslcl_runtime::precision::Precision;
use serde_json::json;
use std::fmt::Write;

/// Plans and prints; no device is needed.
pub fn run(args: &PlanArgs) -> Result<(), Error> {
    let choices = choices::of(&args.choices)?;
    let precision = choices.precision;
    let mut scene = render::load(&args.scene)?;
    choices.apply(&mut scene.integrator);
    let planned = oslcl_runtime::render::plan(&scene, &choices);
    let (plan, compiled) = planned.map_err(|error| render::say(&args.scene, error))?;
    for warning in &compiled.warnings {
        terminal::say(warning);
    }
    terminal::print(&if args.json { json(&plan, precision) } else { text(&plan, precision) })
}

fn text(plan: &Plan, precision: Precision) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "{:<22}{:<5}{:>10}  asked for by", "effect", "", "bytes/path");
    for d in &plan.decisions {
        let (state, bytes) = if d.is_on() {
            ("on", plan.layout.bytes_of(d.effect, precision.real_bytes()).to_string())
        } else {
            ("off", String::new())
        };
        let mut who = d.asked_by.iter().take(3).map(|a| a.to_string()).collect::<Vec<_>>().join(", ");
        if d.asked_by.len() > 3 {
            let _ = write!(who, " and {} more", d.asked_by.len() - 3);
        }
        let added = plan.layout.buffers_of(d.effect);
        if d.is_on() && !added.is_empty() {
            let _ = write!(who, "; buffers: {}", added.join(", "));
        }
        let line = format!("{:<22}{state:<5}{bytes:>10}  {who}", d.effect.name());
        let _ = writeln!(out, "{}", line.trim_end());
    }
    let _ = writeln!(out, "\nprograms:");
    for p in &plan.programs {
        let stages: Vec<&str> = p.stages.iter().map(|s| s.name()).collect();
        let kernels = if p.material.is_some() { format!(": {}", stages.join(", ")) } else { String::new() };
        let _ = writeln!(out, "  {}{kernels}", p.label);
    }
    let _ = writeln!(out, "bytes per path: {}", plan.layout.bytes_per_path(precision.real_bytes()));
    out
}

fn json(plan: &Plan, precision: Precision) -> String {
    let effects: Vec<_> = plan
        .decisions
        .iter()
        .map(|d| {
            json!({
                "effect": d.effect.name(),
                "text": d.effect.text(),
                "on": d.is_on(),
                "asked_by": d.asked_by.iter().map(|a| a.to_string()).collect::<Vec<_>>(),
                "macro": d.effect.macro_name(),
                "bytes_per_path": if d.is_on() { plan.layout.bytes_of(d.effect, precision.real_bytes()) } else { 0 },
                "buffers": if d.is_on() { plan.layout.buffers_of(d.effect) } else { Vec::new() },
            })
        })
        .collect();
    let programs: Vec<_> = plan
        .programs
        .iter()
        .map(|p| json!({ "program": p.label, "kernels": p.stages.iter().map(|s| s.name()).collect::<Vec<_>>() }))
        .collect();
    let all = json!({
        "effects": effects,
        "programs": programs,
        "bytes_per_path": plan.layout.bytes_per_path(precision.real_bytes()),
    });
    format!("{all:#}\n")
}
