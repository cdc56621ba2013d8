//! Noise calls: kinds and options by name become calls of the rows of one kind.
//!
//! In: typed calls of the noise functions. Out: IR. A kind that is no literal becomes a chain of comparisons, as other names
//! (`special`). It must not know what the kinds compute.

use super::special::{Unknown, arg_values};
use super::{Lower, ir_type};
use crate::check::typed::{Expr, ExprKind};
use crate::diag::Diagnostic;
use crate::ir::{Const, Inst, Ty, ValueId};
use crate::messages::PLACE;
use crate::source::Span;
use crate::suggest;
use crate::types::Type;

/// Kinds by name, with the suffix of their rows. The reference implementation takes some of the synonyms for literals only
/// and others for strings of run time only; here all are known everywhere.
const KINDS: [(&str, &str); 15] = [
    ("uperlin", "uperlin"),
    ("noise", "uperlin"),
    ("perlin", "perlin"),
    ("snoise", "perlin"),
    ("cell", "cell"),
    ("cellnoise", "cell"),
    ("hash", "hash"),
    ("hashnoise", "hash"),
    ("simplex", "simplex"),
    ("simplexnoise", "simplex"),
    ("usimplex", "usimplex"),
    ("usimplexnoise", "usimplex"),
    ("gabor", "gabor"),
    ("null", "null"),
    ("unull", "unull"),
];

/// Those with a period.
const PERIODIC_KINDS: [(&str, &str); 11] = [
    ("uperlin", "uperlin"),
    ("noise", "uperlin"),
    ("pnoise", "uperlin"),
    ("perlin", "perlin"),
    ("snoise", "perlin"),
    ("psnoise", "perlin"),
    ("cell", "cell"),
    ("cellnoise", "cell"),
    ("hash", "hash"),
    ("hashnoise", "hash"),
    ("gabor", "gabor"),
];

/// The optional arguments; only gabor noise reads any.
const OPTIONS: [&str; 5] = ["anisotropic", "direction", "bandwidth", "impulses", "do_filter"];

/// Values of the options in the order of [`OPTIONS`], which is that of the rows' arguments.
type Options = [ValueId; 5];

