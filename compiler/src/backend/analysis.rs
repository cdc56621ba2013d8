//! What the writer must know before it writes: uses of values, where locals come to life, which arrays are tables.
//!
//! In: a shader after `passes`. Out: [`Analysis`]. One walk in program order; what no statement reaches does not count.

use crate::ir::{Arg, Block, Const, Inst, LocalId, LocalKind, Shader, SlotArg, Stmt, ValueId};
use std::collections::{HashMap, HashSet};

/// A block, by order of the walk. The parameters' inits and the body share [`ROOT`]: they share a C scope.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::backend) struct BlockNumber(u32);

/// The scope of the function itself.
pub(in crate::backend) const ROOT: BlockNumber = BlockNumber(0);

/// What happens to a local.
#[derive(Clone, Debug, Default)]
pub(in crate::backend) struct LocalUse {
    /// Anything at all.
    pub touched: bool,
    /// The block whose first access to it is a write that later accesses all lie behind: declared there.
    pub home: Option<BlockNumber>,
    /// Statements that write it.
    pub writes: u32,
    /// Whole arrays: handed to a function.
    pub passed: bool,
    /// Arrays: elements set to constants before anything else happens.
    pub initial: Vec<Option<Const>>,
    /// Arrays: such elements are still being collected.
    collecting: bool,
    /// Arrays: written beyond that.
    pub changes: bool,
}

/// The result.
pub(in crate::backend) struct Analysis<'a> {
    shader: &'a Shader,
    /// How often each value is used.
    uses: Vec<u32>,
    /// Where each value is computed.
    defined: Vec<BlockNumber>,
    /// Where each value is used last.
    used: Vec<BlockNumber>,
    /// By local.
    pub locals: Vec<LocalUse>,
    /// Statements that only initialise a table.
    absorbed: HashSet<*const Stmt>,
    numbers: HashMap<*const Block, BlockNumber>,
    /// Blocks around the walk's place.
    path: Vec<BlockNumber>,
}

