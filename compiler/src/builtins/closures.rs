//! The rows of the closures (OSL specification ch. 7, "Material closures", and the deprecated set of stdosl.h).

/// What a closure does to the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosureRole {
    /// A scattering lobe: the renderer's `LOBE_*` type with this name, evaluated by `kernels/bsdf/NAME.h`.
    Lobe(&'static str),
    /// Adds radiance; which side emits is the renderer's to say.
    Emission,
    /// Radiance of the environment.
    Background,
    /// Lets light pass straight on.
    Transparent,
    /// Cuts a hole into alpha.
    Holdout,
    /// Writes its weight to a named output; no effect on the picture.
    Debug,
    /// What light meets inside: listed in the artifact; a renderer without media lets light pass as if nothing were there.
    Volume,
    /// `layer(top, base)`: a combination of its arguments, no slot of its own.
    Layer,
}

/// One closure.
#[derive(Clone, Copy, Debug)]
pub struct ClosureRow {
    /// OSL's name.
    pub name: &'static str,
    /// The formal arguments, as in [`super::Row::overloads`]. Token/value pairs may follow in a call.
    pub args: &'static str,
    /// The tokens that a call may give values for, as `TYPE TOKEN=DEFAULT`. In the IR they are arguments behind the formal ones.
    /// `label` is allowed everywhere.
    pub keys: &'static str,
    /// What it does.
    pub role: ClosureRole,
    /// The color argument that is a factor of the weight: the lobe's constructor does not get it.
    pub tint: Option<u8>,
    /// Fields of `ShaderGlobals` that the constructor gets before the arguments.
    pub state: &'static [&'static str],
    /// What is simplified, for a warning (W3002) when the closure is used; empty: nothing.
    pub simplified: &'static str,
}

const fn row(name: &'static str, args: &'static str, role: ClosureRole) -> ClosureRow {
    ClosureRow { name, args, keys: "", role, tint: None, state: &[], simplified: "" }
}

impl ClosureRow {
    const fn keys(self, keys: &'static str) -> ClosureRow {
        ClosureRow { keys, ..self }
    }

    const fn tint(self, index: u8) -> ClosureRow {
        ClosureRow { tint: Some(index), ..self }
    }

    const fn state(self, state: &'static [&'static str]) -> ClosureRow {
        ClosureRow { state, ..self }
    }

    const fn simplified(self, simplified: &'static str) -> ClosureRow {
        ClosureRow { simplified, ..self }
    }

    /// Whether a call can put a thin film on the lobe: then the last two arguments are its thickness and index.
    pub fn takes_film(&self) -> bool {
        self.keys.ends_with(FILM)
    }

    /// The index of the argument that names a microfacet distribution.
    pub fn distribution(&self) -> Option<usize> {
        self.args.split(',').position(|a| a == "string").filter(|_| matches!(self.role, Lobe(_)))
    }
}

use ClosureRole::*;

/// The tokens of a thin film: nanometres, and its index of refraction.
const FILM: &str = "float thinfilm_thickness=0,float thinfilm_ior=1.5";

const DIFFUSES: &str = "scatters like `diffuse` with the same albedo: light leaves where it entered";

/// The row of closures that a header declares and nothing maps. No shader can write its name. In the IR its first argument is how the
/// call looks in print, with conversions for the values that follow.
pub const UNKNOWN: &str = "declared.closure";

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
    row("conductor_bsdf", "normal,vector,float,float,color,color,string", Lobe("conductor")).keys(FILM),
    row("subsurface", "float,float,color,color", Lobe("diffuse")).tint(3).state(&["N"]).simplified(DIFFUSES),
    row("oren_nayar_diffuse_bsdf", "normal,color,float", Lobe("oren_nayar_diffuse"))
        .tint(1)
        .keys("int energy_compensation=0"),
    row("burley_diffuse_bsdf", "normal,color,float", Lobe("burley_diffuse")).tint(1),
    row("dielectric_bsdf", "normal,vector,color,color,float,float,float,string", Lobe("dielectric"))
        .state(&["backfacing"])
        .keys(FILM),
    row(
        "generalized_schlick_bsdf",
        "normal,vector,color,color,float,float,color,color,float,string",
        Lobe("generalized_schlick"),
    )
    .state(&["backfacing"])
    .keys(FILM),
    row("translucent_bsdf", "normal,color", Lobe("translucent")).tint(1),
    row("transparent_bsdf", "", Transparent),
    row("subsurface_bssrdf", "normal,color,color,float", Lobe("diffuse")).tint(1).simplified(DIFFUSES),
    row("sheen_bsdf", "normal,color,float", Lobe("sheen")).tint(1).keys("int mode=0"),
    row(
        "chiang_hair_bsdf",
        "normal,vector,color,color,color,float,float,float,float,float,float,float,float,color",
        Lobe("chiang_hair"),
    ),
    row("anisotropic_vdf", "color,color,float", Volume),
    row("medium_vdf", "color,float,color,float,float,int", Volume),
    row("uniform_edf", "color", Emission).tint(0),
    row("layer", "closure color,closure color", Layer),
    row("isotropic", "", Volume),
    row("henyey_greenstein", "float", Volume),
    row("absorption", "", Volume),
    row(UNKNOWN, "string", Debug),
];
