//! Typed tree to [`Module`](super::Module): expressions.
//!
//! In: expressions. Out: operations, and the symbols or places of their values. It must not know statements.

use super::write::Writer;
use super::write_symbols::{Home, Place};
use super::{Literal, SymId, SymbolKind};
use crate::ast::{BinaryOp, IncDecOp};
use crate::check::typed::{Callee, Expr, ExprKind, parts};
use crate::types::{Base, Extent, Type};

/// The operation of a binary operator.
fn operation(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::Add => "add",
        BinaryOp::Sub => "sub",
        BinaryOp::Mul => "mul",
        BinaryOp::Div => "div",
        BinaryOp::Mod => "mod",
        BinaryOp::Shl => "shl",
        BinaryOp::Shr => "shr",
        BinaryOp::Lt => "lt",
        BinaryOp::Le => "le",
        BinaryOp::Gt => "gt",
        BinaryOp::Ge => "ge",
        BinaryOp::Eq => "eq",
        BinaryOp::Ne => "neq",
        BinaryOp::BitAnd => "bitand",
        BinaryOp::BitOr => "bitor",
        BinaryOp::BitXor => "xor",
        BinaryOp::And => "and",
        BinaryOp::Or => "or",
    }
}

impl Writer<'_> {
    /// The place that an expression names; the symbols of its value when it names none.
    pub(super) fn place(&mut self, e: &Expr) -> Place {
        match &e.kind {
            ExprKind::Var(id) => Place::Home(self.variable(*id)),
            ExprKind::Index(base, index) => {
                let base = self.place(base);
                let index = self.index(index);
                match base {
                    Place::Home(home) => Place::Element(home, index),
                    other => other,
                }
            }
            ExprKind::Field(base, index) => self.place(base).field(*index as usize),
            ExprKind::Component(base, index) => {
                let base = self.place(base);
                let index = self.index(index);
                Place::Component(Box::new(base), index)
            }
            ExprKind::Element(base, row, column) => {
                let base = self.place(base);
                let row = self.index(row);
                let column = self.index(column);
                Place::Cell(Box::new(base), row, column)
            }
            ExprKind::Convert(inner) if matches!(inner.ty.base, Base::Struct(_)) => self.place(inner),
            _ => Place::Home(self.home(e)),
        }
    }

    /// An index's value. A variable is copied: what is assigned through the place may change it.
    fn index(&mut self, e: &Expr) -> SymId {
        let value = self.value(e, None);
        match self.module.symbol(value).kind {
            SymbolKind::Const | SymbolKind::Temp => value,
            _ => {
                let to = self.temp_symbol(Type::INT);
                self.op("assign", "wr", &[to, value]);
                to
            }
        }
    }

    /// The symbols of an expression's value. Those of a variable are its own.
    pub(super) fn home(&mut self, e: &Expr) -> Home {
        let Base::Struct(_) = e.ty.base else { return Home::One(self.value(e, None)) };
        match &e.kind {
            ExprKind::Var(_) | ExprKind::Index(..) | ExprKind::Field(..) => match self.place(e) {
                Place::Home(home) => home,
                place => {
                    let home = self.temp(e.ty);
                    self.copy(&Place::Home(home.clone()), &place);
                    home
                }
            },
            ExprKind::Convert(inner) => self.home(inner),
            ExprKind::Call(callee, args) => match self.call(callee, args, e, None) {
                Some(home) => home,
                None => self.temp(e.ty),
            },
            ExprKind::Assign(target, value) => {
                let place = self.place(target);
                self.assign_apart(&place, value);
                match place {
                    Place::Home(home) => home,
                    place => {
                        let home = self.temp(e.ty);
                        self.copy(&Place::Home(home.clone()), &place);
                        home
                    }
                }
            }
            ExprKind::Comma(parts) => match parts.split_last() {
                Some((last, head)) => {
                    head.iter().for_each(|p| self.effect(p));
                    self.home(last)
                }
                None => self.temp(e.ty),
            },
            _ => {
                let home = self.temp(e.ty);
                self.assign(&Place::Home(home.clone()), e);
                home
            }
        }
    }

    /// As [`Writer::assign`], where the value may read what is assigned: lists and structs go through a copy.
    pub(super) fn assign_apart(&mut self, place: &Place, e: &Expr) {
        if matches!(e.kind, ExprKind::List(_) | ExprKind::Ternary(..)) && (e.ty.is_array() || is_struct(e.ty)) {
            let home = self.temp(e.ty);
            self.assign(&Place::Home(home.clone()), e);
            self.copy(place, &Place::Home(home));
        } else {
            self.assign(place, e);
        }
    }

    /// Sets a place to an expression's value.
    pub(super) fn assign(&mut self, place: &Place, e: &Expr) {
        match &e.kind {
            ExprKind::List(items) if e.ty.is_array() => self.array_list(place, items, e.ty),
            ExprKind::List(items) => {
                for (i, item) in items.iter().enumerate() {
                    self.assign(&place.clone().field(i), item);
                }
            }
            ExprKind::Ternary(cond, a, b) if e.ty.is_array() || is_struct(e.ty) => {
                let cond = self.value(cond, None);
                self.branch(cond, |w| w.assign(place, a), |w| w.assign(place, b));
            }
            _ if is_struct(e.ty) => {
                let from = Place::Home(self.home(e));
                self.copy(place, &from);
            }
            _ => {
                let wanted = match place {
                    Place::Home(home) => Some(home.symbol()),
                    _ => None,
                };
                let value = self.value(e, wanted);
                self.store(place, value);
            }
        }
    }

    fn array_list(&mut self, place: &Place, items: &[Expr], ty: Type) {
        // Literals of ints, floats and strings are one constant.
        let literals: Option<Vec<Literal>> = items.iter().map(|e| literal(e, ty.base)).collect();
        let full = ty.extent == Extent::Fixed(items.len() as u32);
        if let (Some(values), Place::Home(Home::One(to)), true) = (literals, place, full) {
            let from = self.constant(ty, values);
            self.op("assign", "wr", &[*to, from]);
            return;
        }
        for (i, item) in items.iter().enumerate() {
            let Place::Home(home) = place else { return };
            let index = self.int(i as i32);
            self.assign(&Place::Element(home.clone(), index), item);
        }
    }

    /// Where a result of type `ty` goes: the wanted symbol when it has just this type, or a temporary.
    pub(super) fn target(&mut self, wanted: Option<SymId>, ty: Type) -> SymId {
        match wanted {
            Some(id) if self.type_of(id) == ty && self.module.symbol(id).ty.base().is_some() => id,
            _ => self.temp_symbol(ty),
        }
    }

    /// The symbol of an expression's value; `wanted` would spare a copy. For structs, the struct's own symbol.
    pub(super) fn value(&mut self, e: &Expr, wanted: Option<SymId>) -> SymId {
        if is_struct(e.ty) {
            return self.home(e).symbol();
        }
        match &e.kind {
            ExprKind::Int(v) => self.int(*v),
            ExprKind::Float(v) => self.float(*v),
            ExprKind::Str(s) => self.string(s),
            ExprKind::Var(_) | ExprKind::Index(..) | ExprKind::Field(..) => {
                let place = self.place(e);
                self.load(&place)
            }
            ExprKind::Component(base, index) => {
                let base = self.value(base, None);
                let index = self.value(index, None);
                let to = self.target(wanted, Type::FLOAT);
                self.op("compref", "wrr", &[to, base, index]);
                to
            }
            ExprKind::Element(base, row, column) => {
                let base = self.value(base, None);
                let row = self.value(row, None);
                let column = self.value(column, None);
                let to = self.target(wanted, Type::FLOAT);
                self.op("mxcompref", "wrrr", &[to, base, row, column]);
                to
            }
            ExprKind::Call(callee, args) => match self.call(callee, args, e, wanted) {
                Some(home) => home.symbol(),
                None => self.temp_symbol(e.ty),
            },
            ExprKind::Construct(args) => self.construct(args, e.ty, wanted),
            ExprKind::List(_) => {
                let home = self.temp(e.ty);
                self.assign(&Place::Home(home.clone()), e);
                home.symbol()
            }
            ExprKind::Convert(inner) => self.convert(inner, e.ty, wanted),
            ExprKind::Truth(inner) => {
                let value = self.value(inner, None);
                self.compared(value, "neq")
            }
            ExprKind::Not(inner) => {
                let value = self.value(inner, None);
                self.compared(value, "eq")
            }
            ExprKind::Neg(inner) if e.ty.base == Base::Closure => {
                let value = self.value(inner, None);
                let minus = self.float(-1.0);
                let to = self.target(wanted, e.ty);
                self.op("mul", "wrr", &[to, value, minus]);
                to
            }
            ExprKind::Neg(inner) | ExprKind::Compl(inner) => {
                let value = self.value(inner, None);
                let to = self.target(wanted, e.ty);
                let name = if matches!(e.kind, ExprKind::Neg(_)) { "neg" } else { "compl" };
                self.op(name, "wr", &[to, value]);
                to
            }
            ExprKind::Binary(op @ (BinaryOp::And | BinaryOp::Or), l, r) => self.logic(*op, l, r),
            ExprKind::Binary(..) => self.chain(e, wanted),
            ExprKind::IncDec(op, target) => self.inc_dec(*op, target),
            ExprKind::Assign(target, value) => {
                let place = self.place(target);
                self.assign_apart(&place, value);
                self.load(&place)
            }
            ExprKind::AssignOp(op, target, rhs) => self.assign_op(*op, target, rhs),
            ExprKind::Ternary(cond, a, b) => {
                let to = self.temp_symbol(e.ty);
                let place = Place::Home(Home::One(to));
                let cond = self.value(cond, None);
                self.branch(cond, |w| w.assign(&place, a), |w| w.assign(&place, b));
                to
            }
            ExprKind::Comma(parts) => match parts.split_last() {
                Some((last, head)) => {
                    head.iter().for_each(|p| self.effect(p));
                    self.value(last, wanted)
                }
                None => self.int(0),
            },
        }
    }

    /// `value neq 0` or `value eq 0`, in a temporary int.
    pub(super) fn compared(&mut self, value: SymId, name: &str) -> SymId {
        let zero = match self.type_of(value).base {
            Base::Int | Base::Closure => self.int(0),
            Base::String => self.string(""),
            _ => self.float(0.0),
        };
        let to = self.temp_symbol(Type::INT);
        self.op(name, "wrr", &[to, value, zero]);
        to
    }

    fn convert(&mut self, inner: &Expr, to: Type, wanted: Option<SymId>) -> SymId {
        if to.is_array() {
            return self.value(inner, wanted);
        }
        match (&inner.kind, to.base) {
            (ExprKind::Int(v), Base::Float) => return self.float(f64::from(*v)),
            (ExprKind::Int(v), Base::Matrix) => {
                return self.assigned(to, f64::from(*v), wanted);
            }
            (ExprKind::Int(v), b) if b.is_triple() => {
                return self.constant(to, vec![Literal::Float(f64::from(*v)); 3]);
            }
            (ExprKind::Float(v), b) if b.is_triple() => return self.constant(to, vec![Literal::Float(*v); 3]),
            _ => {}
        }
        if to.base == Base::Closure && inner.ty.base != Base::Closure {
            let zero = self.int(0);
            let id = self.target(wanted, to);
            self.op("assign", "wr", &[id, zero]);
            return id;
        }
        let mut value = self.value(inner, None);
        // Constants become constants of the other kind.
        let symbol = self.module.symbol(value);
        if symbol.kind == SymbolKind::Const && to.base.is_triple() && inner.ty.base.is_triple() {
            let values = symbol.values.clone();
            return self.constant(to, values);
        }
        if inner.ty.base == Base::Int && to.base != Base::Float && to.base != Base::Int {
            let float = self.temp_symbol(Type::FLOAT);
            self.op("assign", "wr", &[float, value]);
            value = float;
        }
        let id = self.target(wanted, to);
        self.op("assign", "wr", &[id, value]);
        id
    }

    /// A number as a value of a wider type.
    fn assigned(&mut self, to: Type, value: f64, wanted: Option<SymId>) -> SymId {
        let value = self.float(value);
        let id = self.target(wanted, to);
        self.op("assign", "wr", &[id, value]);
        id
    }

    fn construct(&mut self, args: &[Expr], ty: Type, wanted: Option<SymId>) -> SymId {
        if ty.base.is_triple() && args.len() == 3 {
            let parts: Option<Vec<Literal>> = args.iter().map(|a| literal(a, Base::Float)).collect();
            if let Some(parts) = parts {
                return self.constant(ty, parts);
            }
        }
        let mut symbols = self.values(args);
        let to = self.target(wanted, ty);
        symbols.insert(0, to);
        let access = format!("w{}", "r".repeat(args.len()));
        self.op(ty.base.keyword(), &access, &symbols);
        to
    }

    /// An operand. A number that was widened to a triple or matrix stays a number: the operation widens it.
    fn operand(&mut self, e: &Expr) -> SymId {
        match &e.kind {
            ExprKind::Convert(inner)
                if inner.ty == Type::FLOAT && (e.ty.base.is_triple() || e.ty.base == Base::Matrix) =>
            {
                self.value(inner, None)
            }
            ExprKind::Convert(inner)
                if inner.ty == Type::INT && (e.ty.base.is_triple() || e.ty.base == Base::Matrix) =>
            {
                self.convert(inner, Type::FLOAT, None)
            }
            // The kinds of triples are the same to operators.
            ExprKind::Convert(inner) if inner.ty.base.is_triple() && e.ty.base.is_triple() => self.value(inner, None),
            _ => self.value(e, None),
        }
    }

    /// A left-deep chain of operators, without recursion along its spine.
    fn chain(&mut self, e: &Expr, wanted: Option<SymId>) -> SymId {
        let mut spine = Vec::new();
        let mut at = e;
        while let ExprKind::Binary(op, l, r) = &at.kind {
            if matches!(op, BinaryOp::And | BinaryOp::Or) {
                break;
            }
            spine.push((at, *op, r));
            at = l;
        }
        let mut left = self.operand(at);
        let last = spine.len();
        for (i, (node, op, r)) in spine.into_iter().rev().enumerate() {
            // What the right side assigns must not change a left side that was read before.
            let left_now = if has_effect(r) { self.kept(left) } else { left };
            let right = self.operand(r);
            let wanted = wanted.filter(|_| i + 1 == last);
            left = self.binary(op, left_now, right, node.ty, wanted);
        }
        left
    }

    /// A value that later assignments do not change.
    fn kept(&mut self, value: SymId) -> SymId {
        if matches!(self.module.symbol(value).kind, SymbolKind::Const | SymbolKind::Temp) {
            return value;
        }
        let to = self.temp_symbol(self.type_of(value));
        self.op("assign", "wr", &[to, value]);
        to
    }

    fn binary(&mut self, op: BinaryOp, l: SymId, r: SymId, ty: Type, wanted: Option<SymId>) -> SymId {
        // Two numbers whose result is wider: one must be widened first.
        let wide = ty.base.is_triple() || ty.base == Base::Matrix;
        let narrow = |w: &Self, id: SymId| w.type_of(id) == Type::FLOAT;
        let l = if wide && narrow(self, l) && narrow(self, r) { self.widened(l, ty) } else { l };
        // The closure of a product comes first.
        let (l, r) = match (self.type_of(l).base, self.type_of(r).base) {
            (a, Base::Closure) if a != Base::Closure => (r, l),
            _ => (l, r),
        };
        let to = self.target(wanted, ty);
        self.op(operation(op), "wrr", &[to, l, r]);
        to
    }

    fn widened(&mut self, value: SymId, ty: Type) -> SymId {
        let to = self.temp_symbol(ty);
        self.op("assign", "wr", &[to, value]);
        to
    }

    /// Short-circuiting `&&` and `||`: the right side is a branch.
    fn logic(&mut self, op: BinaryOp, l: &Expr, r: &Expr) -> SymId {
        let left = self.value(l, None);
        let to = self.compared(left, "neq");
        let right = |w: &mut Self| {
            let value = w.value(r, None);
            let value = w.compared(value, "neq");
            w.op("assign", "wr", &[to, value]);
        };
        if op == BinaryOp::And {
            self.branch(to, right, |_| {});
        } else {
            self.branch(to, |_| {}, right);
        }
        to
    }

    fn inc_dec(&mut self, op: IncDecOp, target: &Expr) -> SymId {
        let place = self.place(target);
        let old = self.load(&place);
        let one = if target.ty == Type::INT { self.int(1) } else { self.float(1.0) };
        let (name, post) = match op {
            IncDecOp::PreInc => ("add", false),
            IncDecOp::PreDec => ("sub", false),
            IncDecOp::PostInc => ("add", true),
            IncDecOp::PostDec => ("sub", true),
        };
        let before = if post { self.kept(old) } else { old };
        let new = match &place {
            Place::Home(home) => home.symbol(),
            _ => self.temp_symbol(target.ty),
        };
        self.op(name, "wrr", &[new, old, one]);
        self.store(&place, new);
        if post { before } else { new }
    }

    fn assign_op(&mut self, op: BinaryOp, target: &Expr, rhs: &Expr) -> SymId {
        let place = self.place(target);
        let right = self.operand(rhs);
        let old = self.load(&place);
        // Computed in the type of the right side, unless that is a closure's factor.
        let factor = target.ty.base == Base::Closure;
        let ty = if factor || (target.ty.base.is_triple() && rhs.ty.base.is_triple()) { target.ty } else { rhs.ty };
        let left = if target.ty == Type::INT && ty == Type::FLOAT { self.widened(old, ty) } else { old };
        let wanted = match &place {
            Place::Home(home) => Some(home.symbol()),
            _ => None,
        };
        let new = self.binary(op, left, right, ty, wanted);
        self.store(&place, new);
        if matches!(place, Place::Home(_)) { self.load(&place) } else { new }
    }
}