impl<'a> Analysis<'a> {
    pub(in crate::backend) fn of(shader: &'a Shader, results: &[LocalId]) -> Analysis<'a> {
        let arrays = shader.locals.iter().map(|l| LocalUse {
            collecting: l.len.is_some() && !matches!(l.kind, LocalKind::Global(_) | LocalKind::Input(_)),
            ..LocalUse::default()
        });
        let mut a = Analysis {
            shader,
            uses: vec![0; shader.values.len()],
            defined: vec![ROOT; shader.values.len()],
            used: vec![ROOT; shader.values.len()],
            locals: arrays.collect(),
            absorbed: HashSet::new(),
            numbers: HashMap::new(),
            path: vec![ROOT],
        };
        for param in &shader.params {
            a.stmts(&param.init);
        }
        a.stmts(&shader.body);
        for slot in &shader.slots {
            a.read(slot.weight);
            for arg in &slot.args {
                if let SlotArg::Local(l) = arg {
                    a.read(*l);
                }
            }
        }
        for l in results {
            a.read(*l);
        }
        a
    }

    /// The scope of a block that the walk met; [`ROOT`] for inits and the body.
    pub(in crate::backend) fn number(&self, block: &Block) -> BlockNumber {
        self.numbers.get(&std::ptr::from_ref(block)).copied().unwrap_or(ROOT)
    }

    /// Whether a statement has become part of an array's initialiser.
    pub(in crate::backend) fn is_absorbed(&self, stmt: &Stmt) -> bool {
        self.absorbed.contains(&std::ptr::from_ref(stmt))
    }

    /// Never used: need not be written.
    pub(in crate::backend) fn is_dead(&self, v: ValueId) -> bool {
        self.uses[v.0 as usize] == 0
    }

    /// Used once, in the block that computes it: may stand where it is used.
    pub(in crate::backend) fn is_single(&self, v: ValueId) -> bool {
        let i = v.0 as usize;
        self.uses[i] == 1 && self.defined[i] == self.used[i]
    }

    /// Whether every load of a single local gives the same value, so that its name may stand for the load.
    pub(in crate::backend) fn is_fixed(&self, l: LocalId) -> bool {
        let u = &self.locals[l.0 as usize];
        match self.shader.locals[l.0 as usize].kind {
            LocalKind::Global(_) | LocalKind::Input(_) => u.writes == 0,
            _ => u.writes == 0 || (u.writes == 1 && u.home.is_some()),
        }
    }

    fn here(&self) -> BlockNumber {
        self.path.last().copied().unwrap_or(ROOT)
    }

    fn block(&mut self, block: &Block) {
        let number = BlockNumber(self.numbers.len() as u32 + 1);
        self.numbers.insert(block, number);
        self.path.push(number);
        self.stmts(block);
        self.path.pop();
    }

    fn stmts(&mut self, block: &Block) {
        for stmt in &block.stmts {
            self.stmt(stmt);
        }
    }

    fn stmt(&mut self, stmt: &Stmt) {
        match stmt {
            Stmt::Let(v) => {
                self.defined[v.0 as usize] = self.here();
                self.inst(&self.shader.values[v.0 as usize].inst);
            }
            Stmt::Store(l, v) => {
                self.value(*v);
                self.write(*l);
            }
            Stmt::StoreElem(l, i, v) => {
                if self.initialises(*l, *i, *v) {
                    self.absorbed.insert(stmt);
                    return;
                }
                self.value(*i);
                self.value(*v);
                self.change(*l);
            }
            Stmt::CopyArray(to, from) => {
                self.read(*from);
                self.change(*to);
            }
            Stmt::Call { args, outputs, result, .. } => {
                for arg in args {
                    self.arg(arg);
                }
                for l in outputs.iter().chain(result) {
                    if self.shader.locals[l.0 as usize].len.is_some() {
                        self.locals[l.0 as usize].passed = true;
                        self.change(*l);
                    } else {
                        self.write(*l);
                    }
                }
            }
            Stmt::If(c, a, b) => {
                self.value(*c);
                self.block(a);
                self.block(b);
            }
            Stmt::Loop(l) => {
                self.block(&l.head);
                // The condition is used where the head computes it.
                let head = self.number(&l.head);
                self.path.push(head);
                self.value(l.cond);
                self.path.pop();
                self.block(&l.body);
                self.block(&l.step);
            }
            Stmt::Break | Stmt::Continue => {}
        }
    }

    /// Whether a store sets an element of a table that nothing has looked at; if so, notes it.
    fn initialises(&mut self, l: LocalId, index: ValueId, value: ValueId) -> bool {
        let shader = self.shader;
        let constant = |v: ValueId| match &shader.values[v.0 as usize].inst {
            Inst::Const(c) => Some(c),
            _ => None,
        };
        let at_root = self.path.len() == 1;
        let u = &mut self.locals[l.0 as usize];
        let (Some(Const::Int(i)), Some(c), Some(len)) =
            (constant(index), constant(value), shader.locals[l.0 as usize].len)
        else {
            return false;
        };
        if !u.collecting || !at_root || len == 0 {
            return false;
        }
        let i = (*i).clamp(0, len as i32 - 1) as usize;
        u.touched = true;
        u.initial.resize(u.initial.len().max(i + 1), None);
        u.initial[i] = Some(c.clone());
        true
    }

    fn inst(&mut self, inst: &Inst) {
        if let Inst::Call(_, args) = inst {
            return args.iter().for_each(|a| self.arg(a));
        }
        inst.locals(&mut |l| self.read(l));
        inst.operands(&mut |v| self.value(v));
    }

    fn arg(&mut self, arg: &Arg) {
        match arg {
            Arg::Value(v) => self.value(*v),
            Arg::Array(l) => {
                self.read(*l);
                self.locals[l.0 as usize].passed = true;
            }
        }
    }

    fn value(&mut self, v: ValueId) {
        self.uses[v.0 as usize] += 1;
        self.used[v.0 as usize] = self.here();
    }

    fn read(&mut self, l: LocalId) {
        self.access(l, false);
    }

    fn write(&mut self, l: LocalId) {
        self.access(l, true);
        self.locals[l.0 as usize].writes += 1;
    }

    fn change(&mut self, l: LocalId) {
        self.access(l, false);
        let u = &mut self.locals[l.0 as usize];
        u.writes += 1;
        u.changes = true;
    }

    fn access(&mut self, l: LocalId, writes: bool) {
        let here = self.here();
        let u = &mut self.locals[l.0 as usize];
        u.collecting = false;
        if !u.touched {
            u.touched = true;
            u.home = writes.then_some(here);
        } else if u.home.is_some_and(|home| self.path.binary_search(&home).is_err()) {
            // Block numbers grow along the path, so a binary search finds them.
            u.home = None;
        }
    }
}
