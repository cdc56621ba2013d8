//! Drops what nothing needs: values, stores, locals, branches, loops, and slots whose weight is never set.
//!
//! What is needed: the weights and arguments of lobe slots, the named output parameters, and what is said to the host. Handles are renumbered in
//! order of use, so that equal shaders print equally.

use super::dead;
use crate::builtins;
use crate::interp::ops;
use crate::ir::{Arg, Block, Const, Inst, LocalId, LocalKind, Shader, SlotArg, Stmt, ValueId};

/// Prunes the shader to its slots and the output parameters with these names.
pub fn prune(shader: &mut Shader, outputs: &[String]) {
    drop_dark_slots(shader);
    let at_end = Live::roots(shader, outputs).locals;
    dead::dead_stores(shader, &at_end);
    let mut live = Live::roots(shader, outputs);
    // Walking backwards settles all but loop-carried needs at once.
    loop {
        let before = live.count;
        live.block(shader, &shader.body);
        for param in shader.params.iter().rev() {
            live.block(shader, &param.init);
        }
        if live.count == before {
            break;
        }
    }
    let body = std::mem::take(&mut shader.body);
    shader.body = live.keep(body);
    for i in 0..shader.params.len() {
        let init = std::mem::take(&mut shader.params[i].init);
        shader.params[i].init = live.keep(init);
    }
    renumber(shader, &live);
}

/// A slot whose weight is stored nowhere, or only as zero, never contributes.
fn drop_dark_slots(shader: &mut Shader) {
    let mut lit = vec![false; shader.locals.len()];
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Store(l, v) = s {
                let dark = matches!(&shader.values[v.0 as usize].inst, Inst::Const(c) if !ops::is_true(c));
                lit[l.0 as usize] |= !dark;
            }
        });
    }
    shader.slots.retain(|s| lit[s.weight.0 as usize]);
}

struct Live {
    locals: Vec<bool>,
    values: Vec<bool>,
    /// Things marked so far.
    count: usize,
}

impl Live {
    fn roots(shader: &Shader, outputs: &[String]) -> Live {
        let mut live =
            Live { locals: vec![false; shader.locals.len()], values: vec![false; shader.values.len()], count: 0 };
        for slot in &shader.slots {
            live.local(slot.weight);
            for arg in &slot.args {
                if let SlotArg::Local(l) = arg {
                    live.local(*l);
                }
            }
        }
        for param in shader.params.iter().filter(|p| outputs.contains(&p.name)) {
            live.local(param.local);
        }
        for (i, local) in shader.locals.iter().enumerate() {
            let LocalKind::Global(g) = local.kind else { continue };
            if outputs.iter().any(|o| o == g.name()) {
                live.local(LocalId(i as u32));
            }
        }
        live
    }

    fn local(&mut self, id: LocalId) {
        let flag = &mut self.locals[id.0 as usize];
        self.count += !*flag as usize;
        *flag = true;
    }

    /// Marks a value and all that it is computed from.
    fn value(&mut self, shader: &Shader, id: ValueId) {
        let mut todo = vec![id];
        while let Some(id) = todo.pop() {
            if std::mem::replace(&mut self.values[id.0 as usize], true) {
                continue;
            }
            self.count += 1;
            let inst = &shader.values[id.0 as usize].inst;
            inst.operands(&mut |v| todo.push(v));
            inst.locals(&mut |l| self.local(l));
        }
    }

    /// Whether something in the block is needed; marks what that needs.
    fn block(&mut self, shader: &Shader, block: &Block) -> bool {
        let mut any = false;
        for stmt in block.stmts.iter().rev() {
            any |= self.stmt(shader, stmt);
        }
        any
    }

    fn stmt(&mut self, shader: &Shader, stmt: &Stmt) -> bool {
        match stmt {
            Stmt::Let(_) => false,
            Stmt::Store(l, v) => {
                let needed = self.locals[l.0 as usize];
                if needed {
                    self.value(shader, *v);
                }
                needed
            }
            Stmt::StoreElem(l, i, v) => {
                let needed = self.locals[l.0 as usize];
                if needed {
                    self.value(shader, *i);
                    self.value(shader, *v);
                }
                needed
            }
            Stmt::CopyArray(to, from) => {
                let needed = self.locals[to.0 as usize];
                if needed {
                    self.local(*from);
                }
                needed
            }
            Stmt::Call { func, args, outputs, result, .. } => {
                let needed = stays(*func) || outputs.iter().chain(result).any(|l| self.locals[l.0 as usize]);
                if needed {
                    // All outputs are written, so all must exist.
                    outputs.iter().chain(result).for_each(|l| self.local(*l));
                    for arg in args {
                        match arg {
                            Arg::Value(v) => self.value(shader, *v),
                            Arg::Array(l) => self.local(*l),
                        }
                    }
                }
                needed
            }
            Stmt::If(cond, a, b) => {
                let needed = self.block(shader, b) | self.block(shader, a);
                if needed {
                    self.value(shader, *cond);
                }
                needed
            }
            Stmt::Loop(l) => {
                let inner = self.block(shader, &l.step) | self.block(shader, &l.body) | self.block(shader, &l.head);
                let needed = inner && has_effect(self, &l.head, &l.body, &l.step);
                if needed {
                    self.value(shader, l.cond);
                }
                needed
            }
            // A jump is needed when its loop is; it makes the branch that holds it needed.
            Stmt::Break | Stmt::Continue => true,
        }
    }

