//! What a shader uses of the renderer, with places that people can find, and with the parameters that decide.
//!
//! In: the optimised shader, and the parts that it was made of. Out: [`Use`]s. That a parameter's value takes something away is no
//! guess: the shader is optimised again with that value.

use super::group::{Files, Parts};
use super::{Entry, Options};
use crate::artifact::uses::{Found, of};
use crate::artifact::{Control, Use};
use crate::ir::{Const, Shader};
use crate::passes::{self, Controls, Target};
use std::collections::{HashMap, HashSet};

/// Values of the shader times values to try: beyond, none is tried.
const MAX_EFFORT: usize = 4_000_000;

impl Parts<'_> {
    /// What the optimised shader uses.
    pub(super) fn uses(&self, shader: &Shader, files: &Files, options: &Options, outputs: &[String]) -> Vec<Use> {
        let found = of(shader);
        let mut out: Vec<Use> = Vec::new();
        let mut known: HashMap<(String, String, u32), usize> = HashMap::new();
        let controls = if options.explain { self.controls(&found, files, options, outputs) } else { Vec::new() };
        for (i, (what, span)) in found.into_iter().enumerate() {
            let (file, line) = files.sources.place(span);
            let file = file.to_owned();
            let mine = controls.get(i).cloned().unwrap_or_default();
            // Several calls of a line count as one.
            match known.get(&(what.clone(), file.clone(), line)).and_then(|i| out.get_mut(*i)) {
                Some(known) => {
                    // What takes one of them away leaves the others.
                    for control in &mut known.controls {
                        if !mine.iter().any(|c| c.param == control.param) {
                            control.off_at = None;
                        }
                    }
                    for control in mine {
                        match known.controls.iter_mut().find(|c| c.param == control.param) {
                            Some(same) if same.off_at != control.off_at => same.off_at = None,
                            Some(_) => {}
                            None => known.controls.push(Control { off_at: None, ..control }),
                        }
                    }
                }
                None => {
                    known.insert((what.clone(), file.clone(), line), out.len());
                    out.push(Use { what, file, line, controls: mine });
                }
            }
        }
        out
    }

    /// Of each thing that is used the parameters that decide about it.
    fn controls(&self, found: &[Found], files: &Files, options: &Options, outputs: &[String]) -> Vec<Vec<Control>> {
        let Ok((linked, outputs)) = self.link(files, options, outputs) else { return Vec::new() };
        let graph = Controls::of(&linked);
        let mut list: Vec<Vec<(usize, Option<String>)>> =
            found.iter().map(|(_, span)| graph.deciding(*span).into_iter().map(|p| (p, None)).collect()).collect();
        let tries: Vec<(usize, Const)> = (0..linked.params.len())
            .filter_map(|p| Some((p, graph.constant(p)?)))
            .flat_map(|(p, value)| ends(&value).into_iter().map(move |end| (p, end)))
            .collect();
        if tries.len() * linked.values.len() <= MAX_EFFORT {
            let grid = matches!(options.entry, Entry::Grid(_));
            let settings = self.settings(Target::Device, files, grid);
            for (param, value) in tries {
                let text = written(&value);
                let Some(mut other) = graph.with(param, value) else { continue };
                if passes::optimise_with(&mut other, &[], &outputs, &settings).is_err() {
                    continue;
                }
                let left: HashSet<Found> = of(&other).into_iter().collect();
                for (_, list) in found.iter().zip(&mut list).filter(|(known, _)| !left.contains(known)) {
                    match list.iter_mut().find(|(p, _)| *p == param) {
                        Some((_, off)) if off.is_none() => *off = text.clone(),
                        Some(_) => {}
                        None => list.push((param, text.clone())),
                    }
                }
            }
        }
        let control = |(param, off_at): (usize, Option<String>)| {
            let declared = &linked.params[param];
            let (file, line) = files.sources.place(declared.span);
            let file = file.to_owned();
            let value = graph.constant(param).as_ref().and_then(written);
            Control { param: declared.name.clone(), value, file, line, off_at }
        };
        list.into_iter()
            .map(|mut list| {
                // What can take it away comes first.
                list.sort_by_key(|(param, off)| (off.is_none(), *param));
                list.into_iter().map(control).collect()
            })
            .collect()
    }
}

/// The values at which things end to matter: none of it, or all.
fn ends(value: &Const) -> Vec<Const> {
    let all = match value {
        Const::Int(_) => vec![Const::Int(0), Const::Int(1)],
        Const::Float(_) => vec![Const::Float(0.0), Const::Float(1.0)],
        Const::Triple(_) => vec![Const::Triple([0.0; 3]), Const::Triple([1.0; 3])],
        Const::Str(_) => vec![Const::Str(String::new())],
        Const::Matrix(_) | Const::Array(_) => Vec::new(),
    };
    all.into_iter().filter(|end| end != value).collect()
}

/// A constant as OSL writes it.
fn written(value: &Const) -> Option<String> {
    Some(match value {
        Const::Int(x) => x.to_string(),
        Const::Float(x) => x.to_string(),
        Const::Triple([x, y, z]) if x == y && y == z => x.to_string(),
        Const::Triple([x, y, z]) => format!("({x}, {y}, {z})"),
        Const::Str(text) => format!("{text:?}"),
        Const::Matrix(_) | Const::Array(_) => return None,
    })
}
