//! Statements and structured control flow as C text.
//!
//! Loops become `while`, `for` or `do` where the IR's shape allows it, else `for (;;)` with a test. A `continue` that has to
//! reach what follows the body leaves a `do {} while (0)` around the body.

use super::writer::{LoopForm, Writer};
use crate::backend::names::ctype;
use crate::builtins;
use crate::ir::{Block, Const, Inst, LocalId, LocalKind, Loop, Stmt, Ty, ValueId};
use crate::source::Span;

/// Whether a block has a `Break` / `Continue` of its own loop.
fn has(block: &Block, wanted: &Stmt) -> bool {
    block.stmts.iter().any(|s| match s {
        Stmt::If(_, a, b) => has(a, wanted) || has(b, wanted),
        s => s == wanted,
    })
}

impl Writer<'_> {
    /// Writes a nested block between braces that the caller writes.
    fn nested(&mut self, block: &Block, span: Option<Span>) {
        self.open(span);
        self.within(block);
        self.close();
    }

    /// Writes a block's statements in its own scope, at the present indentation.
    fn within(&mut self, block: &Block) {
        let outer = std::mem::replace(&mut self.scope, self.analysis.number(block));
        self.stmts(block);
        self.scope = outer;
    }

    /// Writes statements in the present scope.
    pub(super) fn stmts(&mut self, block: &Block) {
        for stmt in &block.stmts {
            self.stmt(stmt);
        }
    }

    fn span(&self, v: ValueId) -> Option<Span> {
        Some(self.shader.values[v.0 as usize].span)
    }

    /// The words in front of a local's name when this write is its declaration.
    fn declaration(&mut self, l: LocalId) -> Option<&'static str> {
        let i = l.0 as usize;
        if self.declared[i] || self.local_use(l).home != Some(self.scope) {
            return None;
        }
        self.declared[i] = true;
        Some(ctype(self.shader.locals[i].ty))
    }

    fn stmt(&mut self, stmt: &Stmt) {
        if self.analysis.is_absorbed(stmt) {
            return;
        }
        match stmt {
            Stmt::Let(v) => self.compute(*v),
            Stmt::Store(l, v) => self.store(*l, *v),
            Stmt::StoreElem(l, i, v) => {
                let len = self.shader.locals[l.0 as usize].len.unwrap_or(1);
                let index = self.index_text(*i, len);
                let value = self.operand(*v);
                self.before_write(*l);
                let text = format!("{}[{index}] = {};", self.name(*l), value.text);
                self.put(self.span(*v), &text);
            }
            Stmt::CopyArray(to, from) => {
                self.before_write(*to);
                let len = |l: &LocalId| self.shader.locals[l.0 as usize].len.unwrap_or(0);
                let count = len(to).min(len(from));
                let element = self.element(*from, "i").text;
                let text = format!("for (int i = 0; i < {count}; i++) {}[i] = {element};", self.name(*to));
                self.put(None, &text);
            }
            Stmt::Call { func, args, span, .. } if builtins::has_effect(*func) => self.print(args, *span),
            Stmt::Call { func, args, outputs, result, span } => {
                let result_ty = result.map(|l| self.shader.locals[l.0 as usize].ty);
                let call = self.builtin(*func, args, outputs, result_ty);
                for l in outputs.iter().chain(result) {
                    self.before_write(*l);
                }
                for l in outputs {
                    if let Some(ty) = self.declaration(*l) {
                        let text = format!("{ty} {};", self.name(*l));
                        self.put(Some(*span), &text);
                    }
                }
                let target = match result {
                    Some(l) => {
                        let ty = self.declaration(*l).map_or(String::new(), |ty| format!("{ty} "));
                        format!("{ty}{} = ", self.name(*l))
                    }
                    None => String::new(),
                };
                self.put(Some(*span), &format!("{target}{};", call.text));
            }
            Stmt::If(c, a, b) => self.branch(*c, a, b),
            Stmt::Loop(l) => self.repeat(l),
            Stmt::Break => match self.loops.last().cloned() {
                Some(LoopForm::Wrapped(flag)) => {
                    self.put(None, &format!("{flag} = 1;"));
                    self.put(None, "break;");
                }
                _ => self.put(None, "break;"),
            },
            Stmt::Continue => match self.loops.last() {
                Some(LoopForm::Wrapped(_)) => self.put(None, "break;"),
                _ => self.put(None, "continue;"),
            },
        }
    }

    fn store(&mut self, l: LocalId, v: ValueId) {
        let span = self.span(v);
        let value = self.operand(v);
        self.before_write(l);
        if let Some(ty) = self.declaration(l) {
            let fixed = if self.analysis.is_fixed(l) { "const " } else { "" };
            let text = format!("{fixed}{ty} {} = {};", self.name(l), value.text);
            self.put(span, &text);
            return;
        }
        let text = match &value.update {
            Some((updated, place, new)) if *updated == l => format!("{place} = {new};"),
            _ => format!("{} = {};", self.name(l), value.text),
        };
        self.put(span, &text);
    }

    fn branch(&mut self, c: ValueId, a: &Block, b: &Block) {
        let span = self.span(c);
        let cond = self.operand(c);
        self.before_branch();
        if a.stmts.is_empty() && b.stmts.is_empty() {
            return;
        }
        if a.stmts.is_empty() {
            self.put(span, &format!("if (!({})) {{", cond.text));
            self.nested(b, span);
            self.put(None, "}");
            return;
        }
        self.put(span, &format!("if ({}) {{", cond.text));
        self.nested(a, span);
        let outer = self.scope;
        let mut rest = b;
        while let Some((last, before)) = rest.stmts.split_last() {
            let chained = match last {
                Stmt::If(c, a, b) if !a.stmts.is_empty() && before.iter().all(|s| matches!(s, Stmt::Let(_))) => {
                    Some((c, a, b))
                }
                _ => None,
            };
            let Some((c, a, b)) = chained else {
                self.put(None, "} else {");
                self.nested(rest, span);
                break;
            };
            // `else { if ... }` is `else if ...` when the condition needs no variables of its own.
            self.scope = self.analysis.number(rest);
            let start = self.out.len();
            self.forget_line();
            self.open(span);
            before.iter().for_each(|s| self.stmt(s));
            if self.out.len() > start {
                let indent = "    ".repeat(self.indent - 1);
                self.out.insert_str(start, &format!("{indent}}} else {{\n"));
                self.branch(*c, a, b);
                self.close();
                break;
            }
            self.close();
            let cond = self.operand(*c);
            self.put(None, &format!("}} else if ({}) {{", cond.text));
            self.nested(a, span);
            rest = b;
        }
        self.scope = outer;
        self.put(None, "}");
    }

    /// Writes a block aside, one level deeper, and returns its text.
    fn aside(&mut self, block: &Block) -> String {
        let start = self.out.len();
        self.forget_line();
        self.open(None);
        self.within(block);
        self.close();
        self.forget_line();
        self.out.split_off(start)
    }

    fn repeat(&mut self, l: &Loop) {
        let span = self.span(l.cond);
        self.before_branch();
        let first_temp = self.temps();
        let head = self.aside(&l.head);
        let head_temps = first_temp..self.temps();
        let cond = self.operand(l.cond);
        let step = self.aside(&l.step);
        // A step that is one assignment can stand in the `for`.
        let assigns = matches!(l.step.stmts.last(), Some(Stmt::Store(..)));
        let one_line = step.lines().count() == 1;
        let mut inline_step = "";
        // The header of a `for` does not see what its body declares.
        let sees_head = head_temps.into_iter().any(|n| step.contains(&format!("t{}", n + 1)));
        if assigns && one_line && !l.tested_after && !sees_head {
            inline_step = step.trim().trim_end_matches(';');
        }
        let always = matches!(self.shader.values[l.cond.0 as usize].inst, Inst::Const(Const::Int(i)) if i != 0);
        let test = if always { String::new() } else { cond.text.clone() };
        let leave = if always { String::new() } else { format!("if (!({})) break;", cond.text) };

        if l.tested_after {
            if head.is_empty() && step.is_empty() {
                self.put(span, "do {");
                self.body(&l.body, LoopForm::Plain, span);
                self.put(span, &format!("}} while ({});", cond.text));
                return;
            }
            self.put(span, "for (;;) {");
            self.open(span);
            self.wrapped(&l.body, span);
            self.out.push_str(&head);
            self.put_if(&leave);
            self.out.push_str(&step);
            self.close();
            self.put(None, "}");
            return;
        }
        let in_header = !inline_step.is_empty() || step.is_empty();
        match (head.is_empty(), inline_step) {
            (true, "") => self.put(span, &format!("while ({}) {{", if always { "1" } else { &test })),
            (true, step) => self.put(span, &format!("for (; {test}; {step}) {{")),
            (false, "") => self.put(span, "for (;;) {"),
            (false, step) => self.put(span, &format!("for (;; {step}) {{")),
        }
        if !head.is_empty() {
            self.out.push_str(&head);
            self.indent += 1;
            self.put_if(&leave);
            self.indent -= 1;
        }
        if in_header {
            self.body(&l.body, LoopForm::Plain, span);
        } else {
            self.open(span);
            self.wrapped(&l.body, span);
            self.out.push_str(&step);
            self.close();
        }
        self.put(None, "}");
    }

    fn put_if(&mut self, text: &str) {
        if !text.is_empty() {
            self.put(None, text);
        }
    }

    fn body(&mut self, block: &Block, form: LoopForm, span: Option<Span>) {
        self.loops.push(form);
        self.nested(block, span);
        self.loops.pop();
    }

    /// A body with something behind it that `continue` must reach.
    fn wrapped(&mut self, block: &Block, span: Option<Span>) {
        if !has(block, &Stmt::Continue) {
            self.loops.push(LoopForm::Plain);
            self.within(block);
            self.loops.pop();
            return;
        }
        self.flags += 1;
        let flag = format!("leave{}", self.flags);
        let breaks = has(block, &Stmt::Break);
        if breaks {
            self.put(None, &format!("int {flag} = 0;"));
        }
        self.put(None, "do {");
        self.body(block, LoopForm::Wrapped(flag.clone()), span);
        self.put(None, "} while (0);");
        if breaks {
            self.put(None, &format!("if ({flag}) break;"));
        }
    }

    /// Declares what has no write to be declared at.
    pub(super) fn declare_rest(&mut self) {
        for i in 0..self.shader.locals.len() {
            let l = LocalId(i as u32);
            let local = &self.shader.locals[i];
            let u = self.local_use(l);
            let unwritten = local.len.is_none() && u.writes == 0;
            if !u.touched || u.home.is_some() || unwritten || local.ty == Ty::Closure {
                continue;
            }
            self.declared[i] = true;
            let (ty, name) = (ctype(local.ty), self.name(l).to_owned());
            match (local.kind, local.len) {
                (LocalKind::Input(i), Some(len)) => self.declare_input(l, i, len),
                (_, Some(len)) => self.declare_array(l, len),
                (LocalKind::Global(g), None) => self.put(None, &format!("{ty} {name} = sg->{};", g.name())),
                _ => {
                    let zero = self.zero(local.ty);
                    self.put(None, &format!("{ty} {name} = {zero};"));
                }
            }
        }
    }
}
