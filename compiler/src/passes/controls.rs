//! Which parameters decide about a place in a shader: what the weight of a closure call there depends on, and the conditions
//! under which a call there is reached.
//!
//! In: linked IR before anything is bound or folded, so that parameters are still there. Out: parameters, by index. The order of
//! statements does not count: what may flow, flows. It must not know what the places are asked for.

use crate::builtins;
use crate::interp::ops;
use crate::ir::{Arg, Block, Const, Inst, LocalId, LocalKind, Shader, Stmt, Ty, Value, ValueId};
use crate::source::Span;
use std::collections::HashMap;

/// Deepest default that is taken for a constant.
const MAX_DEPTH: u32 = 16;

/// Number of a node: values, then locals, then blocks.
type Node = usize;

/// What depends on what in a shader.
pub(crate) struct Controls<'a> {
    shader: &'a Shader,
    /// By node: what it depends on.
    needs: Vec<Vec<Node>>,
    /// The block that computes each value.
    block_of: HashMap<ValueId, Node>,
    /// Values that are closures.
    closures: Vec<ValueId>,
    /// Blocks with stores of closures: local, value, block.
    closure_stores: Vec<(LocalId, ValueId, Node)>,
    /// Calls that are statements.
    calls: Vec<(Span, Vec<Arg>, Node)>,
    /// By parameter: the only constant that is ever stored in it, or that other things are.
    stored: Vec<Stored>,
}

/// What is stored in a parameter's local.
#[derive(Clone, Copy, PartialEq)]
enum Stored {
    Nothing,
    Constant(ValueId),
    /// Constants in the elements of an array.
    Elements,
    Other,
}

