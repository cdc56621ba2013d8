//! Finds the place of statements that others need: the nearest one that comes before all of them.
//!
//! In: a block, statements to insert, and which statements need them. Out: the block with them in it. They never go into a
//! loop that they are outside of; into a branch only when all that needs them is in it.

use crate::ir::{Arg, Block, LocalId, Stmt, Value};

/// What needs the inserted statements: those that touch one of some locals.
pub(super) struct Needs<'a> {
    pub values: &'a [Value],
    pub is_needed: &'a dyn Fn(LocalId) -> bool,
}

impl Needs<'_> {
    /// Whether a statement itself touches such a local.
    pub fn here(&self, stmt: &Stmt) -> bool {
        let mut found = false;
        stmt.written(&mut |l| found |= (self.is_needed)(l));
        match stmt {
            Stmt::Let(v) => self.values[v.0 as usize].inst.locals(&mut |l| found |= (self.is_needed)(l)),
            Stmt::CopyArray(_, from) => found |= (self.is_needed)(*from),
            Stmt::Call { args, .. } => {
                for arg in args {
                    if let Arg::Array(l) = arg {
                        found |= (self.is_needed)(*l);
                    }
                }
            }
            _ => {}
        }
        found
    }

    /// Whether a statement or one inside it does.
    pub fn inside(&self, stmt: &Stmt) -> bool {
        let mut found = self.here(stmt);
        if !found {
            stmt.blocks(&mut |b| found = found || self.block(b));
        }
        found
    }

    pub fn block(&self, block: &Block) -> bool {
        block.stmts.iter().any(|s| self.inside(s))
    }
}

/// Inserts statements at the nearest place before all that need them; with `at_end` the block's end does too. Nothing is
/// inserted when nothing needs them. Whether all inserted statements run exactly when one that needs them does.
pub(super) fn insert(stmts: &mut Vec<Stmt>, unit: &mut Vec<Stmt>, needs: &Needs<'_>, at_end: bool) -> bool {
    let mut hits = stmts.iter().enumerate().filter(|(_, s)| needs.inside(s)).map(|(i, _)| i);
    let Some(first) = hits.next() else {
        if at_end {
            stmts.append(unit);
        }
        return true;
    };
    let only = hits.next().is_none() && !at_end;
    let exact = needs.here(&stmts[first]);
    if only
        && !exact
        && let Stmt::If(_, a, b) = &mut stmts[first]
    {
        match (needs.block(a), needs.block(b)) {
            (true, false) => return insert(&mut a.stmts, unit, needs, false),
            (false, true) => return insert(&mut b.stmts, unit, needs, false),
            _ => {}
        }
    }
    stmts.splice(first..first, unit.drain(..));
    exact
}

/// Whether [`insert`] would put the statements where they run exactly when one that needs them does.
pub(super) fn is_exact(stmts: &[Stmt], needs: &Needs<'_>) -> bool {
    let mut hits = stmts.iter().filter(|s| needs.inside(s));
    let Some(first) = hits.next() else { return true };
    if needs.here(first) {
        return true;
    }
    match first {
        Stmt::If(_, a, b) if hits.next().is_none() => match (needs.block(a), needs.block(b)) {
            (true, false) => is_exact(&a.stmts, needs),
            (false, true) => is_exact(&b.stmts, needs),
            _ => false,
        },
        _ => false,
    }
}

/// The number of places before which [`insert_each`] inserts.
pub(super) fn count_each(stmts: &[Stmt], needs: &Needs<'_>) -> usize {
    let mut count = 0;
    for stmt in stmts {
        if needs.here(stmt) {
            return count + 1;
        }
        stmt.blocks(&mut |b| count += count_each(&b.stmts, needs));
    }
    count
}

/// Inserts statements before the first statement of each way through the block that needs them. They must be such that they
/// do nothing when they run again.
pub(super) fn insert_each(stmts: &mut Vec<Stmt>, make: &mut dyn FnMut() -> Vec<Stmt>, needs: &Needs<'_>) {
    let mut i = 0;
    while i < stmts.len() {
        if needs.here(&stmts[i]) {
            stmts.splice(i..i, make());
            return;
        }
        match &mut stmts[i] {
            Stmt::If(_, a, b) => {
                insert_each(&mut a.stmts, make, needs);
                insert_each(&mut b.stmts, make, needs);
            }
            Stmt::Loop(l) => {
                insert_each(&mut l.head.stmts, make, needs);
                insert_each(&mut l.body.stmts, make, needs);
                insert_each(&mut l.step.stmts, make, needs);
            }
            _ => {}
        }
        i += 1;
    }
}
