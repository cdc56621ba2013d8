//! Point clouds: `pointcloud_search` and its like become one search and a read per attribute.
//!
//! The arrays that a search fills bound how many points it finds; those that nobody asks for are made up. It must not know targets.

use super::Lower;
use super::place::{Place, is_single};
use super::special::arg_values;
use crate::builtins;
use crate::check::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::ir::{Arg, Block, Const, Inst, LocalId, LocalKind, Stmt, Ty, ValueId};
use crate::messages::{FIELD, PART, code};
use crate::source::Span;
use crate::types::{Base, Extent, Type};

/// Where data of points goes: an array, and the variable that has its only element in the end.
struct Data {
    array: LocalId,
    len: u32,
    single: Option<(Place, Ty)>,
}

impl Lower<'_> {
    fn call_cloud(&mut self, row: &str, args: Vec<Arg>, outputs: Vec<LocalId>, span: Span) -> ValueId {
        let result = self.temp(Ty::Int);
        if let Some(func) = builtins::find(row) {
            self.push(Stmt::Call { func, args, outputs, result: Some(result), span });
        }
        self.value(Inst::Load(result), Ty::Int, span)
    }

    /// An array to write to; of a single variable one of length 1.
    fn data(&mut self, call: &str, target: &Expr) -> Option<Data> {
        let base = target.ty.base;
        let fits = matches!(base, Base::Int | Base::Float | Base::String) || base.is_triple();
        if !fits || !self.can_be_written(target) {
            let message = format!("`{call}` writes to variables and arrays of ints, floats, triples or strings");
            self.error(Diagnostic::error("E2016", target.span, message));
            return None;
        }
        let ty = super::ir_type(base);
        if is_single(target.ty) {
            let place = self.place(target);
            let old = self.load(&place, target.span);
            let array = self.array_of(&[old], ty, target.span);
            return Some(Data { array, len: 1, single: Some((place, ty)) });
        }
        let array = self.array(target);
        match (array, target.ty.extent) {
            (Some(array), Extent::Fixed(len)) => Some(Data { array, len, single: None }),
            _ => {
                let message = format!("`{call}` into this array");
                self.error(Diagnostic::not_yet("E3005", target.span, message));
                None
            }
        }
    }

    fn put_back(&mut self, data: &Data, span: Span) {
        if let Some((place, ty)) = &data.single {
            let zero = self.int(0, span);
            let value = self.value(Inst::LoadElem(data.array, zero), *ty, span);
            self.store(place, value, span);
        }
    }

    /// `pointcloud_search(file, place, radius, most, [sort,] name, data, ...)`. The points come sorted in any case.
    pub(super) fn pointcloud_search(&mut self, args: &[Expr], span: Span) -> Option<ValueId> {
        let mut given = Vec::with_capacity(4);
        for (arg, ty) in args[..4].iter().zip([Ty::Str, Ty::Triple, Ty::Float, Ty::Int]) {
            let value = self.expr(arg);
            given.push(self.convert_value(value, ty, arg.span));
        }
        let mut rest = &args[4..];
        if let Some(sort) = rest.first().filter(|a| a.ty == Type::scalar(Base::Int)) {
            self.expr(sort);
            rest = &rest[1..];
        }
        let mut wanted = Vec::new();
        for pair in rest.chunks(2) {
            let [name, data] = pair else {
                let message = "`pointcloud_search` takes pairs of an attribute's name and an array";
                self.error(Diagnostic::error("E2016", span, message));
                return None;
            };
            if name.ty != Type::STRING {
                self.error(Diagnostic::error("E2016", name.span, "an attribute's name is a string"));
                return None;
            }
            wanted.push((name, self.data("pointcloud_search", data)?, data.ty.base));
        }
        let Some(capacity) = wanted.iter().map(|(_, data, _)| data.len).min() else {
            return Some(self.internal("cloud_count", arg_values(&given), Ty::Int, span));
        };
        let most = self.int(capacity as i32, span);
        given[3] = self.internal("min", arg_values(&[given[3], most]), Ty::Int, span);
        let is = |name: &Expr, text: &str| matches!(&name.kind, ExprKind::Str(s) if s == text);
        let reserved = |text: &str, base: Base| {
            wanted.iter().find(|(name, _, of)| is(name, text) && *of == base).map(|(_, data, _)| data.array)
        };
        let made = |l: &mut Self, name: &str, ty| l.local(name, ty, Some(capacity), LocalKind::Variable);
        let indices = reserved("index", Base::Int);
        let indices = indices.unwrap_or_else(|| made(self, "indices", Ty::Int));
        let distances = reserved("distance", Base::Float);
        let distances = distances.unwrap_or_else(|| made(self, "distances", Ty::Float));
        let found = self.call_cloud("cloud_search", arg_values(&given), vec![indices, distances], span);
        for (name, data, base) in &wanted {
            let own = is(name, "index") && *base == Base::Int || is(name, "distance") && *base == Base::Float;
            if !own {
                let name = self.expr(name);
                let list = vec![Arg::Value(given[0]), Arg::Array(indices), Arg::Value(found), Arg::Value(name)];
                self.call_cloud("cloud_get", list, vec![data.array], span);
            } else if data.array != indices && data.array != distances {
                // Asked for twice.
                let from = if *base == Base::Int { indices } else { distances };
                self.push(Stmt::CopyArray(data.array, from));
            }
            self.put_back(data, span);
        }
        Some(found)
    }

    /// `pointcloud_get(file, indices, count, name, data)`.
    pub(super) fn pointcloud_get(&mut self, args: &[Expr], span: Span) -> Option<ValueId> {
        let [file, indices, count, name, data] = args else {
            let message = "`pointcloud_get` takes (string file, int indices[], int count, string attribute, array)";
            self.error(Diagnostic::error("E2004", span, message));
            return None;
        };
        let (file, count, name) = (self.expr(file), self.expr(count), self.expr(name));
        let Some(indices) = self.array(indices) else {
            self.error(Diagnostic::not_yet("E3005", indices.span, "`pointcloud_get` of these indices"));
            return None;
        };
        let data = self.data("pointcloud_get", data)?;
        let list = vec![Arg::Value(file), Arg::Array(indices), Arg::Value(count), Arg::Value(name)];
        let found = self.call_cloud("cloud_get", list, vec![data.array], span);
        self.put_back(&data, span);
        Some(found)
    }

    /// `pointcloud_write(file, place, name, value, ...)`: a message to the host, where somebody listens (`passes::clouds`).
    pub(super) fn pointcloud_write(&mut self, args: &[Expr], span: Span) -> Option<ValueId> {
        let (file, position) = (self.expr(&args[0]), self.expr(&args[1]));
        let position = self.convert_value(position, Ty::Triple, args[1].span);
        let name = self.constant(Const::Str("position".to_owned()), args[1].span);
        let mut format = field('v');
        let mut values = vec![name, position];
        for pair in args[2..].chunks(2) {
            let [name, value] = pair else {
                let message = "`pointcloud_write` takes pairs of an attribute's name and a value";
                self.error(Diagnostic::error("E2016", span, message));
                return None;
            };
            let base = value.ty.base;
            let fits = matches!(base, Base::Int | Base::Float | Base::String) || base.is_triple();
            if name.ty != Type::STRING || !fits || !is_single(value.ty) {
                let message = "`pointcloud_write` takes names and ints, floats, triples or strings";
                self.error(Diagnostic::error("E2016", value.span, message));
                return None;
            }
            values.extend([self.expr(name), self.expr(value)]);
            format.push_str(&field(super::ir_type(base).code()));
        }
        let written = self.call_cloud("cloud_write", arg_values(&[file]), Vec::new(), span);
        let then = self.branch(span, |l| {
            let code = l.int(code::CLOUD, span);
            let format = l.constant(Const::Str(format), span);
            let mut list = vec![code, file, format];
            list.extend(values);
            if let Some(func) = builtins::find("print") {
                let args = arg_values(&list);
                l.push(Stmt::Call { func, args, outputs: Vec::new(), result: None, span });
            }
        });
        self.push(Stmt::If(written, then, Block::default()));
        self.guard_rest();
        Some(written)
    }
}

/// How a point's attribute of this type is said.
fn field(ty: char) -> String {
    let number = match ty {
        'i' => "%d",
        's' => "%s",
        // All digits of a float.
        _ => "%.9g",
    };
    format!("%s{PART}{ty}{PART}{number}{FIELD}")
}
