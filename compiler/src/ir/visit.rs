//! Walks over the IR: operands of instructions, statements of nested blocks.

use super::{Arg, Block, Inst, LocalId, Shader, Stmt, ValueId};

impl Inst {
    /// Calls `f` on every operand, in order.
    pub fn operands(&self, f: &mut dyn FnMut(ValueId)) {
        // The closure form only reads; a copy keeps one list of cases.
        self.clone().operands_mut(&mut |v| f(*v));
    }

    /// Calls `f` on every operand for rewriting, in order.
    pub fn operands_mut(&mut self, f: &mut dyn FnMut(&mut ValueId)) {
        match self {
            Inst::Const(_) | Inst::Load(_) | Inst::NullClosure => {}
            Inst::LoadElem(_, a) | Inst::Unary(_, a) | Inst::Convert(a) | Inst::ClosureIsSet(a) => f(a),
            Inst::Binary(_, a, b)
            | Inst::Component(a, b)
            | Inst::AddClosure(a, b)
            | Inst::ScaleClosure(a, b)
            | Inst::Layer(a, b) => {
                f(a);
                f(b);
            }
            Inst::Triple(parts) => parts.iter_mut().for_each(f),
            Inst::Matrix(parts) => parts.iter_mut().for_each(f),
            Inst::MatrixElement(a, b, c) | Inst::WithComponent(a, b, c) | Inst::Select(a, b, c) => {
                f(a);
                f(b);
                f(c);
            }
            Inst::WithMatrixElement(a, b, c, d) => {
                f(a);
                f(b);
                f(c);
                f(d);
            }
            Inst::Call(_, args) => args.iter_mut().for_each(|a| {
                if let Arg::Value(v) = a {
                    f(v);
                }
            }),
            Inst::Closure(_, args) | Inst::Albedo(_, args) => args.iter_mut().for_each(f),
        }
    }

    /// Calls `f` on every local that the instruction reads.
    pub fn locals(&self, f: &mut dyn FnMut(LocalId)) {
        match self {
            Inst::Load(l) | Inst::LoadElem(l, _) => f(*l),
            Inst::Call(_, args) => args.iter().for_each(|a| {
                if let Arg::Array(l) = a {
                    f(*l);
                }
            }),
            _ => {}
        }
    }
}

impl Stmt {
    /// Calls `f` on the blocks inside, in order of execution.
    pub fn blocks(&self, f: &mut dyn FnMut(&Block)) {
        match self {
            Stmt::If(_, a, b) => {
                f(a);
                f(b);
            }
            Stmt::Loop(l) => {
                f(&l.head);
                f(&l.body);
                f(&l.step);
            }
            _ => {}
        }
    }

    /// Calls `f` on the blocks inside for rewriting, in the same order.
    pub fn blocks_mut(&mut self, f: &mut dyn FnMut(&mut Block)) {
        match self {
            Stmt::If(_, a, b) => [a, b].into_iter().for_each(f),
            Stmt::Loop(l) => [&mut l.head, &mut l.body, &mut l.step].into_iter().for_each(f),
            _ => {}
        }
    }

    /// Calls `f` on every local that the statement itself (not those inside it) may change.
    pub fn written(&self, f: &mut dyn FnMut(LocalId)) {
        match self {
            Stmt::Store(l, _) | Stmt::StoreElem(l, _, _) | Stmt::CopyArray(l, _) => f(*l),
            Stmt::Call { outputs, result, .. } => {
                outputs.iter().for_each(|l| f(*l));
                result.iter().for_each(|l| f(*l));
            }
            _ => {}
        }
    }
}

impl Block {
    /// Calls `f` on every statement, outer before inner.
    pub fn walk(&self, f: &mut dyn FnMut(&Stmt)) {
        for stmt in &self.stmts {
            f(stmt);
            stmt.blocks(&mut |b| b.walk(f));
        }
    }
}

impl Shader {
    /// The blocks in order of execution: each parameter's init, then the body.
    pub fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.params.iter().map(|p| &p.init).chain([&self.body])
    }
}