    fn keep(&self, block: Block) -> Block {
        let mut out = Block::default();
        for stmt in block.stmts {
            match stmt {
                Stmt::Let(id) => {
                    if self.values[id.0 as usize] {
                        out.stmts.push(Stmt::Let(id));
                    }
                }
                Stmt::Store(l, _) | Stmt::StoreElem(l, _, _) | Stmt::CopyArray(l, _) => {
                    if self.locals[l.0 as usize] {
                        out.stmts.push(stmt);
                    }
                }
                Stmt::Call { func, ref outputs, ref result, .. } => {
                    if stays(func) || outputs.iter().chain(result).any(|l| self.locals[l.0 as usize]) {
                        out.stmts.push(stmt);
                    }
                }
                Stmt::If(cond, a, b) => {
                    let (a, b) = (self.keep(a), self.keep(b));
                    let effect = |block: &Block| block.stmts.iter().any(|s| !matches!(s, Stmt::Let(_)));
                    if effect(&a) || effect(&b) {
                        out.stmts.push(Stmt::If(cond, a, b));
                    }
                }
                Stmt::Loop(mut l) => {
                    if has_effect(self, &l.head, &l.body, &l.step) {
                        l.head = self.keep(l.head);
                        l.body = self.keep(l.body);
                        l.step = self.keep(l.step);
                        out.stmts.push(Stmt::Loop(l));
                    }
                }
                jump => out.stmts.push(jump),
            }
        }
        out
    }
}

/// Whether a call stays even when nothing needs its results.
fn stays(func: builtins::FuncId) -> bool {
    builtins::has_effect(func)
}

/// Whether a loop writes something needed or says something.
fn has_effect(live: &Live, head: &Block, body: &Block, step: &Block) -> bool {
    let mut found = false;
    for block in [head, body, step] {
        block.walk(&mut |s| {
            found |= matches!(s, Stmt::Call { func, .. } if stays(*func));
            s.written(&mut |l| found |= live.locals[l.0 as usize]);
        });
    }
    found
}

/// New handles in order of use; parameters keep a local even when nothing reads it.
fn renumber(shader: &mut Shader, live: &Live) {
    let mut locals = vec![None; shader.locals.len()];
    let mut kept = Vec::new();
    for (i, local) in shader.locals.iter().enumerate() {
        if live.locals[i] || matches!(local.kind, LocalKind::Param(_)) {
            locals[i] = Some(LocalId(kept.len() as u32));
            kept.push(local.clone());
        }
    }
    let mut order = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| {
            if let Stmt::Let(id) = s {
                order.push(*id);
            }
        });
    }
    // A do-while's head stands before its body but may use the body's... nothing: values of the body end with it.
    let mut values = vec![ValueId(0); shader.values.len()];
    for (new, old) in order.iter().enumerate() {
        values[old.0 as usize] = ValueId(new as u32);
    }
    let local = |id: &mut LocalId| *id = locals[id.0 as usize].unwrap_or(LocalId(0));
    let renamed = |v: &mut ValueId| *v = values[v.0 as usize];
    let mut new_values = Vec::with_capacity(order.len());
    for old in &order {
        let mut value = shader.values[old.0 as usize].clone();
        value.inst.rename(&local, &renamed);
        new_values.push(value);
    }
    shader.values = new_values;
    shader.locals = kept;
    for param in &mut shader.params {
        local(&mut param.local);
        param.init.rename(&local, &renamed);
    }
    shader.body.rename(&local, &renamed);
    for slot in &mut shader.slots {
        local(&mut slot.weight);
        for arg in &mut slot.args {
            if let SlotArg::Local(l) = arg {
                local(l);
            }
        }
    }
    debug_assert!(shader.values.iter().all(|v| !matches!(v.inst, Inst::Const(Const::Array(_)))));
}
