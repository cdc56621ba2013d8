//! Coordinate and colour spaces by name: constructors, transforms, matrices.
//!
//! In: typed calls that name spaces. Out: IR that multiplies by the spaces' matrices or calls conversions of colours. A name
//! that is none of those known leaves the value as it is, and the shader says so when it runs, as the reference's does.

use super::place::Place;
use super::special::{Unknown, arg_values};
use super::{ColorSystem, Lower};
use crate::check::typed::{Expr, ExprKind};
use crate::ir::{Arg, BinaryOp, Block, Const, Inst, Stmt, Ty, UnaryOp, ValueId};
use crate::source::Span;
use crate::types::{Base, Type};

/// Spaces by name, with their number in `space_matrix`; the renderer's own follow ([`super::Settings::spaces`]).
const SPACES: [(&str, i32); 8] = [
    ("common", 0),
    ("world", 0),
    ("object", 1),
    ("shader", 2),
    ("camera", 3),
    ("screen", 4),
    ("NDC", 5),
    ("raster", 6),
];

/// Colour spaces by name: row to linear RGB and from it; `None`: is linear RGB, as is the working space's own name.
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

/// Whether a name is one of those known.
#[derive(Clone, Copy)]
enum Known {
    Yes,
    No,
    /// 1 or 0 when the shader runs.
    Told(ValueId),
}

/// A name that is evaluated once, however often it is asked.
#[derive(Clone)]
pub(super) struct Name {
    /// When it is a literal.
    pub literal: Option<String>,
    /// Its value.
    pub value: ValueId,
    pub span: Span,
}

