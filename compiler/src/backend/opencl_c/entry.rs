//! The two kinds of functions: a material that offers its lobes, and a grid that stores outputs.

use super::Code;
use super::lobes;
use super::writer::Writer;
use crate::backend::entry::{Output, Source, outputs, role};
use crate::backend::names;
use crate::builtins::ClosureRole;
use crate::diag::Diagnostic;
use crate::ir::{LobeSlot, LocalId, Shader, Ty};
use crate::source::SourceMap;

/// Stands for the function's name until its text is known.
const ENTRY: &str = "@";

/// Arrays of outputs up to this length are stored one by one.
const MAX_UNROLLED: u32 = 16;

/// Writes a material function (kernels/lobe.h).
pub(super) fn material(shader: &Shader, lines: Option<&SourceMap>) -> Result<Code, Vec<Diagnostic>> {
    let mut w = Writer::new(shader, &[], lines);
    w.includes.extend(["globals.h", "lobe.h"]);
    body(&mut w);
    w.forget_line();
    w.put(None, "out->lobe.type = LOBE_NONE;");
    w.put(None, "out->emission = out->background = out->holdout = (real3)(0.0);");
    let scatters = |s: &&LobeSlot| matches!(role(s), ClosureRole::Lobe(_) | ClosureRole::Transparent);
    let lobes: Vec<&LobeSlot> = shader.slots.iter().filter(scatters).collect();
    if lobes.len() > 1 {
        w.put(None, "LobeChoice choice = {pick, 0.0, 0.0};");
        w.put(None, "const real3 wo = -sg->I;");
    }
    for slot in &shader.slots {
        let weight = w.load(slot.weight).text;
        match role(slot) {
            ClosureRole::Emission => w.put(Some(slot.span), &format!("out->emission += {weight};")),
            ClosureRole::Background => w.put(Some(slot.span), &format!("out->background += {weight};")),
            ClosureRole::Holdout => w.put(Some(slot.span), &format!("out->holdout += {weight};")),
            ClosureRole::Lobe(_) | ClosureRole::Transparent => lobe(&mut w, slot, &weight, lobes.len() == 1),
            ClosureRole::Debug | ClosureRole::Volume => {}
            ClosureRole::Layer => {
                let message = "internal error: a layer reached the back end";
                w.errors.push(Diagnostic::error("E4299", slot.span, message));
            }
        }
    }
    if lobes.len() > 1 {
        w.put(None, "lobe_finish(out, &choice);");
    }
    if !lobes.is_empty() {
        w.includes.insert("bsdf/pick.h");
    }
    finish(w, "material", "real pick, ShadeResult *out", Vec::new())
}

/// Offers a lobe, or takes the only one.
fn lobe(w: &mut Writer, slot: &LobeSlot, weight: &str, only: bool) {
    let call = lobes::of_slot(w, slot);
    w.put(Some(slot.span), &format!("if (lobe_counts({weight})) {{"));
    w.open(Some(slot.span));
    if only {
        w.put(Some(slot.span), &format!("out->lobe = {call};"));
        w.put(Some(slot.span), &format!("out->lobe.weight = {weight};"));
    } else {
        w.put(Some(slot.span), &format!("const Lobe lobe = {call};"));
        w.put(Some(slot.span), &format!("lobe_offer(out, &choice, &lobe, {weight}, wo);"));
    }
    w.close();
    w.put(None, "}");
}

/// Writes a grid function.
pub(super) fn grid(shader: &Shader, names: &[String], lines: Option<&SourceMap>) -> Result<Code, Vec<Diagnostic>> {
    let outputs = outputs(shader, names)?;
    let local = |source: &Source| match source {
        Source::Local(l) => Some(*l),
        Source::Field(_) | Source::Ci => None,
    };
    let results: Vec<LocalId> = outputs.iter().filter_map(|(s, _)| local(s)).collect();
    let mut w = Writer::new(shader, &results, lines);
    w.includes.insert("globals.h");
    body(&mut w);
    w.forget_line();
    for (source, output) in &outputs {
        match source {
            Source::Local(l) => store(&mut w, *l, output.offset),
            Source::Field(g) => {
                store_single(&mut w, Ty::Triple, &format!("sg->{}", g.name()), &output.offset.to_string());
            }
            Source::Ci => {
                let weights: Vec<String> = shader.slots.iter().map(|s| w.load(s.weight).text).collect();
                let sum = if weights.is_empty() { "(real3)(0.0)".to_owned() } else { weights.join(" + ") };
                w.put(None, &format!("const real3 Ci{} = {sum};", output.offset));
                store_single(&mut w, Ty::Triple, &format!("Ci{}", output.offset), &output.offset.to_string());
            }
        }
    }
    let list = outputs.into_iter().map(|(_, o)| o).collect();
    finish(w, "grid", "real *outputs", list)
}

