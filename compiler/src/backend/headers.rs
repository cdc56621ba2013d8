//! Which kernel header holds which function. Only headers in use are included: what is not included costs no build time.

/// The header of an operator's helper.
pub(in crate::backend) fn of_op(name: &str) -> &'static str {
    let of_matrix = name.ends_with("_m") || name == "op_matrix_f";
    if of_matrix { "osl/matrix.h" } else { "osl/ops.h" }
}

/// What the rows of texture lookups start with.
const TEXTURES: [&str; 3] = ["texture", "texture3d", "environment"];

/// The header of a built-in's kernel function, by the name of its row.
pub(in crate::backend) fn of_function(name: &str) -> &'static str {
    if let Some(kind) = name.strip_prefix("noise_").or_else(|| name.strip_prefix("pnoise_")) {
        return match kind {
            "perlin_slopes" | "perlin_slopes_triple" => "osl/noise_perlin_slopes.h",
            "simplex_slopes" | "simplex_slopes_triple" => "osl/noise_simplex_slopes.h",
            "perlin" | "uperlin" => "osl/noise_perlin.h",
            "simplex" | "usimplex" => "osl/noise_simplex.h",
            "cell" => "osl/noise_cell.h",
            "gabor" => "osl/noise_gabor.h",
            "gabor_slopes" | "gabor_slopes_triple" => "osl/noise_gabor_slopes.h",
            _ => "osl/noise_hash.h",
        };
    }
    if name.ends_with("_slope") {
        return "osl/spline_slope.h";
    }
    if name.starts_with("spline") {
        return "osl/spline.h";
    }
    if let Some((kind, _)) = name.split_once('_').filter(|(kind, _)| TEXTURES.contains(kind)) {
        return match kind {
            "texture3d" => "osl/texture3d.h",
            "environment" => "osl/environment.h",
            _ => "osl/texture.h",
        };
    }
    match name {
        "dot" | "cross" | "length" | "normalize" | "distance" | "faceforward_ref" | "reflect" | "refract"
        | "fresnel" | "rotate" => "osl/geometric.h",
        "transform_point" | "transform_vector" | "transform_normal" | "determinant" | "transpose" => "osl/matrix.h",
        "luminance_rec709"
        | "blackbody_rec709"
        | "blackbody_in"
        | "wavelength_color_rec709"
        | "wavelength_color_in"
        | "hsv_to_rgb"
        | "rgb_to_hsv"
        | "hsl_to_rgb"
        | "rgb_to_hsl"
        | "yiq_to_rgb"
        | "rgb_to_yiq"
        | "xyz_to_rgb"
        | "rgb_to_xyz"
        | "xyy_to_rgb"
        | "rgb_to_xyy"
        | "srgb_to_rgb"
        | "rgb_to_srgb" => "osl/color.h",
        "step" | "linearstep" | "smoothstep" | "smooth_linearstep" => "osl/pattern.h",
        "hash_value" => "osl/hash.h",
        "cloud_count" | "cloud_search" | "cloud_get" => "osl/points.h",
        "trace_any" | "trace_nearest" => "osl/trace.h",
        "surfacearea"
        | "backfacing"
        | "shading_index"
        | "trace_hit"
        | "flip_handedness"
        | "raytype_bit"
        | "space_matrix"
        | "space_matrix_inverse" => "osl/state.h",
        _ => "osl/math.h",
    }
}
