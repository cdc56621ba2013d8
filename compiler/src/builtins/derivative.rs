//! Which built-ins have derivatives, and which are operators on derivatives.
//!
//! In: a row's name. Out: what `passes::derivatives` does with a call of it. The formulas themselves are IR and live in that
//! pass; compiler/tests/derivatives.rs holds that every row of floats or triples is listed here.
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

/// Rows with results of floats or triples whose derivatives are zero.
const ZERO: &[&str] = &[
    "logb",
    "sign",
    "floor",
    "ceil",
    "round",
    "trunc",
    "step",
    "blackbody_rec709",
    "blackbody_in",
    "wavelength_color_rec709",
    "wavelength_color_in",
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
    "pnoise_cell",
    "pnoise_hash",
    "unknown_name",
    "surfacearea",
    "trace_nearest",
    "cloud_search",
    "cloud_get",
    "splineinverse_constant",
    "environment_lookup",
    "texture_ds",
    "texture_dt",
    "texture3d_ds",
    "texture3d_dt",
    "texture3d_dr",
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
    "luminance_rec709",
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
    "noise_gabor",
    "pnoise_gabor",
    "pnoise_perlin",
    "pnoise_uperlin",
    "texture_lookup",
    "texture3d_lookup",
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

/// Operators on the derivatives of their first argument: the pass puts values in their places. Whatever else wants
/// derivatives, as texture lookups do, takes results of these.
const OPERATORS: &[&str] = &["Dx", "Dy", "Dz", "filterwidth", "area", "calculatenormal"];

/// The derivative of the row's results; `None` when the row is not listed.
pub fn of(name: &str) -> Option<Derivative> {
    if RULES.contains(&name) { Some(Derivative::Rule) } else { ZERO.contains(&name).then_some(Derivative::Zero) }
}

/// Whether the row is an operator on derivatives.
pub fn is_operator(name: &str) -> bool {
    OPERATORS.contains(&name)
}