impl Lower<'_> {
    /// Noise of one kind.
    pub(super) fn noise_of(&mut self, row: &str, args: &[Expr], e: &Expr) -> ValueId {
        let values: Vec<ValueId> = args.iter().map(|a| self.expr(a)).collect();
        self.internal(row, arg_values(&values), ir_type(e.ty.base), e.span)
    }

    /// `noise(x)` and `noise("kind", x, options...)`; `name` is `noise` or `pnoise`.
    pub(super) fn named_noise(&mut self, name: &str, args: &[Expr], e: &Expr) -> ValueId {
        let Some(kind) = args.first().filter(|a| a.ty == Type::STRING) else {
            return self.noise_of(&format!("{name}_uperlin"), args, e);
        };
        // Options start with the first string behind the coordinates.
        let split = args[1..].iter().position(|a| a.ty == Type::STRING).map_or(args.len(), |i| i + 1);
        if let Some(odd) = odd_coordinate(&args[1..split], name == "pnoise") {
            let message = "neither a coordinate nor the name of an optional argument";
            self.error(Diagnostic::error("E2004", odd.span, message));
            return self.zero_of(ir_type(e.ty.base), e.span);
        }
        let coordinates: Vec<ValueId> = args[1..split].iter().map(|c| self.expr(c)).collect();
        let options = self.noise_options(kind, &args[split..], e.span);
        let kinds: &[(&str, &str)] = if name == "noise" { &KINDS } else { &PERIODIC_KINDS };
        let names: Vec<&str> = kinds.iter().map(|k| k.0).collect();
        let (ty, span) = (ir_type(e.ty.base), e.span);
        if let ExprKind::Str(unknown) = &kind.kind
            && self.settings.unknown_noise_runs
            && !names.contains(&unknown.as_str())
        {
            let name = self.constant(Const::Str(unknown.clone()), kind.span);
            self.report_error(&format!("noise type \"%s\" is unknown, called from ({PLACE})"), &[name], span);
            return self.zero_of(ty, span);
        }
        let name_of_kind = self.name_of(kind);
        self.by_given("noise kind", &name_of_kind, &names, ty, Unknown::Refused, |l, i| {
            match i.map_or("", |i| kinds[i].1) {
                "" => {
                    l.report_error("Unknown noise type \"%s\"", &[name_of_kind.value], span);
                    l.zero_of(ty, span)
                }
                "null" => l.zero_of(ty, span),
                "unull" => {
                    let half = l.constant(Const::Float(0.5), span);
                    l.convert_value(half, ty, span)
                }
                "gabor" => l.gabor(name, &coordinates, options, ty, span),
                other => l.internal(&format!("{name}_{other}"), arg_values(&coordinates), ty, span),
            }
        })
    }

    fn noise_options(&mut self, kind: &Expr, args: &[Expr], span: Span) -> Options {
        let gabor = match &kind.kind {
            ExprKind::Str(name) => name == "gabor",
            _ => true,
        };
        let float = |l: &mut Self, x: f64| l.constant(Const::Float(x), span);
        let x = self.constant(Const::Triple([1.0, 0.0, 0.0]), span);
        let mut options = [self.int(0, span), x, float(self, 1.0), float(self, 16.0), self.int(1, span)];
        for pair in args.chunks(2) {
            let [name, value] = pair else {
                let message = "a value must follow the name of an optional argument";
                self.error(Diagnostic::error("E2004", pair[0].span, message));
                break;
            };
            if name.ty != Type::STRING {
                let message = "the name of an optional argument is expected here";
                self.error(Diagnostic::error("E2004", name.span, message));
                continue;
            }
            let given = self.expr(value);
            // What other kinds do not read is not looked at.
            if !gabor {
                continue;
            }
            let ExprKind::Str(text) = &name.kind else {
                let what = "the name of an optional argument that is no literal";
                self.error(Diagnostic::not_yet("E3005", name.span, what));
                continue;
            };
            let Some(at) = OPTIONS.iter().position(|o| o == text) else {
                let message = format!("noise has no optional argument \"{text}\"");
                let help = suggest::known_names(text, &OPTIONS);
                self.error(Diagnostic::error("E2004", name.span, message).help(help));
                continue;
            };
            let fits = match at {
                0 | 4 => value.ty == Type::INT,
                1 => value.ty.base.is_triple() && !value.ty.is_array(),
                _ => value.ty == Type::INT || value.ty == Type::FLOAT,
            };
            if !fits {
                let wanted = ["an int", "a vector", "a number", "a number", "an int"][at];
                let message = format!("the optional argument \"{text}\" takes {wanted}");
                self.error(Diagnostic::error("E2003", value.span, message));
                continue;
            }
            let ty = self.ty_of(options[at]);
            options[at] = self.convert_value(given, ty, value.span);
        }
        options
    }

    /// Gabor noise is always that of a point: missing coordinates are 0, and the reference leaves out a fourth one.
    fn gabor(&mut self, name: &str, coordinates: &[ValueId], options: Options, ty: Ty, span: Span) -> ValueId {
        let half = if name == "noise" { coordinates.len() } else { coordinates.len() / 2 };
        let p = self.point_of(&coordinates[..half], span);
        let mut args = vec![p, self.difference("Dx", p, span), self.difference("Dy", p, span)];
        if half < coordinates.len() {
            args.push(self.point_of(&coordinates[half..], span));
        }
        args.extend(options);
        self.internal(&format!("{name}_gabor"), arg_values(&args), ty, span)
    }

    fn point_of(&mut self, coordinates: &[ValueId], span: Span) -> ValueId {
        if self.ty_of(coordinates[0]) == Ty::Triple {
            return coordinates[0];
        }
        let zero = self.constant(Const::Float(0.0), span);
        let at = |i: usize| coordinates.get(i).copied().unwrap_or(zero);
        self.value(Inst::Triple([at(0), at(1), zero]), Ty::Triple, span)
    }

    /// The difference of a point between neighbouring pixels.
    fn difference(&mut self, row: &str, p: ValueId, span: Span) -> ValueId {
        self.internal(row, arg_values(&[p]), Ty::Triple, span)
    }
}

/// The first argument that is too much for coordinates: one or two floats, a point, or a point and a float; with periods of the
/// same shape behind them. What follows the first coordinates of a call, its signature leaves open.
fn odd_coordinate(coordinates: &[Expr], periodic: bool) -> Option<&Expr> {
    let is_number = |a: &Expr| a.ty == Type::INT || a.ty == Type::FLOAT;
    let is_point = |a: &Expr| a.ty.base.is_triple() && !a.ty.is_array();
    // Of the arguments from `at` on, how many make one set of coordinates of at most `most`.
    let set = |at: usize, most: usize| {
        let first = coordinates.get(at).is_some_and(|a| is_number(a) || is_point(a));
        let second = most > 1 && coordinates.get(at + 1).is_some_and(is_number);
        usize::from(first) + usize::from(first && second)
    };
    let taken = if periodic {
        let half = coordinates.len().div_ceil(2).min(2);
        let first = set(0, half);
        first + set(first, first)
    } else {
        set(0, 2)
    };
    coordinates.get(taken)
}
