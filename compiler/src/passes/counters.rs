//! Loops that count: which reads of a counter see what.
//!
//! In: IR. Out: for loads inside a loop whose condition compares a variable with a bound, and that changes the variable once
//! a turn by a constant: where it starts, how it steps and where it ends.

use crate::ir::{BinaryOp, Block, Const, Inst, LocalId, Loop, Shader, Stmt, ValueId};
use std::collections::HashMap;

/// A counter.
#[derive(Clone, Debug)]
pub(super) struct Counter {
    /// What it starts with.
    pub first: ValueId,
    /// What it is compared with before each turn; in a loop that is tested after its body, after it.
    pub bound: ValueId,
    /// Whether the bound is reached.
    pub including: bool,
    /// What each turn adds: not 0.
    pub step: i32,
    /// do-while.
    pub tested_after: bool,
}

/// The counters of a shader.
pub(super) struct Counters {
    counters: Vec<Counter>,
    /// For a load: the counter, and whether it is read after it was stepped.
    loads: HashMap<ValueId, (usize, bool)>,
}

impl Counters {
    pub fn of(shader: &Shader) -> Counters {
        let mut found = Counters { counters: Vec::new(), loads: HashMap::new() };
        for block in shader.blocks() {
            found.block(shader, block);
        }
        found
    }

    /// The counter that a value reads inside its loop, and whether that is after the step.
    pub fn read_by(&self, load: ValueId) -> Option<(&Counter, bool)> {
        let (i, after) = self.loads.get(&load)?;
        Some((&self.counters[*i], *after))
    }

    fn block(&mut self, shader: &Shader, block: &Block) {
        for (i, stmt) in block.stmts.iter().enumerate() {
            stmt.blocks(&mut |b| self.block(shader, b));
            if let Stmt::Loop(l) = stmt {
                self.loop_(shader, l, &block.stmts[..i]);
            }
        }
    }

    fn loop_(&mut self, shader: &Shader, l: &Loop, before: &[Stmt]) {
        let Inst::Binary(op, a, b) = shader.values[l.cond.0 as usize].inst else { return };
        let loaded = |v: ValueId| match shader.values[v.0 as usize].inst {
            Inst::Load(local) => Some(local),
            _ => None,
        };
        use BinaryOp::{Ge, Gt, Le, Lt};
        let turned = |op| match op {
            Lt => Gt,
            Le => Ge,
            Gt => Lt,
            Ge => Le,
            op => op,
        };
        // Either side may be the counter; the other must not be one that this loop changes.
        for (counter, op, bound) in [(a, op, b), (b, turned(op), a)] {
            let Some(local) = loaded(counter) else { continue };
            let fixed = loaded(bound).is_none_or(|other| !changes(l, other));
            let (Some((at, step)), true) = (steps(shader, l, local), fixed) else { continue };
            let fits = matches!(op, Lt | Le) && step > 0 || matches!(op, Gt | Ge) && step < 0;
            let (Some(first), true) = (starts_with(local, before), fits) else { continue };
            let including = matches!(op, Le | Ge);
            self.counters.push(Counter { first, bound, including, step, tested_after: l.tested_after });
            self.reads(shader, l, local, at);
            return;
        }
    }

    fn reads(&mut self, shader: &Shader, l: &Loop, local: LocalId, at: Option<usize>) {
        let counter = self.counters.len() - 1;
        let mut read = |stmt: &Stmt, after: bool| {
            if let Stmt::Let(v) = stmt
                && matches!(shader.values[v.0 as usize].inst, Inst::Load(l) if l == local)
            {
                self.loads.insert(*v, (counter, after));
            }
        };
        for (i, stmt) in l.body.stmts.iter().enumerate() {
            let after = at.is_some_and(|at| i > at);
            read(stmt, after);
            stmt.blocks(&mut |b| b.walk(&mut |s| read(s, after)));
        }
        // What the step reads, it reads before it stores.
        if at.is_none() {
            l.step.walk(&mut |s| read(s, false));
        }
    }
}

fn changes(l: &Loop, local: LocalId) -> bool {
    let mut found = false;
    for block in [&l.head, &l.body, &l.step] {
        block.walk(&mut |s| s.written(&mut |w| found |= w == local));
    }
    found
}

/// Where the body steps the counter (`None`: the loop's step does), and by how much. It does so once, whatever the way.
fn steps(shader: &Shader, l: &Loop, local: LocalId) -> Option<(Option<usize>, i32)> {
    let mut count = 0;
    for block in [&l.head, &l.body, &l.step] {
        block.walk(&mut |s| s.written(&mut |w| count += usize::from(w == local)));
    }
    if count != 1 {
        return None;
    }
    let stored = |s: &Stmt| match s {
        Stmt::Store(to, v) if *to == local => added(shader, *v, local),
        _ => None,
    };
    if let Some(step) = l.step.stmts.iter().find_map(stored) {
        return Some((None, step));
    }
    l.body.stmts.iter().enumerate().find_map(|(i, s)| stored(s).map(|step| (Some(i), step)))
}

/// The constant that a value adds to a local.
fn added(shader: &Shader, v: ValueId, local: LocalId) -> Option<i32> {
    let inst = |v: ValueId| &shader.values[v.0 as usize].inst;
    let reads = |v: ValueId| matches!(inst(v), Inst::Load(l) if *l == local);
    let constant = |v: ValueId| match inst(v) {
        Inst::Const(Const::Int(i)) if *i != 0 && *i != i32::MIN => Some(*i),
        _ => None,
    };
    match *inst(v) {
        Inst::Binary(BinaryOp::Add, a, b) if reads(a) => constant(b),
        Inst::Binary(BinaryOp::Add, a, b) if reads(b) => constant(a),
        Inst::Binary(BinaryOp::Sub, a, b) if reads(a) => constant(b).map(|i| -i),
        _ => None,
    }
}

/// What was last stored before the loop, if that is sure.
fn starts_with(local: LocalId, before: &[Stmt]) -> Option<ValueId> {
    for stmt in before.iter().rev() {
        if let Stmt::Store(to, v) = stmt
            && *to == local
        {
            return Some(*v);
        }
        let mut written = false;
        stmt.written(&mut |w| written |= w == local);
        stmt.blocks(&mut |b| b.walk(&mut |s| s.written(&mut |w| written |= w == local)));
        if written {
            return None;
        }
    }
    None
}
