//! Checks that a shader obeys the rules of [`super`]: types of operands, visibility of values, jumps inside loops, calls
//! that fit the table of built-ins.

use super::{Arg, BinaryOp, Block, Inst, LocalId, LocalKind, Shader, Stmt, Ty, UnaryOp, ValueId};
use crate::builtins::{self, ClosureRole, sig};
use crate::types::Base;

/// The first rule that is broken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("invalid IR in shader `{shader}`: {rule}")]
pub struct VerifyError {
    /// The shader's name.
    pub shader: String,
    /// What is wrong, with the handle.
    pub rule: String,
}

/// Verifies a whole shader.
pub fn verify(shader: &Shader) -> Result<(), VerifyError> {
    let mut v = Verifier { shader, visible: vec![false; shader.values.len()], loops: 0 };
    v.run().map_err(|rule| VerifyError { shader: shader.name.clone(), rule })
}

struct Verifier<'a> {
    shader: &'a Shader,
    visible: Vec<bool>,
    loops: u32,
}

type Rule = Result<(), String>;

fn ensure(condition: bool, message: impl FnOnce() -> String) -> Rule {
    if condition { Ok(()) } else { Err(message()) }
}

/// The IR type of a formal of the tables.
fn formal_ty(base: Base) -> Option<Ty> {
    Some(match base {
        Base::Int => Ty::Int,
        Base::Float => Ty::Float,
        Base::Color | Base::Point | Base::Vector | Base::Normal => Ty::Triple,
        Base::Matrix => Ty::Matrix,
        Base::String => Ty::Str,
        Base::Closure => Ty::Closure,
        Base::Void | Base::Struct(_) => return None,
    })
}

