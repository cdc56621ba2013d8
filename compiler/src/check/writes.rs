//! Writing what must not be written: parameters of the shader that are no outputs, and constants.
//!
//! In: the typed tree of the file. Out: findings. A function's parameters stand for what it is called with, as in the reference
//! implementation, which looks once all functions are inlined: what a function writes, `output` or not, counts where it is
//! called with a parameter of the shader or a constant. Functions that nothing calls may write what they like.

use super::Checker;
use super::typed::{Callee, Expr, ExprKind, FunctionId, Shader, Stmt, VarId, VarKind, expressions, visit};
use crate::ast::BinaryOp;
use crate::builtins;
use crate::diag::Diagnostic;
use crate::source::Span;
use crate::types::Type;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// Most places at which a parameter is written that are told where a function is called.
const MAX_PLACES: usize = 8;

/// What a body does that may write.
enum Event {
    /// A variable, or a part of it, is written at a place.
    Write(VarId, Span),
    /// A variable, whole or a field, stands for a function's parameter; where the argument is.
    Pass(FunctionId, usize, VarId, Span),
    /// So does a constant.
    Constant(FunctionId, usize, Span),
    /// A function is called.
    Call(FunctionId),
}

impl Checker {
    pub(super) fn check_writes(&mut self, shader: &Shader) {
        let mut outermost = Vec::new();
        for init in shader.params.iter().filter_map(|p| p.init.as_ref()) {
            self.events_of(init, &mut outermost);
        }
        self.events(&shader.body, &mut outermost);
        // The bodies that the shader reaches.
        let mut bodies: BTreeMap<FunctionId, Vec<Event>> = BTreeMap::new();
        let mut todo = called(&outermost);
        while let Some(id) = todo.pop() {
            if let Entry::Vacant(entry) = bodies.entry(id) {
                let mut events = Vec::new();
                self.events(self.functions[id.0 as usize].body.as_deref().unwrap_or_default(), &mut events);
                todo.extend(called(&events));
                entry.insert(events);
            }
        }
        let written = self.written(bodies.values().flatten());
        let places = |id: FunctionId, i: usize| {
            let formal = self.formal(id, i);
            formal.and_then(|formal| written.get(&formal)).map_or(&[][..], Vec::as_slice)
        };
        let mut findings = BTreeMap::new();
        let mut found = |at: Span, var: Option<VarId>, passed: Option<Span>| {
            if var.is_some_and(|id| self.may_be_written(id)) {
                return;
            }
            let key = (at.file.0, at.start, passed.map_or(0, |p| p.start));
            findings.entry(key).or_insert((var, at, passed));
        };
        for event in outermost.iter().chain(bodies.values().flatten()) {
            match event {
                Event::Call(_) => {}
                Event::Write(var, at) => found(*at, Some(*var), None),
                Event::Pass(id, i, var, passed) => {
                    places(*id, *i).iter().for_each(|at| found(*at, Some(*var), Some(*passed)));
                }
                Event::Constant(id, i, passed) => {
                    places(*id, *i).iter().for_each(|at| found(*at, None, Some(*passed)));
                }
            }
        }
        let before = self.errors.len();
        for (var, at, passed) in findings.into_values() {
            self.report_write(var, at, passed);
        }
        // What is an error at a place need not be a warning too.
        let places: BTreeSet<_> =
            self.errors[before..].iter().map(|d| (d.labels[0].span.file, d.labels[0].span.start)).collect();
        self.warnings
            .retain(|w| w.code != "W2004" || !places.contains(&(w.labels[0].span.file, w.labels[0].span.start)));
    }

    fn may_be_written(&self, id: VarId) -> bool {
        let var = self.var(id);
        var.writable || !matches!(var.kind, VarKind::ShaderParam(_))
    }

    fn report_write(&mut self, var: Option<VarId>, at: Span, passed: Option<Span>) {
        let d = match var.map(|id| self.var(id)) {
            Some(var) => {
                let message = format!("`{}` is a parameter without `output`, and is written here", var.name);
                Diagnostic::error("E2018", at, message)
                    .label(var.span, "declared here")
                    .help("declare it `output`, or copy it to a variable")
            }
            None => Diagnostic::error("E2018", at, "a constant is written here").help("copy it to a variable"),
        };
        self.error(match passed {
            Some(passed) => d.label(passed, "passed here"),
            None => d,
        });
    }

    fn formal(&self, id: FunctionId, index: usize) -> Option<VarId> {
        self.functions[id.0 as usize].params.get(index).map(|(var, _)| *var)
    }