impl<'a> Controls<'a> {
    /// Reads a shader.
    pub fn of(shader: &'a Shader) -> Controls<'a> {
        let mut out = Controls {
            shader,
            needs: vec![Vec::new(); shader.values.len() + shader.locals.len()],
            block_of: HashMap::new(),
            closures: Vec::new(),
            closure_stores: Vec::new(),
            calls: Vec::new(),
            stored: vec![Stored::Nothing; shader.params.len()],
        };
        for block in shader.blocks() {
            let top = out.node(Vec::new());
            out.block(block, top);
        }
        out
    }

    /// The parameters that decide about what is called at a place. Those that only pass on what another parameter has are not
    /// among them.
    pub fn deciding(&self, span: Span) -> Vec<usize> {
        let mut roots = Vec::new();
        self.closure_calls(span, &mut roots);
        for (value, block) in &self.block_of {
            if let Value { inst: Inst::Call(_, args), .. } = self.value(*value)
                && self.value(*value).span == span
            {
                roots.push(*block);
                self.file_of(args, &mut roots);
            }
        }
        for (_, args, block) in self.calls.iter().filter(|(s, ..)| *s == span) {
            roots.push(*block);
            self.file_of(args, &mut roots);
        }
        let mut met = vec![false; self.needs.len()];
        while let Some(node) = roots.pop() {
            if !std::mem::replace(&mut met[node], true) {
                roots.extend(&self.needs[node]);
            }
        }
        let is_met = |local: LocalId| met[self.shader.values.len() + local.0 as usize];
        let params = self.shader.params.iter().enumerate();
        params.filter(|(i, p)| is_met(p.local) && self.stored[*i] != Stored::Other).map(|(i, _)| i).collect()
    }

    /// The value of a parameter that is given one constant.
    pub fn constant(&self, param: usize) -> Option<Const> {
        match self.stored[param] {
            Stored::Constant(v) => self.constant_of(v, MAX_DEPTH),
            _ => None,
        }
    }

    /// What a value is that is made of constants alone.
    fn constant_of(&self, v: ValueId, depth: u32) -> Option<Const> {
        let value = self.value(v);
        match &value.inst {
            Inst::Const(c) => Some(c.clone()),
            Inst::Load(_) | Inst::LoadElem(..) | Inst::Call(..) => None,
            _ if depth == 0 => None,
            inst => {
                let mut parts = Vec::new();
                inst.operands(&mut |o| parts.push(self.constant_of(o, depth - 1)));
                ops::evaluate(inst, value.ty, &parts.into_iter().collect::<Option<Vec<_>>>()?)
            }
        }
    }

    /// The same shader with another constant for such a parameter.
    pub fn with(&self, param: usize, value: Const) -> Option<Shader> {
        let Stored::Constant(v) = self.stored[param] else { return None };
        // Others may read the same constant.
        let mut uses = 0;
        for needs in &self.needs {
            uses += needs.iter().filter(|n| **n == v.0 as usize).count();
        }
        if uses != 1 {
            return None;
        }
        let mut shader = self.shader.clone();
        shader.values[v.0 as usize].inst = Inst::Const(value);
        Some(shader)
    }

    fn value(&self, v: ValueId) -> &Value {
        &self.shader.values[v.0 as usize]
    }

    fn local(&self, l: LocalId) -> Node {
        self.shader.values.len() + l.0 as usize
    }

    fn node(&mut self, needs: Vec<Node>) -> Node {
        self.needs.push(needs);
        self.needs.len() - 1
    }

    fn arg(&self, arg: &Arg) -> Node {
        match arg {
            Arg::Value(v) => v.0 as usize,
            Arg::Array(l) => self.local(*l),
        }
    }

    fn block(&mut self, block: &Block, at: Node) {
        for stmt in &block.stmts {
            self.stmt(stmt, at);
        }
    }

    fn stmt(&mut self, stmt: &Stmt, at: Node) {
        match stmt {
            Stmt::Let(v) => {
                let mut needs = Vec::new();
                self.value(*v).inst.operands(&mut |o| needs.push(o.0 as usize));
                self.value(*v).inst.locals(&mut |l| needs.push(self.local(l)));
                self.needs[v.0 as usize].extend(needs);
                self.block_of.insert(*v, at);
                if self.value(*v).ty == Ty::Closure {
                    self.closures.push(*v);
                }
            }
            Stmt::Store(l, v) => {
                self.note(*l, || Stored::Constant(*v), *v);
                self.store(*l, [v.0 as usize, at]);
                if self.shader.locals[l.0 as usize].ty == Ty::Closure {
                    self.closure_stores.push((*l, *v, at));
                }
            }
            Stmt::StoreElem(l, i, v) => {
                self.note(*l, || Stored::Elements, *v);
                self.store(*l, [i.0 as usize, v.0 as usize, at]);
                if self.shader.locals[l.0 as usize].ty == Ty::Closure {
                    self.closure_stores.push((*l, *v, at));
                }
            }
            Stmt::CopyArray(to, from) => {
                self.mark(*to, Stored::Other);
                let from = self.local(*from);
                self.store(*to, [from, at]);
            }
            Stmt::Call { args, outputs, result, span, .. } => {
                let needs: Vec<Node> = args.iter().map(|a| self.arg(a)).chain([at]).collect();
                for l in outputs.iter().chain(result) {
                    self.mark(*l, Stored::Other);
                    self.store(*l, needs.iter().copied());
                }
                self.calls.push((*span, args.clone(), at));
            }
            Stmt::If(cond, a, b) => {
                let inner = self.node(vec![at, cond.0 as usize]);
                self.block(a, inner);
                self.block(b, inner);
            }
            Stmt::Loop(l) => {
                // How often it turns hangs on its condition, and on those of its jumps.
                let inner = self.node(vec![at, l.cond.0 as usize]);
                let mut jumps = Vec::new();
                jump_conditions(&l.body, &mut jumps);
                self.needs[inner].extend(jumps);
                for block in [&l.head, &l.body, &l.step] {
                    self.block(block, inner);
                }
            }
            Stmt::Break | Stmt::Continue => {}
        }
    }

    fn store(&mut self, l: LocalId, needs: impl IntoIterator<Item = Node>) {
        let node = self.local(l);
        self.needs[node].extend(needs);
    }

    fn note(&mut self, l: LocalId, what: impl Fn() -> Stored, v: ValueId) {
        let what = match &self.value(v).inst {
            _ if self.constant_of(v, MAX_DEPTH).is_some() => what(),
            // What the renderer supplies is the parameter's own value.
            Inst::Load(from) | Inst::LoadElem(from, _)
                if matches!(self.shader.locals[from.0 as usize].kind, LocalKind::Input(_)) =>
            {
                Stored::Elements
            }
            _ => Stored::Other,
        };
        self.mark(l, what);
    }

    fn mark(&mut self, l: LocalId, what: Stored) {
        let LocalKind::Param(param) = self.shader.locals[l.0 as usize].kind else { return };
        let Some(stored) = self.stored.get_mut(param as usize) else { return };
        *stored = match (*stored, what) {
            (Stored::Nothing, what) => what,
            // A default that the renderer may replace, or one of many elements.
            (Stored::Constant(_) | Stored::Elements, Stored::Constant(_) | Stored::Elements) => Stored::Elements,
            _ => Stored::Other,
        };
    }

    /// What the weights depend on of the closure calls at a place.
    fn closure_calls(&self, span: Span, roots: &mut Vec<Node>) {
        let mut open: Vec<Node> = Vec::new();
        for v in &self.closures {
            let value = self.value(*v);
            let (Inst::Closure(closure, args), Some(block)) = (&value.inst, self.block_of.get(v)) else { continue };
            if value.span != span {
                continue;
            }
            open.push(v.0 as usize);
            roots.push(*block);
            let row = builtins::closure(*closure);
            roots.extend(row.tint.and_then(|t| args.get(usize::from(t))).map(|v| v.0 as usize));
            if row.takes_film() {
                // The thickness decides about the film.
                let at = builtins::sig::closure_arity(*closure) - 2;
                roots.extend(args.get(at).map(|v| v.0 as usize));
            }
        }
        if open.is_empty() {
            return;
        }
        let mut met = vec![false; self.needs.len()];
        while let Some(node) = open.pop() {
            if std::mem::replace(&mut met[node], true) {
                continue;
            }
            for v in &self.closures {
                let is = |x: &ValueId| x.0 as usize == node;
                let side = match &self.value(*v).inst {
                    Inst::ScaleClosure(a, x) if is(a) => Some(*x),
                    Inst::AddClosure(a, b) if is(a) || is(b) => None,
                    Inst::Layer(a, b) if is(a) || is(b) => (is(b)).then_some(*a),
                    Inst::Select(c, a, b) if is(a) || is(b) => Some(*c),
                    Inst::Load(l) if self.local(*l) == node => None,
                    Inst::LoadElem(l, i) if self.local(*l) == node => Some(*i),
                    _ => continue,
                };
                roots.extend(side.map(|s| s.0 as usize));
                open.push(v.0 as usize);
            }
            for (l, ..) in self.closure_stores.iter().filter(|(_, v, _)| v.0 as usize == node) {
                open.push(self.local(*l));
            }
        }
        // A statement that only adds to what a variable has decides about what it adds.
        for (l, v, block) in &self.closure_stores {
            let mut terms = vec![*v];
            while let Some(term) = terms.pop() {
                match &self.value(term).inst {
                    Inst::AddClosure(a, b) => terms.extend([*a, *b]),
                    Inst::Load(from) if from == l => {}
                    _ if met[term.0 as usize] => roots.push(*block),
                    _ => {}
                }
            }
        }
    }

    /// The name of a file decides about a lookup.
    fn file_of(&self, args: &[Arg], roots: &mut Vec<Node>) {
        if let Some(Arg::Value(v)) = args.first()
            && self.value(*v).ty == Ty::Str
        {
            roots.push(v.0 as usize);
        }
    }
}

/// The conditions of the jumps of a loop.
fn jump_conditions(body: &Block, out: &mut Vec<Node>) {
    for stmt in &body.stmts {
        if let Stmt::If(cond, a, b) = stmt {
            let mut jumps = false;
            for block in [a, b] {
                block.walk(&mut |s| jumps |= matches!(s, Stmt::Break | Stmt::Continue));
                jump_conditions(block, out);
            }
            if jumps {
                out.push(cond.0 as usize);
            }
        }
    }
}
