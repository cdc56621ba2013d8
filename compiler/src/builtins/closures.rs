//! The rows of the closures (OSL specification ch. 7, "Material closures", and the deprecated set of stdosl.h).

/// What a closure does to the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureRole {
    /// A scattering lobe: the renderer's `LOBE_*` type with this name, evaluated by `kernels/bsdf/NAME.h`.
    Lobe(&'static str),
    /// Adds radiance on the front side.
    Emission,
    /// Radiance of the environment.
    Background,
    /// Lets light pass straight on.
    Transparent,
    /// Cuts a hole into alpha.
    Holdout,
    /// Writes its weight to a named output; no effect on the picture.
    Debug,
    /// Checked, but lowering answers "not supported yet".
    NotYet,
}

/// One closure.
#[derive(Clone, Copy, Debug)]
pub struct ClosureRow {
    /// OSL's name.
    pub name: &'static str,
    /// The formal arguments, as in [`super::Row::overloads`]. Token/value pairs may follow in a call.
    pub args: &'static str,
    /// What it does.
    pub role: ClosureRole,
}

const fn row(name: &'static str, args: &'static str, role: ClosureRole) -> ClosureRow {
    ClosureRow { name, args, role }
}

use ClosureRole::*;

/// Every closure. A name may stand in several rows: its overloads.
///
/// The role names the lobe; kernels/lobe.h says which argument goes into which field of `Lobe`.
pub static CLOSURES: &[ClosureRow] = &[
    row("diffuse", "normal", Lobe("diffuse")),
    row("oren_nayar", "normal,float", Lobe("oren_nayar")),
    row("translucent", "normal", Lobe("translucent")),
    row("phong", "normal,float", Lobe("phong")),
    row("ward", "normal,vector,float,float", Lobe("ward")),
    row("microfacet", "string,normal,vector,float,float,float,int", Lobe("microfacet")),
    row("microfacet", "string,normal,float,float,int", Lobe("microfacet")),
    row("reflection", "normal,float", Lobe("reflection")),
    row("reflection", "normal", Lobe("reflection")),
    row("refraction", "normal,float", Lobe("refraction")),
    row("transparent", "", Transparent),
    row("emission", "", Emission),
    row("background", "", Background),
    row("holdout", "", Holdout),
    row("debug", "string", Debug),
    row("conductor_bsdf", "normal,vector,float,float,color,color,string", Lobe("conductor")),
    row("subsurface", "float,float,color,color", NotYet),
    row("oren_nayar_diffuse_bsdf", "normal,color,float", NotYet),
    row("burley_diffuse_bsdf", "normal,color,float", NotYet),
    row("dielectric_bsdf", "normal,vector,color,color,float,float,float,string", NotYet),
    row("generalized_schlick_bsdf", "normal,vector,color,color,float,float,color,color,float,string", NotYet),
    row("translucent_bsdf", "normal,color", NotYet),
    row("transparent_bsdf", "", NotYet),
    row("subsurface_bssrdf", "normal,color,color,float", NotYet),
    row("sheen_bsdf", "normal,color,float", NotYet),
    row(
        "chiang_hair_bsdf",
        "normal,vector,color,color,color,float,float,vector,vector,vector,color,float,float,float",
        NotYet,
    ),
    row("anisotropic_vdf", "color,color,float", NotYet),
    row("medium_vdf", "color,float,color,float,float,int", NotYet),
    row("uniform_edf", "color", NotYet),
    row("layer", "closure color,closure color", NotYet),
];
