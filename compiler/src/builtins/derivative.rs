//! Which built-ins have derivatives, and which take those of their arguments.
//!
//! In: a row's name. Out: what `passes::derivatives` does with a call of it. The formulas themselves are IR and live in that
//! pass; a test there holds that every row of floats or triples is listed here.
//!
//! Where the reference implementation gives zero derivatives (its floor, step, cell noise, spectra...), so do we.

/// How a result depends on arguments, to first order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// Not at all, or the derivative is defined to be zero.
    Zero,
    /// By the formula of that name in `passes::derivatives`.
    Rule,
}

/// What a call does with derivatives of its arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taker {
    /// It is an operator on derivatives (`Dx`): the pass puts values in its place. It reads those of its first argument.
    Operator,
    /// It becomes a call of another row, which takes the derivatives of these arguments behind its other arguments: by x, then
    /// by y, for each.
    Appended(&'static str, &'static [usize]),
}

/// Rows with results of floats or triples whose derivatives are zero.
const ZERO: &[&str] = &[
    "logb",
    "sign",
    "floor",
    "ceil",
    "round",
    "trunc",
    "step",
    "blackbody",
    "wavelength_color",
    "determinant",
    "noise_cell",
    "noise_hash",
    // As in the reference implementation.
    "environment_lookup",
    "texture_ds",
    "texture_dt",
    "texture3d_ds",
    "texture3d_dt",
    "texture3d_dr",
    // The filter's width counts, the slope does not.
    "noise_gabor",
    "pnoise_gabor",
    "pnoise_cell",
    "pnoise_hash",
    "unknown_name",
    "surfacearea",
    "splineinverse_constant",
    "spline_catmullrom_slope",
    "spline_bezier_slope",
    "spline_bspline_slope",
    "spline_hermite_slope",
    "spline_linear_slope",
    "Dx",
    "Dy",
    "Dz",
    "filterwidth",
    "area",
    "calculatenormal",
];

/// Rows with formulas in `passes::derivatives`.
const RULES: &[&str] = &[
    "texture_lookup",
    "texture3d_lookup",
    "radians",
    "degrees",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sincos",
    "sinh",
    "cosh",
    "tanh",
    "pow",
    "exp",
    "exp2",
    "expm1",
    "log",
    "log2",
    "log10",
    "sqrt",
    "inversesqrt",
    "cbrt",
    "hypot",
    "abs",
    "fabs",
    "fmod",
    "mod",
    "min",
    "max",
    "clamp",
    "mix_float",
    "select_nonzero",
    "erf",
    "erfc",
    "linearstep",
    "smoothstep",
    "smooth_linearstep",
    "dot",
    "cross",
    "length",
    "normalize",
    "distance",
    "faceforward_ref",
    "reflect",
    "refract",
    "fresnel",
    "rotate",
    "transform_point",
    "transform_vector",
    "transform_normal",
    "luminance",
    "hsv_to_rgb",
    "rgb_to_hsv",
    "hsl_to_rgb",
    "rgb_to_hsl",
    "yiq_to_rgb",
    "rgb_to_yiq",
    "xyz_to_rgb",
    "rgb_to_xyz",
    "xyy_to_rgb",
    "rgb_to_xyy",
    "srgb_to_rgb",
    "rgb_to_srgb",
    "noise_perlin",
    "noise_uperlin",
    "noise_simplex",
    "noise_usimplex",
    "pnoise_perlin",
    "pnoise_uperlin",
    "spline_catmullrom",
    "spline_bezier",
    "spline_bspline",
    "spline_hermite",
    "spline_linear",
    "spline_constant",
    "splineinverse_catmullrom",
    "splineinverse_bezier",
    "splineinverse_bspline",
    "splineinverse_hermite",
    "splineinverse_linear",
];

const TAKERS: &[(&str, Taker)] = &[
    ("Dx", Taker::Operator),
    ("Dy", Taker::Operator),
    ("Dz", Taker::Operator),
    ("filterwidth", Taker::Operator),
    ("area", Taker::Operator),
    ("calculatenormal", Taker::Operator),
];

/// The derivative of the row's results; `None` when the row is not listed.
pub fn of(name: &str) -> Option<Derivative> {
    if RULES.contains(&name) { Some(Derivative::Rule) } else { ZERO.contains(&name).then_some(Derivative::Zero) }
}

/// What the row does with derivatives of its arguments; `None` for most.
pub fn taker(name: &str) -> Option<Taker> {
    TAKERS.iter().find(|t| t.0 == name).map(|t| t.1)
}