impl Lower<'_> {
    pub(super) fn name_of(&mut self, e: &Expr) -> Name {
        let literal = match &e.kind {
            ExprKind::Str(text) => Some(text.clone()),
            _ => None,
        };
        Name { literal, value: self.expr(e), span: e.span }
    }

    fn known(&mut self, name: &Name, choices: &[&str]) -> Known {
        if let Some(text) = &name.literal {
            return if choices.contains(&text.as_str()) { Known::Yes } else { Known::No };
        }
        let mut known = self.int(0, name.span);
        for choice in choices {
            let text = self.constant(Const::Str((*choice).to_owned()), name.span);
            let same = self.value(Inst::Binary(BinaryOp::Eq, name.value, text), Ty::Int, name.span);
            known = self.value(Inst::Binary(BinaryOp::BitOr, known, same), Ty::Int, name.span);
        }
        Known::Told(known)
    }

    fn both(&mut self, a: Known, b: Known, span: Span) -> Known {
        match (a, b) {
            (Known::No, _) | (_, Known::No) => Known::No,
            (Known::Yes, other) | (other, Known::Yes) => other,
            (Known::Told(a), Known::Told(b)) => {
                Known::Told(self.value(Inst::Binary(BinaryOp::BitAnd, a, b), Ty::Int, span))
            }
        }
    }

    /// The changed value where the names are known, else the one as it was.
    fn if_known(&mut self, known: Known, changed: ValueId, unchanged: ValueId, span: Span) -> ValueId {
        match known {
            Known::Yes => changed,
            Known::No => unchanged,
            Known::Told(k) => {
                let ty = self.ty_of(changed);
                self.value(Inst::Select(k, changed, unchanged), ty, span)
            }
        }
    }

    /// Says so at run time where a name is not known.
    fn complain(&mut self, known: Known, format: &str, names: &[ValueId], span: Span) {
        match known {
            Known::Yes => {}
            Known::No => self.report_error(format, names, span),
            Known::Told(k) => {
                let unknown = self.value(Inst::Unary(UnaryOp::Not, k), Ty::Int, span);
                let then = self.in_block(|l| l.report_error(format, names, span));
                self.push(Stmt::If(unknown, then, Block::default()));
            }
        }
    }

    fn space_names(&self) -> Vec<(String, i32)> {
        let own = self.settings.spaces.iter().zip(SPACES.len() as i32 - 1..).map(|(name, i)| (name.clone(), i));
        SPACES.iter().map(|(name, i)| ((*name).to_owned(), *i)).chain(own).collect()
    }

    /// The matrix from a space to common (`to_common`) or back, the identity for one that is not known; and whether it is.
    fn space(&mut self, name: &Name, to_common: bool) -> (ValueId, Known) {
        let span = name.span;
        let spaces = self.space_names();
        let names: Vec<&str> = spaces.iter().map(|s| s.0.as_str()).collect();
        let known = self.known(name, &names);
        let matrix = self.by_given("space", name, &names, Ty::Matrix, Unknown::Silent, |l, i| {
            let number = i.map_or(0, |i| spaces[i].1);
            if number == 0 {
                let one = l.constant(Const::Float(1.0), span);
                return l.value(Inst::Convert(one), Ty::Matrix, span);
            }
            let number = l.int(number, span);
            let row = if to_common { "space_matrix" } else { "space_matrix_inverse" };
            l.internal(row, vec![Arg::Value(number)], Ty::Matrix, span)
        });
        self.complain(known, "Unknown transformation \"%s\"", &[name.value], span);
        (matrix, known)
    }

    /// Whether a space is certainly the common one, so that nothing needs to be done.
    fn is_common(name: &Name) -> bool {
        name.literal.as_ref().is_some_and(|s| SPACES.iter().any(|(n, i)| n == s && *i == 0))
    }

    pub(super) fn transform(&mut self, formals: &[Type], args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let Some((subject, spaces)) = args.split_last() else { return self.int(0, span) };
        let original = self.expr(subject);
        if formals.first().is_some_and(|f| f.base == Base::Matrix) {
            let matrix = self.expr(&spaces[0]);
            return self.internal(transform_row(e.ty.base), arg_values(&[matrix, original]), Ty::Triple, span);
        }
        let names: Vec<Name> = spaces.iter().map(|s| self.name_of(s)).collect();
        match names.as_slice() {
            [from, to] => self.transform_by(&[(from, true), (to, false)], original, e.ty.base, span),
            [to] => self.transform_by(&[(to, false)], original, e.ty.base, span),
            _ => original,
        }
    }

    /// Through spaces, each with whether the way is to common; as it was where one is not known.
    fn transform_by(&mut self, steps: &[(&Name, bool)], original: ValueId, base: Base, span: Span) -> ValueId {
        let mut value = original;
        let mut all = Known::Yes;
        for (name, to_common) in steps.iter().filter(|(name, _)| !Self::is_common(name)) {
            let (matrix, known) = self.space(name, *to_common);
            all = self.both(all, known, span);
            value = self.internal(transform_row(base), arg_values(&[matrix, value]), Ty::Triple, span);
        }
        self.if_known(all, value, original, span)
    }

    /// 1, or 0 where a space is not known.
    pub(super) fn getmatrix(&mut self, args: &[Expr], e: &Expr) -> Option<Place> {
        let span = e.span;
        let (target, spaces) = args.split_last()?;
        let from = self.name_of(spaces.first()?);
        let (mut matrix, mut known) = self.space(&from, true);
        if let Some(to) = spaces.get(1) {
            let to = self.name_of(to);
            let (back, known_too) = self.space(&to, false);
            matrix = self.value(Inst::Binary(BinaryOp::Mul, matrix, back), Ty::Matrix, span);
            known = self.both(known, known_too, span);
        }
        let place = self.place(target);
        self.store(&place, matrix, span);
        let result = match known {
            Known::Yes => self.int(1, span),
            Known::No => self.int(0, span),
            Known::Told(k) => k,
        };
        Some(Place::Value(result))
    }

    /// A constant matrix that leaves the fourth coordinate alone.
    fn matrix3(&mut self, m: &[[f64; 3]; 3], span: Span) -> ValueId {
        let mut out = [0.0; 16];
        for (i, row) in m.iter().enumerate() {
            out[4 * i..4 * i + 3].copy_from_slice(row);
        }
        out[15] = 1.0;
        self.constant(Const::Matrix(out), span)
    }

    /// To or from XYZ in a working space that is not the default one.
    fn through_xyz(&mut self, value: ValueId, to_rgb: bool, span: Span) -> ValueId {
        let system = self.settings.color_system.clone();
        let matrix = self.matrix3(if to_rgb { &system.xyz_to_rgb } else { &system.rgb_to_xyz }, span);
        self.internal("transform_vector", arg_values(&[matrix, value]), Ty::Triple, span)
    }

    fn is_default_system(&self) -> bool {
        self.settings.color_system == ColorSystem::default()
    }

    fn color_names(&self) -> Vec<&'static str> {
        let own = self.settings.color_system.name;
        let others = COLOR_SPACES.iter().map(|s| s.0).filter(|n| *n != own);
        std::iter::once(own).chain(others).collect()
    }

    fn color_step(&mut self, value: ValueId, name: &Name, to_rgb: bool) -> ValueId {
        let span = name.span;
        let names = self.color_names();
        self.by_given("colour space", name, &names, Ty::Triple, Unknown::Silent, |l, i| {
            let row = i.and_then(|i| COLOR_SPACES.iter().find(|s| s.0 == names[i])).and_then(|s| s.1);
            let Some((to, from)) = row.filter(|_| i != Some(0)) else { return value };
            let call = |l: &mut Self, row: &str, v| l.internal(row, vec![Arg::Value(v)], Ty::Triple, span);
            // The rows speak of the default working space: from there to XYZ, then to the other.
            match (l.is_default_system(), to, to_rgb) {
                (false, "xyz_to_rgb", _) => l.through_xyz(value, to_rgb, span),
                (false, "xyy_to_rgb", true) => {
                    let rgb = call(l, to, value);
                    let xyz = call(l, "rgb_to_xyz", rgb);
                    l.through_xyz(xyz, true, span)
                }
                (false, "xyy_to_rgb", false) => {
                    let xyz = l.through_xyz(value, false, span);
                    let rgb = call(l, "xyz_to_rgb", xyz);
                    call(l, from, rgb)
                }
                _ => call(l, if to_rgb { to } else { from }, value),
            }
        })
    }

    pub(super) fn transformc(&mut self, args: &[Expr], span: Span) -> ValueId {
        let Some((subject, spaces)) = args.split_last() else { return self.int(0, span) };
        let original = self.expr(subject);
        let mut names: Vec<Name> = spaces.iter().map(|s| self.name_of(s)).collect();
        if let [_] = names.as_slice() {
            let value = self.constant(Const::Str("RGB".to_owned()), span);
            names.insert(0, Name { literal: Some("RGB".to_owned()), value, span });
        }
        let [from, to] = names.as_slice() else { return original };
        self.color_between(from, to, original, span)
    }

    fn color_between(&mut self, from: &Name, to: &Name, original: ValueId, span: Span) -> ValueId {
        let choices = self.color_names();
        let known = [from, to].map(|n| self.known(n, &choices));
        let known = self.both(known[0], known[1], span);
        let format = "Unknown color space transformation \"%s\" -> \"%s\"";
        self.complain(known, format, &[from.value, to.value], span);
        let rgb = self.color_step(original, from, true);
        let value = self.color_step(rgb, to, false);
        self.if_known(known, value, original, span)
    }

    pub(super) fn luminance(&mut self, args: &[Expr], span: Span) -> ValueId {
        let value = self.expr(&args[0]);
        if self.is_default_system() {
            return self.internal("luminance_rec709", vec![Arg::Value(value)], Ty::Float, span);
        }
        let weights = Const::Triple(self.settings.color_system.luminance);
        let weights = self.constant(weights, span);
        self.internal("dot", arg_values(&[value, weights]), Ty::Float, span)
    }

    /// `blackbody` and `wavelength_color`: rows that take the conversion from XYZ.
    pub(super) fn spectrum(&mut self, name: &str, args: &[Expr], span: Span) -> ValueId {
        let value = self.expr(&args[0]);
        if self.is_default_system() {
            return self.internal(&format!("{name}_rec709"), vec![Arg::Value(value)], Ty::Triple, span);
        }
        let m = self.settings.color_system.xyz_to_rgb;
        let matrix = self.matrix3(&m, span);
        self.internal(&format!("{name}_in"), arg_values(&[value, matrix]), Ty::Triple, span)
    }

    /// `color(...)`, `point(space, ...)`, `matrix(...)` of more than one argument.
    pub(super) fn construct(&mut self, args: &[Expr], e: &Expr) -> ValueId {
        let span = e.span;
        let strings = args.iter().take_while(|a| a.ty == Type::STRING).count();
        let names: Vec<Name> = args[..strings].iter().map(|a| self.name_of(a)).collect();
        let numbers: Vec<ValueId> = args[strings..].iter().map(|a| self.expr(a)).collect();
        if e.ty.base == Base::Matrix {
            let mut matrix = match numbers.len() {
                16 => {
                    // The length was just checked.
                    let mut parts = [numbers[0]; 16];
                    parts.copy_from_slice(&numbers);
                    self.value(Inst::Matrix(Box::new(parts)), Ty::Matrix, span)
                }
                1 => self.convert_value(numbers[0], Ty::Matrix, span),
                _ => self.space(&names[0], true).0,
            };
            if let [_, to] = names.as_slice() {
                let (back, _) = self.space(to, false);
                matrix = self.value(Inst::Binary(BinaryOp::Mul, matrix, back), Ty::Matrix, span);
            } else if let [space] = names.as_slice()
                && !Self::is_common(space)
            {
                // Given in a space, the matrix maps to common: first the space's own way there.
                let (from, _) = self.space(space, true);
                matrix = self.value(Inst::Binary(BinaryOp::Mul, from, matrix), Ty::Matrix, span);
            }
            return matrix;
        }
        let triple = match numbers.as_slice() {
            [x, y, z] => self.value(Inst::Triple([*x, *y, *z]), Ty::Triple, span),
            [x, ..] => self.convert_value(*x, Ty::Triple, span),
            [] => self.zero(e.ty, span),
        };
        let Some(space) = names.first() else { return triple };
        if e.ty.base == Base::Color {
            let value = self.constant(Const::Str("RGB".to_owned()), span);
            let rgb = Name { literal: Some("RGB".to_owned()), value, span };
            return self.color_between(space, &rgb, triple, span);
        }
        self.transform_by(&[(space, true)], triple, e.ty.base, span)
    }
}

/// Points, vectors and normals go through a matrix in ways of their own.
fn transform_row(base: Base) -> &'static str {
    match base {
        Base::Point => "transform_point",
        Base::Normal => "transform_normal",
        _ => "transform_vector",
    }
}
