//! Turns closure values into lobe slots.
//!
//! Each closure call is a slot. A closure value becomes one triple weight per slot that can be part of it, a closure local one
//! weight local per slot; sums and scales become arithmetic on the weights. The arguments of a call are stored into
//! locals where the call happens. Slots that never reach `Ci` are dropped. See docs/adr/0002. `print` shows closures term by term
//! ([`print`]).

mod print;

pub(super) use print::parts;

use crate::builtins::{self, ClosureRole, sig};
use crate::diag::Diagnostic;
use crate::ir::{
    Arg, BinaryOp, Block, Const, Global, Inst, LobeSlot, LocalId, LocalKind, Rewriter, Shader, SlotArg, Stmt, Ty,
    Value, ValueId,
};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Slots as a set of indices into the calls, in order of appearance.
type Slots = BTreeSet<u32>;

/// Rewrites all closures. Afterwards no value or used local has type `Closure`.
pub fn closures(shader: &mut Shader) -> Result<(), Vec<Diagnostic>> {
    if let Some(d) = too_many(shader) {
        return Err(vec![d]);
    }
    let mut pass = Pass {
        reach: Reach::of(shader),
        shader,
        weights: HashMap::new(),
        values: HashMap::new(),
        calls: BTreeMap::new(),
        extras: BTreeMap::new(),
        errors: Vec::new(),
    };
    if let Some(d) = pass.unsupported() {
        return Err(vec![d]);
    }
    pass.run();
    if pass.errors.is_empty() { Ok(()) } else { Err(pass.errors) }
}

/// Most closure calls of a shader: each weight of a sum is carried on its own, and this bounds the square.
const MAX_CALLS: usize = 1_000;

fn too_many(shader: &Shader) -> Option<Diagnostic> {
    let mut calls = Vec::new();
    for block in shader.blocks() {
        block.walk(&mut |s| match s {
            Stmt::Let(id) if matches!(shader.values[id.0 as usize].inst, Inst::Closure(..)) => calls.push(*id),
            _ => {}
        });
    }
    let span = shader.values[calls.get(MAX_CALLS)?.0 as usize].span;
    let message =
        format!("the shader calls closures in more than {MAX_CALLS} places once loops and functions are unfolded");
    Some(Diagnostic::error("E4005", span, message).help("sum weights first, then call the closure once"))
}

/// Which slots can be part of which value and local, whatever the flow of control.
struct Reach {
    values: HashMap<ValueId, Slots>,
    locals: HashMap<LocalId, Slots>,
}

impl Reach {
    fn of(shader: &Shader) -> Reach {
        let mut reach = Reach { values: HashMap::new(), locals: HashMap::new() };
        let mut lets = Vec::new();
        let mut stores = Vec::new();
        let mut copies = Vec::new();
        for block in shader.blocks() {
            block.walk(&mut |s| match s {
                Stmt::Let(id) if shader.values[id.0 as usize].ty == Ty::Closure => lets.push(*id),
                Stmt::Store(l, v) | Stmt::StoreElem(l, _, v) if shader.locals[l.0 as usize].ty == Ty::Closure => {
                    stores.push((*l, *v));
                }
                Stmt::CopyArray(a, b) if shader.locals[a.0 as usize].ty == Ty::Closure => copies.push((*a, *b)),
                _ => {}
            });
        }
        // Loops carry closures around: repeat until nothing grows. Sets only grow, so this ends.
        loop {
            let mut grown = false;
            for id in &lets {
                let set = reach.value(shader, *id);
                grown |= reach.values.insert(*id, set.clone()).is_none_or(|old| old != set);
            }
            for (local, value) in &stores {
                let set = reach.values.get(value).cloned().unwrap_or_default();
                let into = reach.locals.entry(*local).or_default();
                let before = into.len();
                into.extend(set);
                grown |= into.len() > before;
            }
            for (to, from) in &copies {
                let set = reach.locals.get(from).cloned().unwrap_or_default();
                let into = reach.locals.entry(*to).or_default();
                let before = into.len();
                into.extend(set);
                grown |= into.len() > before;
            }
            if !grown {
                return reach;
            }
        }
    }

    fn value(&self, shader: &Shader, id: ValueId) -> Slots {
        let get = |v: &ValueId| self.values.get(v).cloned().unwrap_or_default();
        match &shader.values[id.0 as usize].inst {
            Inst::Closure(..) => Slots::from([id.0]),
            Inst::Load(l) | Inst::LoadElem(l, _) => self.locals.get(l).cloned().unwrap_or_default(),
            Inst::ScaleClosure(a, _) => get(a),
            Inst::AddClosure(a, b) | Inst::Layer(a, b) | Inst::Select(_, a, b) => &get(a) | &get(b),
            _ => Slots::new(),
        }
    }
}

