//! Texture functions: coordinates, their derivatives and the options become the arguments of one pure call.
//!
//! `texture` is `texture_lookup` of file; s, t, dsdx, dtdx, dsdy, dtdy; mode, first channel, subimage, its name; swidth,
//! twidth, sblur, tblur, fill; colour of a missing file. Where a call gives no derivatives, they are `Dx` and `Dy` of the
//! coordinates. Bits of the mode: [`crate::textures`]. `alpha` is a second lookup, of the channel behind the result's;
//! `errormessage` is `texture_error`.

use super::place::Place;
use super::special::{Unknown, arg_values};
use super::{Lower, ir_type};
use crate::builtins::{self, Lowering};
use crate::check::typed::{Expr, ExprKind, VarKind};
use crate::diag::Diagnostic;
use crate::ir::{Arg, BinaryOp, Const, Inst, LocalId, Stmt, Ty, ValueId};
use crate::source::Span;
use crate::suggest;
use crate::textures::{INTERPS, MODE_INTERP, MODE_MISSING, MODE_QUIET, MODE_R, MODE_T, WRAPS};
use crate::types::{Base, Type};

/// Names of the options.
const OPTIONS: [&str; 23] = [
    "blur",
    "sblur",
    "tblur",
    "rblur",
    "width",
    "swidth",
    "twidth",
    "rwidth",
    "wrap",
    "swrap",
    "twrap",
    "rwrap",
    "fill",
    "firstchannel",
    "subimage",
    "interp",
    "colorspace",
    "missingcolor",
    "missingalpha",
    "alpha",
    "errormessage",
    "time",
    "",
];

/// The options of a call, those not given at their defaults.
struct Options<'a> {
    /// s, t, r.
    wraps: [Option<ValueId>; 3],
    interp: Option<ValueId>,
    /// s, t.
    width: [Option<ValueId>; 2],
    blur: [Option<ValueId>; 2],
    fill: Option<ValueId>,
    first: Option<ValueId>,
    subimage: Option<ValueId>,
    subimage_name: Option<ValueId>,
    missing_color: Option<ValueId>,
    missing_alpha: Option<ValueId>,
    alpha: Option<&'a Expr>,
    message: Option<&'a Expr>,
}

/// What a call looks up, before its options.
enum Coordinates {
    /// s, t, dsdx, dtdx, dsdy, dtdy
    Plane([ValueId; 6]),
    /// The position.
    Volume(ValueId),
    /// R, dRdx, dRdy
    Direction([ValueId; 3]),
}

impl<'a> Lower<'a> {
    /// `texture`, `texture3d` and `environment`.
    pub(super) fn texture(&mut self, name: &str, args: &[Expr], e: &Expr) -> Option<ValueId> {
        let span = e.span;
        let file = self.expr(&args[0]);
        let is_number = |a: &Expr| !a.ty.is_array() && matches!(a.ty.base, Base::Int | Base::Float);
        let is_triple = |a: &Expr| !a.ty.is_array() && a.ty.base.is_triple();
        let (at, rest) = match name {
            "texture" => {
                let count = args[3..].iter().take_while(|a| is_number(a)).count();
                if !matches!(count, 0 | 4) {
                    return self.wrong_derivatives(name, "dsdx, dtdx, dsdy, dtdy", args[3..][0].span);
                }
                let (s, t) = (self.expr(&args[1]), self.expr(&args[2]));
                let derivatives = if count == 4 {
                    [3, 4, 5, 6].map(|i| {
                        let value = self.expr(&args[i]);
                        self.convert_value(value, Ty::Float, args[i].span)
                    })
                } else {
                    [("Dx", s), ("Dx", t), ("Dy", s), ("Dy", t)].map(|(d, v)| self.derivative(d, v, span))
                };
                let [a, b, c, d] = derivatives;
                (Coordinates::Plane([s, t, a, b, c, d]), &args[3 + count..])
            }
            "texture3d" => {
                let count = args[2..].iter().take_while(|a| is_triple(a)).count();
                if !matches!(count, 0 | 3) {
                    return self.wrong_derivatives(name, "dPdx, dPdy, dPdz", args[2].span);
                }
                // The reference does not filter volumes, whatever the derivatives.
                (Coordinates::Volume(self.expr(&args[1])), &args[2 + count..])
            }
            _ => {
                let count = args[2..].iter().take_while(|a| is_triple(a)).count();
                if !matches!(count, 0 | 2) {
                    return self.wrong_derivatives(name, "dRdx, dRdy", args[2].span);
                }
                let r = self.expr(&args[1]);
                let [a, b] = if count == 2 {
                    [2, 3].map(|i| self.expr(&args[i]))
                } else {
                    [("Dx", r), ("Dy", r)].map(|(d, v)| self.derivative(d, v, span))
                };
                (Coordinates::Direction([r, a, b]), &args[2 + count..])
            }
        };
        let options = self.texture_options(name, rest)?;
        Some(self.texture_call(file, &at, &options, e))
    }

