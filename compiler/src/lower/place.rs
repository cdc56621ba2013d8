//! Where values live: storage of variables, and places inside them that can be read and assigned.

use super::Lower;
use crate::check::typed::{Expr, ExprKind};
use crate::ir::{Inst, LocalId, LocalKind, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::types::Type;

/// The locals that hold a variable.
#[derive(Clone, Debug)]
pub(super) enum Storage {
    /// One local, possibly an array.
    Local(LocalId),
    /// One storage per field; of a struct array all are arrays.
    Struct(Vec<Storage>),
}

/// Something that can be read or assigned.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// A variable, or one element (the index is computed already) of an array variable.
    Stored(Storage, Option<ValueId>),
    /// A component of a triple.
    Component(Box<Place>, ValueId),
    /// Row and column of a matrix.
    Element(Box<Place>, ValueId, ValueId),
    /// A result that lives nowhere: can be read only.
    Value(ValueId),
}

impl Place {
    pub fn whole(storage: Storage) -> Place {
        Place::Stored(storage, None)
    }

    /// The first of the locals that a whole variable lives in.
    pub fn first_local(&self) -> Option<LocalId> {
        let Place::Stored(mut storage, None) = self.clone() else { return None };
        loop {
            match storage {
                Storage::Local(local) => return Some(local),
                Storage::Struct(fields) => storage = fields.into_iter().next()?,
            }
        }
    }

    /// A field of a struct place.
    fn field(self, index: u32) -> Place {
        match self {
            Place::Stored(Storage::Struct(fields), at) => Place::Stored(fields[index as usize].clone(), at),
            // Fields of what is no struct are refused by the checker.
            other => other,
        }
    }
}

