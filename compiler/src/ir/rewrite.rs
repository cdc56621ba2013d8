//! What passes rewrite with: new values and locals, statements replaced one by one, handles renamed.

use super::{Arg, Block, Const, Inst, Local, LocalId, LocalKind, Shader, Stmt, Ty, Value, ValueId};
use crate::source::Span;

impl Shader {
    /// A new value, computed at the end of `out`.
    pub fn emit(&mut self, inst: Inst, ty: Ty, span: Span, out: &mut Block) -> ValueId {
        let id = ValueId(self.values.len() as u32);
        self.values.push(Value { inst, ty, span });
        out.stmts.push(Stmt::Let(id));
        id
    }

    /// A constant at the end of `out`.
    pub fn emit_constant(&mut self, c: Const, span: Span, out: &mut Block) -> ValueId {
        let ty = c.ty().unwrap_or(Ty::Int);
        self.emit(Inst::Const(c), ty, span, out)
    }

    /// A new variable; an array with `len`.
    pub fn add_variable(&mut self, name: String, ty: Ty, len: Option<u32>) -> LocalId {
        self.locals.push(Local { name, ty, len, kind: LocalKind::Variable });
        LocalId(self.locals.len() as u32 - 1)
    }
}

/// A pass that puts something in the place of each statement.
pub trait Rewriter {
    /// What is rewritten.
    fn shader(&mut self) -> &mut Shader;

    /// Puts at the end of `out` what stands for a statement. The blocks inside it are rewritten already.
    fn stmt(&mut self, stmt: Stmt, out: &mut Block);

    /// Rewrites the shader in order of execution.
    fn rewrite(&mut self) {
        for i in 0..self.shader().params.len() {
            let init = std::mem::take(&mut self.shader().params[i].init);
            let init = self.block(init);
            self.shader().params[i].init = init;
        }
        let body = std::mem::take(&mut self.shader().body);
        let body = self.block(body);
        self.shader().body = body;
    }

    /// Rewrites a block. The head of a loop that is tested after its body comes after it, as it runs.
    fn block(&mut self, block: Block) -> Block {
        let mut out = Block { stmts: Vec::with_capacity(block.stmts.len()) };
        for stmt in block.stmts {
            let stmt = match stmt {
                Stmt::If(cond, a, b) => {
                    let a = self.block(a);
                    Stmt::If(cond, a, self.block(b))
                }
                Stmt::Loop(mut l) => {
                    if l.tested_after {
                        l.body = self.block(l.body);
                        l.head = self.block(l.head);
                    } else {
                        l.head = self.block(l.head);
                        l.body = self.block(l.body);
                    }
                    l.step = self.block(l.step);
                    Stmt::Loop(l)
                }
                other => other,
            };
            self.stmt(stmt, &mut out);
        }
        out
    }
}

impl Inst {
    /// Renames operands and locals.
    pub fn rename(&mut self, local: &dyn Fn(&mut LocalId), value: &dyn Fn(&mut ValueId)) {
        self.operands_mut(&mut |v| value(v));
        match self {
            Inst::Load(l) | Inst::LoadElem(l, _) => local(l),
            Inst::Call(_, args) => args.iter_mut().for_each(|arg| {
                if let Arg::Array(l) = arg {
                    local(l);
                }
            }),
            _ => {}
        }
    }
}

impl Block {
    /// Renames the handles of the block and of those inside it.
    pub fn rename(&mut self, local: &dyn Fn(&mut LocalId), value: &dyn Fn(&mut ValueId)) {
        for stmt in &mut self.stmts {
            match stmt {
                Stmt::Let(v) => value(v),
                Stmt::Store(l, v) => {
                    local(l);
                    value(v);
                }
                Stmt::StoreElem(l, i, v) => {
                    local(l);
                    value(i);
                    value(v);
                }
                Stmt::CopyArray(a, b) => {
                    local(a);
                    local(b);
                }
                Stmt::Call { args, outputs, result, .. } => {
                    for arg in args {
                        match arg {
                            Arg::Value(v) => value(v),
                            Arg::Array(l) => local(l),
                        }
                    }
                    outputs.iter_mut().chain(result).for_each(local);
                }
                Stmt::If(cond, ..) => value(cond),
                Stmt::Loop(l) => value(&mut l.cond),
                Stmt::Break | Stmt::Continue => {}
            }
            stmt.blocks_mut(&mut |b| b.rename(local, value));
        }
    }
}
