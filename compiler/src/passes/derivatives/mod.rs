//! Derivatives by x and y as dual numbers (specification ch. 7.7): beside each value and local that a use of derivatives
//! depends on, two companions.
//!
//! In: folded and pruned IR with calls of `Dx` and its like. Out: IR without them, in which companions are computed where the
//! values are and stored where the locals are, so that control flow needs no care. What no use reaches gets nothing: a shader
//! without uses stays as it is. Method: Piponi, "Automatic Differentiation, C++ Templates, and Photogrammetry", 2004. Second
//! derivatives are zero, as in the reference implementation. Unneeded companions are left to pruning.
//!
//! [`reach`](self) finds what needs companions; `dual` holds arithmetic; `rules`, `geometry` and `pattern` the formulas.

mod dual;
mod geometry;
mod pattern;
mod reach;
mod rules;

use crate::builtins::{
    self, FuncId,
    derivative::{self, Derivative},
};
use crate::ir::{
    Arg, BinaryOp, Block, Const, Inst, Local, LocalId, LocalKind, Loop, Shader, Stmt, Ty, UnaryOp, Value, ValueId,
};
use crate::source::Span;
use dual::{Dual, Slope};
use reach::{Reach, SOURCES};
use std::collections::HashMap;

/// Replaces all uses of derivatives; whether there were any.
pub fn derivatives(shader: &mut Shader) -> bool {
    let mut reach = Reach::of(shader);
    if reach.uses.is_empty() {
        return false;
    }
    shader.derivative_uses = std::mem::take(&mut reach.uses);
    let mut r = Rewriter {
        old: std::mem::take(&mut shader.values),
        map: HashMap::new(),
        values: Vec::new(),
        slopes: HashMap::new(),
        companions: HashMap::new(),
        locals: std::mem::take(&mut shader.locals),
        zeros: HashMap::new(),
        out: Vec::new(),
        span: None,
        reach,
    };
    r.add_companions();
    for param in &mut shader.params {
        param.init = r.block(&param.init);
    }
    shader.body = r.block(&shader.body);
    shader.values = r.values;
    shader.locals = r.locals;
    true
}

/// An argument of a call: a number with its derivatives, or an array.
#[derive(Clone, Copy)]
enum Operand {
    Number(Dual),
    Array(LocalId),
}

struct Rewriter {
    reach: Reach,
    old: Vec<Value>,
    /// Old values to new ones.
    map: HashMap<ValueId, ValueId>,
    /// New values.
    values: Vec<Value>,
    /// Derivatives of new values.
    slopes: HashMap<ValueId, [ValueId; 2]>,
    /// Derivatives of locals.
    companions: HashMap<LocalId, [LocalId; 2]>,
    /// Locals keep their handles; companions follow behind them.
    locals: Vec<Local>,
    /// Arrays of zeros by type and length, to copy from.
    zeros: HashMap<(Ty, u32), LocalId>,
    /// The block being written.
    out: Vec<Stmt>,
    /// Of the old value whose companions are being written.
    span: Option<Span>,
}

impl Rewriter {
    fn add_companions(&mut self) {
        for i in 0..self.reach.locals.len() {
            if !self.reach.locals[i] {
                continue;
            }
            let local = self.locals[i].clone();
            let source = SOURCES.iter().find(|(g, _)| local.kind == LocalKind::Global(*g));
            let pair = [0, 1].map(|k| {
                let (kind, name) = match source {
                    Some((_, derivatives)) => (LocalKind::Global(derivatives[k]), derivatives[k].name().to_owned()),
                    None => (LocalKind::Variable, format!("{}.d{}", local.name, ["x", "y"][k])),
                };
                self.locals.push(Local { name, kind, ..local.clone() });
                LocalId(self.locals.len() as u32 - 1)
            });
            self.companions.insert(LocalId(i as u32), pair);
        }
    }

    /// Computes a value here.
    fn value(&mut self, inst: Inst, ty: Ty) -> ValueId {
        let id = ValueId(self.values.len() as u32);
        let span = self.span.unwrap_or(Span { file: crate::source::FileId(0), start: 0, end: 0 });
        self.values.push(Value { inst, ty, span });
        self.out.push(Stmt::Let(id));
        id
    }

    fn ty(&self, v: ValueId) -> Ty {
        self.values[v.0 as usize].ty
    }

    /// The new value that stands for an old one.
    fn renamed(&self, old: ValueId) -> ValueId {
        // Values are computed before they are used: the verifier saw to that.
        self.map.get(&old).copied().unwrap_or(old)
    }

    fn dual(&self, v: ValueId) -> Dual {
        Dual { v, d: self.slopes.get(&v).copied() }
    }

