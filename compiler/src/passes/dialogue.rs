//! Messages between the layers of a group: `setmessage` and `getmessage` as variables.
//!
//! In: folded IR before `closures`, since messages may be closures. Out: the same without these calls. Each message has a
//! variable that tells which call set it or looked for it first, and one variable per type that it is set with. What the
//! reference finds wrong at run time (a message set twice, or of another type, or after it was looked for) is printed as it
//! prints it. Names must be constants.

use crate::builtins::{self, FuncId};
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, LocalId, Rewriter, Shader, Stmt, Ty, ValueId};
use crate::messages::code;
use crate::source::{SourceMap, Span};

/// Most calls of a shader: each is compared with each other one of its message.
const MAX_CALLS: usize = 1024;

/// A call.
#[derive(Clone)]
struct Call {
    name: String,
    ty: String,
    sets: bool,
    place: String,
}

/// Where a message of a type is kept.
struct Slot {
    name: String,
    ty: String,
    local: LocalId,
}

/// Carries the calls out.
pub(super) fn dialogue(shader: &mut Shader, sources: Option<&SourceMap>) -> Result<(), Vec<Diagnostic>> {
    let (Some(set), Some(get)) = (builtins::find("message_set"), builtins::find("message_get")) else { return Ok(()) };
    let mut found = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Call { func, args, span, .. } = s
                && (*func == set || *func == get)
            {
                found.push((*func == set, args.clone(), *span));
            }
        });
    }
    if found.is_empty() {
        return Ok(());
    }
    let mut dialogue = Dialogue { shader, set, get, calls: Vec::new(), slots: Vec::new(), states: Vec::new(), next: 0 };
    let mut errors = Vec::new();
    for (sets, args, span) in found {
        let text = |i: usize| dialogue.text(args.get(i));
        let at = usize::from(!sets);
        let (Some(name), Some(ty)) = (text(at), text(at + 1)) else {
            let d = Diagnostic::not_yet(
                "E3003",
                span,
                "a message's name that only running the shader tells, while others are as unknown",
            );
            errors.push(d.help("choose among names that are known, by parameters or conditions, where messages are sent or where they are asked for"));
            continue;
        };
        let place = sources.map_or_else(String::new, |s| place_of(s, span));
        if sets {
            dialogue.slot(&name, &ty, args.get(2));
        }
        dialogue.calls.push(Call { name, ty, sets, place });
    }
    if dialogue.calls.len() > MAX_CALLS {
        errors
            .push(Diagnostic::global("E3004", format!("more than {MAX_CALLS} calls of `setmessage` and `getmessage`")));
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    dialogue.rewrite();
    Ok(())
}

/// File and line, as the reference says them. The text of a compiled shader names the places in its source.
fn place_of(sources: &SourceMap, span: Span) -> String {
    let file = sources.file(span.file);
    if !file.name.ends_with(".oso") {
        let (name, line) = sources.shown(span);
        return format!("{name}:{line}");
    }
    let end = (span.start as usize).min(file.text.len());
    let end = file.text[end..].find('\n').map_or(file.text.len(), |n| end + n);
    let before = &file.text[..end];
    let last = |hint: &str| {
        let from = before.rfind(hint)? + hint.len();
        before[from..].split(['"', '}']).next()
    };
    match (last("%filename{\""), last("%line{")) {
        (Some(name), Some(line)) => format!("{name}:{line}"),
        _ => format!("{}:{}", file.name, sources.line(span)),
    }
}

struct Dialogue<'a> {
    shader: &'a mut Shader,
    set: FuncId,
    get: FuncId,
    /// In the order of the walk.
    calls: Vec<Call>,
    slots: Vec<Slot>,
    /// For each message: 0, or the number (from 1) of the call that set it, or less than 0: that looked for it in vain.
    states: Vec<(String, LocalId)>,
    /// The call that the walk meets next.
    next: usize,
}

impl Rewriter for Dialogue<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        match stmt {
            Stmt::Call { func, args, span, .. } if func == self.set => {
                let number = self.next;
                self.next += 1;
                self.send(number, &args, span, out);
            }
            Stmt::Call { func, outputs, result, span, .. } if func == self.get => {
                let number = self.next;
                self.next += 1;
                self.receive(number, outputs.first().copied(), result, span, out);
            }
            other => out.stmts.push(other),
        }
    }
}