    fn wrong_derivatives(&mut self, name: &str, wanted: &str, at: Span) -> Option<ValueId> {
        let message = format!("`{name}` takes all derivatives, {wanted}, or none");
        self.error(Diagnostic::error("E2016", at, message).help("options come as pairs of a name and a value"));
        None
    }

    /// `Dx` or `Dy` of a coordinate.
    fn derivative(&mut self, row: &str, value: ValueId, span: Span) -> ValueId {
        let ty = self.ty_of(value);
        let known = builtins::find(row).is_some_and(|id| builtins::row(id).lowering != Lowering::NotYet);
        if known {
            return self.internal(row, vec![Arg::Value(value)], ty, span);
        }
        match ty {
            Ty::Triple => self.constant(Const::Triple([0.0; 3]), span),
            _ => self.constant(Const::Float(0.0), span),
        }
    }

    /// Reads pairs of name and value.
    fn texture_options<'e>(&mut self, call: &str, args: &'e [Expr]) -> Option<Options<'e>> {
        let mut o = Options {
            wraps: [None; 3],
            interp: None,
            width: [None; 2],
            blur: [None; 2],
            fill: None,
            first: None,
            subimage: None,
            subimage_name: None,
            missing_color: None,
            missing_alpha: None,
            alpha: None,
            message: None,
        };
        let mut fine = true;
        for pair in args.chunks(2) {
            let ExprKind::Str(name) = &pair[0].kind else {
                let message = format!("`{call}` takes pairs of an option's name, a string literal, and its value");
                self.error(Diagnostic::error("E2016", pair[0].span, message));
                return None;
            };
            let Some(value) = pair.get(1) else {
                let message = format!("the option \"{name}\" of `{call}` has no value");
                self.error(Diagnostic::error("E2016", pair[0].span, message));
                return None;
            };
            fine &= self.texture_option(call, name, pair[0].span, value, &mut o);
        }
        fine.then_some(o)
    }

    fn texture_option<'e>(&mut self, call: &str, name: &str, at: Span, value: &'e Expr, o: &mut Options<'e>) -> bool {
        if !OPTIONS.contains(&name) {
            let message = format!("`{call}` has no option \"{name}\"");
            let known: Vec<&str> = OPTIONS.iter().copied().filter(|n| !n.is_empty()).collect();
            self.error(Diagnostic::error("E2016", at, message).help(suggest::known_names(name, &known)));
            return false;
        }
        let ty = value.ty;
        let wanted = match name {
            // An empty name is passed over, whatever its value.
            "" => return true,
            "subimage" if matches!(ty, Type::STRING) || ty == Type::scalar(Base::Int) => None,
            "subimage" => Some("an int or a string"),
            "firstchannel" if ty != Type::scalar(Base::Int) => Some("an int"),
            "wrap" | "swrap" | "twrap" | "rwrap" | "interp" | "colorspace" | "errormessage" if ty != Type::STRING => {
                Some("a string")
            }
            "missingcolor" if ty.is_array() || !ty.base.is_triple() => Some("a color"),
            "alpha" if ty != Type::scalar(Base::Float) => Some("a float variable"),
            "blur" | "sblur" | "tblur" | "rblur" | "width" | "swidth" | "twidth" | "rwidth" | "fill"
            | "missingalpha" | "time"
                if ty != Type::scalar(Base::Float) && ty != Type::scalar(Base::Int) =>
            {
                Some("a float")
            }
            "alpha" | "errormessage" if !self.can_be_written(value) => Some("a variable that can be written"),
            _ => None,
        };
        if let Some(wanted) = wanted {
            let message = format!("the option \"{name}\" of `{call}` takes {wanted}");
            self.error(Diagnostic::error("E2016", value.span, message));
            return false;
        }
        match name {
            "alpha" => o.alpha = Some(value),
            "errormessage" => o.message = Some(value),
            "missingcolor" => o.missing_color = Some(self.expr(value)),
            "missingalpha" => o.missing_alpha = Some(self.number(value)),
            "fill" => o.fill = Some(self.number(value)),
            "firstchannel" => o.first = Some(self.expr(value)),
            "subimage" if ty == Type::STRING => o.subimage_name = Some(self.expr(value)),
            "subimage" => {
                o.subimage = Some(self.expr(value));
                o.subimage_name = None;
            }
            "interp" => o.interp = Some(self.code_of("interpolation", value, &INTERPS)),
            "wrap" => o.wraps = [Some(self.code_of("wrap mode", value, &WRAPS)); 3],
            "swrap" => o.wraps[0] = Some(self.code_of("wrap mode", value, &WRAPS)),
            "twrap" => o.wraps[1] = Some(self.code_of("wrap mode", value, &WRAPS)),
            "rwrap" => o.wraps[2] = Some(self.code_of("wrap mode", value, &WRAPS)),
            "width" => o.width = [Some(self.number(value)); 2],
            "swidth" => o.width[0] = Some(self.number(value)),
            "twidth" => o.width[1] = Some(self.number(value)),
            "blur" => o.blur = [Some(self.number(value)); 2],
            "sblur" => o.blur[0] = Some(self.number(value)),
            "tblur" => o.blur[1] = Some(self.number(value)),
            // As in the reference, `colorspace` and `time` are accepted and change nothing, and volumes are not filtered.
            _ => {}
        }
        true
    }

    fn number(&mut self, e: &Expr) -> ValueId {
        let value = self.expr(e);
        self.convert_value(value, Ty::Float, e.span)
    }

    /// The place of a name among those known; unknown ones are the first, the default, as in the reference.
    fn code_of(&mut self, what: &str, name: &Expr, known: &[&str]) -> ValueId {
        let span = name.span;
        self.by_name(what, name, known, Ty::Int, Unknown::Silent, |l, i| l.int(i.unwrap_or(0) as i32, span))
    }

    pub(super) fn can_be_written(&self, e: &Expr) -> bool {
        match &e.kind {
            // The checker warns of functions that write their parameters, and refuses it where it counts.
            ExprKind::Var(id) => self.tree.var(*id).writable || self.tree.var(*id).kind == VarKind::FunctionParam,
            ExprKind::Index(base, _)
            | ExprKind::Component(base, _)
            | ExprKind::Element(base, ..)
            | ExprKind::Field(base, _) => self.can_be_written(base),
            _ => false,
        }
    }

    fn or_float(&mut self, value: Option<ValueId>, default: f64, span: Span) -> ValueId {
        value.unwrap_or_else(|| self.constant(Const::Float(default), span))
    }

    fn or_int(&mut self, value: Option<ValueId>, default: i32, span: Span) -> ValueId {
        value.unwrap_or_else(|| self.int(default, span))
    }

    /// The calls, the stores of alpha and message; the result.
    fn texture_call(&mut self, file: ValueId, at: &Coordinates, o: &Options<'_>, e: &Expr) -> ValueId {
        let span = e.span;
        let ty = ir_type(e.ty.base);
        let mode = self.texture_mode(o, span);
        let first = self.or_int(o.first, 0, span);
        let subimage = self.or_int(o.subimage, 0, span);
        let subimage_name = o.subimage_name.unwrap_or_else(|| self.constant(Const::Str(String::new()), span));
        let fill = self.or_float(o.fill, 0.0, span);
        let black = self.constant(Const::Triple([0.0; 3]), span);
        let missing = o.missing_color.unwrap_or(black);
        let row = match at {
            Coordinates::Plane(_) => "texture_lookup",
            Coordinates::Volume(_) => "texture3d_lookup",
            Coordinates::Direction(_) => "environment_lookup",
        };
        let mut before = vec![file];
        let mut after = Vec::new();
        match at {
            Coordinates::Plane(values) => before.extend(values),
            Coordinates::Volume(p) => before.push(*p),
            Coordinates::Direction(values) => before.extend(values),
        }
        before.push(mode);
        if !matches!(at, Coordinates::Volume(_)) {
            after.extend(o.width.map(|w| self.or_float(w, 1.0, span)));
            after.extend(o.blur.map(|b| self.or_float(b, 0.0, span)));
        }
        after.push(fill);
        let args = |first: ValueId, missing: ValueId| {
            let all = before.iter().copied().chain([first, subimage, subimage_name]);
            arg_values(&all.chain(after.iter().copied()).chain([missing]).collect::<Vec<_>>())
        };
        let result = self.internal(row, args(first, missing), ty, span);
        let alpha = o.alpha.map(|target| {
            let step = self.int(if ty == Ty::Triple { 3 } else { 1 }, span);
            let behind = self.value(Inst::Binary(BinaryOp::Add, first, step), Ty::Int, span);
            let missing = self.or_float(o.missing_alpha, 0.0, span);
            let missing = self.convert_value(missing, Ty::Triple, span);
            (target, self.internal(row, args(behind, missing), Ty::Float, span))
        });
        let message =
            o.message.map(|target| (target, self.texture_message(file, at, o, subimage, subimage_name, span)));
        for (target, value) in alpha.into_iter().chain(message) {
            let place = self.place(target);
            self.store(&place, value, target.span);
        }
        result
    }

    fn texture_message(
        &mut self,
        file: ValueId,
        at: &Coordinates,
        o: &Options<'_>,
        subimage: ValueId,
        subimage_name: ValueId,
        span: Span,
    ) -> ValueId {
        // Where a colour stands in for the file, nothing is wrong.
        if o.missing_color.is_some() || o.missing_alpha.is_some() {
            return self.constant(Const::Str(String::new()), span);
        }
        let (s, t) = match at {
            Coordinates::Plane([s, t, ..]) => (*s, *t),
            _ => {
                let zero = self.constant(Const::Float(0.0), span);
                (zero, zero)
            }
        };
        let args = arg_values(&[file, s, t, subimage, subimage_name]);
        self.internal("texture_error", args, Ty::Str, span)
    }

    /// The mode of a call: one number, a constant where its parts are.
    fn texture_mode(&mut self, o: &Options<'_>, span: Span) -> ValueId {
        let has_missing = o.missing_color.is_some() || o.missing_alpha.is_some();
        let flag = |set: bool, bit: i32| if set { bit } else { 0 };
        let mut mode = self.int(flag(has_missing, MODE_MISSING) + flag(o.message.is_some(), MODE_QUIET), span);
        let parts = [(o.wraps[0], 1), (o.wraps[1], MODE_T), (o.wraps[2], MODE_R), (o.interp, MODE_INTERP)];
        for (value, weight) in parts {
            let Some(value) = value else { continue };
            let weight = self.int(weight, span);
            let part = self.value(Inst::Binary(BinaryOp::Mul, value, weight), Ty::Int, span);
            mode = self.value(Inst::Binary(BinaryOp::Add, mode, part), Ty::Int, span);
        }
        mode
    }

    /// `gettextureinfo(file, [s, t,] name, output)`: one call that the pass `textures` answers.
    pub(super) fn textureinfo(&mut self, args: &[Expr], e: &Expr) -> Option<Place> {
        let span = e.span;
        let [file, st @ .., name, target] = args else { return None };
        if matches!(target.ty.base, Base::Closure | Base::Struct(_) | Base::Void) || !self.can_be_written(target) {
            let message = "the last argument of `gettextureinfo` is a variable that the answer is written to";
            self.error(Diagnostic::error("E2016", target.span, message));
            return None;
        }
        let file = self.expr(file);
        let given = self.int((!st.is_empty()) as i32, span);
        let mut coordinates: Vec<ValueId> = st.iter().map(|c| self.number(c)).collect();
        while coordinates.len() < 2 {
            coordinates.push(self.constant(Const::Float(0.0), span));
        }
        let name = self.expr(name);
        let place = self.place(target);
        let (local, copy_back): (LocalId, bool) = match &place {
            Place::Stored(super::Storage::Local(local), None) => (*local, false),
            _ => {
                // What the call does not answer stays as it is.
                let temp = self.temp(ir_type(target.ty.base));
                let old = self.load(&place, target.span);
                self.push(Stmt::Store(temp, old));
                (temp, true)
            }
        };
        let result = self.temp(Ty::Int);
        let func = builtins::find("textureinfo")?;
        let args = arg_values(&[file, coordinates[0], coordinates[1], given, name]);
        self.push(Stmt::Call { func, args, outputs: vec![local], result: Some(result), span });
        if copy_back {
            let value = self.value(Inst::Load(local), ir_type(target.ty.base), target.span);
            self.store(&place, value, target.span);
        }
        Some(Place::whole(super::Storage::Local(result)))
    }
}