impl Verifier<'_> {
    fn run(&mut self) -> Rule {
        for (i, param) in self.shader.params.iter().enumerate() {
            let local = self.local(param.local)?;
            ensure(local.kind == LocalKind::Param(i as u32), || format!("param {i}: its local is not its own"))?;
        }
        for (i, local) in self.shader.locals.iter().enumerate() {
            if let LocalKind::Input(n) = local.kind {
                let input = self.shader.inputs.get(n as usize);
                let fits = input.is_some_and(|input| (input.ty, input.len) == (local.ty, local.len));
                ensure(fits, || format!("L{i}: there is no such input"))?;
            }
        }
        for param in &self.shader.params {
            self.block(&param.init)?;
        }
        self.block(&self.shader.body)?;
        for slot in &self.shader.slots {
            let weight = self.local(slot.weight)?;
            ensure(weight.ty == Ty::Triple && weight.len.is_none(), || "a slot's weight is no triple".into())?;
            let formals = sig::closure_arity(slot.closure);
            ensure(slot.args.len() == formals, || format!("a slot has {} arguments, not {formals}", slot.args.len()))?;
        }
        Ok(())
    }

    fn local(&self, id: LocalId) -> Result<&super::Local, String> {
        self.shader.locals.get(id.0 as usize).ok_or_else(|| format!("there is no local L{}", id.0))
    }

    fn single(&self, id: LocalId) -> Result<Ty, String> {
        let local = self.local(id)?;
        ensure(local.len.is_none(), || format!("L{} is an array", id.0))?;
        Ok(local.ty)
    }

    fn array(&self, id: LocalId) -> Result<Ty, String> {
        let local = self.local(id)?;
        ensure(local.len.is_some(), || format!("L{} is no array", id.0))?;
        Ok(local.ty)
    }

    /// The type of a value that is visible here.
    fn ty(&self, id: ValueId) -> Result<Ty, String> {
        let seen = self.visible.get(id.0 as usize).copied().unwrap_or(false);
        ensure(seen, || format!("%{} is used where it is not visible", id.0))?;
        Ok(self.shader.values[id.0 as usize].ty)
    }

    fn expect(&self, id: ValueId, ty: Ty) -> Rule {
        let found = self.ty(id)?;
        ensure(found == ty, || format!("%{} is {found:?}, not {ty:?}", id.0))
    }

    /// Values of a block are visible to its end.
    fn block(&mut self, block: &Block) -> Rule {
        let mut mine = Vec::new();
        for stmt in &block.stmts {
            self.stmt(stmt, &mut mine)?;
        }
        for id in mine {
            self.visible[id] = false;
        }
        Ok(())
    }

    fn stmt(&mut self, stmt: &Stmt, mine: &mut Vec<usize>) -> Rule {
        match stmt {
            Stmt::Let(id) => {
                let value = self.shader.values.get(id.0 as usize).ok_or_else(|| format!("there is no %{}", id.0))?;
                ensure(!self.visible[id.0 as usize], || format!("%{} is computed twice", id.0))?;
                let ty = self.inst(&value.inst, value.ty).map_err(|e| format!("%{}: {e}", id.0))?;
                ensure(ty == value.ty, || format!("%{} is declared {:?} but computes {ty:?}", id.0, value.ty))?;
                self.visible[id.0 as usize] = true;
                mine.push(id.0 as usize);
                Ok(())
            }
            Stmt::Store(local, value) => self.expect(*value, self.single(*local)?),
            Stmt::StoreElem(local, index, value) => {
                self.expect(*index, Ty::Int)?;
                self.expect(*value, self.array(*local)?)
            }
            Stmt::CopyArray(a, b) => {
                ensure(self.array(*a)? == self.array(*b)?, || format!("L{} and L{} differ in type", a.0, b.0))
            }
            Stmt::Call { func, args, outputs, result, .. } => {
                let wanted = result.map(|l| self.single(l)).transpose()?;
                let ret = self.call(*func, args, outputs, wanted)?;
                match (result, ret) {
                    (Some(local), Some(ty)) => {
                        ensure(self.single(*local)? == ty, || format!("L{} does not fit the result", local.0))
                    }
                    (Some(_), None) => Err("a call without result stores one".into()),
                    (None, _) => Ok(()),
                }
            }
            Stmt::If(cond, a, b) => {
                self.expect(*cond, Ty::Int)?;
                self.block(a)?;
                self.block(b)
            }
            Stmt::Loop(l) => {
                // The condition is computed in the head and must be visible at its end only.
                let mut mine = Vec::new();
                self.loops += 1;
                for stmt in &l.head.stmts {
                    self.stmt(stmt, &mut mine)?;
                }
                self.expect(l.cond, Ty::Int)?;
                if l.tested_after {
                    mine.drain(..).for_each(|id| self.visible[id] = false);
                }
                self.block(&l.body)?;
                let jumps = std::mem::replace(&mut self.loops, 0);
                self.block(&l.step)?;
                self.loops = jumps - 1;
                mine.into_iter().for_each(|id| self.visible[id] = false);
                Ok(())
            }
            Stmt::Break | Stmt::Continue => ensure(self.loops > 0, || "a jump outside of loops".into()),
        }
    }

    fn inst(&self, inst: &Inst, declared: Ty) -> Result<Ty, String> {
        match inst {
            Inst::Const(c) => match c {
                super::Const::Array(_) => Err("an array is no value".into()),
                _ => c.ty().ok_or_else(|| "a constant without type".into()),
            },
            Inst::Load(l) => self.single(*l),
            Inst::LoadElem(l, i) => {
                self.expect(*i, Ty::Int)?;
                self.array(*l)
            }
            Inst::Unary(op, a) => {
                let ty = self.ty(*a)?;
                let fits = match op {
                    UnaryOp::Neg => matches!(ty, Ty::Int | Ty::Float | Ty::Triple | Ty::Matrix),
                    UnaryOp::Compl | UnaryOp::Not => ty == Ty::Int,
                };
                ensure(fits, || format!("{op:?} does not take {ty:?}"))?;
                Ok(ty)
            }
            Inst::Binary(op, a, b) => self.binary(*op, self.ty(*a)?, self.ty(*b)?),
            Inst::Convert(a) => {
                let from = self.ty(*a)?;
                ensure(Inst::convertible(from, declared), || format!("no conversion {from:?} to {declared:?}"))?;
                Ok(declared)
            }
            Inst::Triple(parts) => {
                parts.iter().try_for_each(|p| self.expect(*p, Ty::Float))?;
                Ok(Ty::Triple)
            }
            Inst::Matrix(parts) => {
                parts.iter().try_for_each(|p| self.expect(*p, Ty::Float))?;
                Ok(Ty::Matrix)
            }
            Inst::Component(a, i) => {
                self.expect(*a, Ty::Triple)?;
                self.expect(*i, Ty::Int)?;
                Ok(Ty::Float)
            }
            Inst::MatrixElement(a, r, c) => {
                self.expect(*a, Ty::Matrix)?;
                self.expect(*r, Ty::Int)?;
                self.expect(*c, Ty::Int)?;
                Ok(Ty::Float)
            }
            Inst::WithComponent(a, i, x) => {
                self.expect(*a, Ty::Triple)?;
                self.expect(*i, Ty::Int)?;
                self.expect(*x, Ty::Float)?;
                Ok(Ty::Triple)
            }
            Inst::WithMatrixElement(a, r, c, x) => {
                self.expect(*a, Ty::Matrix)?;
                self.expect(*r, Ty::Int)?;
                self.expect(*c, Ty::Int)?;
                self.expect(*x, Ty::Float)?;
                Ok(Ty::Matrix)
            }
            Inst::Select(c, a, b) => {
                self.expect(*c, Ty::Int)?;
                self.expect(*b, self.ty(*a)?)?;
                self.ty(*a)
            }
            Inst::Call(func, args) => {
                self.call(*func, args, &[], Some(declared))?.ok_or_else(|| "a call for its value has none".to_string())
            }
            Inst::Closure(id, args) => {
                self.closure(*id, args)?;
                ensure(builtins::closure(*id).role != ClosureRole::Layer, || "a layer is no slot".into())?;
                if let Some(label) = args.get(sig::closure_arity(*id)) {
                    self.expect(*label, Ty::Str)?;
                    ensure(args.len() == sig::closure_arity(*id) + 1, || "arguments behind the label".into())?;
                }
                Ok(Ty::Closure)
            }
            Inst::Albedo(id, args) => {
                self.closure(*id, args)?;
                let is_lobe = matches!(builtins::closure(*id).role, ClosureRole::Lobe(_));
                ensure(is_lobe && args.len() == sig::closure_arity(*id), || "the albedo of no lobe".into())?;
                Ok(Ty::Triple)
            }
            Inst::Layer(a, b) => {
                self.expect(*a, Ty::Closure)?;
                self.expect(*b, Ty::Closure)?;
                Ok(Ty::Closure)
            }
            Inst::NullClosure => Ok(Ty::Closure),
            Inst::AddClosure(a, b) => {
                self.expect(*a, Ty::Closure)?;
                self.expect(*b, Ty::Closure)?;
                Ok(Ty::Closure)
            }
            Inst::ScaleClosure(a, x) => {
                self.expect(*a, Ty::Closure)?;
                let ty = self.ty(*x)?;
                ensure(matches!(ty, Ty::Float | Ty::Triple), || format!("a closure is scaled by {ty:?}"))?;
                Ok(Ty::Closure)
            }
            Inst::ClosureIsSet(a) => {
                self.expect(*a, Ty::Closure)?;
                Ok(Ty::Int)
            }
        }
    }

    /// The arguments of a closure or of a lobe's albedo.
    fn closure(&self, id: builtins::ClosureId, args: &[ValueId]) -> Result<(), String> {
        let formals = sig::closure_formals(id).iter().filter_map(|f| f.ty);
        let types: Vec<_> = formals.chain(sig::closure_keys(id).iter().map(|k| k.ty)).collect();
        ensure(types.len() <= args.len(), || format!("closure with {} arguments", args.len()))?;
        for (ty, arg) in types.iter().zip(args) {
            if let Some(ty) = formal_ty(ty.base) {
                self.expect(*arg, ty)?;
            }
        }
        Ok(())
    }

    fn binary(&self, op: BinaryOp, a: Ty, b: Ty) -> Result<Ty, String> {
        use BinaryOp::*;
        ensure(a == b, || format!("{op:?} of {a:?} and {b:?}"))?;
        let (fits, result) = match op {
            Add | Sub => (matches!(a, Ty::Int | Ty::Float | Ty::Triple), a),
            Mul | Div => (matches!(a, Ty::Int | Ty::Float | Ty::Triple | Ty::Matrix), a),
            Mod | BitAnd | BitOr | BitXor | Shl | Shr => (a == Ty::Int, a),
            Eq | Ne => (a != Ty::Closure, Ty::Int),
            Lt | Le | Gt | Ge => (matches!(a, Ty::Int | Ty::Float), Ty::Int),
        };
        ensure(fits, || format!("{op:?} does not take {a:?}"))?;
        Ok(result)
    }

    /// The result type of a call when some overload fits; `wanted` tells apart those that differ in the result only.
    fn call(
        &self,
        func: builtins::FuncId,
        args: &[Arg],
        outputs: &[LocalId],
        wanted: Option<Ty>,
    ) -> Result<Option<Ty>, String> {
        let mut given = Vec::new();
        for arg in args {
            given.push(match arg {
                Arg::Value(v) => (self.ty(*v)?, false),
                Arg::Array(l) => (self.array(*l)?, true),
            });
        }
        for l in outputs {
            let local = self.local(*l)?;
            given.push((local.ty, local.len.is_some()));
        }
        let row = builtins::row(func);
        let fitting = sig::overloads(func).iter().find(|o| {
            // Inputs first, then outputs: as every row is written.
            let (ins, outs): (Vec<_>, Vec<_>) = o.formals.iter().partition(|f| !f.output);
            wanted.is_none_or(|w| formal_ty(o.ret.base) == Some(w))
                && (ins.len() == args.len() || o.variadic && ins.len() < args.len())
                && outs.len() == outputs.len()
                && ins.iter().zip(&given).chain(outs.iter().zip(&given[args.len()..])).all(|(f, (ty, array))| {
                    f.ty.is_none_or(|t| formal_ty(t.base) == Some(*ty) && t.is_array() == *array)
                })
        });
        match fitting {
            Some(o) => Ok(formal_ty(o.ret.base)),
            None => Err(format!("no overload of `{}` fits {given:?}", row.name)),
        }
    }
}