/// The weights of a closure value, by slot.
type Weights = Vec<(u32, ValueId)>;

struct Pass<'a> {
    shader: &'a mut Shader,
    reach: Reach,
    /// The weight of a slot (named by its call's value) in a closure local.
    weights: HashMap<(LocalId, u32), LocalId>,
    /// The weights of a closure value.
    values: HashMap<ValueId, Weights>,
    /// The argument locals or constants of each call.
    calls: BTreeMap<u32, LobeSlot>,
    /// What calls have beyond the arguments of their slots: labels, and all that an unknown closure prints.
    extras: BTreeMap<u32, (String, Vec<SlotArg>)>,
    errors: Vec<Diagnostic>,
}

impl Rewriter for Pass<'_> {
    fn shader(&mut self) -> &mut Shader {
        self.shader
    }

    fn stmt(&mut self, stmt: Stmt, out: &mut Block) {
        let is_closure = |shader: &Shader, l: LocalId| shader.locals[l.0 as usize].ty == Ty::Closure;
        match stmt {
            Stmt::Let(id) => self.value(id, out),
            Stmt::Store(local, value) if is_closure(self.shader, local) => self.store(local, None, value, out),
            Stmt::StoreElem(local, index, value) if is_closure(self.shader, local) => {
                self.store(local, Some(index), value, out);
            }
            Stmt::CopyArray(to, from) if is_closure(self.shader, to) => {
                // Slots that the source never has get an array of zeros to copy from: its weights are never stored.
                for slot in self.reach.locals.get(&to).cloned().unwrap_or_default() {
                    let (a, b) = (self.weight(to, slot), self.weight(from, slot));
                    out.stmts.push(Stmt::CopyArray(a, b));
                }
            }
            Stmt::Call { func, args, span, .. } if self.prints_closures(func, &args) => {
                self.print(func, &args, span, out);
            }
            other => out.stmts.push(other),
        }
    }
}

