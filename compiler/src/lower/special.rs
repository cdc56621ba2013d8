//! Built-ins that are not one IR call: names resolved to functions, spaces to matrices, polymorphism spelt out.
//!
//! A name that is a literal is resolved here. One that only a parameter's value tells becomes a chain of comparisons, which
//! specialisation and folding cut down to one branch.

use super::place::{Place, Storage, is_single};
use super::spaces::Name;
use super::{Lower, ir_type};
use crate::attributes::RAY_TYPES;
use crate::check::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Const, Global, Inst, LocalId, LocalKind, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::types::{Base, Type};

const SPLINES: [(&str, &str); 6] = [
    ("catmull-rom", "catmullrom"),
    ("bezier", "bezier"),
    ("bspline", "bspline"),
    ("hermite", "hermite"),
    ("linear", "linear"),
    ("constant", "constant"),
];

/// What becomes of a name that is none of those known.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Unknown {
    /// What `make` makes of it: nothing is said.
    Silent,
    /// An error where it is certain; when only running the shader tells, what `make` makes of it.
    Refused,
    /// The same as this name: a warning where it is certain.
    Taken(&'static str),
}

impl Lower<'_> {
    pub(super) fn special(&mut self, name: &str, formals: &[Type], args: &[Expr], e: &Expr) -> Option<Place> {
        let span = e.span;
        let ty = ir_type(e.ty.base);
        let value = match name {
            "mix" => self.mix(args, e),
            "select" => self.select(args, e),
            "faceforward" => {
                let mut values = self.values(args);
                if values.len() == 2 {
                    let ng = self.global(Global::Ng, span);
                    values.push(ng);
                }
                self.internal("faceforward_ref", arg_values(&values), ty, span)
            }
            "aastep" => self.aastep(args, span),
            "transform" => self.transform(formals, args, e),
            "transformc" => self.transformc(args, span),
            "luminance" => self.luminance(args, span),
            "blackbody" | "wavelength_color" => self.spectrum(name, args, span),
            "getmatrix" => return self.getmatrix(args, e),
            "noise" | "pnoise" => self.named_noise(name, args, e),
            "snoise" => self.noise_of("noise_perlin", args, e),
            "cellnoise" => self.noise_of("noise_cell", args, e),
            "hashnoise" => self.noise_of("noise_hash", args, e),
            "psnoise" => self.noise_of("pnoise_perlin", args, e),
            "pcellnoise" => self.noise_of("pnoise_cell", args, e),
            "phashnoise" => self.noise_of("pnoise_hash", args, e),
            "hash" => {
                let row = if args[0].ty == Type::STRING { "hash_string" } else { "hash_value" };
                let values = self.values(args);
                self.internal(row, arg_values(&values), ty, span)
            }
            "spline" | "splineinverse" => self.spline(name, args, e)?,
            "texture" | "texture3d" | "environment" => self.texture(name, args, e)?,
            "gettextureinfo" => return self.textureinfo(args, e),
            "raytype" => {
                let names = RAY_TYPES.map(|r| r.0);
                self.by_name("ray type", &args[0], &names, Ty::Int, Unknown::Silent, |l, i| match i {
                    Some(i) => l.ray_bit(i, span),
                    None => l.int(0, span),
                })
            }
            "iscameraray" => self.ray_bit(0, span),
            "isdiffuseray" => self.ray_bit(2, span),
            "isglossyray" => self.ray_bit(3, span),
            "isshadowray" => self.ray_bit(1, span),
            "isconnected" => match self.parameter(&args[0]) {
                Some(name) => {
                    let name = self.constant(Const::Str(name), span);
                    self.internal("is_connected", vec![Arg::Value(name)], Ty::Int, span)
                }
                None => self.int(0, span),
            },
            // What folding makes of the value tells; arrays, structs and closures are no constants.
            "isconstant" if super::place::is_single(args[0].ty) && args[0].ty.base != Base::Closure => {
                let value = self.expr(&args[0]);
                self.internal("is_constant", vec![Arg::Value(value)], Ty::Int, span)
            }
            "isconstant" => self.int(0, span),
            "arraylength" if self.array(&args[0]).is_some_and(|l| self.is_open(l)) => {
                let array = self.array(&args[0])?;
                self.internal("array_length", vec![Arg::Array(array)], ty, span)
            }
            "arraylength" => {
                // Of an array of structs, each field is an array of its length.
                let len = self.place(&args[0]).first_local().and_then(|l| self.out.locals[l.0 as usize].len);
                let len = len.or_else(|| match args[0].ty.extent {
                    crate::types::Extent::Fixed(n) => Some(n),
                    _ => None,
                });
                match len {
                    Some(n) => self.int(n as i32, span),
                    None => {
                        self.error(Diagnostic::not_yet("E3005", span, "the length of this array"));
                        return None;
                    }
                }
            }
            "printf" | "error" | "warning" | "fprintf" => {
                self.print(name, args, span);
                return None;
            }
            "setmessage" => {
                self.setmessage(args, span);
                return None;
            }
            "getmessage" => return self.getmessage(args, span),
            "getattribute" => return self.getattribute(args, span),
            "dict_value" => return self.dict_value(args, span),
            "trace" => self.trace(args, e),
            "pointcloud_search" => self.pointcloud_search(args, span)?,
            "pointcloud_get" => self.pointcloud_get(args, span)?,
            "pointcloud_write" => self.pointcloud_write(args, span)?,
            // `exit` as a statement is handled there.
            other => {
                self.error(Diagnostic::not_yet("E3001", span, format!("`{other}` here")));
                return None;
            }
        };
        Some(Place::Value(value))
    }

    /// The flattened name of the shader's parameter that an expression names; of a struct its first field's.
    fn parameter(&mut self, e: &Expr) -> Option<String> {
        let Place::Stored(mut storage, None) = self.place(e) else { return None };
        let local = loop {
            match storage {
                Storage::Local(local) => break local,
                Storage::Struct(fields) => storage = fields.into_iter().next()?,
            }
        };
        match self.out.locals[local.0 as usize].kind {
            LocalKind::Param(index) => self.out.params.get(index as usize).map(|p| p.name.clone()),
            _ => None,
        }
    }

    /// Whether a local is an unsized parameter, whose length is known when the group is.
    pub(super) fn is_open(&self, local: LocalId) -> bool {
        let LocalKind::Param(index) = self.out.locals[local.0 as usize].kind else { return false };
        self.out.params.get(index as usize).is_some_and(|p| p.traits.open)
    }

    fn values(&mut self, args: &[Expr]) -> Vec<ValueId> {
        args.iter().map(|a| self.expr(a)).collect()
    }

    fn global(&mut self, global: Global, span: Span) -> ValueId {
        let index = self
            .tree
            .vars
            .iter()
            .position(|v| v.name == global.name() && v.kind == crate::check::typed::VarKind::Global);
        // The checker declares every global before anything else.
        let storage = self.variable(crate::check::typed::VarId(index.unwrap_or(0) as u32));
        self.load(&Place::whole(storage), span)
    }

    fn ray_bit(&mut self, which: usize, span: Span) -> ValueId {
        let bit = self.int(RAY_TYPES[which].1 as i32, span);
        self.internal("raytype_bit", vec![Arg::Value(bit)], Ty::Int, span)
    }

    /// As [`Lower::by_given`] for a name as it is written.
    pub(super) fn by_name(
        &mut self,
        what: &str,
        name: &Expr,
        choices: &[&str],
        ty: Ty,
        unknown: Unknown,
        make: impl FnMut(&mut Self, Option<usize>) -> ValueId,
    ) -> ValueId {
        let name = self.name_of(name);
        self.by_given(what, &name, choices, ty, unknown, make)
    }

    /// Chooses by a string: at once for a literal, else by comparisons in order. `what` names the kind of name; `make` gets
    /// the index of the choice, `None` for a name that is none of them, which `unknown` deals with.
    pub(super) fn by_given(
        &mut self,
        what: &str,
        name: &Name,
        choices: &[&str],
        ty: Ty,
        unknown: Unknown,
        mut make: impl FnMut(&mut Self, Option<usize>) -> ValueId,
    ) -> ValueId {
        let span = name.span;
        if let Some(text) = &name.literal {
            let choice = choices.iter().position(|c| c == text);
            if choice.is_none() && unknown == Unknown::Refused {
                self.error(crate::suggest::unknown_name(what, text, choices, span));
            }
            // The pass `review` warns of what is taken as something else.
            if choice.is_some() || !matches!(unknown, Unknown::Taken(_)) {
                return make(self, choice);
            }
        }
        let given = name.value;
        let result = self.temp(ty);
        self.compare_names(given, choices, 0, span, &mut |l, choice| {
            let taken = match unknown {
                Unknown::Silent => None,
                Unknown::Refused => Some(""),
                Unknown::Taken(as_what) => Some(as_what),
            };
            if let (None, Some(taken)) = (choice, taken) {
                // The pass `review` looks whether this can be reached.
                let texts = [what.to_owned(), choices.join(","), taken.to_owned()];
                let [what, list, taken] = texts.map(|t| l.constant(Const::Str(t), span));
                let reached = l.internal("unknown_name", arg_values(&[what, list, given, taken]), Ty::Int, span);
                let then = l.branch(span, |l| {
                    let value = make(l, None);
                    l.push(Stmt::Store(result, value));
                });
                l.push(Stmt::If(reached, then, crate::ir::Block::default()));
                return l.guard_rest();
            }
            let value = make(l, choice);
            l.push(Stmt::Store(result, value));
        });
        self.value(Inst::Load(result), ty, span)
    }

    fn compare_names(
        &mut self,
        given: ValueId,
        choices: &[&str],
        i: usize,
        span: Span,
        choose: &mut dyn FnMut(&mut Self, Option<usize>),
    ) {
        let Some(choice) = choices.get(i) else { return choose(self, None) };
        let text = self.constant(Const::Str((*choice).to_string()), span);
        let same = self.value(Inst::Binary(BinaryOp::Eq, given, text), Ty::Int, span);
        let then = self.branch(span, |l| choose(l, Some(i)));
        let rest = self.branch(span, |l| l.compare_names(given, choices, i + 1, span, choose));
        self.push(Stmt::If(same, then, rest));
        self.guard_rest();
    }

    pub(super) fn zero_of(&mut self, ty: Ty, span: Span) -> ValueId {
        let base = match ty {
            Ty::Int => Base::Int,
            Ty::Float => Base::Float,
            Ty::Triple => Base::Color,
            Ty::Matrix => Base::Matrix,
            Ty::Str => Base::String,
            Ty::Closure => Base::Closure,
        };
        self.zero(Type::scalar(base), span)
    }

    fn mix(&mut self, args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let values = self.values(args);
        let (a, b, x) = (values[0], values[1], values[2]);
        if e.ty.base == Base::Closure {
            let one = self.constant(Const::Float(1.0), span);
            let one = self.convert_value(one, self.ty_of(x), span);
            let ty = self.ty_of(x);
            let rest = self.value(Inst::Binary(BinaryOp::Sub, one, x), ty, span);
            let a = self.value(Inst::ScaleClosure(a, rest), Ty::Closure, span);
            let b = self.value(Inst::ScaleClosure(b, x), Ty::Closure, span);
            return self.value(Inst::AddClosure(a, b), Ty::Closure, span);
        }
        let ty = self.ty_of(a);
        let x = self.convert_value(x, ty, span);
        self.internal("mix_float", arg_values(&[a, b, x]), ty, span)
    }

    /// A step that is filtered by a box as wide as both widths together; those that are not given are filter widths.
    fn aastep(&mut self, args: &[Expr], span: Span) -> ValueId {
        let values = self.values(args);
        let (edge, s) = (values[0], values[1]);
        let widths = match values[2..] {
            [dedge, ds] => [dedge, ds],
            [ds] => [self.internal("filterwidth", arg_values(&[edge]), Ty::Float, span), ds],
            _ => [edge, s].map(|v| self.internal("filterwidth", arg_values(&[v]), Ty::Float, span)),
        };
        let sizes = widths.map(|w| self.internal("fabs", arg_values(&[w]), Ty::Float, span));
        let mut number = |c: f64| self.constant(Const::Float(c), span);
        let (half, zero, one) = (number(0.5), number(0.0), number(1.0));
        let mut binary = |op, a, b, ty| self.value(Inst::Binary(op, a, b), ty, span);
        let width = binary(BinaryOp::Add, sizes[0], sizes[1], Ty::Float);
        let half = binary(BinaryOp::Mul, half, width, Ty::Float);
        let (low, high) = (binary(BinaryOp::Sub, edge, half, Ty::Float), binary(BinaryOp::Add, edge, half, Ty::Float));
        let (below, above) = (binary(BinaryOp::Le, s, low, Ty::Int), binary(BinaryOp::Ge, s, high, Ty::Int));
        let offset = binary(BinaryOp::Sub, s, low, Ty::Float);
        let ramp = binary(BinaryOp::Div, offset, width, Ty::Float);
        let upper = self.value(Inst::Select(above, one, ramp), Ty::Float, span);
        self.value(Inst::Select(below, zero, upper), Ty::Float, span)
    }

    fn select(&mut self, args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let values = self.values(args);
        let (a, b, cond) = (values[0], values[1], values[2]);
        let ty = self.ty_of(a);
        let cond = match self.ty_of(cond) {
            Ty::Triple => return self.internal("select_nonzero", arg_values(&[a, b, cond]), ty, span),
            Ty::Float => {
                let zero = self.constant(Const::Float(0.0), span);
                self.value(Inst::Binary(BinaryOp::Ne, cond, zero), Ty::Int, span)
            }
            _ => cond,
        };
        self.value(Inst::Select(cond, b, a), ty, span)
    }

    /// `spline(basis, x, knots[])`, `(basis, x, n, knots[])` or `(basis, x, y0, y1, ...)`. A basis that is not known is
    /// linear, as in the reference implementation.
    fn spline(&mut self, name: &str, args: &[Expr], e: &Expr) -> Option<ValueId> {
        let (ty, span) = (ir_type(e.ty.base), e.span);
        let [basis, x, rest @ ..] = args else { return None };
        let mut call = vec![Arg::Value(self.expr(x))];
        match rest {
            [array] if array.ty.is_array() => call.push(Arg::Array(self.array(array)?)),
            [count, array] if array.ty.is_array() => {
                let whole = self.array(array)?;
                let len = self.out.locals[whole.0 as usize].len.unwrap_or(1);
                if let ExprKind::Int(n) = count.kind
                    && (n < 1 || n as u32 > len && !self.is_open(whole))
                {
                    let message = format!("{n} knots are asked for, but the array has {len}");
                    self.error(Diagnostic::error("E2011", count.span, message));
                    return None;
                }
                call.extend([Arg::Value(self.expr(count)), Arg::Array(whole)]);
            }
            values => {
                // The signature says nothing of the further knots.
                let fits = |v: &Expr| {
                    let number = matches!(v.ty.base, Base::Int | Base::Float);
                    is_single(v.ty) && (number || ty == Ty::Triple && v.ty.base.is_triple())
                };
                if let Some(odd) = values.iter().find(|v| !fits(v)) {
                    let message = format!("a knot of this {name} must be {}", e.ty.base.keyword());
                    self.error(Diagnostic::error("E2003", odd.span, message));
                    return None;
                }
                let values: Vec<ValueId> = values
                    .iter()
                    .map(|v| {
                        let value = self.expr(v);
                        self.convert_value(value, ty, v.span)
                    })
                    .collect();
                call.push(Arg::Array(self.array_of(&values, ty, span)));
            }
        }
        let names = SPLINES.map(|s| s.0);
        let unknown = Unknown::Taken("linear");
        Some(self.by_name("spline basis", basis, &names, ty, unknown, |l, i| {
            let kind = i.map_or("linear", |i| SPLINES[i].1);
            l.internal(&format!("{name}_{kind}"), call.clone(), ty, span)
        }))
    }
}

pub(super) fn arg_values(values: &[ValueId]) -> Vec<Arg> {
    values.iter().map(|v| Arg::Value(*v)).collect()
}