/// Stores an output parameter from `outputs[offset]` on.
fn store(w: &mut Writer, l: LocalId, offset: u32) {
    let local = &w.shader.locals[l.0 as usize];
    let ty = local.ty;
    let width = match ty {
        Ty::Triple => 3,
        Ty::Matrix => 16,
        _ => 1,
    };
    match local.len {
        None => {
            let value = w.load(l).text;
            store_single(w, ty, &value, &offset.to_string());
        }
        Some(len) if len <= MAX_UNROLLED => {
            for i in 0..len {
                let value = w.element(l, &i.to_string()).text;
                store_single(w, ty, &value, &(offset + i * width).to_string());
            }
        }
        Some(len) => {
            w.put(None, &format!("for (int i = 0; i < {len}; i++) {{"));
            w.open(None);
            let value = w.element(l, "i").text;
            store_single(w, ty, &value, &format!("{offset} + {width} * i"));
            w.close();
            w.put(None, "}");
        }
    }
}

fn store_single(w: &mut Writer, ty: Ty, value: &str, at: &str) {
    match ty {
        Ty::Triple => {
            let value = if value.starts_with('(') { format!("({value})") } else { value.to_owned() };
            for (i, c) in ["x", "y", "z"].iter().enumerate() {
                w.put(None, &format!("outputs[{at} + {i}] = {value}.{c};"));
            }
        }
        Ty::Matrix => {
            w.put(None, "{");
            w.open(None);
            w.put(None, &format!("const mat4 matrix = {value};"));
            w.put(None, &format!("for (int k = 0; k < 16; k++) outputs[{at} + k] = matrix.m[k];"));
            w.close();
            w.put(None, "}");
        }
        _ => w.put(None, &format!("outputs[{at}] = (real){value};")),
    }
}

/// Writes declarations, the parameters' inits and the body.
fn body(w: &mut Writer) {
    let shader = w.shader;
    w.declare_rest();
    for param in &shader.params {
        w.stmts(&param.init);
    }
    w.stmts(&shader.body);
    if shader.locals.iter().enumerate().any(|(i, l)| l.ty == Ty::Matrix && w.analysis.locals[i].touched) {
        w.includes.insert("osl/matrix.h");
    }
}

/// Puts the parts together and gives the function its name.
fn finish(w: Writer, prefix: &str, params: &str, outputs: Vec<Output>) -> Result<Code, Vec<Diagnostic>> {
    if !w.errors.is_empty() {
        return Err(w.errors);
    }
    let shader = w.shader;
    // Headers of lobes come last: they build on the others.
    let (lobes, others): (Vec<&str>, Vec<&str>) = w.includes.iter().partition(|h| h.starts_with("bsdf/"));
    let includes: Vec<String> = others.into_iter().chain(lobes).map(str::to_owned).collect();
    let mut text = format!("// {} {}\n", names::sanitise(&shader.kind), names::sanitise(&shader.name));
    for include in &includes {
        text.push_str(&format!("#include \"{include}\"\n"));
    }
    text.push('\n');
    text.push_str(&w.tables);
    text.push_str(&format!("void {ENTRY}(const ShaderGlobals *sg, {params})\n{{\n"));
    text.push_str(&w.out);
    text.push_str("}\n");
    let entry = names::entry(prefix, &shader.name, &text);
    let mut text = text.replace(ENTRY, &entry);
    if w.tracks_lines() {
        // What follows in the same program is not OSL any more.
        let next = text.lines().count() + 2;
        text.push_str(&format!("#line {next} \"{entry}.cl\"\n"));
    }
    let mut strings: Vec<String> = w.strings.into_values().collect();
    strings.sort_unstable();
    Ok(Code { entry, text, includes, outputs, sites: w.sites, strings })
}
