//! Looks at what folding left, for what the device would answer wrongly without a word.
//!
//! In: folded and pruned IR. Out: errors for calls that only the host can carry out and for names that are none of the
//! known ones; warnings for names of distributions and numbers of knots that the kernels take as something else. For the host
//! nothing is refused but what nobody carries out.

use super::numbers::Numbers;
use super::strings::Strings;
use super::{Settings, Target};
use crate::builtins::{self, Lowering};
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, Shader, SlotArg, Stmt, Ty, Value, ValueId};
use crate::source::Span;
use crate::suggest;
use std::collections::BTreeSet;

/// Microfacet distributions that kernels/bsdf/distribution.h knows.
const DISTRIBUTIONS: [&str; 3] = ["ggx", "beckmann", "default"];

/// Refuses statements that only the host could carry out, such as `printf`; calls of what no renderer has done yet, the reference
/// included, do nothing or give 0, with a warning. To be called before pruning, which drops what nothing uses: such a call may
/// write to more than its result.
pub(super) fn refuse_calls(shader: &mut Shader, settings: &Settings<'_>) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let is_attribute = |func| builtins::row(func).name == "attribute_get";
    let is_host = |func| settings.target == Target::Device && is_host(func) && !is_attribute(func);
    let (mut errors, mut warnings) = (Vec::new(), Vec::new());
    for block in shader.blocks() {
        block.walk(&mut |s| {
            let (func, span) = match s {
                Stmt::Call { func, span, .. } => (*func, *span),
                Stmt::Let(id) => match &shader.values[id.0 as usize] {
                    Value { inst: Inst::Call(func, _), span, .. } if is_missing(*func) => (*func, *span),
                    _ => return,
                },
                _ => return,
            };
            let name = public_name(builtins::row(func).name);
            if is_missing(func) {
                let effect = match name {
                    "random" | "transformu" => "gives 0",
                    _ => "does nothing",
                };
                add(&mut warnings, Diagnostic::warning("W3003", span, format!("`{name}` {effect}")));
            } else if settings.target == Target::Device && is_attribute(func) {
                let message = "the attribute's name is not known at compile time: it is taken as missing";
                add(&mut warnings, Diagnostic::warning("W3003", span, message));
            } else if is_host(func) {
                let args = match s {
                    Stmt::Call { args, .. } => args.as_slice(),
                    _ => &[],
                };
                at_run_time(shader, name, args, span).into_iter().for_each(|d| add(&mut errors, d));
            }
        });
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    if warnings.is_empty() {
        return Ok(warnings);
    }
    for value in &mut shader.values {
        let Inst::Call(func, _) = &value.inst else { continue };
        if !is_missing(*func) {
            continue;
        }
        value.inst = Inst::Const(match value.ty {
            Ty::Int => Const::Int(0),
            Ty::Triple => Const::Triple([0.0; 3]),
            _ => Const::Float(0.0),
        });
    }
    let gone = |func| is_missing(func) || settings.target == Target::Device && is_attribute(func);
    for param in &mut shader.params {
        drop_calls(&mut param.init, &gone, &mut shader.values);
    }
    drop_calls(&mut shader.body, &gone, &mut shader.values);
    Ok(warnings)
}

/// Leaves calls out; their results are 0.
fn drop_calls(block: &mut Block, gone: &dyn Fn(builtins::FuncId) -> bool, values: &mut Vec<Value>) {
    for stmt in std::mem::take(&mut block.stmts) {
        match stmt {
            Stmt::Call { func, result, span, .. } if gone(func) => {
                let Some(result) = result else { continue };
                let id = ValueId(values.len() as u32);
                values.push(Value { inst: Inst::Const(Const::Int(0)), ty: Ty::Int, span });
                block.stmts.extend([Stmt::Let(id), Stmt::Store(result, id)]);
            }
            Stmt::If(cond, mut a, mut b) => {
                drop_calls(&mut a, gone, values);
                drop_calls(&mut b, gone, values);
                block.stmts.push(Stmt::If(cond, a, b));
            }
            Stmt::Loop(mut l) => {
                for inner in [&mut l.head, &mut l.body, &mut l.step] {
                    drop_calls(inner, gone, values);
                }
                block.stmts.push(Stmt::Loop(l));
            }
            other => block.stmts.push(other),
        }
    }
}

/// A call that only the host can carry out, on what only running the shader tells: which argument that is, and what to do.
/// Nothing where the argument is such a call itself.
fn at_run_time(shader: &Shader, name: &str, args: &[Arg], span: Span) -> Option<Diagnostic> {
    let strings = Strings::of(shader);
    let numbers = Numbers::of(shader);
    let culprit = args.iter().enumerate().find_map(|(i, arg)| {
        let Arg::Value(v) = arg else { return Some((i, None)) };
        let value = &shader.values[v.0 as usize];
        let known = match (&value.inst, value.ty) {
            (Inst::Const(_), _) => true,
            (_, Ty::Str) => strings.trace(shader, vec![*v], Vec::new()).is_some(),
            (_, Ty::Int) => numbers.few(shader, *v).is_some(),
            _ => false,
        };
        (!known).then_some((i, Some(value)))
    });
    let makes = "strings are made and looked into at compile time";
    let Some((i, value)) = culprit else {
        let message = format!("`{name}` has too many possible results, and {makes}");
        return Some(Diagnostic::error("E3001", span, message).help("choose among fewer strings or numbers"));
    };
    if value.is_some_and(|v| matches!(v.inst, Inst::Call(func, _) if is_host(func))) {
        return None;
    }
    let message = format!("argument {} of `{name}` is known only when the shader runs, and {makes}", i + 1);
    let d = Diagnostic::error("E3001", span, message);
    let Some(value) = value else { return Some(d) };
    let d = if value.span == span { d } else { d.label(value.span, "this one") };
    Some(d.help(match value.ty {
        Ty::Str => "choose among known strings; what the geometry or the user supplies while rendering is none of them",
        Ty::Int => "keep the number in a known range: `clamp(i, 0, 9)`, `abs(i) % 10`, a loop's counter",
        _ => "choose among known numbers, or make it an int in a known range: `clamp(int(x), 0, 9)`",
    }))
}

/// A built-in as users know it.
fn public_name(name: &str) -> &str {
    match name {
        "attribute_get" => "getattribute",
        "message_get" => "getmessage",
        "message_set" => "setmessage",
        "dict_get" => "dict_value",
        "trace_call" => "trace",
        "hash_string" => "hash",
        name => name,
    }
}

fn is_missing(func: builtins::FuncId) -> bool {
    builtins::row(func).lowering == Lowering::NotYet
}

fn is_host(func: builtins::FuncId) -> bool {
    matches!(builtins::row(func).lowering, Lowering::Host | Lowering::InternalHost)
}

/// What an inlined function says twice is said once.
pub(super) fn add(list: &mut Vec<Diagnostic>, d: Diagnostic) {
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
                "unknown_name" => {
                    let (reached, said) = unknown_name(shader, &strings, args, id);
                    match said {
                        // The host says it when it gets there.
                        Some(_) if target == Target::Host => {}
                        Some(d) => add(if d.is_error() { &mut errors } else { &mut warnings }, d),
                        None => {}
                    }
                    settled.push((id, Const::Int(reached.into())));
                }
                name if is_host(*func) && target == Target::Device => {
                    let said = at_run_time(shader, public_name(name), args, value.span);
                    said.into_iter().for_each(|d| add(&mut errors, d));
                }
                name => {
                    if let Some((_, basis)) = name.split_once('_').filter(|(f, _)| f.starts_with("spline"))
                        && let Some(Arg::Array(knots)) = args.last()
                        && let Some(count) = knots_count(shader, args, shader.locals[knots.0 as usize].len.unwrap_or(0))
                        && let Some(message) = knots_message(basis, count)
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

/// Whether a chain of comparisons may come to its end, and what is to be said about it: nothing where only running the
/// shader tells.
fn unknown_name(shader: &Shader, strings: &Strings, args: &[Arg], id: ValueId) -> (bool, Option<Diagnostic>) {
    let constant = |arg: Option<&Arg>| match arg {
        Some(Arg::Value(v)) => match &shader.values[v.0 as usize].inst {
            Inst::Const(Const::Str(s)) => s.clone(),
            _ => String::new(),
        },
        _ => String::new(),
    };
    let (what, list, taken) = (constant(args.first()), constant(args.get(1)), constant(args.get(3)));
    let known: Vec<&str> = list.split(',').collect();
    let span = shader.values[id.0 as usize].span;
    let Some(Arg::Value(given)) = args.get(2) else { return (true, None) };
    let Some(names) = strings.trace(shader, vec![*given], Vec::new()) else { return (true, None) };
    match names.iter().find(|n| !known.contains(&n.as_str())) {
        None => (false, None),
        Some(unknown) if taken.is_empty() => (true, Some(suggest::unknown_name(&what, unknown, &known, span))),
        Some(unknown) => {
            let message = format!("the {what} \"{unknown}\" is not known and is taken as \"{taken}\"");
            let help = suggest::known_names(unknown, &known);
            (true, Some(Diagnostic::warning("W3001", span, message).help(help)))
        }
    }
}

/// How many knots a spline takes of an array of `len`; `None`: only running it tells.
fn knots_count(shader: &Shader, args: &[Arg], len: u32) -> Option<u32> {
    let [_, Arg::Value(count), _] = args else { return Some(len) };
    match shader.values[count.0 as usize].inst {
        Inst::Const(Const::Int(n)) => Some(u32::try_from(n).unwrap_or(0).clamp(1, len.max(1))),
        _ => None,
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