    fn block(&mut self, block: &Block) -> Block {
        let around = std::mem::take(&mut self.out);
        for stmt in &block.stmts {
            self.stmt(stmt);
        }
        Block { stmts: std::mem::replace(&mut self.out, around) }
    }

    fn stmt(&mut self, stmt: &Stmt) {
        match stmt {
            Stmt::Let(v) => self.define(*v),
            Stmt::Store(l, v) => {
                let v = self.renamed(*v);
                self.out.push(Stmt::Store(*l, v));
                for (to, d) in self.pairs(*l, v) {
                    self.out.push(Stmt::Store(to, d));
                }
            }
            Stmt::StoreElem(l, i, v) => {
                let (i, v) = (self.renamed(*i), self.renamed(*v));
                self.out.push(Stmt::StoreElem(*l, i, v));
                for (to, d) in self.pairs(*l, v) {
                    self.out.push(Stmt::StoreElem(to, i, d));
                }
            }
            Stmt::CopyArray(to, from) => {
                self.out.push(Stmt::CopyArray(*to, *from));
                if let Some(to) = self.companions.get(to).copied() {
                    let from = self.companion_arrays(*from);
                    for (to, from) in to.into_iter().zip(from) {
                        self.out.push(Stmt::CopyArray(to, from));
                    }
                }
            }
            Stmt::Call { func, args, outputs, result, span } => self.call(*func, args, outputs, *result, *span),
            Stmt::If(cond, a, b) => {
                let cond = self.renamed(*cond);
                let (a, b) = (self.block(a), self.block(b));
                self.out.push(Stmt::If(cond, a, b));
            }
            Stmt::Loop(l) => {
                // In order of execution: a value must be met before its uses.
                let (head, body);
                if l.tested_after {
                    body = self.block(&l.body);
                    head = self.block(&l.head);
                } else {
                    head = self.block(&l.head);
                    body = self.block(&l.body);
                }
                let step = self.block(&l.step);
                let cond = self.renamed(l.cond);
                self.out.push(Stmt::Loop(Box::new(Loop { head, cond, tested_after: l.tested_after, body, step })));
            }
            Stmt::Break | Stmt::Continue => self.out.push(stmt.clone()),
        }
    }

    /// The companions of a local with what to store there beside a value.
    fn pairs(&mut self, local: LocalId, v: ValueId) -> Vec<(LocalId, ValueId)> {
        let Some(to) = self.companions.get(&local).copied() else { return Vec::new() };
        let d = self.slope_or_zero(self.dual(v).d, self.ty(v));
        to.into_iter().zip(d).collect()
    }

    /// The companions of an array; arrays of zeros when it has none.
    fn companion_arrays(&mut self, array: LocalId) -> [LocalId; 2] {
        if let Some(pair) = self.companions.get(&array) {
            return *pair;
        }
        let Local { ty, len, .. } = self.locals[array.0 as usize];
        let locals = &mut self.locals;
        let zero = *self.zeros.entry((ty, len.unwrap_or(1))).or_insert_with(|| {
            locals.push(Local { name: "zeros".to_owned(), ty, len, kind: LocalKind::Variable });
            LocalId(locals.len() as u32 - 1)
        });
        [zero, zero]
    }

    /// Writes a value and, if it is reached, its companions.
    fn define(&mut self, old: ValueId) {
        let Value { mut inst, ty, span } = self.old[old.0 as usize].clone();
        self.span = Some(span);
        inst.operands_mut(&mut |v| *v = self.renamed(*v));
        if let Inst::Call(func, args) = &inst
            && derivative::is_operator(builtins::row(*func).name)
        {
            let operand = match args.first() {
                Some(Arg::Value(v)) => self.dual(*v),
                _ => self.constant(0.0, ty),
            };
            let value = self.operator(builtins::row(*func).name, operand, ty);
            self.map.insert(old, value);
            return;
        }
        let id = self.value(inst.clone(), ty);
        self.map.insert(old, id);
        if self.reach.values[old.0 as usize] {
            let Dual { v, d } = self.derive(&inst, id);
            self.map.insert(old, v);
            if let Some(d) = d {
                self.slopes.insert(v, d);
            }
        }
    }

    /// What stands in the place of `Dx(x)` and its like (specification ch. 7.7).
    fn operator(&mut self, name: &str, x: Dual, ty: Ty) -> ValueId {
        let Some([dx, dy]) = x.d.filter(|_| name != "Dz") else {
            // In z nothing changes but in volumes.
            return self.constant(0.0, ty).v;
        };
        match name {
            "Dx" => dx,
            "Dy" => dy,
            "filterwidth" => {
                let (a, b) = (self.binary(BinaryOp::Mul, dx, dx), self.binary(BinaryOp::Mul, dy, dy));
                let sum = self.binary(BinaryOp::Add, a, b);
                self.plain("sqrt", &[sum], ty)
            }
            "area" => {
                let normal = self.plain("cross", &[dx, dy], Ty::Triple);
                self.plain("length", &[normal], ty)
            }
            // calculatenormal
            _ => {
                let normal = self.plain("cross", &[dx, dy], Ty::Triple);
                let turned = self.value(Inst::Unary(UnaryOp::Neg, normal), Ty::Triple);
                let flip = self.plain("flip_handedness", &[], Ty::Int);
                self.value(Inst::Select(flip, turned, normal), ty)
            }
        }
    }

