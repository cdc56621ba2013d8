//! The plan as a table for people: effects that are on, each with who asked for it and what it adds; the others in one list.
//!
//! In: what is known of a plan. Out: text. It must not know how any of it is found.

use super::Findings;
use oslcl_runtime::explain::{Added, Change, Timing};
use oslcl_runtime::plan::{Asker, Decider, Decision, Effect};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Askers of an effect that are printed unless all are; places of a shader; parameters of a place.
const ASKERS: usize = 2;
const PLACES: usize = 2;
const DECIDERS: usize = 3;

/// Longest line of lists.
const WIDTH: usize = 120;

/// The whole text.
pub(super) fn table(findings: &Findings, verbose: bool) -> String {
    let plan = &findings.plan;
    let mut out = String::new();
    let on: Vec<&Decision> = plan.decisions.iter().filter(|d| d.is_on()).collect();
    let mut rows = vec![heads(findings)];
    rows.extend(on.iter().map(|d| cells(findings, d)));
    let lines = aligned(&rows);
    let _ = writeln!(out, "{}", lines[0]);
    for (d, line) in on.iter().zip(&lines[1..]) {
        let _ = writeln!(out, "{line}");
        details(&mut out, findings, d, verbose);
    }
    let left_out: Vec<&Decision> = plan.decisions.iter().filter(|d| d.removed && !d.asked_by.is_empty()).collect();
    if !left_out.is_empty() {
        out.push_str("\nleft out, though the scene calls for it:\n");
        for d in left_out {
            let _ = writeln!(out, "  {}: {}", d.effect.name(), d.effect.missed());
            askers(&mut out, &d.asked_by, verbose);
        }
    }
    let off = plan.decisions.iter().filter(|d| !d.is_on() && (!d.removed || d.asked_by.is_empty()));
    let off: Vec<&str> = off.map(|d| d.effect.name()).collect();
    let _ = writeln!(out, "\noff ({}):", off.len());
    list(&mut out, "  ", &off);
    forced(&mut out, findings);
    let kernels: usize = plan.programs.iter().map(|p| p.stages.len()).sum();
    let _ = writeln!(out, "\nprograms: {}, with {kernels} kernels", plan.programs.len());
    if verbose {
        for p in &plan.programs {
            let stages: Vec<&str> = p.stages.iter().map(|s| s.name()).collect();
            let kernels = if p.material.is_some() { format!(": {}", stages.join(", ")) } else { String::new() };
            let _ = writeln!(out, "  {}{kernels}", p.label);
        }
    }
    let bytes = plan.layout.bytes_per_path(plan.choices.precision.real_bytes());
    let _ = writeln!(out, "bytes per path: {bytes}");
    if let Some(measured) = &findings.measured {
        let (median, least, most) = spread(&measured.planned);
        let _ = writeln!(
            out,
            "a sample as planned: {} ms ({} to {}) on {}",
            ms(median),
            ms(least),
            ms(most),
            measured.device
        );
    }
    out
}

fn heads(findings: &Findings) -> Vec<String> {
    let mut heads = vec!["effect", "", "bytes/path", "kernels", "its own"];
    if findings.measured.is_some() {
        heads.extend(["ms/sample", "from", "to"]);
    }
    heads.into_iter().map(str::to_owned).collect()
}

fn cells(findings: &Findings, d: &Decision) -> Vec<String> {
    let state = if d.forced && d.asked_by.is_empty() { "forced" } else { "on" };
    let mut cells = vec![d.effect.name().to_owned(), state.to_owned()];
    match findings.added(d.effect) {
        Some(a) => {
            let own = a.kernels.iter().filter(|k| k.alone).count();
            cells.extend([a.bytes_per_path.to_string(), a.kernels.len().to_string(), own.to_string()]);
        }
        None => cells.extend(["", "", ""].map(str::to_owned)),
    }
    if findings.measured.is_some() {
        match findings.timing(d.effect).map(|t| (t, &t.cost)) {
            Some((t, Ok(cost))) => {
                let (median, least, most) = cost.seconds(t.change);
                cells.extend([median, least, most].map(ms));
            }
            _ => cells.extend(["-", "", ""].map(str::to_owned)),
        }
    }
    cells
}

