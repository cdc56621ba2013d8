//! Drops stores that are overwritten before anything reads them.
//!
//! In: IR after `closures`, and the locals that are read at the end. Out: the same without those stores. One walk against
//! the order of execution carries the locals whose present value may still be read. In a loop that is everything read
//! anywhere inside it, or after it: coarse, and right for every jump. Arrays are left alone.

use crate::ir::{Arg, Block, Inst, LocalId, Shader, Stmt, Value};

/// A set of locals.
#[derive(Clone)]
struct Set(Vec<u64>);

impl Set {
    fn insert(&mut self, l: LocalId) {
        self.0[l.0 as usize / 64] |= 1 << (l.0 % 64);
    }

    fn remove(&mut self, l: LocalId) {
        self.0[l.0 as usize / 64] &= !(1 << (l.0 % 64));
    }

    fn has(&self, l: LocalId) -> bool {
        self.0[l.0 as usize / 64] >> (l.0 % 64) & 1 == 1
    }

    fn join(&mut self, other: &Set) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a |= b);
    }
}

/// Drops dead stores of the body; `at_end` tells for each local whether it is read at the end of the shader.
pub(super) fn dead_stores(shader: &mut Shader, at_end: &[bool]) {
    let mut live = Set(vec![0; shader.locals.len().div_ceil(64)]);
    for (i, _) in at_end.iter().enumerate().filter(|(_, read)| **read) {
        live.insert(LocalId(i as u32));
    }
    let body = std::mem::take(&mut shader.body);
    let mut walk = Walk { values: &shader.values, loops: Vec::new() };
    shader.body = walk.block(body, &mut live);
}

struct Walk<'a> {
    values: &'a [Value],
    /// What may be read after a jump, for each loop around.
    loops: Vec<Set>,
}

impl Walk<'_> {
    /// `live` is what may be read after the block, and becomes what may be read from its start.
    fn block(&mut self, block: Block, live: &mut Set) -> Block {
        let mut kept = Vec::with_capacity(block.stmts.len());
        for stmt in block.stmts.into_iter().rev() {
            kept.extend(self.stmt(stmt, live));
        }
        kept.reverse();
        Block { stmts: kept }
    }

    fn stmt(&mut self, stmt: Stmt, live: &mut Set) -> Option<Stmt> {
        match stmt {
            Stmt::Store(l, _) if !live.has(l) => return None,
            Stmt::Store(l, _) => live.remove(l),
            Stmt::Let(_) | Stmt::StoreElem(..) | Stmt::CopyArray(..) => reads(self.values, &stmt, live),
            Stmt::Call { ref outputs, ref result, .. } => {
                outputs.iter().chain(result).for_each(|l| live.remove(*l));
                reads(self.values, &stmt, live);
            }
            Stmt::If(cond, a, b) => {
                let mut other = live.clone();
                let a = self.block(a, live);
                let b = self.block(b, &mut other);
                live.join(&other);
                return Some(Stmt::If(cond, a, b));
            }
            Stmt::Loop(mut l) => {
                for block in [&l.head, &l.body, &l.step] {
                    block.walk(&mut |s| reads(self.values, s, live));
                }
                self.loops.push(live.clone());
                for block in [&mut l.head, &mut l.body, &mut l.step] {
                    // From the end of each part control may go to any other, or out.
                    let mut inside = live.clone();
                    *block = self.block(std::mem::take(block), &mut inside);
                }
                self.loops.pop();
                return Some(Stmt::Loop(l));
            }
            Stmt::Break | Stmt::Continue => {
                if let Some(around) = self.loops.last() {
                    *live = around.clone();
                }
            }
        }
        Some(stmt)
    }
}

/// Adds what a statement reads; statements inside it aside.
fn reads(values: &[Value], stmt: &Stmt, live: &mut Set) {
    match stmt {
        Stmt::Let(id) => match &values[id.0 as usize].inst {
            Inst::Load(l) | Inst::LoadElem(l, _) => live.insert(*l),
            inst => inst.locals(&mut |l| live.insert(l)),
        },
        Stmt::CopyArray(_, from) => live.insert(*from),
        Stmt::Call { args, .. } => {
            for arg in args {
                if let Arg::Array(l) = arg {
                    live.insert(*l);
                }
            }
        }
        _ => {}
    }
}
