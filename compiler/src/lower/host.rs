//! What OSL says to and asks of the host and the renderer: printing, messages, attributes, dictionaries, traced rays.
//!
//! Each becomes a statement of one internal row, which passes answer (`passes::traces`, `passes::dialogue`, `passes::cases`,
//! `passes::dictionary`) or the back end writes as a record (`print`).

use super::place::{Place, is_single};
use super::special::arg_values;
use super::{Lower, Storage, ir_type};
use crate::builtins;
use crate::check::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::ir::{Arg, Const, Inst, LocalId, Stmt, Ty, ValueId};
use crate::messages::code;
use crate::source::Span;
use crate::types::{Base, Extent, Type};

/// Options of `trace`, which take a value each.
const TRACE_OPTIONS: [&str; 4] = ["mindist", "maxdist", "shade", "traceset"];

/// How far rays of `trace` go that are told nothing else.
const FARTHEST: f64 = 1e30;

impl Lower<'_> {
    /// A statement that says something to the host.
    pub(super) fn print(&mut self, name: &str, args: &[Expr], span: Span) {
        // The host knows what a closure's terms look like.
        let texts: Vec<Expr> = args.iter().filter(|a| a.ty.base != Base::Closure || a.ty.is_array()).cloned().collect();
        if !self.printable(name, &texts) {
            return;
        }
        let shader = || Const::Str(self.tree.name.clone());
        let (code, owner, from) = match name {
            "printf" => (code::PRINT, Some(Const::Str(String::new())), 0),
            "error" => (code::ERROR, Some(shader()), 0),
            "warning" => (code::WARNING, Some(shader()), 0),
            _ => (code::FILE, None, 1),
        };
        let owner = match owner {
            Some(c) => self.constant(c, span),
            None => self.expr(&args[0]),
        };
        let mut list = arg_values(&[self.int(code, span), owner]);
        for arg in &args[from..] {
            list.extend(self.input(arg));
        }
        self.call_row("print", list, Vec::new(), None, span);
    }

    /// A statement that tells the host of an error of the shader's, in the reference implementation's words: `%s` stands for
    /// the names in order.
    pub(super) fn report_error(&mut self, format: &str, names: &[ValueId], span: Span) {
        let [owner, format] = ["", format].map(|t| self.constant(Const::Str(t.to_owned()), span));
        let mut args = vec![self.int(code::ERROR, span), owner, format];
        args.extend(names);
        self.call_row("print", arg_values(&args), Vec::new(), None, span);
    }

    /// A single value, or an array by reference.
    fn input(&mut self, arg: &Expr) -> Option<Arg> {
        if is_single(arg.ty) {
            return Some(Arg::Value(self.expr(arg)));
        }
        self.array(arg).map(Arg::Array)
    }

    fn call_row(&mut self, row: &str, args: Vec<Arg>, outputs: Vec<LocalId>, result: Option<LocalId>, span: Span) {
        if let Some(func) = builtins::find(row) {
            self.push(Stmt::Call { func, args, outputs, result, span });
        }
    }

    fn text(&mut self, text: impl Into<String>, span: Span) -> ValueId {
        self.constant(Const::Str(text.into()), span)
    }

    /// A type in OSL's words.
    fn type_name(&mut self, ty: Type, span: Span) -> ValueId {
        let base = if ty.base == Base::Closure { "closure color" } else { ty.base.keyword() };
        let name = match ty.extent {
            Extent::Fixed(n) => format!("{base}[{n}]"),
            _ => base.to_owned(),
        };
        self.text(name, span)
    }

    /// A call whose last argument is written to when there is something to write; its result tells whether.
    fn ask(&mut self, name: &str, row: &str, args: Vec<Arg>, target: &Expr, span: Span) -> Option<Place> {
        if matches!(target.ty.base, Base::Struct(_) | Base::Void) || !self.can_be_written(target) {
            let message = format!("the last argument of `{name}` is a variable that the answer is written to");
            self.error(Diagnostic::error("E2016", target.span, message));
            return None;
        }
        let place = self.place(target);
        let (local, copy_back) = match &place {
            Place::Stored(Storage::Local(local), None) => (*local, false),
            _ => {
                // What the call does not answer stays as it is.
                let temp = self.temp(ir_type(target.ty.base));
                let old = self.load(&place, target.span);
                self.push(Stmt::Store(temp, old));
                (temp, true)
            }
        };
        let result = self.temp(Ty::Int);
        self.call_row(row, args, vec![local], Some(result), span);
        if copy_back {
            let value = self.value(Inst::Load(local), ir_type(target.ty.base), target.span);
            self.store(&place, value, target.span);
        }
        Some(Place::whole(Storage::Local(result)))
    }

    /// `setmessage(name, value)`.
    pub(super) fn setmessage(&mut self, args: &[Expr], span: Span) {
        let [name, value] = args else {
            return self.error(Diagnostic::error("E2004", span, "`setmessage` takes a name and a value"));
        };
        if matches!(value.ty.base, Base::Struct(_)) {
            return self.error(Diagnostic::error("E2004", value.span, "a message cannot be a struct"));
        }
        let name = self.expr(name);
        let ty = self.type_name(value.ty, span);
        let mut list = arg_values(&[name, ty]);
        list.extend(self.input(value));
        self.call_row("message_set", list, Vec::new(), None, span);
    }

    /// `getmessage([source,] name, value)`.
    pub(super) fn getmessage(&mut self, args: &[Expr], span: Span) -> Option<Place> {
        let (source, name, target) = match args {
            [name, target] => (None, name, target),
            [source, name, target] => (Some(source), name, target),
            _ => {
                self.error(Diagnostic::error(
                    "E2004",
                    span,
                    "`getmessage` takes a name and a variable, or a source first",
                ));
                return None;
            }
        };
        let source = match source {
            Some(e) => self.expr(e),
            None => self.text("", span),
        };
        let name = self.expr(name);
        let ty = self.type_name(target.ty, span);
        self.ask("getmessage", "message_get", arg_values(&[source, name, ty]), target, span)
    }

    /// `getattribute([object,] name, [index,] value)`.
    pub(super) fn getattribute(&mut self, args: &[Expr], span: Span) -> Option<Place> {
        let wrong = |l: &mut Self| {
            let message = "`getattribute` takes ([string object,] string name, [int index,] variable)";
            l.error(Diagnostic::error("E2004", span, message));
        };
        let Some((target, names)) = args.split_last() else {
            wrong(self);
            return None;
        };
        let is_int = |e: &Expr| e.ty == Type::scalar(Base::Int);
        let (index, names) = match names.split_last() {
            Some((last, rest)) if is_int(last) => (Some(last), rest),
            _ => (None, names),
        };
        let (object, name) = match names {
            [name] => (None, name),
            [object, name] => (Some(object), name),
            _ => {
                wrong(self);
                return None;
            }
        };
        if [Some(name), object].into_iter().flatten().any(|e| e.ty != Type::STRING) {
            wrong(self);
            return None;
        }
        let object = match object {
            Some(e) => self.expr(e),
            None => self.text("", span),
        };
        let name = self.expr(name);
        let index = match index {
            Some(e) => self.expr(e),
            None => self.int(-1, span),
        };
        let ty = self.type_name(target.ty, span);
        // Shader, layer, group: `link` knows the last two.
        let shader = self.text(self.tree.name.clone(), span);
        let [layer, group] = ["", ""].map(|s| self.text(s, span));
        let list = arg_values(&[object, name, index, ty, shader, layer, group]);
        self.ask("getattribute", "attribute_get", list, target, span)
    }

    /// `dict_value(node, name, value)`.
    pub(super) fn dict_value(&mut self, args: &[Expr], span: Span) -> Option<Place> {
        let [node, name, target] = args else {
            self.error(Diagnostic::error("E2004", span, "`dict_value` takes a node, a name and a variable"));
            return None;
        };
        let (node, name) = (self.expr(node), self.expr(name));
        let ty = self.type_name(target.ty, span);
        self.ask("dict_value", "dict_get", arg_values(&[node, name, ty]), target, span)
    }

    /// `trace(point, direction, options...)`: a statement, since what it finds is asked for later (`passes::traces`).
    pub(super) fn trace(&mut self, args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let (from, direction) = (self.expr(&args[0]), self.expr(&args[1]));
        let [mut nearest, mut farthest] = [0.0, FARTHEST].map(|x| self.constant(Const::Float(x), span));
        let (mut shade, mut set) = (self.int(0, span), self.text("", span));
        for pair in args.get(2..).unwrap_or_default().chunks(2) {
            let [option, value] = pair else {
                self.error(Diagnostic::error("E2004", span, "an option of `trace` has no value"));
                break;
            };
            let ExprKind::Str(name) = &option.kind else {
                let message = "`trace` takes pairs of an option's name, a string literal, and its value";
                self.error(Diagnostic::error("E2016", option.span, message));
                continue;
            };
            if !TRACE_OPTIONS.contains(&name.as_str()) {
                self.error(crate::suggest::unknown_name("option of `trace`", name, &TRACE_OPTIONS, option.span));
                continue;
            }
            let is = |base| value.ty == Type::scalar(base);
            let wanted = match name.as_str() {
                "shade" if !is(Base::Int) => "an int",
                "traceset" if !is(Base::String) => "a string",
                "mindist" | "maxdist" if !is(Base::Float) && !is(Base::Int) => "a float",
                _ => "",
            };
            if !wanted.is_empty() {
                let message = format!("the option \"{name}\" of `trace` takes {wanted}");
                self.error(Diagnostic::error("E2016", value.span, message));
                continue;
            }
            let given = self.expr(value);
            match name.as_str() {
                "shade" => shade = given,
                "traceset" => set = given,
                "mindist" => nearest = self.convert_value(given, Ty::Float, value.span),
                _ => farthest = self.convert_value(given, Ty::Float, value.span),
            }
        }
        let result = self.temp(Ty::Int);
        let list = arg_values(&[from, direction, nearest, farthest, shade, set]);
        self.call_row("trace_call", list, Vec::new(), Some(result), span);
        self.value(Inst::Load(result), Ty::Int, span)
    }
}
