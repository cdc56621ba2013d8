//! Looks at what folding left, for what the device would answer wrongly without a word.
//!
//! In: folded and pruned IR. Out: errors for calls that only the host can carry out and for names that are none of the
//! known ones; warnings for names of distributions and numbers of knots that the kernels take as something else. For the host
//! nothing is refused but what nobody carries out.

use super::Target;
use super::strings::Strings;
use crate::builtins::{self, Lowering};
use crate::diag::Diagnostic;
use crate::interp::ops;
use crate::ir::{Arg, BinaryOp, Const, Inst, Shader, SlotArg, Stmt, Ty, Value, ValueId};
use crate::suggest;
use std::collections::BTreeSet;

/// Microfacet distributions that kernels/bsdf/distribution.h knows.
const DISTRIBUTIONS: [&str; 3] = ["ggx", "beckmann", "default"];

/// Refuses built-ins that are not supported, and statements that only the host could carry out, such as `printf`. To be
/// called before pruning, which drops what nothing uses: such a call may write to more than its result.
pub(super) fn refuse_calls(shader: &Shader, target: Target) -> Result<(), Vec<Diagnostic>> {
    let is_host = |func| target == Target::Device && is_host(func);
    let mut errors = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            let (func, span) = match s {
                Stmt::Call { func, span, .. } if is_host(*func) || is_missing(*func) => (func, *span),
                Stmt::Let(id) => match &shader.values[id.0 as usize] {
                    Value { inst: Inst::Call(func, _), span, .. } if is_missing(*func) => (func, *span),
                    _ => return,
                },
                _ => return,
            };
            add(&mut errors, Diagnostic::not_yet("E3001", span, format!("`{}`", builtins::row(*func).name)));
        });
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

fn is_missing(func: builtins::FuncId) -> bool {
    builtins::row(func).lowering == Lowering::NotYet
}

fn is_host(func: builtins::FuncId) -> bool {
    matches!(builtins::row(func).lowering, Lowering::Host | Lowering::InternalHost)
}

/// What an inlined function says twice is said once.
fn add(list: &mut Vec<Diagnostic>, d: Diagnostic) {
    if list.len() < 100 && !list.contains(&d) {
        list.push(d);
    }
}

/// The warnings, and whether something was rewritten that folding makes less of.
pub(super) fn review(shader: &mut Shader, target: Target) -> Result<(Vec<Diagnostic>, bool), Vec<Diagnostic>> {
    let strings = Strings::of(shader);
    let mut errors = Vec::new();
    let mut warnings = Vec::new();
    let mut settled = Vec::new();
    let mut lets = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Let(id) = s {
                lets.push(*id);
            }
        });
    }
    for id in lets {
        let value = &shader.values[id.0 as usize];
        match &value.inst {
            Inst::Binary(BinaryOp::Eq, a, b)
                if shader.values[a.0 as usize].ty == Ty::Str && strings.never_equal(shader, *a, *b) =>
            {
                settled.push((id, Const::Int(0)));
            }
            Inst::Call(func, args) => match builtins::row(*func).name {
                "unknown_name" => match unknown_name(shader, &strings, args, id) {
                    Some(_) if target == Target::Host => {}
                    Some(d) => add(&mut errors, d),
                    None => settled.extend(ops::zero(value.ty).map(|zero| (id, zero))),
                },
                name if is_host(*func) && target == Target::Device => {
                    let what = format!("`{name}` of what is not known at compile time");
                    add(&mut errors, Diagnostic::not_yet("E3001", value.span, what));
                }
                name => {
                    if let Some((_, basis)) = name.split_once('_').filter(|(f, _)| f.starts_with("spline"))
                        && let [_, Arg::Array(knots)] = args.as_slice()
                        && let Some(message) = knots_message(basis, shader.locals[knots.0 as usize].len.unwrap_or(0))
                    {
                        add(&mut warnings, Diagnostic::warning("W2003", value.span, message));
                    }
                }
            },
            _ => {}
        }
    }
    for slot in &shader.slots {
        let row = builtins::closure(slot.closure);
        let name = row.name;
        if !row.simplified.is_empty() {
            let message = format!("`{name}` {}", row.simplified);
            add(&mut warnings, Diagnostic::warning("W3002", slot.span, message).help("docs/closures.md tells more"));
        }
        let Some(at) = row.distribution() else { continue };
        let names = match &slot.args[at] {
            SlotArg::Const(Const::Str(s)) => BTreeSet::from([s.clone()]),
            SlotArg::Const(_) => continue,
            SlotArg::Local(l) => strings.trace(shader, Vec::new(), vec![*l]).unwrap_or_default(),
        };
        for unknown in names.iter().filter(|n| !DISTRIBUTIONS.contains(&n.as_str())) {
            let message = format!("`{name}` does not know the distribution \"{unknown}\" and takes it as \"ggx\"");
            let help = suggest::known_names(unknown, &DISTRIBUTIONS);
            add(&mut warnings, Diagnostic::warning("W3001", slot.span, message).help(help));
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let changed = !settled.is_empty();
    for (id, c) in settled {
        shader.values[id.0 as usize].inst = Inst::Const(c);
    }
    Ok((warnings, changed))
}

/// What is wrong with the name that a chain of comparisons did not find; `None` when it always finds one.
fn unknown_name(shader: &Shader, strings: &Strings, args: &[Arg], id: ValueId) -> Option<Diagnostic> {
    let constant = |arg: Option<&Arg>| match arg {
        Some(Arg::Value(v)) => match &shader.values[v.0 as usize].inst {
            Inst::Const(Const::Str(s)) => s.clone(),
            _ => String::new(),
        },
        _ => String::new(),
    };
    let (what, list) = (constant(args.first()), constant(args.get(1)));
    let known: Vec<&str> = list.split(',').collect();
    let span = shader.values[id.0 as usize].span;
    let Some(Arg::Value(given)) = args.get(2) else { return None };
    match strings.trace(shader, vec![*given], Vec::new()) {
        Some(names) => {
            let unknown = names.iter().find(|n| !known.contains(&n.as_str()))?;
            Some(suggest::unknown_name(&what, unknown, &known, span))
        }
        None => Some(
            Diagnostic::not_yet("E3003", span, format!("a {what} that is not known at compile time"))
                .help("choose among constants, by parameters or conditions"),
        ),
    }
}

/// What is odd about a number of knots. The specification wants whole segments (ch. 7.6); the reference leaves out knots
/// at the end that fill no segment, and so do the kernels, which repeat the last knot where some are missing.
fn knots_message(basis: &str, knots: u32) -> Option<String> {
    let step = match basis {
        "bezier" => 3,
        "hermite" => 2,
        _ => 1,
    };
    let takes = match step {
        1 => format!("a {basis} spline takes 4 knots or more"),
        _ => format!("a {basis} spline takes 4 knots, or {step} more each time"),
    };
    if knots < 4 {
        return Some(format!("{takes}; here the last of {knots} is repeated"));
    }
    let rest = (knots - 4) % step;
    (rest > 0).then(|| format!("{takes}; here {} of {knots} are used", knots - rest))
}