    /// Where variables are written, by themselves or as the parameters of functions; some places of each.
    fn written<'e>(&self, events: impl Iterator<Item = &'e Event>) -> BTreeMap<VarId, Vec<Span>> {
        let mut written: BTreeMap<VarId, Vec<Span>> = BTreeMap::new();
        let mut passed: BTreeMap<VarId, Vec<VarId>> = BTreeMap::new();
        let mut todo = Vec::new();
        for event in events {
            match event {
                Event::Write(var, at) => todo.push((*var, *at)),
                Event::Pass(id, i, var, _) => {
                    if let Some(formal) = self.formal(*id, *i) {
                        passed.entry(formal).or_default().push(*var);
                    }
                }
                _ => {}
            }
        }
        while let Some((var, at)) = todo.pop() {
            let places = written.entry(var).or_default();
            if places.len() < MAX_PLACES && !places.contains(&at) {
                places.push(at);
                todo.extend(passed.get(&var).into_iter().flatten().map(|outer| (*outer, at)));
            }
        }
        written
    }

    fn events(&self, stmts: &[Stmt], out: &mut Vec<Event>) {
        expressions(stmts, &mut |e| self.events_of(e, out));
    }

    fn events_of(&self, e: &Expr, out: &mut Vec<Event>) {
        visit(e, &mut |e| match &e.kind {
            ExprKind::Assign(to, from) if is_itself(to, from) => {}
            ExprKind::Assign(to, _) | ExprKind::AssignOp(_, to, _) | ExprKind::IncDec(_, to) => {
                out.extend(variable(to).map(|(var, _)| Event::Write(var, to.span)));
            }
            ExprKind::Call(Callee::User(id), args) => {
                out.push(Event::Call(*id));
                let params = &self.functions[id.0 as usize].params;
                for (i, (arg, (_, output))) in args.iter().zip(params).enumerate() {
                    out.extend(match variable(arg) {
                        Some((var, Part::Whole)) => Some(Event::Pass(*id, i, var, arg.span)),
                        // The element is a copy, which goes back where it came from.
                        Some((var, Part::Element)) if *output => Some(Event::Write(var, arg.span)),
                        None if is_constant(arg) => Some(Event::Constant(*id, i, arg.span)),
                        _ => None,
                    });
                }
            }
            ExprKind::Call(Callee::Builtin { id, outputs, .. }, args) => {
                let name = builtins::row(*id).name;
                for (i, arg) in args.iter().enumerate() {
                    if outputs.get(i).copied().unwrap_or_else(|| is_answer(name, args, i)) {
                        out.extend(variable(arg).map(|(var, _)| Event::Write(var, arg.span)));
                    }
                }
            }
            _ => {}
        });
    }
}

/// The functions that are called.
fn called(events: &[Event]) -> Vec<FunctionId> {
    let call = |e: &Event| if let Event::Call(id) = e { Some(*id) } else { None };
    events.iter().filter_map(call).collect()
}

/// Whether a built-in function writes its answer to an argument that has no type of its own in the table.
fn is_answer(name: &str, args: &[Expr], i: usize) -> bool {
    let option = |words: &[&str]| matches!(i.checked_sub(1).map(|k| &args[k].kind), Some(ExprKind::Str(s)) if words.contains(&s.as_str()));
    match name {
        "getattribute" | "getmessage" | "dict_value" | "gettextureinfo" | "pointcloud_get" => i + 1 == args.len(),
        "texture" | "texture3d" | "environment" => option(&["alpha", "errormessage"]),
        "pointcloud_search" => i > 5 && args[i - 1].ty == Type::STRING,
        _ => false,
    }
}

/// How much of a variable a place is.
enum Part {
    /// All of it, or a field, which the reference takes for a variable of its own.
    Whole,
    /// An element or component.
    Element,
}

/// The variable that an expression names, through conversions that do nothing.
fn variable(e: &Expr) -> Option<(VarId, Part)> {
    match &e.kind {
        ExprKind::Var(id) => Some((*id, Part::Whole)),
        ExprKind::Field(base, _) => variable(base),
        ExprKind::Index(base, _) | ExprKind::Component(base, _) | ExprKind::Element(base, ..) => {
            variable(base).map(|(id, _)| (id, Part::Element))
        }
        ExprKind::Convert(inner) if does_nothing(e, inner) => variable(inner),
        ExprKind::Comma(parts) => variable(parts.last()?),
        _ => None,
    }
}

/// Conversions among triples; `float(k)` of a float is a copy.
fn does_nothing(e: &Expr, inner: &Expr) -> bool {
    e.ty != inner.ty && e.ty.base.is_triple() && inner.ty.base.is_triple() && e.ty.extent == inner.ty.extent
}

/// `k = k` or `k = color(k)`, for which the reference makes no code.
fn is_itself(to: &Expr, from: &Expr) -> bool {
    let from = match &from.kind {
        ExprKind::Convert(inner) if inner.ty == from.ty => inner,
        _ => from,
    };
    let whole = |e| match variable(e) {
        Some((id, Part::Whole)) => Some(id),
        _ => None,
    };
    matches!(to.kind, ExprKind::Var(_)) && to.ty == from.ty && whole(to).is_some() && whole(to) == whole(from)
}

/// What the reference has no variable for: literals, what its parser computes of them, and triples of those.
fn is_constant(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Convert(inner) if does_nothing(e, inner) => is_constant(inner),
        // An int where a float is wanted; a cast, whose text is longer, makes a variable.
        ExprKind::Convert(inner) => {
            e.ty == Type::FLOAT && inner.ty == Type::INT && e.span == inner.span && is_constant(inner)
        }
        ExprKind::Construct(parts) if e.ty.base.is_triple() => parts.iter().all(|part| match &part.kind {
            ExprKind::Convert(inner) => part.span == inner.span && is_literal(inner),
            _ => part.ty != Type::STRING && is_literal(part),
        }),
        ExprKind::Comma(parts) => parts.last().is_some_and(is_constant),
        _ => is_literal(e),
    }
}

/// Literals, and operators on two of one type.
fn is_literal(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Int(_) | ExprKind::Float(_) | ExprKind::Str(_) => true,
        ExprKind::Neg(inner) => matches!(e.ty, Type::INT | Type::FLOAT) && is_literal(inner),
        ExprKind::Binary(op, a, b) => {
            !matches!(op, BinaryOp::And | BinaryOp::Or)
                && a.ty == b.ty
                && matches!(a.ty, Type::INT | Type::FLOAT)
                && is_literal(a)
                && is_literal(b)
        }
        _ => false,
    }
}
