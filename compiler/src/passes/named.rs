//! Messages whose names only a run tells: a branch per name.
//!
//! In: folded IR before `traces` and `dialogue`, which want constants. Out: calls of `setmessage` and `getmessage` by constant
//! names alone. A name that is a choice among constants has a branch for each; any other is compared with the names that
//! matter: those which the shader's other calls use, and what can be asked of traced rays. No other could find anything, unless both a
//! message that is sent and one that is asked for may have any name: these stay as they are, for `dialogue` to refuse.

use super::strings::Strings;
use super::traces::FACTS;
use crate::builtins::{self, FuncId};
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, LocalId, Rewriter, Shader, Stmt, Ty, ValueId};
use crate::source::Span;
use std::collections::BTreeSet;

/// Where `getmessage` looks for traced rays' messages.
const TRACE: &str = "trace";

/// Puts branches in the place of calls; whether there were any to replace.
pub(super) fn named(shader: &mut Shader) -> bool {
    let (Some(set), Some(get)) = (builtins::find("message_set"), builtins::find("message_get")) else { return false };
    let mut texts = Vec::new();
    let (mut sent, mut asked) = (Vec::new(), Vec::new());
    for block in shader.blocks() {
        block.walk(&mut |s| {
            let Stmt::Call { func, args, .. } = s else { return };
            let value = |at: usize| match args.get(at) {
                Some(Arg::Value(v)) => Some(*v),
                _ => None,
            };
            if *func == set {
                texts.extend(value(0));
                sent.extend(value(0));
            } else if *func == get {
                texts.extend([value(0), value(1)].into_iter().flatten());
                let of_rays = value(0).and_then(|v| constant(shader, v)) == Some(TRACE);
                asked.extend(value(1).filter(|_| !of_rays));
            }
        });
    }
    if texts.iter().all(|v| constant(shader, *v).is_some()) {
        return false;
    }
    let strings = Strings::of(shader);
    let names = |v: &ValueId| strings.trace(shader, vec![*v], Vec::new());
    let known = texts.iter().filter_map(names).flatten().collect();
    let open = [sent, asked].iter().all(|list| list.iter().any(|v| names(v).is_none()));
    Named { shader, strings, known, open, set, get }.rewrite();
    true
}

fn constant(shader: &Shader, v: ValueId) -> Option<&str> {
    match &shader.values[v.0 as usize].inst {
        Inst::Const(Const::Str(s)) => Some(s),
        _ => None,
    }
}

struct Named<'a> {
    shader: &'a mut Shader,
    strings: Strings,
    /// All names that some call can be about.
    known: BTreeSet<String>,
    /// Both what is sent and what is asked for may have any name.
    open: bool,
    set: FuncId,
    get: FuncId,
}

impl Rewriter for Named<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        let Stmt::Call { func, args, outputs, result, span } = stmt else { return out.stmts.push(stmt) };
        if func == self.set || func == self.get {
            self.call(func, args, outputs, result, span, out);
        } else {
            out.stmts.push(Stmt::Call { func, args, outputs, result, span });
        }
    }
}

impl Named<'_> {
    fn call(
        &mut self,
        func: FuncId,
        args: Vec<Arg>,
        outputs: Vec<LocalId>,
        result: Option<LocalId>,
        span: Span,
        out: &mut Block,
    ) {
        let names = if func == self.get { 2 } else { 1 };
        let open = args.iter().take(names).enumerate().find_map(|(at, arg)| match arg {
            Arg::Value(v) if constant(self.shader, *v).is_none() => Some((at, *v)),
            _ => None,
        });
        let Some((at, told_by)) = open else {
            return out.stmts.push(Stmt::Call { func, args, outputs, result, span });
        };
        let is_source = func == self.get && at == 0;
        let choices = match self.strings.trace(self.shader, vec![told_by], Vec::new()) {
            Some(choices) => choices,
            // Sources other than traced rays are one to us.
            None if is_source => BTreeSet::from([TRACE.to_owned(), String::new()]),
            None => match self.candidates(func, &args) {
                Some(candidates) => candidates,
                None => return out.stmts.push(Stmt::Call { func, args, outputs, result, span }),
            },
        };
        let mut rest = Block::default();
        if is_source {
            let mut list = args.clone();
            list[0] = Arg::Value(self.shader.emit_constant(Const::Str(String::new()), span, &mut rest));
            self.call(func, list, outputs.clone(), result, span, &mut rest);
        } else if let Some(result) = result {
            let zero = self.shader.emit_constant(Const::Int(0), span, &mut rest);
            rest.stmts.push(Stmt::Store(result, zero));
        }
        for name in choices.iter().rev().filter(|n| !is_source || *n == TRACE) {
            let mut test = Block::default();
            let text = self.shader.emit_constant(Const::Str(name.clone()), span, &mut test);
            let same = self.shader.emit(Inst::Binary(BinaryOp::Eq, told_by, text), Ty::Int, span, &mut test);
            let mut then = Block::default();
            let mut list = args.clone();
            list[at] = Arg::Value(self.shader.emit_constant(Const::Str(name.clone()), span, &mut then));
            self.call(func, list, outputs.clone(), result, span, &mut then);
            test.stmts.push(Stmt::If(same, then, rest));
            rest = test;
        }
        out.stmts.append(&mut rest.stmts);
    }

    /// The names that a call by an unknown name may be about; `None`: any.
    fn candidates(&self, func: FuncId, args: &[Arg]) -> Option<BTreeSet<String>> {
        let text = |at: usize| match args.get(at) {
            Some(Arg::Value(v)) => constant(self.shader, *v),
            _ => None,
        };
        if func == self.get && text(0) == Some(TRACE) {
            let ty = text(2).unwrap_or_default();
            let facts = FACTS.iter().map(|(name, declared, _)| (*name, *declared)).chain([("hit", "int")]);
            return Some(facts.filter(|(_, declared)| *declared == ty).map(|(name, _)| name.to_owned()).collect());
        }
        (!self.open).then(|| self.known.clone())
    }
}