/// Columns as wide as their widest cell, with two blanks between: words to the left, numbers to the right.
fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |i: usize| rows.iter().filter_map(|r| r.get(i)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cell = |(i, c): (usize, &String)| match i {
            0 | 1 => format!("{c:<w$}", w = widths[i]),
            _ => format!("{c:>w$}", w = widths[i]),
        };
        row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

/// The lines below an effect.
fn details(out: &mut String, findings: &Findings, d: &Decision, verbose: bool) {
    askers(out, &d.asked_by, verbose);
    if let Some(added) = findings.added(d.effect) {
        adds(out, added, verbose);
    }
    if let Some(timing) = findings.timing(d.effect) {
        let _ = writeln!(out, "    {}", consequence(d.effect, timing));
    }
}

fn askers(out: &mut String, all: &[Asker], verbose: bool) {
    let shown = if verbose { all.len() } else { ASKERS };
    for asker in all.iter().take(shown) {
        let at = asker.at.as_ref().filter(|at| at.line > 0);
        let at = at.map_or(String::new(), |at| format!(" ({}:{})", at.file.display(), at.line));
        let why = if asker.why.is_empty() { String::new() } else { format!(": {}", asker.why) };
        let _ = writeln!(out, "    asked for by {}{at}{why}", asker.who());
        let places = if verbose { asker.shader.len() } else { PLACES };
        for place in asker.shader.iter().take(places) {
            let mut line = format!("      at {}:{}", place.file, place.line);
            if !place.deciders.is_empty() {
                let count = if verbose { place.deciders.len() } else { DECIDERS };
                let shown: Vec<String> = place.deciders.iter().take(count).map(Decider::to_string).collect();
                let _ = write!(line, ", controlled by {}", shown.join(", "));
                more(&mut line, place.deciders.len(), count);
            }
            wrapped(out, &line);
        }
        if asker.shader.len() > places {
            let _ = writeln!(out, "      and at {} more", asker.shader.len() - places);
        }
    }
    if all.len() > shown {
        let _ = writeln!(out, "    and by {} more (-v names them)", all.len() - shown);
    }
}

fn more(line: &mut String, all: usize, shown: usize) {
    if all > shown {
        let _ = write!(line, " and {} more", all - shown);
    }
}

fn adds(out: &mut String, added: &Added, verbose: bool) {
    let mut parts = Vec::new();
    let mut part = |what: &str, names: Vec<String>| {
        if !names.is_empty() {
            parts.push(format!("{what} {}", names.join(", ")));
        }
    };
    part("macros", added.macros.clone());
    part("buffers", added.buffers.iter().map(|b| (*b).to_owned()).collect());
    part("kernels of its own", counted(added, true));
    if verbose {
        part("code in", counted(added, false));
    }
    if !parts.is_empty() {
        wrapped(out, &format!("    adds {}", parts.join("; ")));
    }
}

/// Kernels by name, with how many there are of each.
fn counted(added: &Added, alone: bool) -> Vec<String> {
    let mut counts: BTreeMap<&str, u32> = BTreeMap::new();
    for kernel in added.kernels.iter().filter(|k| k.alone == alone) {
        *counts.entry(kernel.stage.name()).or_default() += 1;
    }
    let name = |(name, count): (&str, u32)| if count > 1 { format!("{name} x{count}") } else { name.to_owned() };
    counts.into_iter().map(name).collect()
}

/// What is seen of an effect's absence, or of its presence.
fn consequence(effect: Effect, timing: &Timing) -> String {
    let also: Vec<&str> = timing.also.iter().map(|e| e.name()).collect();
    let also = if also.is_empty() { String::new() } else { format!(" (and {})", also.join(", ")) };
    match (&timing.cost, timing.change) {
        (Err(cause), _) => format!("not measured: {}", cause.lines().next().unwrap_or_default()),
        (Ok(cost), _) if cost.difference == 0.0 => match timing.change {
            Change::Without => format!("without it{also} this picture is the same to the last bit"),
            Change::Forced => format!("forced on{also} it changes no bit"),
        },
        (Ok(cost), Change::Without) => {
            let (percent, missed) = (percent(cost.difference), effect.missed());
            match effect.keeps_mean() {
                true => format!("without it{also} the picture differs by {percent}, but not in the mean: {missed}"),
                false => format!("without it{also} the picture is wrong by {percent}: {missed}"),
            }
        }
        (Ok(cost), Change::Forced) => format!("forced on{also} the picture differs by {}", percent(cost.difference)),
    }
}

fn percent(part: f64) -> String {
    match part {
        p if p.is_infinite() => "all that is in it".to_owned(),
        p if p < 1e-4 => format!("{:.1e} %", 100.0 * p),
        p => format!("{:.2} %", 100.0 * p),
    }
}

/// What effects that are off would cost, where that was measured.
fn forced(out: &mut String, findings: &Findings) {
    let Some(measured) = &findings.measured else { return };
    let off: Vec<&Timing> = measured.timings.iter().filter(|t| t.change == Change::Forced).collect();
    if off.is_empty() {
        return;
    }
    let mut rows = vec![["forced on", "", "ms/sample", "from", "to"].map(str::to_owned).to_vec()];
    for timing in &off {
        let times = match &timing.cost {
            Ok(cost) => {
                let (median, least, most) = cost.seconds(timing.change);
                [median, least, most].map(ms)
            }
            Err(_) => ["-", "", ""].map(str::to_owned),
        };
        rows.push([timing.effect.name().to_owned(), String::new()].into_iter().chain(times).collect());
    }
    let lines = aligned(&rows);
    let _ = writeln!(out, "\n{}", lines[0]);
    for (timing, line) in off.iter().zip(&lines[1..]) {
        let _ = writeln!(out, "{line}\n    {}", consequence(timing.effect, timing));
    }
}

/// Names with commas, in lines that are not too long.
fn list(out: &mut String, indent: &str, names: &[&str]) {
    let mut line = indent.to_owned();
    for (i, name) in names.iter().enumerate() {
        let comma = if i + 1 < names.len() { "," } else { "" };
        if line.len() > indent.len() && line.len() + name.len() + 2 > WIDTH {
            let _ = writeln!(out, "{}", line.trim_end());
            line = indent.to_owned();
        }
        let _ = write!(line, "{name}{comma} ");
    }
    if line.len() > indent.len() {
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// A line, broken at blanks where it is too long; what follows stands deeper.
fn wrapped(out: &mut String, text: &str) {
    let indent = text.len() - text.trim_start().len();
    let mut line = String::new();
    for word in text.trim_start().split(' ') {
        if !line.trim().is_empty() && line.len() + word.len() + 1 > WIDTH {
            let _ = writeln!(out, "{line}");
            line = " ".repeat(indent + 4) + word;
        } else if line.is_empty() {
            line = " ".repeat(indent) + word;
        } else {
            let _ = write!(line, " {word}");
        }
    }
    let _ = writeln!(out, "{line}");
}

/// Median, least and greatest.
fn spread(numbers: &[f64]) -> (f64, f64, f64) {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => (f64::NAN, f64::NAN, f64::NAN),
        n => ((sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0, sorted[0], sorted[n - 1]),
    }
}

fn ms(seconds: f64) -> String {
    format!("{:.3}", 1e3 * seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_never_run_together() {
        let rows = [["effect", "", "bytes"], ["lobe_oren_nayar_diffuse", "on", "4"], ["a", "forced", "123456"]];
        let rows: Vec<Vec<String>> = rows.iter().map(|r| r.map(str::to_owned).to_vec()).collect();
        assert_eq!(
            aligned(&rows),
            [
                "effect                            bytes",
                "lobe_oren_nayar_diffuse  on           4",
                "a                        forced  123456"
            ]
        );
    }

    #[test]
    fn long_lists_are_broken() {
        let names = vec!["texture_closest"; 20];
        let mut out = String::new();
        list(&mut out, "  ", &names);
        assert!(out.lines().all(|l| l.len() <= WIDTH && l.starts_with("  ")), "{out}");
        assert_eq!(out.matches("texture_closest").count(), 20);
    }
}