pub(super) fn is_struct(ty: Type) -> bool {
    matches!(ty.base, Base::Struct(_))
}

/// Whether evaluating it may change a variable.
fn has_effect(e: &Expr) -> bool {
    let mut todo = vec![e];
    while let Some(e) = todo.pop() {
        match &e.kind {
            ExprKind::Assign(..) | ExprKind::AssignOp(..) | ExprKind::IncDec(..) => return true,
            ExprKind::Call(Callee::User(_), _) => return true,
            // What follows the formals may be written too.
            ExprKind::Call(Callee::Builtin { outputs, formals, .. }, args)
                if outputs.contains(&true) || args.len() > formals.len() =>
            {
                return true;
            }
            _ => {}
        }
        todo.extend(parts(e));
    }
    false
}

impl Writer<'_> {
    /// The values of arguments, as they are before any of them changes a variable.
    pub(super) fn values(&mut self, args: &[Expr]) -> Vec<SymId> {
        let mut out = Vec::with_capacity(args.len());
        let last_effect = args.iter().rposition(has_effect);
        for (i, arg) in args.iter().enumerate() {
            let value = self.value(arg, None);
            // Structs and arrays are passed as they are.
            let movable = !is_struct(arg.ty) && !arg.ty.is_array();
            let kept = movable && last_effect.is_some_and(|last| i < last);
            out.push(if kept { self.kept(value) } else { value });
        }
        out
    }
}

/// A literal of a base type that is one int, float or string.
fn literal(e: &Expr, base: Base) -> Option<Literal> {
    match (&e.kind, base) {
        (ExprKind::Int(v), Base::Int) => Some(Literal::Int(*v)),
        (ExprKind::Int(v), Base::Float) => Some(Literal::Float(f64::from(*v))),
        (ExprKind::Float(v), Base::Float) => Some(Literal::Float(*v)),
        (ExprKind::Str(s), Base::String) => Some(Literal::Str(s.clone())),
        (ExprKind::Convert(inner), Base::Float) if e.ty == Type::FLOAT && inner.ty == Type::INT => {
            literal(inner, Base::Float)
        }
        _ => None,
    }
}
