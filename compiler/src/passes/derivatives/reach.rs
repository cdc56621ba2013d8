//! What needs derivatives: the values and locals that a use of derivatives depends on, as far as they can differ from zero.
//!
//! In: a shader. Out: [`Reach`]. Nodes are values and locals of floats and triples; an edge leads from what contributes to a
//! derivative to what has it. Backward from the uses, forward from the globals that have derivatives; the order of
//! statements does not count. It must not know formulas.

use crate::builtins::{
    self,
    derivative::{self, Derivative},
};
use crate::ir::{Arg, BinaryOp, Global, Inst, LocalId, LocalKind, Shader, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;

/// The globals that have derivatives, as in the reference's ShaderGlobals, and theirs by x and y.
pub(super) const SOURCES: [(Global, [Global; 2]); 5] = [
    (Global::P, [Global::DPdx, Global::DPdy]),
    (Global::I, [Global::DIdx, Global::DIdy]),
    (Global::Ps, [Global::DPsdx, Global::DPsdy]),
    (Global::U, [Global::DUdx, Global::DUdy]),
    (Global::V, [Global::DVdx, Global::DVdy]),
];

/// The findings.
#[derive(Default)]
pub(super) struct Reach {
    /// By value: has companions.
    pub values: Vec<bool>,
    /// By local.
    pub locals: Vec<bool>,
    /// The calls that use derivatives, be they zero.
    pub uses: Vec<Span>,
}

/// A value or a local.
#[derive(Clone, Copy)]
enum Node {
    Value(ValueId),
    Local(LocalId),
}

struct Graph<'a> {
    shader: &'a Shader,
    /// By node: to what it contributes.
    forward: Vec<Vec<u32>>,
    /// By node: what contributes to it.
    backward: Vec<Vec<u32>>,
    /// What uses take derivatives of.
    roots: Vec<u32>,
    uses: Vec<Span>,
}

impl Reach {
    /// Looks at the whole shader.
    pub(super) fn of(shader: &Shader) -> Reach {
        let nodes = shader.values.len() + shader.locals.len();
        let mut graph = Graph {
            shader,
            forward: vec![Vec::new(); nodes],
            backward: vec![Vec::new(); nodes],
            roots: Vec::new(),
            uses: Vec::new(),
        };
        for block in shader.blocks() {
            block.walk(&mut |s| graph.stmt(s));
        }
        if graph.uses.is_empty() {
            return Reach::default();
        }
        let is_source = |l: &crate::ir::Local| SOURCES.iter().any(|(g, _)| l.kind == LocalKind::Global(*g));
        let sources = shader.locals.iter().enumerate().filter(|(_, l)| is_source(l));
        let sources = sources.map(|(i, _)| (shader.values.len() + i) as u32).collect();
        let active = flood(&graph.forward, sources);
        let needed = flood(&graph.backward, std::mem::take(&mut graph.roots));
        let mut values: Vec<bool> = active.iter().zip(&needed).map(|(a, b)| *a && *b).collect();
        let locals = values.split_off(shader.values.len());
        Reach { values, locals, uses: graph.uses }
    }
}

fn flood(edges: &[Vec<u32>], mut open: Vec<u32>) -> Vec<bool> {
    let mut met = vec![false; edges.len()];
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut met[node as usize], true) {
            open.extend(&edges[node as usize]);
        }
    }
    met
}

impl Graph<'_> {
    /// The number of a node that can have derivatives.
    fn number(&self, node: Node) -> Option<u32> {
        let (ty, number) = match node {
            Node::Value(v) => (self.shader.values[v.0 as usize].ty, v.0),
            Node::Local(l) => (self.shader.locals[l.0 as usize].ty, self.shader.values.len() as u32 + l.0),
        };
        matches!(ty, Ty::Float | Ty::Triple).then_some(number)
    }

    fn edge(&mut self, from: Node, to: Node) {
        if let (Some(from), Some(to)) = (self.number(from), self.number(to)) {
            self.forward[from as usize].push(to);
            self.backward[to as usize].push(from);
        }
    }

    fn root(&mut self, arg: &Arg) {
        let number = self.number(node(arg));
        self.roots.extend(number);
    }

    /// Notes the arguments whose derivatives the call reads.
    fn call(&mut self, func: builtins::FuncId, args: &[Arg], span: Span) {
        if derivative::is_operator(builtins::row(func).name) {
            self.uses.push(span);
            args.iter().take(1).for_each(|a| self.root(a));
        }
    }

    fn stmt(&mut self, stmt: &Stmt) {
        match stmt {
            Stmt::Let(v) => {
                let shader = self.shader;
                let inst = &shader.values[v.0 as usize].inst;
                contributors(inst, &mut |n| self.edge(n, Node::Value(*v)));
                if let Inst::Call(func, args) = inst {
                    self.call(*func, args, shader.values[v.0 as usize].span);
                }
            }
            Stmt::Store(l, v) | Stmt::StoreElem(l, _, v) => self.edge(Node::Value(*v), Node::Local(*l)),
            Stmt::CopyArray(to, from) => self.edge(Node::Local(*from), Node::Local(*to)),
            Stmt::Call { func, args, outputs, span, .. } => {
                self.call(*func, args, *span);
                if derivative::of(builtins::row(*func).name) == Some(Derivative::Rule) {
                    for output in outputs {
                        args.iter().for_each(|a| self.edge(node(a), Node::Local(*output)));
                    }
                }
            }
            _ => {}
        }
    }
}

fn node(arg: &Arg) -> Node {
    match arg {
        Arg::Value(v) => Node::Value(*v),
        Arg::Array(l) => Node::Local(*l),
    }
}

/// Calls `f` on what an instruction's derivative is made of.
fn contributors(inst: &Inst, f: &mut dyn FnMut(Node)) {
    match inst {
        Inst::Load(l) | Inst::LoadElem(l, _) => f(Node::Local(*l)),
        Inst::Unary(UnaryOp::Neg, a) | Inst::Convert(a) | Inst::Component(a, _) => f(Node::Value(*a)),
        Inst::Binary(BinaryOp::Add | BinaryOp::Sub | BinaryOp::Mul | BinaryOp::Div, a, b)
        | Inst::WithComponent(a, _, b)
        | Inst::Select(_, a, b) => {
            f(Node::Value(*a));
            f(Node::Value(*b));
        }
        Inst::Triple(parts) => parts.iter().for_each(|p| f(Node::Value(*p))),
        Inst::Call(func, args) if derivative::of(builtins::row(*func).name) == Some(Derivative::Rule) => {
            args.iter().for_each(|a| f(node(a)));
        }
        // Numbers out of matrices have none, as in the reference implementation.
        _ => {}
    }
}
