//! Closures in `printf` and `fprintf`: the terms as the reference implementation writes them,
//! `(r, g, b) * name (arguments, "token", value)`, joined by a line break, a tab and a plus sign. Terms of weight 0 are not there.
//!
//! In: a `print` call with closure values, whose weights and arguments the pass knows. Out: a `print` per piece of the format and per
//! term, each term under the condition that its weight is not 0.

use super::Pass;
use crate::builtins::{self, ClosureId, FuncId, sig};
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, SlotArg, Stmt, Ty, ValueId};
use crate::messages::code;
use crate::passes::printed::text_of;
use crate::source::Span;

/// Closures whose label is part of the text even when the call has none: testshade registers them so.
const LABELLED: [&str; 2] = ["diffuse", "phong"];

/// Number, owner and format come before the values.
const FIRST_VALUE: usize = 3;

impl Pass<'_> {
    /// Whether a call prints and has a closure among its values.
    pub(super) fn prints_closures(&self, func: FuncId, args: &[Arg]) -> bool {
        builtins::row(func).name == "print" && args.iter().any(|a| self.closure_of(a).is_some())
    }

    fn closure_of(&self, arg: &Arg) -> Option<ValueId> {
        match arg {
            Arg::Value(v) if self.shader.values[v.0 as usize].ty == Ty::Closure => Some(*v),
            _ => None,
        }
    }

    fn constant(&self, arg: Option<&Arg>) -> Option<&Const> {
        match arg {
            Some(Arg::Value(v)) => match &self.shader.values[v.0 as usize].inst {
                Inst::Const(c) => Some(c),
                _ => None,
            },
            _ => None,
        }
    }

    /// Keeps what only print shows of a call: its text, with conversions, and their values. Strings that are made by `format` are not made:
    /// their parts are shown instead.
    pub(super) fn print_only(
        &mut self,
        closure: ClosureId,
        args: &[ValueId],
        out: &mut Block,
    ) -> (String, Vec<SlotArg>) {
        let arity = sig::closure_arity(closure);
        let unknown = builtins::closure(closure).name == builtins::UNKNOWN;
        let template = match (&self.shader.values[args[0].0 as usize].inst, unknown) {
            (Inst::Const(Const::Str(text)), true) => text.clone(),
            _ => "\"label\", \"%s\"".to_owned(),
        };
        let (mut text, mut kept) = (String::new(), Vec::new());
        let mut values = args[arity..].iter();
        for part in parts(&template) {
            if !part.starts_with('%') || part == "%%" {
                text.push_str(part);
                continue;
            }
            let Some(value) = values.next() else { break };
            let (inner, list) = self.formatted(*value).unwrap_or_else(|| (part.to_owned(), vec![*value]));
            text.push_str(&inner);
            for value in list {
                let name = format!("closure{}_p{}", self.calls.len(), kept.len());
                kept.push(self.keep(name, value, out));
            }
        }
        (text, kept)
    }

    /// The parts of a string that is made on the way.
    fn formatted(&self, value: ValueId) -> Option<(String, Vec<ValueId>)> {
        let (text, args) = text_of(self.shader, &Arg::Value(value), 0)?;
        let values: Option<Vec<ValueId>> = args
            .iter()
            .map(|a| match a {
                Arg::Value(v) => Some(*v),
                Arg::Array(_) => None,
            })
            .collect();
        Some((text, values?))
    }

    /// Replaces the call.
    pub(super) fn print(&mut self, func: FuncId, args: &[Arg], span: Span, out: &mut Block) {
        let kind = self.constant(args.first());
        let whole = matches!(kind, Some(Const::Int(k)) if *k == code::ERROR || *k == code::WARNING);
        let Some(Const::Str(format)) = self.constant(args.get(2)).cloned().filter(|_| !whole) else {
            let what =
                if whole { "a closure in `error` or `warning`" } else { "a closure in a format that is not constant" };
            self.errors.push(Diagnostic::not_yet("E3001", span, what).help("print it by `printf`"));
            return;
        };
        let mut piece = String::new();
        let mut values: Vec<Arg> = Vec::new();
        let mut rest = args[FIRST_VALUE..].iter();
        for part in parts(&format) {
            if !part.starts_with('%') || part == "%%" {
                piece.push_str(part);
                continue;
            }
            let arg = rest.next();
            match arg.and_then(|a| self.closure_of(a)) {
                Some(closure) => {
                    self.piece(func, args, &mut piece, &mut values, span, out);
                    self.terms(func, args, closure, span, out);
                }
                None => {
                    piece.push_str(part);
                    values.extend(arg.cloned());
                }
            }
        }
        // Values beyond the conversions change nothing, but closures must not stay.
        self.piece(func, args, &mut piece, &mut values, span, out);
    }

    fn piece(
        &mut self,
        func: FuncId,
        call: &[Arg],
        format: &mut String,
        values: &mut Vec<Arg>,
        span: Span,
        out: &mut Block,
    ) {
        if format.is_empty() {
            return;
        }
        let text = self.shader.emit_constant(Const::Str(std::mem::take(format)), span, out);
        let mut args = call[..FIRST_VALUE - 1].to_vec();
        args.push(Arg::Value(text));
        args.append(values);
        out.stmts.push(Stmt::Call { func, args, outputs: Vec::new(), result: None, span });
    }

    /// Prints the terms of a closure.
    fn terms(&mut self, func: FuncId, call: &[Arg], closure: ValueId, span: Span, out: &mut Block) {
        let weights = self.values.get(&closure).cloned().unwrap_or_default();
        let any = self.shader.add_variable("terms".into(), Ty::Int, None);
        let zero = self.shader.emit_constant(Const::Int(0), span, out);
        out.stmts.push(Stmt::Store(any, zero));
        for (index, (slot, weight)) in weights.into_iter().enumerate() {
            let black = self.shader.emit_constant(Const::Triple([0.0; 3]), span, out);
            let there = self.shader.emit(Inst::Binary(BinaryOp::Ne, weight, black), Ty::Int, span, out);
            let mut inner = Block::default();
            if index > 0 {
                let earlier = self.shader.emit(Inst::Load(any), Ty::Int, span, &mut inner);
                let mut joint = Block::default();
                self.piece(func, call, &mut "\n\t+ ".to_owned(), &mut Vec::new(), span, &mut joint);
                inner.stmts.push(Stmt::If(earlier, joint, Block::default()));
            }
            let mut values = Vec::new();
            let mut format = String::new();
            self.value_text(weight, &mut format, &mut values, span, &mut inner);
            format.push_str(" * ");
            self.call_text(slot, &mut format, &mut values, span, &mut inner);
            self.piece(func, call, &mut format, &mut values, span, &mut inner);
            let one = self.shader.emit_constant(Const::Int(1), span, &mut inner);
            inner.stmts.push(Stmt::Store(any, one));
            out.stmts.push(Stmt::If(there, inner, Block::default()));
        }
    }

    /// `name (arguments)`.
    fn call_text(&mut self, slot: u32, format: &mut String, values: &mut Vec<Arg>, span: Span, out: &mut Block) {
        let Some(lobe) = self.calls.get(&slot).cloned() else { return };
        let (more, extras) = self.extras.get(&slot).cloned().unwrap_or_default();
        let row = builtins::closure(lobe.closure);
        let extra = |pass: &mut Self, values: &mut Vec<Arg>, out: &mut Block| {
            for kept in &extras {
                let value = pass.argument(kept, span, out);
                values.push(Arg::Value(value));
            }
        };
        if row.name == builtins::UNKNOWN {
            match lobe.args.first() {
                // A call without values has its text still.
                Some(SlotArg::Const(Const::Str(text))) if more.is_empty() => format.push_str(text),
                _ => format.push_str(&more),
            }
            extra(self, values, out);
            return;
        }
        let formals = sig::closure_formals(lobe.closure).len();
        let keys = sig::closure_keys(lobe.closure);
        format.push_str(&format!("{} (", row.name));
        let order = written(row.name, row.args, lobe.args.len());
        for (i, arg) in order.into_iter().enumerate() {
            if i > 0 {
                format.push_str(", ");
            }
            if let Some(key) = i.checked_sub(formals).and_then(|k| keys.get(k)) {
                format.push_str(&format!("\"{}\", ", key.token));
            }
            match arg {
                Written::Argument(at) => {
                    let value = self.argument(&lobe.args[at], span, out);
                    self.value_text(value, format, values, span, out);
                }
                Written::Text(text) => format.push_str(text),
            }
        }
        if more.is_empty() && LABELLED.contains(&row.name) {
            format.push_str(", \"label\", \"\"");
        } else if !more.is_empty() {
            format.push_str(if lobe.args.is_empty() { "" } else { ", " });
            format.push_str(&more);
            extra(self, values, out);
        }
        format.push(')');
    }

    fn value_text(&mut self, value: ValueId, format: &mut String, values: &mut Vec<Arg>, span: Span, out: &mut Block) {
        match self.shader.values[value.0 as usize].ty {
            Ty::Int => format.push_str("%d"),
            Ty::Str => format.push_str("\"%s\""),
            Ty::Triple => {
                format.push_str("(%g, %g, %g)");
                for i in 0..3 {
                    let index = self.shader.emit_constant(Const::Int(i), span, out);
                    let part = self.shader.emit(Inst::Component(value, index), Ty::Float, span, out);
                    values.push(Arg::Value(part));
                }
                return;
            }
            _ => format.push_str("%g"),
        }
        values.push(Arg::Value(value));
    }
}