impl Pass<'_> {
    fn unsupported(&self) -> Option<Diagnostic> {
        let is_closure = |l: LocalId| self.shader.locals[l.0 as usize].ty == Ty::Closure;
        let param = self.shader.params.iter().find(|p| is_closure(p.local) && p.varying);
        param.map(|p| Diagnostic::not_yet("E4004", p.span, format!("varying closure parameter `{}`", p.name)))
    }

    fn run(&mut self) {
        self.rewrite();
        let ci = self.shader.locals.iter().position(|l| l.kind == LocalKind::Global(Global::Ci));
        let Some(ci) = ci.map(|i| LocalId(i as u32)) else { return };
        let reaching = self.reach.locals.get(&ci).cloned().unwrap_or_default();
        for slot in reaching {
            if let Some(mut lobe) = self.calls.remove(&slot) {
                lobe.weight = self.weight(ci, slot);
                self.tint(&mut lobe);
                self.shader.slots.push(lobe);
            }
        }
    }

    /// Multiplies a slot's weight by its tint, at the end of the shader.
    fn tint(&mut self, lobe: &mut LobeSlot) {
        let row = builtins::closure(lobe.closure);
        let Some(tint) = row.tint.map(usize::from) else { return };
        let mut out = std::mem::take(&mut self.shader.body);
        let span = lobe.span;
        let weight = self.shader.emit(Inst::Load(lobe.weight), Ty::Triple, span, &mut out);
        let factor = self.argument(&lobe.args[tint].clone(), span, &mut out);
        let product = self.shader.emit(Inst::Binary(BinaryOp::Mul, weight, factor), Ty::Triple, span, &mut out);
        let name = format!("{}_tinted", self.shader.locals[lobe.weight.0 as usize].name);
        let local = self.shader.add_variable(name, Ty::Triple, None);
        out.stmts.push(Stmt::Store(local, product));
        self.shader.body = out;
        lobe.weight = local;
        lobe.args[tint] = SlotArg::Const(Const::Triple([1.0; 3]));
    }

    /// An argument of a call, where it is wanted again.
    fn argument(&mut self, arg: &SlotArg, span: Span, out: &mut Block) -> ValueId {
        let (inst, ty) = match arg {
            SlotArg::Const(c) => (Inst::Const(c.clone()), c.ty().unwrap_or(Ty::Int)),
            SlotArg::Local(l) => (Inst::Load(*l), self.shader.locals[l.0 as usize].ty),
        };
        self.shader.emit(inst, ty, span, out)
    }

    /// `layer(top, base)`: what the top leaves of the light reaches the base. The top's albedo is the sum over its lobes of weight times
    /// albedo; what has no lobe (emission, holes, straight transmission, media) covers nothing.
    fn layer(&mut self, top: &[(u32, ValueId)], base: &[(u32, ValueId)], span: Span, out: &mut Block) -> Weights {
        let mut covered: Option<ValueId> = None;
        for (slot, weight) in top {
            let Some(call) = self.calls.get(slot).cloned() else { continue };
            let row = builtins::closure(call.closure);
            if !matches!(row.role, ClosureRole::Lobe(_)) {
                continue;
            }
            let args: Vec<ValueId> = call.args.iter().map(|arg| self.argument(arg, span, out)).collect();
            let tint = row.tint.map(|t| args[usize::from(t)]);
            let mut share = self.shader.emit(Inst::Albedo(call.closure, args), Ty::Triple, span, out);
            for factor in tint.into_iter().chain([*weight]) {
                share = self.shader.emit(Inst::Binary(BinaryOp::Mul, share, factor), Ty::Triple, span, out);
            }
            // A call that was not reached has weight 0, and arguments that mean nothing.
            let zero = self.shader.emit_constant(Const::Triple([0.0; 3]), span, out);
            let reached = self.shader.emit(Inst::Binary(BinaryOp::Ne, *weight, zero), Ty::Int, span, out);
            share = self.shader.emit(Inst::Select(reached, share, zero), Ty::Triple, span, out);
            covered = Some(match covered {
                Some(sum) => self.shader.emit(Inst::Binary(BinaryOp::Add, sum, share), Ty::Triple, span, out),
                None => share,
            });
        }
        let mut list = top.to_vec();
        let factor = covered.map(|covered| {
            let one = self.shader.emit_constant(Const::Triple([1.0; 3]), span, out);
            let zero = self.shader.emit_constant(Const::Triple([0.0; 3]), span, out);
            let left = self.shader.emit(Inst::Binary(BinaryOp::Sub, one, covered), Ty::Triple, span, out);
            match builtins::find("clamp") {
                Some(clamp) => {
                    let args = [left, zero, one].map(Arg::Value).to_vec();
                    self.shader.emit(Inst::Call(clamp, args), Ty::Triple, span, out)
                }
                None => left,
            }
        });
        for (slot, w) in base {
            let w = match factor {
                Some(f) => self.shader.emit(Inst::Binary(BinaryOp::Mul, *w, f), Ty::Triple, span, out),
                None => *w,
            };
            match list.iter_mut().find(|(s, _)| s == slot) {
                Some((_, sum)) => *sum = self.shader.emit(Inst::Binary(BinaryOp::Add, *sum, w), Ty::Triple, span, out),
                None => list.push((*slot, w)),
            }
        }
        list
    }

    fn weight(&mut self, local: LocalId, slot: u32) -> LocalId {
        if let Some(id) = self.weights.get(&(local, slot)) {
            return *id;
        }
        let index = self.calls.keys().position(|k| *k == slot).unwrap_or(0);
        let name = format!("{}_w{index}", self.shader.locals[local.0 as usize].name);
        let id = self.shader.add_variable(name, Ty::Triple, None);
        self.shader.locals[id.0 as usize].len = self.shader.locals[local.0 as usize].len;
        self.weights.insert((local, slot), id);
        id
    }

    /// `local = value` or `local[index] = value`: every slot that can be in the local gets its weight, zero for those not in
    /// the value.
    fn store(&mut self, local: LocalId, index: Option<ValueId>, value: ValueId, out: &mut Block) {
        let span = self.shader.values[value.0 as usize].span;
        let given = self.values.get(&value).cloned().unwrap_or_default();
        for slot in self.reach.locals.get(&local).cloned().unwrap_or_default() {
            let weight = match given.iter().find(|(s, _)| *s == slot) {
                Some((_, w)) => *w,
                None => self.shader.emit_constant(Const::Triple([0.0; 3]), span, out),
            };
            let target = self.weight(local, slot);
            out.stmts.push(match index {
                Some(index) => Stmt::StoreElem(target, index, weight),
                None => Stmt::Store(target, weight),
            });
        }
    }

    fn value(&mut self, id: ValueId, out: &mut Block) {
        let Value { inst, ty, span } = self.shader.values[id.0 as usize].clone();
        let of = |this: &Self, v: &ValueId| this.values.get(v).cloned().unwrap_or_default();
        let weights = match &inst {
            Inst::ClosureIsSet(a) => return self.is_set(id, of(self, a), span, out),
            _ if ty != Ty::Closure => {
                out.stmts.push(Stmt::Let(id));
                return;
            }
            Inst::Closure(closure, args) => {
                self.call(id, *closure, args, span, out);
                let one = self.shader.emit_constant(Const::Triple([1.0; 3]), span, out);
                vec![(id.0, one)]
            }
            Inst::Load(l) => {
                let slots = self.reach.locals.get(l).cloned().unwrap_or_default();
                let mut list = Vec::new();
                for slot in slots {
                    let local = self.weight(*l, slot);
                    list.push((slot, self.shader.emit(Inst::Load(local), Ty::Triple, span, out)));
                }
                list
            }
            Inst::LoadElem(l, index) => {
                let slots = self.reach.locals.get(l).cloned().unwrap_or_default();
                let mut list = Vec::new();
                for slot in slots {
                    let local = self.weight(*l, slot);
                    list.push((slot, self.shader.emit(Inst::LoadElem(local, *index), Ty::Triple, span, out)));
                }
                list
            }
            Inst::ScaleClosure(a, x) => {
                let mut factor = *x;
                if self.shader.values[x.0 as usize].ty == Ty::Float {
                    factor = self.shader.emit(Inst::Convert(factor), Ty::Triple, span, out);
                }
                let mut list = of(self, a);
                for (_, w) in &mut list {
                    *w = self.shader.emit(Inst::Binary(BinaryOp::Mul, *w, factor), Ty::Triple, span, out);
                }
                list
            }
            Inst::AddClosure(a, b) => {
                let mut list = of(self, a);
                for (slot, w) in of(self, b) {
                    match list.iter_mut().find(|(s, _)| *s == slot) {
                        Some((_, sum)) => {
                            *sum = self.shader.emit(Inst::Binary(BinaryOp::Add, *sum, w), Ty::Triple, span, out)
                        }
                        None => list.push((slot, w)),
                    }
                }
                list
            }
            Inst::Layer(a, b) => {
                let (top, base) = (of(self, a), of(self, b));
                self.layer(&top, &base, span, out)
            }
            Inst::Select(c, a, b) => {
                let (a, b) = (of(self, a), of(self, b));
                let slots: Slots = a.iter().chain(&b).map(|(s, _)| *s).collect();
                let zero = self.shader.emit_constant(Const::Triple([0.0; 3]), span, out);
                let find =
                    |list: &[(u32, ValueId)], slot| list.iter().find(|(s, _)| *s == slot).map_or(zero, |(_, w)| *w);
                let mut list = Vec::new();
                for slot in slots {
                    let inst = Inst::Select(*c, find(&a, slot), find(&b, slot));
                    list.push((slot, self.shader.emit(inst, Ty::Triple, span, out)));
                }
                list
            }
            _ => Vec::new(),
        };
        self.values.insert(id, weights);
    }

    /// A value where the end of the shader finds it.
    fn keep(&mut self, name: String, arg: ValueId, out: &mut Block) -> SlotArg {
        let value = &self.shader.values[arg.0 as usize];
        if let Inst::Const(c) = &value.inst {
            return SlotArg::Const(c.clone());
        }
        let ty = value.ty;
        let local = self.shader.add_variable(name, ty, None);
        out.stmts.push(Stmt::Store(local, arg));
        SlotArg::Local(local)
    }

    /// Keeps the arguments of a call where the end of the shader finds them.
    fn call(&mut self, id: ValueId, closure: builtins::ClosureId, args: &[ValueId], span: Span, out: &mut Block) {
        let name = builtins::closure(closure).name;
        let arity = sig::closure_arity(closure).min(args.len());
        let mut slot_args = Vec::with_capacity(arity);
        for (i, arg) in args[..arity].iter().enumerate() {
            slot_args.push(self.keep(format!("{name}{}_a{i}", self.calls.len()), *arg, out));
        }
        if args.len() > arity {
            let more = self.print_only(closure, args, out);
            self.extras.insert(id.0, more);
        }
        // The weight is set at the end, for the slots that reach Ci.
        self.calls.insert(id.0, LobeSlot { closure, weight: LocalId(0), args: slot_args, span });
    }

    /// A closure is set when some weight is not zero.
    fn is_set(&mut self, id: ValueId, weights: Vec<(u32, ValueId)>, span: Span, out: &mut Block) {
        let mut any = self.shader.emit_constant(Const::Int(0), span, out);
        for (_, w) in weights {
            let zero = self.shader.emit_constant(Const::Triple([0.0; 3]), span, out);
            let set = self.shader.emit(Inst::Binary(BinaryOp::Ne, w, zero), Ty::Int, span, out);
            any = self.shader.emit(Inst::Binary(BinaryOp::BitOr, any, set), Ty::Int, span, out);
        }
        // The value keeps its handle, since others refer to it.
        let zero = self.shader.emit_constant(Const::Int(0), span, out);
        self.shader.values[id.0 as usize].inst = Inst::Binary(BinaryOp::Ne, any, zero);
        out.stmts.push(Stmt::Let(id));
    }
}
