//! The rows of the built-in functions (OSL specification ch. 7), in the order of the specification.

use super::Lowering::{self, *};
use super::Row;

const fn row(name: &'static str, overloads: &'static [&'static str], lowering: Lowering) -> Row {
    Row { name, overloads, lowering }
}

/// Every built-in function.
pub static TABLE: &[Row] = &[
    // Mathematical.
    row("radians", &["T(T)"], Componentwise),
    row("degrees", &["T(T)"], Componentwise),
    row("sin", &["T(T)"], Componentwise),
    row("cos", &["T(T)"], Componentwise),
    row("tan", &["T(T)"], Componentwise),
    row("asin", &["T(T)"], Componentwise),
    row("acos", &["T(T)"], Componentwise),
    row("atan", &["T(T)"], Componentwise),
    row("atan2", &["T(T,T)"], Componentwise),
    row("sincos", &["void(T,out T,out T)"], Direct),
    row("sinh", &["T(T)"], Componentwise),
    row("cosh", &["T(T)"], Componentwise),
    row("tanh", &["T(T)"], Componentwise),
    row("pow", &["T(T,T)", "triple(triple,float)"], Componentwise),
    row("exp", &["T(T)"], Componentwise),
    row("exp2", &["T(T)"], Componentwise),
    row("expm1", &["T(T)"], Componentwise),
    row("log", &["T(T)", "T(T,float)"], Componentwise),
    row("log2", &["T(T)"], Componentwise),
    row("log10", &["T(T)"], Componentwise),
    row("logb", &["T(T)"], Componentwise),
    row("sqrt", &["T(T)"], Componentwise),
    row("inversesqrt", &["T(T)"], Componentwise),
    row("cbrt", &["T(T)"], Componentwise),
    row("hypot", &["float(float,float)", "float(float,float,float)"], Direct),
    row("abs", &["int(int)", "T(T)"], Componentwise),
    row("fabs", &["int(int)", "T(T)"], Componentwise),
    row("sign", &["T(T)"], Componentwise),
    row("floor", &["T(T)"], Componentwise),
    row("ceil", &["T(T)"], Componentwise),
    row("round", &["T(T)"], Componentwise),
    row("trunc", &["T(T)"], Componentwise),
    row("fmod", &["T(T,T)", "triple(triple,float)"], Componentwise),
    row("mod", &["int(int,int)", "T(T,T)", "triple(triple,float)"], Componentwise),
    row("min", &["int(int,int)", "T(T,T)"], Componentwise),
    row("max", &["int(int,int)", "T(T,T)"], Componentwise),
    row("clamp", &["int(int,int,int)", "T(T,T,T)"], Componentwise),
    row(
        "mix",
        &[
            "T(T,T,T)",
            "triple(triple,triple,float)",
            "closure color(closure color,closure color,float)",
            "closure color(closure color,closure color,color)",
        ],
        Special,
    ),
    row("mix_float", &["float(float,float,float)", "vector(vector,vector,vector)"], Internal),
    row("select", &["T(T,T,T)", "triple(triple,triple,float)", "T(T,T,int)"], Special),
    row("select_nonzero", &["vector(vector,vector,vector)"], Internal),
    row("isnan", &["int(float)"], Direct),
    row("isinf", &["int(float)"], Direct),
    row("isfinite", &["int(float)"], Direct),
    row("erf", &["float(float)"], Direct),
    row("erfc", &["float(float)"], Direct),
    // Geometric.
    row("dot", &["float(vector,vector)"], Direct),
    row("cross", &["vector(vector,vector)"], Direct),
    row("length", &["float(vector)", "float(normal)"], Direct),
    row("normalize", &["vector(vector)", "normal(normal)"], Direct),
    row("distance", &["float(point,point)", "float(point,point,point)"], Direct),
    row("faceforward", &["vector(vector,vector,vector)", "vector(vector,vector)"], Special),
    row("faceforward_ref", &["vector(vector,vector,vector)"], Internal),
    row("reflect", &["vector(vector,vector)"], Direct),
    row("refract", &["vector(vector,vector,float)"], Direct),
    row(
        "fresnel",
        &[
            "void(vector,normal,float,out float,out float)",
            "void(vector,normal,float,out float,out float,out vector,out vector)",
        ],
        Direct,
    ),
    row("rotate", &["point(point,float,point,point)", "point(point,float,vector)"], Direct),
    // Special: named spaces become matrices (`space_matrix`), then a product by kind.
    row("transform", &["ptype(string,ptype)", "ptype(string,string,ptype)", "ptype(matrix,ptype)"], Special),
    row("transform_point", &["point(matrix,point)"], Internal),
    row("transform_vector", &["vector(matrix,vector)"], Internal),
    row("transform_normal", &["normal(matrix,normal)"], Internal),
    row("transformu", &["float(string,float)", "float(string,string,float)"], NotYet),
    // Colour.
    // Special: what they are depends on the working space; `_in` takes its conversion from XYZ.
    row("luminance", &["float(color)"], Special),
    row("luminance_rec709", &["float(color)"], Internal),
    row("blackbody", &["color(float)"], Special),
    row("blackbody_rec709", &["color(float)"], Internal),
    row("blackbody_in", &["color(float,matrix)"], Internal),
    row("wavelength_color", &["color(float)"], Special),
    row("wavelength_color_rec709", &["color(float)"], Internal),
    row("wavelength_color_in", &["color(float,matrix)"], Internal),
    // Special: constant space names pick one of the internal conversions below, by way of linear RGB.
    row("transformc", &["color(string,color)", "color(string,string,color)"], Special),
    row("hsv_to_rgb", &["color(color)"], Internal),
    row("rgb_to_hsv", &["color(color)"], Internal),
    row("hsl_to_rgb", &["color(color)"], Internal),
    row("rgb_to_hsl", &["color(color)"], Internal),
    row("yiq_to_rgb", &["color(color)"], Internal),
    row("rgb_to_yiq", &["color(color)"], Internal),
    row("xyz_to_rgb", &["color(color)"], Internal),
    row("rgb_to_xyz", &["color(color)"], Internal),
    row("xyy_to_rgb", &["color(color)"], Internal),
    row("rgb_to_xyy", &["color(color)"], Internal),
    row("srgb_to_rgb", &["color(color)"], Internal),
    row("rgb_to_srgb", &["color(color)"], Internal),
    // Matrix.
    row("getmatrix", &["int(string,string,out matrix)", "int(string,out matrix)"], Special),
    // space_matrix(i): matrix from space i to common; space_matrix_inverse(i): from common to space i.
    // i: 0 common/world, 1 object, 2 shader, 3 camera.
    row("space_matrix", &["matrix(int)"], InternalState),
    row("space_matrix_inverse", &["matrix(int)"], InternalState),
    row("determinant", &["float(matrix)"], Direct),
    row("transpose", &["matrix(matrix)"], Direct),
    // Pattern.
    row("step", &["T(T,T)", "triple(float,triple)"], Componentwise),
    row("linearstep", &["T(T,T,T)", "triple(float,float,triple)"], Componentwise),
    row("smoothstep", &["T(T,T,T)", "triple(float,float,triple)"], Componentwise),
    row("smooth_linearstep", &["T(T,T,T,T)", "triple(float,float,triple,float)"], Componentwise),
    row("aastep", &["float(float,float)", "float(float,float,float)", "float(float,float,float,float)"], Special),
    row("noise", NOISE_NAMED, Special),
    row("snoise", NOISE, Special),
    row("cellnoise", NOISE, Special),
    row("hashnoise", NOISE, Special),
    row("pnoise", PNOISE_NAMED, Special),
    row("psnoise", PNOISE, Special),
    row("pcellnoise", PNOISE, Special),
    row("phashnoise", PNOISE, Special),
    row("noise_perlin", NOISE_KIND, Internal),
    row("noise_uperlin", NOISE_KIND, Internal),
    row("noise_cell", NOISE_KIND, Internal),
    row("noise_hash", NOISE_KIND, Internal),
    row("noise_simplex", NOISE_KIND, Internal),
    row("noise_usimplex", NOISE_KIND, Internal),
    row("noise_gabor", GABOR_KIND, Internal),
    // Slopes of noise: row j holds the derivatives of the result's components by coordinate j.
    row("noise_perlin_slopes", NOISE_SLOPES, Internal),
    row("noise_perlin_slopes_triple", NOISE_SLOPES, Internal),
    row("noise_simplex_slopes", NOISE_SLOPES, Internal),
    row("noise_simplex_slopes_triple", NOISE_SLOPES, Internal),
    row("noise_gabor_slopes", GABOR_SLOPES, Internal),
    row("noise_gabor_slopes_triple", GABOR_SLOPES, Internal),
    row("pnoise_gabor_slopes", PGABOR_SLOPES, Internal),
    row("pnoise_gabor_slopes_triple", PGABOR_SLOPES, Internal),
    row("pnoise_perlin_slopes", PNOISE_SLOPES, Internal),
    row("pnoise_perlin_slopes_triple", PNOISE_SLOPES, Internal),
    row("pnoise_perlin", PNOISE_KIND, Internal),
    row("pnoise_uperlin", PNOISE_KIND, Internal),
    row("pnoise_cell", PNOISE_KIND, Internal),
    row("pnoise_hash", PNOISE_KIND, Internal),
    row("pnoise_gabor", PGABOR_KIND, Internal),
    row(
        "hash",
        &["int(int)", "int(float)", "int(float,float)", "int(point)", "int(point,float)", "int(string)"],
        Special,
    ),
    row("hash_string", &["int(string)"], InternalHost),
    // Whether a name can be none of the known ones: what kind of name, those known (with commas), the name, and as which it
    // is then taken, "" where it is an error.
    row("unknown_name", &["int(string,string,string,string)"], InternalHost),
    row("hash_value", &["int(int)", "int(float)", "int(float,float)", "int(vector)", "int(vector,float)"], Internal),
    row("spline", &["T(string,float,T[])", "T(string,float,int,T[])", "T(string,float,T,...)"], Special),
    row("spline_catmullrom", SPLINE_KIND, Internal),
    row("spline_bezier", SPLINE_KIND, Internal),
    row("spline_bspline", SPLINE_KIND, Internal),
    row("spline_hermite", SPLINE_KIND, Internal),
    row("spline_linear", SPLINE_KIND, Internal),
    row("spline_constant", SPLINE_KIND, Internal),
    // Slopes of splines by their position.
    row("spline_catmullrom_slope", SPLINE_KIND, Internal),
    row("spline_bezier_slope", SPLINE_KIND, Internal),
    row("spline_bspline_slope", SPLINE_KIND, Internal),
    row("spline_hermite_slope", SPLINE_KIND, Internal),
    row("spline_linear_slope", SPLINE_KIND, Internal),
    row(
        "splineinverse",
        &["float(string,float,float[])", "float(string,float,int,float[])", "float(string,float,float,...)"],
        Special,
    ),
    row("splineinverse_catmullrom", SPLINEINVERSE_KIND, Internal),
    row("splineinverse_bezier", SPLINEINVERSE_KIND, Internal),
    row("splineinverse_bspline", SPLINEINVERSE_KIND, Internal),
    row("splineinverse_hermite", SPLINEINVERSE_KIND, Internal),
    row("splineinverse_linear", SPLINEINVERSE_KIND, Internal),
    row("splineinverse_constant", SPLINEINVERSE_KIND, Internal),
    // Derivatives (passes/derivatives replaces the calls).
    row("Dx", &["float(float)", "vector(point)", "vector(vector)", "vector(normal)", "color(color)"], Direct),
    row("Dy", &["float(float)", "vector(point)", "vector(vector)", "vector(normal)", "color(color)"], Direct),
    row("Dz", &["float(float)", "vector(point)", "vector(vector)", "vector(normal)", "color(color)"], Direct),
    row("filterwidth", &["float(float)", "vector(point)", "vector(vector)"], Direct),
    row("area", &["float(point)"], Direct),
    row("calculatenormal", &["vector(point)"], Direct),
    // 1 when raster space and common space turn opposite ways.
    row("flip_handedness", &["int()"], InternalState),
    row("displace", &["void(float)", "void(string,float)", "void(vector)"], NotYet),
    row("bump", &["void(float)", "void(string,float)", "void(vector)"], NotYet),
    // Strings.
    row("printf", &["void(string,...)"], Special),
    row("format", &["string(string,...)"], Host),
    row("error", &["void(string,...)"], Special),
    row("warning", &["void(string,...)"], Special),
    row("fprintf", &["void(string,string,...)"], Special),
    // Kind (`messages::code`), the file's or the shader's name, the format, the values.
    row("print", &["void(int,string,string,...)"], InternalEffect),
    row("concat", &["string(string,string,...)"], Host),
    row("strlen", &["int(string)"], Host),
    row("startswith", &["int(string,string)"], Host),
    row("endswith", &["int(string,string)"], Host),
    row("stoi", &["int(string)"], Host),
    row("stof", &["float(string)"], Host),
    row(
        "split",
        &["int(string,out string[],string,int)", "int(string,out string[],string)", "int(string,out string[])"],
        Host,
    ),
    row("substr", &["string(string,int)", "string(string,int,int)"], Host),
    row("getchar", &["int(string,int)"], Host),
    row("regex_search", &["int(string,string)", "int(string,out int[],string)"], Host),
    row("regex_match", &["int(string,string)", "int(string,out int[],string)"], Host),
    // Texture.
    row(
        "texture",
        &["float(string,float,float,...)", "color(string,float,float,...)", "vector(string,float,float,...)"],
        Special,
    ),
    row("texture3d", &["float(string,point,...)", "color(string,point,...)", "vector(string,point,...)"], Special),
    row("environment", &["float(string,vector,...)", "color(string,vector,...)", "vector(string,vector,...)"], Special),
    row("gettextureinfo", &["int(string,string,any)", "int(string,float,float,string,any)"], Special),
    // The lookups, and their derivatives by s, t and r. `lower::texture` says what each argument is. A lookup's own
    // derivative by x is _ds times that of s plus _dt times that of t; its other arguments have none.
    row("texture_lookup", TEXTURE, InternalState),
    row("texture_ds", TEXTURE, InternalState),
    row("texture_dt", TEXTURE, InternalState),
    row("texture3d_lookup", TEXTURE3D, InternalState),
    row("texture3d_ds", TEXTURE3D, InternalState),
    row("texture3d_dt", TEXTURE3D, InternalState),
    row("texture3d_dr", TEXTURE3D, InternalState),
    row("environment_lookup", ENVIRONMENT, InternalState),
    // File, s, t, subimage by number and by name: the message of a lookup that finds nothing, else "".
    row("texture_error", &["string(string,float,float,int,string)"], InternalState),
    // File, s, t, whether they were given, which information. The pass `textures` answers it.
    row("textureinfo", &["int(string,float,float,int,string,out any)"], Internal),
    row("pointcloud_search", &["int(string,point,float,int,...)"], Special),
    row("pointcloud_get", &["int(string,int[],int,string,...)"], Special),
    row("pointcloud_write", &["int(string,point,...)"], Special),
    // File, place, radius, most: how many points; in arrays their indices and distances, the nearest first.
    row("cloud_count", &["int(string,point,float,int)"], InternalState),
    row("cloud_search", &["int(string,point,float,int,out int[],out float[])"], InternalState),
    // File, indices, how many, attribute: whether it is there in this type.
    row(
        "cloud_get",
        &[
            "int(string,int[],int,string,out int[])",
            "int(string,int[],int,string,out float[])",
            "int(string,int[],int,string,out vector[])",
            "int(string,int[],int,string,out string[])",
        ],
        InternalState,
    ),
    // Whether somebody writes to the point cloud of this name. The pass `clouds` knows.
    row("cloud_write", &["int(string)"], InternalHost),
    // Renderer state.
    row("getattribute", &["int(string,...)"], Special),
    // Object, name, index (-1: none), type, shader's name, layer's, group's. The pass `cases` answers it.
    row("attribute_get", &["int(string,string,int,string,string,string,string,out any)"], InternalHost),
    row("shading_index", &["int()"], InternalState),
    row("setmessage", &["void(string,...)"], Special),
    row("getmessage", &["int(string,...)"], Special),
    // Name, type, value; source, name, type. The pass `dialogue` carries them out.
    row("message_set", &["void(string,string,any)"], InternalHost),
    row("message_get", &["int(string,string,string,out any)"], InternalHost),
    row("surfacearea", &["float()"], State),
    row("raytype", &["int(string)"], Special),
    row("raytype_bit", &["int(int)"], InternalState),
    row("backfacing", &["int()"], State),
    row("isconnected", &["int(any)"], Special),
    // By the flattened name of a parameter; `passes::link` knows the answer.
    row("is_connected", &["int(string)"], InternalHost),
    row("isconstant", &["int(any)"], Special),
    // 1 when folding finds the argument constant, else 0.
    row("is_constant", &["int(int)", "int(float)", "int(vector)", "int(matrix)", "int(string)"], InternalHost),
    row("iscameraray", &["int()"], Special),
    row("isdiffuseray", &["int()"], Special),
    row("isglossyray", &["int()"], Special),
    row("isshadowray", &["int()"], Special),
    // The pass `dictionary` answers these.
    row("dict_find", &["int(string,string)", "int(int,string)"], Host),
    row("dict_next", &["int(int)"], Host),
    row("dict_value", &["int(int,string,...)"], Special),
    // Node, attribute, type.
    row("dict_get", &["int(int,string,string,out any)"], InternalHost),
    row("trace", &["int(point,vector,...)"], Special),
    // From, direction, nearest, farthest, shade, set. The pass `traces` puts one of the others in its place.
    row("trace_call", &["int(vector,vector,float,float,int,string)"], InternalHost),
    // What testshade's renderer answers: it has no surfaces.
    row("trace_hit", &["int(vector,vector)"], InternalState),
    // Whether a ray meets anything; and what it meets first: distance, P, N, Ng, I, dPdu, dPdv, u, v, name (all zero when nothing).
    row("trace_any", &["int(vector,vector,float,float,string)"], InternalState),
    row(
        "trace_nearest",
        &["int(vector,vector,float,float,string,out float,out point,out normal,out normal,out vector,out vector,\
             out vector,out float,out float,out string)"],
        InternalState,
    ),
    row("arraylength", &["int(any[])"], Special),
    // Of an unsized parameter, whose length `passes::link` knows.
    row("array_length", &["int(any[])"], InternalHost),
    row("exit", &["void()"], Special),
    row("random", &["float()", "color()", "point()", "vector()", "normal()"], NotYet),
];

/// Unnamed noise: float and triple results of every coordinate shape.
const NOISE: &[&str] = &[
    "float(float)",
    "float(float,float)",
    "float(point)",
    "float(point,float)",
    "color(float)",
    "color(float,float)",
    "color(point)",
    "color(point,float)",
    "vector(float)",
    "vector(float,float)",
    "vector(point)",
    "vector(point,float)",
    "point(float)",
    "point(float,float)",
    "point(point)",
    "point(point,float)",
    "normal(float)",
    "normal(float,float)",
    "normal(point)",
    "normal(point,float)",
];

/// `noise` also takes the kind first, and options after the coordinates.
const NOISE_NAMED: &[&str] = &[
    "float(float)",
    "float(float,float)",
    "float(point)",
    "float(point,float)",
    "color(float)",
    "color(float,float)",
    "color(point)",
    "color(point,float)",
    "vector(float)",
    "vector(float,float)",
    "vector(point)",
    "vector(point,float)",
    "point(float)",
    "point(float,float)",
    "point(point)",
    "point(point,float)",
    "normal(float)",
    "normal(float,float)",
    "normal(point)",
    "normal(point,float)",
    "float(string,float,...)",
    "float(string,float,float,...)",
    "float(string,point,...)",
    "float(string,point,float,...)",
    "color(string,float,...)",
    "color(string,float,float,...)",
    "color(string,point,...)",
    "color(string,point,float,...)",
    "vector(string,float,...)",
    "vector(string,float,float,...)",
    "vector(string,point,...)",
    "vector(string,point,float,...)",
    "point(string,float,...)",
    "point(string,float,float,...)",
    "point(string,point,...)",
    "point(string,point,float,...)",
    "normal(string,float,...)",
    "normal(string,float,float,...)",
    "normal(string,point,...)",
    "normal(string,point,float,...)",
];

/// Periodic noise: coordinates, then periods of the same shape.
const PNOISE: &[&str] = &[
    "float(float,float)",
    "float(float,float,float,float)",
    "float(point,point)",
    "float(point,float,point,float)",
    "color(float,float)",
    "color(float,float,float,float)",
    "color(point,point)",
    "color(point,float,point,float)",
    "vector(float,float)",
    "vector(float,float,float,float)",
    "vector(point,point)",
    "vector(point,float,point,float)",
    "point(float,float)",
    "point(float,float,float,float)",
    "point(point,point)",
    "point(point,float,point,float)",
    "normal(float,float)",
    "normal(float,float,float,float)",
    "normal(point,point)",
    "normal(point,float,point,float)",
];

/// `pnoise` also takes the kind first, and options at the end.
const PNOISE_NAMED: &[&str] = &[
    "float(float,float)",
    "float(float,float,float,float)",
    "float(point,point)",
    "float(point,float,point,float)",
    "color(float,float)",
    "color(float,float,float,float)",
    "color(point,point)",
    "color(point,float,point,float)",
    "vector(float,float)",
    "vector(float,float,float,float)",
    "vector(point,point)",
    "vector(point,float,point,float)",
    "point(float,float)",
    "point(float,float,float,float)",
    "point(point,point)",
    "point(point,float,point,float)",
    "normal(float,float)",
    "normal(float,float,float,float)",
    "normal(point,point)",
    "normal(point,float,point,float)",
    "float(string,float,float,...)",
    "float(string,float,float,float,float,...)",
    "float(string,point,point,...)",
    "float(string,point,float,point,float,...)",
    "color(string,float,float,...)",
    "color(string,float,float,float,float,...)",
    "color(string,point,point,...)",
    "color(string,point,float,point,float,...)",
    "vector(string,float,float,...)",
    "vector(string,float,float,float,float,...)",
    "vector(string,point,point,...)",
    "vector(string,point,float,point,float,...)",
    "point(string,float,float,...)",
    "point(string,float,float,float,float,...)",
    "point(string,point,point,...)",
    "point(string,point,float,point,float,...)",
    "normal(string,float,float,...)",
    "normal(string,float,float,float,float,...)",
    "normal(string,point,point,...)",
    "normal(string,point,float,point,float,...)",
];

/// One kind of noise after its name was resolved.
const NOISE_KIND: &[&str] = &[
    "float(float)",
    "float(float,float)",
    "float(vector)",
    "float(vector,float)",
    "vector(float)",
    "vector(float,float)",
    "vector(vector)",
    "vector(vector,float)",
];

/// The slopes of one kind of noise.
const NOISE_SLOPES: &[&str] = &["matrix(float)", "matrix(float,float)", "matrix(vector)", "matrix(vector,float)"];

/// Those of Gabor noise, by its point; arguments as of the noise.
const GABOR_SLOPES: &[&str] = &["matrix(vector,vector,vector,int,vector,float,float,int)"];

/// Those of periodic Gabor noise.
const PGABOR_SLOPES: &[&str] = &["matrix(vector,vector,vector,vector,int,vector,float,float,int)"];

/// The slopes of one kind of periodic noise.
const PNOISE_SLOPES: &[&str] = &[
    "matrix(float,float)",
    "matrix(float,float,float,float)",
    "matrix(vector,vector)",
    "matrix(vector,float,vector,float)",
];

/// One kind of periodic noise after its name was resolved.
const PNOISE_KIND: &[&str] = &[
    "float(float,float)",
    "float(float,float,float,float)",
    "float(vector,vector)",
    "float(vector,float,vector,float)",
    "vector(float,float)",
    "vector(float,float,float,float)",
    "vector(vector,vector)",
    "vector(vector,float,vector,float)",
];

/// File; s, t, dsdx, dtdx, dsdy, dtdy; mode, first channel, subimage by number, by name; swidth, twidth, sblur, tblur, fill;
/// colour of a missing file.
const TEXTURE: &[&str] = &[
    "float(string,float,float,float,float,float,float,int,int,int,string,float,float,float,float,float,vector)",
    "vector(string,float,float,float,float,float,float,int,int,int,string,float,float,float,float,float,vector)",
];

/// File; position; mode, first channel, subimage by number, by name; fill; colour of a missing file.
const TEXTURE3D: &[&str] =
    &["float(string,point,int,int,int,string,float,vector)", "vector(string,point,int,int,int,string,float,vector)"];

/// File; R, dRdx, dRdy; the rest as in `TEXTURE`.
const ENVIRONMENT: &[&str] = &[
    "float(string,vector,vector,vector,int,int,int,string,float,float,float,float,float,vector)",
    "vector(string,vector,vector,vector,int,int,int,string,float,float,float,float,float,vector)",
];

/// Point, its differences between pixels along x and y; anisotropic, direction, bandwidth, impulses, do_filter.
const GABOR_KIND: &[&str] = &[
    "float(vector,vector,vector,int,vector,float,float,int)",
    "vector(vector,vector,vector,int,vector,float,float,int)",
];

/// The same with the period after the differences.
const PGABOR_KIND: &[&str] = &[
    "float(vector,vector,vector,vector,int,vector,float,float,int)",
    "vector(vector,vector,vector,vector,int,vector,float,float,int)",
];

/// One basis: position, how many knots, knots.
const SPLINE_KIND: &[&str] =
    &["float(float,float[])", "vector(float,vector[])", "float(float,int,float[])", "vector(float,int,vector[])"];

/// The inverse of one basis: value, knots.
const SPLINEINVERSE_KIND: &[&str] = &["float(float,float[])", "float(float,int,float[])"];
