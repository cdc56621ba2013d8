//! Built-ins that are not one IR call: names resolved to functions, spaces to matrices, polymorphism spelt out.
//!
//! A name that is a literal is resolved here. One that only a parameter's value tells becomes a chain of comparisons, which
//! specialisation and folding cut down to one branch.

use super::place::{Place, Storage, is_single};
use super::{Lower, ir_type};
use crate::builtins;
use crate::check::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Const, Global, Inst, LocalId, LocalKind, Stmt, Ty, ValueId};
use crate::messages::code;
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

/// Most knots of which a number that is no literal may be taken.
const MAX_COUNTED_KNOTS: u32 = 32;

/// Spaces by name, with their number in `space_matrix`.
const SPACES: [(&str, i32); 5] = [("common", 0), ("world", 0), ("object", 1), ("shader", 2), ("camera", 3)];

/// Ray types by name, with their bit in `ShaderGlobals.raytype` (kernels/globals.h).
const RAY_TYPES: [(&str, i32); 6] =
    [("camera", 1), ("shadow", 2), ("diffuse", 4), ("glossy", 8), ("reflection", 16), ("refraction", 32)];

/// Colour spaces by name: row to linear RGB and from it; `None`: is linear RGB.
const COLOR_SPACES: [(&str, Option<(&str, &str)>); 9] = [
    ("rgb", None),
    ("RGB", None),
    ("linear", None),
    ("hsv", Some(("hsv_to_rgb", "rgb_to_hsv"))),
    ("hsl", Some(("hsl_to_rgb", "rgb_to_hsl"))),
    ("YIQ", Some(("yiq_to_rgb", "rgb_to_yiq"))),
    ("XYZ", Some(("xyz_to_rgb", "rgb_to_xyz"))),
    ("xyY", Some(("xyy_to_rgb", "rgb_to_xyy"))),
    ("sRGB", Some(("srgb_to_rgb", "rgb_to_srgb"))),
];

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
            "raytype" => self.by_name("ray type", &args[0], &RAY_TYPES.map(|r| r.0), Ty::Int, true, |l, i| {
                let bit = l.int(RAY_TYPES[i].1, span);
                l.internal("raytype_bit", vec![Arg::Value(bit)], Ty::Int, span)
            }),
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
    fn is_open(&self, local: LocalId) -> bool {
        let LocalKind::Param(index) = self.out.locals[local.0 as usize].kind else { return false };
        self.out.params.get(index as usize).is_some_and(|p| p.traits.open)
    }

    /// A statement that says something to the host.
    fn print(&mut self, name: &str, args: &[Expr], span: Span) {
        if !self.printable(name, args) {
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
            if is_single(arg.ty) {
                list.push(Arg::Value(self.expr(arg)));
            } else if let Some(local) = self.array(arg) {
                list.push(Arg::Array(local));
            }
        }
        if let Some(func) = builtins::find("print") {
            self.push(Stmt::Call { func, args: list, outputs: Vec::new(), result: None, span });
        }
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
        let bit = self.int(RAY_TYPES[which].1, span);
        self.internal("raytype_bit", vec![Arg::Value(bit)], Ty::Int, span)
    }

    /// Chooses by a string: at once for a literal, else by comparisons in order. `what` names the kind of name. Unknown
    /// names give zero (`or_zero`), or are an error: at once for literals, else of the pass `review`.
    pub(super) fn by_name(
        &mut self,
        what: &str,
        name: &Expr,
        choices: &[&str],
        ty: Ty,
        or_zero: bool,
        mut make: impl FnMut(&mut Self, usize) -> ValueId,
    ) -> ValueId {
        if let ExprKind::Str(text) = &name.kind {
            if let Some(i) = choices.iter().position(|c| c == text) {
                return make(self, i);
            }
            if !or_zero {
                self.error(crate::suggest::unknown_name(what, text, choices, name.span));
            }
            return self.zero_of(ty, name.span);
        }
        let span = name.span;
        let given = self.expr(name);
        let result = self.temp(ty);
        let mut choose = |l: &mut Self, choice: Option<usize>| {
            if let Some(i) = choice {
                return make(l, i);
            }
            if or_zero {
                return l.zero_of(ty, span);
            }
            let texts = [what.to_owned(), choices.join(",")].map(|t| l.constant(Const::Str(t), span));
            l.internal("unknown_name", arg_values(&[texts[0], texts[1], given]), ty, span)
        };
        self.compare_names(given, choices, 0, result, span, &mut choose);
        self.value(Inst::Load(result), ty, span)
    }

    fn compare_names(
        &mut self,
        given: ValueId,
        choices: &[&str],
        i: usize,
        result: crate::ir::LocalId,
        span: Span,
        choose: &mut dyn FnMut(&mut Self, Option<usize>) -> ValueId,
    ) {
        let Some(choice) = choices.get(i) else {
            let value = choose(self, None);
            return self.push(Stmt::Store(result, value));
        };
        let text = self.constant(Const::Str((*choice).to_string()), span);
        let same = self.value(Inst::Binary(BinaryOp::Eq, given, text), Ty::Int, span);
        let then = self.in_block(|l| {
            let value = choose(l, Some(i));
            l.push(Stmt::Store(result, value));
        });
        let rest = self.in_block(|l| l.compare_names(given, choices, i + 1, result, span, choose));
        self.push(Stmt::If(same, then, rest));
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

    /// The matrix from a space to common (`to_common`) or back.
    fn space(&mut self, name: &Expr, to_common: bool) -> ValueId {
        let span = name.span;
        self.by_name("space", name, &SPACES.map(|s| s.0), Ty::Matrix, false, |l, i| {
            let number = SPACES[i].1;
            if number == 0 {
                let one = l.constant(Const::Float(1.0), span);
                return l.value(Inst::Convert(one), Ty::Matrix, span);
            }
            let number = l.int(number, span);
            let row = if to_common { "space_matrix" } else { "space_matrix_inverse" };
            l.internal(row, vec![Arg::Value(number)], Ty::Matrix, span)
        })
    }

    /// Whether a space is certainly the common one, so that nothing needs to be done.
    fn is_common(e: &Expr) -> bool {
        matches!(&e.kind, ExprKind::Str(s) if SPACES.iter().any(|(n, i)| n == s && *i == 0))
    }

    fn transform(&mut self, formals: &[Type], args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let Some((subject, spaces)) = args.split_last() else { return self.int(0, span) };
        let mut value = self.expr(subject);
        let row = match e.ty.base {
            Base::Point => "transform_point",
            Base::Normal => "transform_normal",
            _ => "transform_vector",
        };
        let mut steps = Vec::new();
        if formals.first().is_some_and(|f| f.base == Base::Matrix) {
            steps.push(self.expr(&spaces[0]));
        } else {
            let (from, to) = match spaces {
                [from, to] => (Some(from), to),
                [to, ..] => (None, to),
                [] => return value,
            };
            if let Some(from) = from.filter(|f| !Self::is_common(f)) {
                steps.push(self.space(from, true));
            }
            if !Self::is_common(to) {
                steps.push(self.space(to, false));
            }
        }
        for matrix in steps {
            value = self.internal(row, arg_values(&[matrix, value]), Ty::Triple, span);
        }
        value
    }

    fn getmatrix(&mut self, args: &[Expr], e: &Expr) -> Option<Place> {
        let span = e.span;
        let (target, spaces) = args.split_last()?;
        let mut matrix = self.space(spaces.first()?, true);
        if let Some(to) = spaces.get(1) {
            let back = self.space(to, false);
            matrix = self.value(Inst::Binary(BinaryOp::Mul, matrix, back), Ty::Matrix, span);
        }
        let place = self.place(target);
        self.store(&place, matrix, span);
        // Unknown names were refused already.
        let known = self.int(1, span);
        Some(Place::Value(known))
    }

    fn color_step(&mut self, value: ValueId, space: &Expr, to_rgb: bool) -> ValueId {
        let span = space.span;
        self.by_name("colour space", space, &COLOR_SPACES.map(|s| s.0), Ty::Triple, false, |l, i| {
            match COLOR_SPACES[i].1 {
                None => value,
                Some((to, from)) => {
                    l.internal(if to_rgb { to } else { from }, vec![Arg::Value(value)], Ty::Triple, span)
                }
            }
        })
    }

    fn transformc(&mut self, args: &[Expr], span: Span) -> ValueId {
        let Some((subject, spaces)) = args.split_last() else { return self.int(0, span) };
        let mut value = self.expr(subject);
        let (from, to) = match spaces {
            [from, to] => (Some(from), to),
            [to, ..] => (None, to),
            [] => return value,
        };
        if let Some(from) = from {
            value = self.color_step(value, from, true);
        }
        self.color_step(value, to, false)
    }

    /// `spline(basis, x, knots[])`, `(basis, x, n, knots[])` or `(basis, x, y0, y1, ...)`.
    fn spline(&mut self, name: &str, args: &[Expr], e: &Expr) -> Option<ValueId> {
        let span = e.span;
        let ty = ir_type(e.ty.base);
        let [basis, x, rest @ ..] = args else { return None };
        let position = self.expr(x);
        let knots = match rest {
            [array] if array.ty.is_array() => self.array(array)?,
            [count, array] if array.ty.is_array() => {
                let whole = self.array(array)?;
                let len = self.out.locals[whole.0 as usize].len.unwrap_or(1);
                let ExprKind::Int(n) = count.kind else {
                    return self.spline_of_some(name, basis, position, count, whole, e);
                };
                if n < 1 || n as u32 > len && !self.is_open(whole) {
                    let message = format!("{n} knots are asked for, but the array has {len}");
                    self.error(Diagnostic::error("E2011", count.span, message));
                    return None;
                }
                self.first_knots(whole, n as u32)
            }
            values => {
                let values: Vec<ValueId> = values
                    .iter()
                    .map(|v| {
                        let value = self.expr(v);
                        self.convert_value(value, ty, v.span)
                    })
                    .collect();
                self.array_of(&values, ty, span)
            }
        };
        Some(self.spline_call(name, basis, position, knots, e))
    }

    fn first_knots(&mut self, whole: LocalId, n: u32) -> LocalId {
        let ty = self.out.locals[whole.0 as usize].ty;
        let part = self.local("knots", ty, Some(n), crate::ir::LocalKind::Variable);
        self.push(Stmt::CopyArray(part, whole));
        part
    }

    /// A spline of as many knots as only folding or the device tells, clamped to what there is: a call for each number.
    fn spline_of_some(
        &mut self,
        name: &str,
        basis: &Expr,
        position: ValueId,
        count: &Expr,
        whole: LocalId,
        e: &Expr,
    ) -> Option<ValueId> {
        let len = self.out.locals[whole.0 as usize].len.unwrap_or(1);
        if len > MAX_COUNTED_KNOTS {
            let what = format!("a knot count that is no literal, for more than {MAX_COUNTED_KNOTS} knots,");
            self.error(Diagnostic::not_yet("E3005", count.span, what));
            return None;
        }
        let ty = ir_type(e.ty.base);
        let n = self.expr(count);
        let result = self.temp(ty);
        let value = self.spline_call(name, basis, position, whole, e);
        self.push(Stmt::Store(result, value));
        for k in (1..len).rev() {
            let limit = self.int(k as i32, count.span);
            let fewer = self.value(Inst::Binary(BinaryOp::Le, n, limit), Ty::Int, count.span);
            let then = self.in_block(|l| {
                let part = l.first_knots(whole, k);
                let value = l.spline_call(name, basis, position, part, e);
                l.push(Stmt::Store(result, value));
            });
            self.push(Stmt::If(fewer, then, crate::ir::Block::default()));
        }
        Some(self.value(Inst::Load(result), ty, e.span))
    }

    fn spline_call(&mut self, name: &str, basis: &Expr, position: ValueId, knots: LocalId, e: &Expr) -> ValueId {
        let (ty, span) = (ir_type(e.ty.base), e.span);
        let call = [Arg::Value(position), Arg::Array(knots)];
        self.by_name("spline basis", basis, &SPLINES.map(|s| s.0), ty, false, |l, i| {
            l.internal(&format!("{name}_{}", SPLINES[i].1), call.to_vec(), ty, span)
        })
    }

    /// `color(...)`, `point(space, ...)`, `matrix(...)` of more than one argument.
    pub(super) fn construct(&mut self, args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let strings = args.iter().take_while(|a| a.ty == Type::STRING).count();
        let numbers = self.values(&args[strings..]);
        if e.ty.base == Base::Matrix {
            let mut matrix = match numbers.len() {
                16 => {
                    // The length was just checked.
                    let mut parts = [numbers[0]; 16];
                    parts.copy_from_slice(&numbers);
                    self.value(Inst::Matrix(Box::new(parts)), Ty::Matrix, span)
                }
                1 => self.convert_value(numbers[0], Ty::Matrix, span),
                _ => self.space(&args[0], true),
            };
            if strings == 2 {
                let back = self.space(&args[1], false);
                matrix = self.value(Inst::Binary(BinaryOp::Mul, matrix, back), Ty::Matrix, span);
            } else if strings == 1 && !Self::is_common(&args[0]) {
                // Given in a space, the matrix maps to common: first the space's own way there.
                let from = self.space(&args[0], true);
                matrix = self.value(Inst::Binary(BinaryOp::Mul, from, matrix), Ty::Matrix, span);
            }
            return matrix;
        }
        let triple = match numbers.as_slice() {
            [x, y, z] => self.value(Inst::Triple([*x, *y, *z]), Ty::Triple, span),
            [x, ..] => self.convert_value(*x, Ty::Triple, span),
            [] => self.zero(e.ty, span),
        };
        let Some(space) = args.first().filter(|_| strings > 0) else { return triple };
        match e.ty.base {
            Base::Color => self.color_step(triple, space, true),
            _ if Self::is_common(space) => triple,
            base => {
                let row = match base {
                    Base::Point => "transform_point",
                    Base::Normal => "transform_normal",
                    _ => "transform_vector",
                };
                let matrix = self.space(space, true);
                self.internal(row, arg_values(&[matrix, triple]), Ty::Triple, span)
            }
        }
    }
}

pub(super) fn arg_values(values: &[ValueId]) -> Vec<Arg> {
    values.iter().map(|v| Arg::Value(*v)).collect()
}
