//! Calls: user functions are inlined; built-ins become IR calls or go to `special`; closures become lobes.

use super::place::{Place, is_single};
use super::{Frame, Lower, Storage, ir_type};
use crate::builtins::{self, ClosureRole, FuncId, Lowering};
use crate::check::typed::{Callee, Expr, ExprKind, FunctionId, VendorClosure};
use crate::diag::Diagnostic;
use crate::ir::{Arg, Const, Inst, LocalId, LocalKind, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::types::{Base, Extent, Type};

/// A variable, or a field of one: what has storage of its own.
fn is_whole(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Var(_) => true,
        ExprKind::Field(base, _) => is_whole(base),
        _ => false,
    }
}

impl Lower<'_> {
    /// Lowers a call; the place of its result, unless it returns nothing.
    pub(super) fn call(&mut self, callee: &Callee, args: &[Expr], e: &Expr) -> Option<Place> {
        match callee {
            Callee::User(id) => self.inline(*id, args, e),
            Callee::Builtin { id, formals, outputs } => self.builtin(*id, formals, outputs, args, e),
            Callee::Closure { id, .. } => {
                let values: Vec<ValueId> = args.iter().map(|a| self.expr(a)).collect();
                let inst = match (builtins::closure(*id).role, values.as_slice()) {
                    (ClosureRole::Layer, [top, base, ..]) => Inst::Layer(*top, *base),
                    _ => Inst::Closure(*id, values),
                };
                let value = self.value(inst, Ty::Closure, e.span);
                Some(Place::Value(value))
            }
        }
    }

    fn inline(&mut self, id: FunctionId, args: &[Expr], e: &Expr) -> Option<Place> {
        let tree = self.tree;
        let function = &tree.functions[id.0 as usize];
        if function.closure == VendorClosure::Unknown {
            let value = self.unknown_closure(&function.name, args, e.span);
            return Some(Place::Value(value));
        }
        let Some(body) = &function.body else {
            let message = format!("function `{}` is declared but has no body", function.name);
            self.error(Diagnostic::error("E2015", e.span, message).label(function.span, "declared here"));
            return None;
        };
        if self.too_large {
            return None;
        }
        let mut bound = Vec::new();
        let mut copy_back = Vec::new();
        for ((var, output), arg) in function.params.iter().zip(args) {
            let formal = tree.var(*var).ty;
            let is_variable = is_whole(arg);
            // By reference: a variable is bound itself, as long as its type fits exactly.
            let storage = if is_variable && (arg.ty == formal || arg.ty.is_array()) {
                match self.place(arg) {
                    Place::Stored(storage, None) => storage,
                    _ => continue,
                }
            } else if *output && arg.is_place() {
                let place = self.place(arg);
                let ty = if arg.ty.is_array() { arg.ty } else { formal };
                let storage = self.storage(&tree.var(*var).name, ty, LocalKind::Variable);
                self.copy(&Place::whole(storage.clone()), &place, arg.span);
                copy_back.push((place, storage.clone(), arg.span));
                storage
            } else {
                let ty = if arg.ty.is_array() { arg.ty } else { formal };
                let storage = self.storage(&tree.var(*var).name, ty, LocalKind::Variable);
                self.assign_expr(&Place::whole(storage.clone()), arg);
                storage
            };
            bound.push((*var, storage));
        }
        // Bound only now: an argument may itself call the function.
        self.env.extend(bound);
        let result =
            (function.ret.base != Base::Void).then(|| self.storage(&function.name, function.ret, LocalKind::Variable));
        self.frames.push(Frame { result: result.clone(), flag: None, loops: 0, function: Some(id) });
        let first = self.blocks.last().map_or(0, |b| b.stmts.len());
        self.stmts(body, true);
        if let Some(flag) = self.frames.pop().and_then(|f| f.flag) {
            // The flag starts at 0 each time the call is reached, in loops too.
            self.reset_flag(flag, first, e.span);
        }
        for (place, storage, span) in copy_back {
            self.copy(&place, &Place::whole(storage), span);
        }
        self.guard_call(id);
        result.map(Place::whole)
    }

    /// A call of a closure that nothing maps: how it looks in print, and the values to print.
    fn unknown_closure(&mut self, name: &str, args: &[Expr], span: Span) -> ValueId {
        let mut format = Vec::new();
        let mut values = Vec::new();
        for arg in args {
            let conversion = match arg.ty.base {
                Base::Int => "%d",
                Base::Float => "%g",
                Base::String => "\"%s\"",
                base if base.is_triple() => "(%g, %g, %g)",
                // Nothing else is an argument that the reference's closures take.
                _ => continue,
            };
            let first = values.len();
            match arg.ty.extent {
                Extent::Scalar => values.push(self.expr(arg)),
                _ => {
                    let Some(local) = self.array(arg) else { continue };
                    let len = self.out.locals[local.0 as usize].len.unwrap_or(0);
                    for i in 0..len {
                        let index = self.int(i as i32, arg.span);
                        let value = self.value(Inst::LoadElem(local, index), ir_type(arg.ty.base), arg.span);
                        values.push(value);
                    }
                }
            }
            let each = vec![conversion; values.len() - first].join(", ");
            format.push(if arg.ty.is_array() { format!("[{each}]") } else { each });
            if arg.ty.base.is_triple() {
                for value in values.split_off(first) {
                    for i in 0..3 {
                        let index = self.int(i, arg.span);
                        let part = self.value(Inst::Component(value, index), Ty::Float, arg.span);
                        values.push(part);
                    }
                }
            }
        }
        let text = format!("{name} ({})", format.join(", "));
        let mut list = vec![self.constant(Const::Str(text), span)];
        list.extend(values);
        match builtins::find_closure(builtins::UNKNOWN) {
            Some(id) => self.value(Inst::Closure(id, list), Ty::Closure, span),
            None => self.value(Inst::NullClosure, Ty::Closure, span),
        }
    }

    /// Puts `flag = 0` before the inlined body, whose statements start at `first` of the present block.
    fn reset_flag(&mut self, flag: LocalId, first: usize, span: Span) {
        let tail = self.blocks.last_mut().map(|b| b.stmts.split_off(first)).unwrap_or_default();
        let zero = self.int(0, span);
        self.push(Stmt::Store(flag, zero));
        if let Some(block) = self.blocks.last_mut() {
            block.stmts.extend(tail);
        }
    }

    fn builtin(&mut self, id: FuncId, formals: &[Type], outputs: &[bool], args: &[Expr], e: &Expr) -> Option<Place> {
        let row = builtins::row(id);
        match row.lowering {
            // Whether the call is ever reached is known after folding.
            Lowering::Host | Lowering::NotYet => {
                if !self.printable(row.name, args) {
                    return None;
                }
                self.direct(id, outputs, args, e)
            }
            Lowering::Special if row.name == "exit" => {
                self.exit_inside(e.span);
                None
            }
            Lowering::Special => self.special(row.name, formals, args, e),
            _ => self.direct(id, outputs, args, e),
        }
    }

    /// Whether the arguments have values that a format could show; says so if not.
    pub(super) fn printable(&mut self, name: &str, args: &[Expr]) -> bool {
        let odd = |a: &&Expr| matches!(a.ty.base, Base::Closure | Base::Struct(_));
        let Some(arg) = args.iter().find(odd) else { return true };
        let kind = if arg.ty.base == Base::Closure { "closure" } else { "struct" };
        self.error(Diagnostic::not_yet("E3001", arg.span, format!("`{name}` of a {kind}")));
        false
    }

    /// One IR call.
    fn direct(&mut self, id: FuncId, outputs: &[bool], args: &[Expr], e: &Expr) -> Option<Place> {
        let mut inputs = Vec::new();
        let mut places = Vec::new();
        for (i, arg) in args.iter().enumerate() {
            if outputs.get(i).copied().unwrap_or(false) {
                places.push((self.place(arg), arg));
            } else if is_single(arg.ty) {
                inputs.push(Arg::Value(self.expr(arg)));
            } else {
                let local = self.array(arg)?;
                inputs.push(Arg::Array(local));
            }
        }
        if places.is_empty() && e.ty.base != Base::Void {
            let value = self.value(Inst::Call(id, inputs), ir_type(e.ty.base), e.span);
            return Some(Place::Value(value));
        }
        let mut targets = Vec::new();
        let mut copy_back = Vec::new();
        for (place, arg) in places {
            match &place {
                Place::Stored(Storage::Local(local), None) => targets.push(*local),
                _ => {
                    let temp = self.temp(ir_type(arg.ty.base));
                    targets.push(temp);
                    copy_back.push((place, temp, arg.span));
                }
            }
        }
        let result = (e.ty.base != Base::Void).then(|| self.temp(ir_type(e.ty.base)));
        self.push(Stmt::Call { func: id, args: inputs, outputs: targets, result, span: e.span });
        for (place, temp, span) in copy_back {
            self.copy(&place, &Place::whole(Storage::Local(temp)), span);
        }
        result.map(|local| Place::whole(Storage::Local(local)))
    }

    /// An IR call to an internal row that certainly exists.
    pub(super) fn internal(&mut self, name: &str, args: Vec<Arg>, ty: Ty, span: Span) -> ValueId {
        match builtins::find(name) {
            Some(id) => self.value(Inst::Call(id, args), ty, span),
            None => {
                self.error(Diagnostic::not_yet("E3001", span, format!("`{name}`")));
                self.int(0, span)
            }
        }
    }
}