impl Dialogue<'_> {
    fn text(&self, arg: Option<&Arg>) -> Option<String> {
        match arg {
            Some(Arg::Value(v)) => match &self.shader.values[v.0 as usize].inst {
                Inst::Const(Const::Str(s)) => Some(s.clone()),
                _ => None,
            },
            _ => None,
        }
    }

    /// The variable of a message that is set with this value.
    fn slot(&mut self, name: &str, ty: &str, value: Option<&Arg>) {
        if self.slots.iter().any(|s| s.name == name && s.ty == ty) {
            return;
        }
        let (kind, len) = match value {
            Some(Arg::Value(v)) => (self.shader.values[v.0 as usize].ty, None),
            Some(Arg::Array(l)) => {
                let local = &self.shader.locals[l.0 as usize];
                (local.ty, local.len)
            }
            None => return,
        };
        let local = self.shader.add_variable(format!("message_{name}"), kind, len);
        self.slots.push(Slot { name: name.to_owned(), ty: ty.to_owned(), local });
    }

    fn state(&mut self, name: &str) -> LocalId {
        if let Some((_, local)) = self.states.iter().find(|(n, _)| n == name) {
            return *local;
        }
        let local = self.shader.add_variable(format!("state_{name}"), Ty::Int, None);
        self.states.push((name.to_owned(), local));
        local
    }

    fn int(&mut self, v: i32, span: Span, out: &mut Block) -> ValueId {
        self.shader.emit_constant(Const::Int(v), span, out)
    }

    /// Does `then` when the state is `value`.
    fn when(
        &mut self,
        state: LocalId,
        value: i32,
        span: Span,
        out: &mut Block,
        then: impl FnOnce(&mut Self, &mut Block),
    ) {
        let now = self.shader.emit(Inst::Load(state), Ty::Int, span, out);
        let value = self.int(value, span, out);
        let same = self.shader.emit(Inst::Binary(BinaryOp::Eq, now, value), Ty::Int, span, out);
        let mut block = Block::default();
        then(self, &mut block);
        out.stmts.push(Stmt::If(same, block, Block::default()));
    }

    fn error(&mut self, text: String, span: Span, out: &mut Block) {
        let Some(func) = builtins::find("print") else { return };
        let code = self.int(code::RUNTIME, span, out);
        // The text is no format.
        let parts = ["", "%s", &text].map(|s| self.shader.emit_constant(Const::Str(s.to_owned()), span, out));
        let args = [code, parts[0], parts[1], parts[2]].map(Arg::Value).to_vec();
        out.stmts.push(Stmt::Call { func, args, outputs: Vec::new(), result: None, span });
    }

    /// Numbers of the calls of a message, from 1, but for this one.
    fn others(&self, name: &str, sets: bool) -> Vec<(i32, Call)> {
        let all = self.calls.iter().enumerate().filter(|(_, c)| c.name == name && c.sets == sets);
        all.map(|(i, c)| (i as i32 + 1, c.clone())).collect()
    }

    fn send(&mut self, number: usize, args: &[Arg], span: Span, out: &mut Block) {
        let call = self.calls[number].clone();
        let state = self.state(&call.name);
        // What was there before decides; it must not see what this call does.
        let before = self.shader.add_variable("state".to_owned(), Ty::Int, None);
        let now = self.shader.emit(Inst::Load(state), Ty::Int, span, out);
        out.stmts.push(Stmt::Store(before, now));
        self.when(before, 0, span, out, |this, then| {
            let slot = this.slots.iter().find(|s| s.name == call.name && s.ty == call.ty).map(|s| s.local);
            match (slot, args.get(2)) {
                (Some(slot), Some(Arg::Value(v))) => then.stmts.push(Stmt::Store(slot, *v)),
                (Some(slot), Some(Arg::Array(l))) => then.stmts.push(Stmt::CopyArray(slot, *l)),
                _ => {}
            }
            let mine = this.int(number as i32 + 1, span, then);
            then.stmts.push(Stmt::Store(state, mine));
        });
        for (other, first) in self.others(&call.name, true) {
            let text = format!(
                "message \"{}\" already exists (created here: {}) cannot set again from {}",
                call.name, first.place, call.place
            );
            self.when(before, other, span, out, |this, then| this.error(text, span, then));
        }
        for (other, asker) in self.others(&call.name, false) {
            let text = format!(
                "message \"{}\" was queried before being set (queried here: {}) setting it now ({}) would lead to \
                 inconsistent results",
                call.name, asker.place, call.place
            );
            self.when(before, -other, span, out, |this, then| this.error(text, span, then));
        }
    }

    fn receive(
        &mut self,
        number: usize,
        output: Option<LocalId>,
        result: Option<LocalId>,
        span: Span,
        out: &mut Block,
    ) {
        let call = self.calls[number].clone();
        let state = self.state(&call.name);
        let zero = self.int(0, span, out);
        if let Some(result) = result {
            out.stmts.push(Stmt::Store(result, zero));
        }
        let mismatch = |other: &Call, how: &str| {
            format!(
                "type mismatch for message \"{}\" ({how} as {} here: {}) cannot fetch as {} from {}",
                call.name, other.ty, other.place, call.ty, call.place
            )
        };
        for (other, asker) in self.others(&call.name, false) {
            if asker.ty != call.ty {
                let text = mismatch(&asker, "queried");
                self.when(state, -other, span, out, |this, then| this.error(text, span, then));
            }
        }
        self.when(state, 0, span, out, |this, then| {
            let mine = this.int(-(number as i32 + 1), span, then);
            then.stmts.push(Stmt::Store(state, mine));
        });
        for (other, setter) in self.others(&call.name, true) {
            if setter.ty != call.ty {
                let text = mismatch(&setter, "created");
                self.when(state, other, span, out, |this, then| this.error(text, span, then));
                continue;
            }
            let slot = self.slots.iter().find(|s| s.name == call.name && s.ty == call.ty).map(|s| s.local);
            let (Some(slot), Some(output)) = (slot, output) else { continue };
            self.when(state, other, span, out, |this, then| {
                let source = this.shader.locals[slot.0 as usize].clone();
                if source.len.is_some() {
                    then.stmts.push(Stmt::CopyArray(output, slot));
                } else {
                    let value = this.shader.emit(Inst::Load(slot), source.ty, span, then);
                    then.stmts.push(Stmt::Store(output, value));
                }
                let one = this.int(1, span, then);
                if let Some(result) = result {
                    then.stmts.push(Stmt::Store(result, one));
                }
            });
        }
    }
}