impl Lower<'_> {
    /// The place that an expression names. Expressions that name none get a fresh variable that holds their value.
    pub(super) fn place(&mut self, e: &Expr) -> Place {
        match &e.kind {
            ExprKind::Var(id) => Place::whole(self.variable(*id)),
            ExprKind::Index(of, index) => {
                let base = self.place(of);
                let index = self.expr(index);
                self.check_element(of, &base, index, e.span);
                match base {
                    Place::Stored(storage, _) => Place::Stored(storage, Some(index)),
                    other => other,
                }
            }
            ExprKind::Field(base, index) => self.place(base).field(*index),
            ExprKind::Component(of, index) => {
                let base = self.place(of);
                let index = self.expr(index);
                self.check_component(of, index, e.span);
                Place::Component(Box::new(base), index)
            }
            ExprKind::Element(of, row, column) => {
                let base = self.place(of);
                let row = self.expr(row);
                let column = self.expr(column);
                self.check_component(of, row, e.span);
                self.check_component(of, column, e.span);
                Place::Element(Box::new(base), row, column)
            }
            ExprKind::Convert(inner) if matches!(inner.ty.base, crate::types::Base::Struct(_)) => self.place(inner),
            _ => {
                let storage = self.storage("t", e.ty, LocalKind::Variable);
                let place = Place::whole(storage);
                self.assign_expr(&place, e);
                place
            }
        }
    }

    /// The value at a place of a single (not struct, not array) type.
    pub(super) fn load(&mut self, place: &Place, span: Span) -> ValueId {
        match place {
            Place::Stored(Storage::Local(local), None) => {
                let ty = self.out.locals[local.0 as usize].ty;
                self.value(Inst::Load(*local), ty, span)
            }
            Place::Stored(Storage::Local(local), Some(index)) => {
                let ty = self.out.locals[local.0 as usize].ty;
                self.value(Inst::LoadElem(*local, *index), ty, span)
            }
            Place::Stored(Storage::Struct(_), _) => self.int(0, span),
            Place::Value(value) => *value,
            Place::Component(base, index) => {
                let base = self.load(base, span);
                self.value(Inst::Component(base, *index), Ty::Float, span)
            }
            Place::Element(base, row, column) => {
                let base = self.load(base, span);
                self.value(Inst::MatrixElement(base, *row, *column), Ty::Float, span)
            }
        }
    }

    /// Sets a place of a single type.
    pub(super) fn store(&mut self, place: &Place, value: ValueId, span: Span) {
        match place {
            Place::Stored(Storage::Local(local), None) => self.push(Stmt::Store(*local, value)),
            Place::Stored(Storage::Local(local), Some(index)) => self.push(Stmt::StoreElem(*local, *index, value)),
            Place::Stored(Storage::Struct(_), _) | Place::Value(_) => {}
            Place::Component(base, index) => {
                let old = self.load(base, span);
                let new = self.value(Inst::WithComponent(old, *index, value), Ty::Triple, span);
                self.store(base, new, span);
            }
            Place::Element(base, row, column) => {
                let old = self.load(base, span);
                let new = self.value(Inst::WithMatrixElement(old, *row, *column, value), Ty::Matrix, span);
                self.store(base, new, span);
            }
        }
    }

    /// Copies structs and arrays (and single values) between places of one type.
    pub(super) fn copy(&mut self, to: &Place, from: &Place, span: Span) {
        if let (Place::Stored(Storage::Struct(a), at_a), Place::Stored(Storage::Struct(b), at_b)) = (to, from) {
            for (a, b) in a.iter().zip(b) {
                self.copy(&Place::Stored(a.clone(), *at_a), &Place::Stored(b.clone(), *at_b), span);
            }
            return;
        }
        if let (Place::Stored(Storage::Local(a), None), Place::Stored(Storage::Local(b), None)) = (to, from) {
            let array = |l: &LocalId, this: &Self| this.out.locals[l.0 as usize].len.is_some();
            if array(a, self) && array(b, self) {
                if a != b {
                    self.push(Stmt::CopyArray(*a, *b));
                }
                return;
            }
        }
        let value = self.load(from, span);
        self.store(to, value, span);
    }

    /// `place = e` for any type.
    pub(super) fn assign_expr(&mut self, place: &Place, e: &Expr) {
        if is_single(e.ty) {
            let value = self.expr(e);
            self.check_finite(place, value, e);
            self.store(place, value, e.span);
            return;
        }
        match &e.kind {
            ExprKind::List(items) if e.ty.is_array() => {
                for (i, item) in items.iter().enumerate() {
                    let index = self.int(i as i32, item.span);
                    if let Place::Stored(storage, _) = place {
                        self.assign_expr(&Place::Stored(storage.clone(), Some(index)), item);
                    }
                }
            }
            ExprKind::List(items) => {
                // All values first: `s = { s.b, s.a }` swaps.
                let sources: Vec<Place> = items.iter().map(|item| self.snapshot(item)).collect();
                for (i, source) in sources.iter().enumerate() {
                    self.copy(&place.clone().field(i as u32), source, e.span);
                }
            }
            ExprKind::Ternary(cond, a, b) => {
                let cond = self.expr(cond);
                let then = self.branch(a.span, |l| l.assign_expr(place, a));
                let otherwise = self.branch(b.span, |l| l.assign_expr(place, b));
                self.push(Stmt::If(cond, then, otherwise));
                self.guard_rest();
            }
            ExprKind::Comma(parts) => {
                if let Some((last, head)) = parts.split_last() {
                    head.iter().for_each(|p| self.effect(p));
                    self.assign_expr(place, last);
                }
            }
            ExprKind::Assign(target, value) => {
                let target = self.place(target);
                self.assign_expr(&target, value);
                self.copy(place, &target, e.span);
            }
            ExprKind::Call(callee, args) => {
                if let Some(result) = self.call(callee, args, e) {
                    self.copy(place, &result, e.span);
                }
            }
            _ => {
                let source = self.place(e);
                self.copy(place, &source, e.span);
            }
        }
    }

    /// A place with the value that `e` has now; later assignments don't change it.
    pub(super) fn snapshot(&mut self, e: &Expr) -> Place {
        let storage = self.storage("t", e.ty, LocalKind::Variable);
        let place = Place::whole(storage);
        self.assign_expr(&place, e);
        place
    }
}

/// Neither struct nor array.
pub(super) fn is_single(ty: Type) -> bool {
    !ty.is_array() && !matches!(ty.base, crate::types::Base::Struct(_))
}