/// What is written of a call.
#[derive(Clone, Copy)]
enum Written {
    Argument(usize),
    Text(&'static str),
}

/// The arguments of a call as written: the reference implementation's header makes the short forms of these closures of their
/// long ones.
fn written(name: &str, formals: &str, count: usize) -> Vec<Written> {
    use Written::{Argument, Text};
    match (name, formals) {
        ("reflection", "normal") => vec![Argument(0), Text("0")],
        ("microfacet", "string,normal,float,float,int") => {
            let zero = Text("(0, 0, 0)");
            vec![Argument(0), Argument(1), zero, Argument(2), Argument(2), Argument(3), Argument(4)]
        }
        _ => (0..count).map(Argument).collect(),
    }
}

/// A format's conversions and what stands between them.
pub(in crate::passes) fn parts(format: &str) -> Vec<&str> {
    let mut out = Vec::new();
    let mut rest = format;
    while !rest.is_empty() {
        let end = match rest.strip_prefix('%') {
            None => rest.find('%').unwrap_or(rest.len()),
            // Flags, width and precision end at the conversion's letter.
            Some(tail) => tail.find(|c: char| c.is_ascii_alphabetic() || c == '%').map_or(rest.len(), |i| i + 2),
        };
        let (part, tail) = rest.split_at(end);
        out.push(part);
        rest = tail;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::parts;

    #[test]
    fn formats_come_apart_at_conversions() {
        assert_eq!(parts("a %s%%b %5.2f"), ["a ", "%s", "%%", "b ", "%5.2f"]);
        assert_eq!(parts("50%"), ["50", "%"]);
    }
}