    /// A value with its derivatives. It may be another value than the one given: see `pow`.
    fn derive(&mut self, inst: &Inst, v: ValueId) -> Dual {
        let of = |r: &Self, v: &ValueId| r.dual(*v);
        let ty = self.ty(v);
        let d = match inst {
            Inst::Load(l) => self.load(*l, ty, Inst::Load),
            Inst::LoadElem(l, i) => self.load(*l, ty, |l| Inst::LoadElem(l, *i)),
            Inst::Unary(UnaryOp::Neg, a) => self.neg_slope(of(self, a).d),
            Inst::Binary(op, a, b) => {
                let (a, b) = (of(self, a), of(self, b));
                self.arithmetic(*op, a, b, v)
            }
            Inst::Convert(a) => of(self, a).d.map(|d| d.map(|d| self.value(Inst::Convert(d), ty))),
            Inst::Triple(parts) => {
                let parts = parts.map(|p| self.dual(p));
                self.gather(parts)
            }
            Inst::Component(a, i) => of(self, a).d.map(|d| d.map(|d| self.value(Inst::Component(d, *i), Ty::Float))),
            Inst::WithComponent(a, i, x) => {
                let (a, x) = (of(self, a), of(self, x));
                self.zip_slopes((a.d, ty), (x.d, Ty::Float), |r, a, x| r.value(Inst::WithComponent(a, *i, x), ty))
            }
            Inst::Select(cond, a, b) => {
                let (a, b) = (of(self, a), of(self, b));
                self.pick_slope(*cond, a.d, b.d, ty)
            }
            Inst::Call(func, args) => {
                let name = builtins::row(*func).name;
                let args = self.operands(args);
                return self.rule(name, v, &args);
            }
            _ => None,
        };
        Dual { v, d }
    }

    fn operands(&self, args: &[Arg]) -> Vec<Operand> {
        let one = |a: &Arg| match a {
            Arg::Value(v) => Operand::Number(self.dual(*v)),
            Arg::Array(l) => Operand::Array(*l),
        };
        args.iter().map(one).collect()
    }

    fn load(&mut self, local: LocalId, ty: Ty, inst: impl Fn(LocalId) -> Inst) -> Slope {
        let pair = self.companions.get(&local).copied()?;
        Some(pair.map(|l| self.value(inst(l), ty)))
    }

    /// A call with outputs: their companions follow it.
    fn call(&mut self, func: FuncId, args: &[Arg], outputs: &[LocalId], result: Option<LocalId>, span: Span) {
        self.span = Some(span);
        let args: Vec<Arg> = args
            .iter()
            .map(|a| match a {
                Arg::Value(v) => Arg::Value(self.renamed(*v)),
                array => *array,
            })
            .collect();
        let name = builtins::row(func).name;
        let operands = self.operands(&args);
        self.out.push(Stmt::Call { func, args, outputs: outputs.to_vec(), result, span });
        let ruled = derivative::of(name) == Some(Derivative::Rule);
        let slopes = if ruled { self.output_rule(name, &operands) } else { Vec::new() };
        for (i, local) in outputs.iter().chain(&result).enumerate() {
            let Some(to) = self.companions.get(local).copied() else { continue };
            let Local { ty, len, .. } = self.locals[local.0 as usize];
            if len.is_some() {
                let from = self.zero_arrays(*local);
                to.into_iter().zip(from).for_each(|(to, from)| self.out.push(Stmt::CopyArray(to, from)));
                continue;
            }
            let d = self.slope_or_zero(slopes.get(i).copied().flatten(), ty);
            to.into_iter().zip(d).for_each(|(to, d)| self.out.push(Stmt::Store(to, d)));
        }
    }

    fn zero_arrays(&mut self, like: LocalId) -> [LocalId; 2] {
        let kept = self.companions.remove(&like);
        let zeros = self.companion_arrays(like);
        if let Some(pair) = kept {
            self.companions.insert(like, pair);
        }
        zeros
    }

    fn constant(&mut self, c: f64, ty: Ty) -> Dual {
        let c = if ty == Ty::Triple { Const::Triple([c; 3]) } else { Const::Float(c) };
        let v = self.value(Inst::Const(c), ty);
        Dual { v, d: None }
    }
}
