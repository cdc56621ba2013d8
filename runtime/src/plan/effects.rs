//! The effects that a scene can call for, and who asked for them.
//!
//! In: a scene and its materials' artifacts. Out: [`Decision`]s. Pure: it must not know devices.

use crate::accel;
use crate::scene::{Filter, Scene};
use oslcl_compiler::attributes::asked;
use oslcl_compiler::{Artifact, Radiance};

macro_rules! effects {
    ($($effect:ident: $name:literal, $text:literal;)*) => {
        /// Something that is simulated only when a scene calls for it. Off means: no code, no buffer, no launch.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Effect {
            $(#[doc = $text] $effect,)*
        }

        impl Effect {
            /// All of them, in the order of the table that `oslcl plan` prints.
            pub const ALL: &'static [Effect] = &[$(Effect::$effect),*];

            /// Its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Effect::$effect => $name,)*
                }
            }

            /// What it is, in a few words.
            pub fn text(self) -> &'static str {
                match self {
                    $(Effect::$effect => $text,)*
                }
            }
        }
    };
}

effects! {
    Surfaces: "surfaces", "surfaces that rays can meet";
    ThinLens: "thin_lens", "depth of field of a thin lens";
    TentFilter: "tent_filter", "samples weighted by a tent around the middle of their pixel";
    MiddleFilter: "middle_filter", "samples of the middles of pixels only";
    TwoSidedEmission: "two_sided_emission", "surfaces that emit on both sides";
    Lights: "lights", "emissive surfaces, sampled directly";
    VaryingLights: "varying_lights", "emission that differs from point to point: light rays ask the shader";
    Environment: "environment", "light from outside the scene";
    VaryingEnvironment: "varying_environment", "environment that differs by direction: paths ask the shader";
    EnvironmentSampling: "environment_sampling", "environment sampled directly, by a map of its radiance";
    SharedCubes: "shared_cubes", "random numbers as testrender takes them";
    Roulette: "roulette", "Russian roulette";
    Instances: "instances", "meshes that are placed more than once: a second level of the tree";
    Displacement: "displacement", "vertices moved by shaders before anything is built";
    Normals: "normals", "interpolated shading normals";
    TrustedNormals: "trusted_normals", "directions may lie below the surface that shading normals are for";
    Uvs: "uvs", "texture coordinates";
    Tangents: "tangents", "dPdu and dPdv";
    Derivatives: "derivatives", "footprints of pixels: Dx(), filterwidth(), filtered textures";
    SurfaceArea: "surface_area", "surfacearea()";
    ObjectSpace: "object_space", "object and shader space";
    CameraSpace: "camera_space", "camera space";
    OtherSpaces: "other_spaces", "screen, NDC and raster space";
    RayType: "raytype", "raytype()";
    Userdata: "userdata", "data of vertices that shaders read";
    Attributes: "attributes", "attributes that differ from object to object";
    Interactive: "interactive", "parameters that change between renders";
    Messages: "messages", "what shaders print";
    Textures: "textures", "texture files";
    TextureCubic: "texture_cubic", "cubic interpolation between texels";
    TextureClosest: "texture_closest", "the closest texel alone";
    Holdout: "holdout", "holdout: an alpha channel";
    LobeDiffuse: "lobe_diffuse", "a lobe of the BSDFs";
    LobeOrenNayar: "lobe_oren_nayar", "a lobe of the BSDFs";
    LobeTranslucent: "lobe_translucent", "a lobe of the BSDFs";
    LobePhong: "lobe_phong", "a lobe of the BSDFs";
    LobeWard: "lobe_ward", "a lobe of the BSDFs";
    LobeMicrofacet: "lobe_microfacet", "a lobe of the BSDFs";
    LobeReflection: "lobe_reflection", "a lobe of the BSDFs";
    LobeRefraction: "lobe_refraction", "a lobe of the BSDFs";
    LobeTransparent: "lobe_transparent", "a lobe of the BSDFs";
    LobeConductor: "lobe_conductor", "a lobe of the BSDFs";
    LobeOrenNayarDiffuse: "lobe_oren_nayar_diffuse", "a lobe of the BSDFs";
    LobeBurleyDiffuse: "lobe_burley_diffuse", "a lobe of the BSDFs";
    LobeDielectric: "lobe_dielectric", "a lobe of the BSDFs";
    LobeGeneralizedSchlick: "lobe_generalized_schlick", "a lobe of the BSDFs";
    LobeSheen: "lobe_sheen", "a lobe of the BSDFs";
    LobeChiangHair: "lobe_chiang_hair", "a lobe of the BSDFs";
    LobeThinFilm: "lobe_thin_film", "thin films on the lobes";
    DoublePrecision: "double_precision", "64-bit arithmetic";
}

use Effect::*;

impl Effect {
    /// Its macro in the kernels.
    pub fn macro_name(self) -> String {
        format!("HAS_{}", self.name().to_uppercase())
    }

    /// The effect of a lobe, by its name in artifacts.
    pub fn of_lobe(name: &str) -> Option<Effect> {
        Effect::ALL.iter().copied().find(|e| e.name().strip_prefix("lobe_") == Some(name))
    }
}

/// Whether an effect is on, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// Which.
    pub effect: Effect,
    /// Who asked for it: materials, meshes, settings. Empty: off.
    pub asked_by: Vec<String>,
}

impl Decision {
    /// Whether it is on.
    pub fn is_on(&self) -> bool {
        !self.asked_by.is_empty()
    }
}

/// Decides every effect. `materials` has one element per material of the scene, `None` for those that nothing uses.
pub(super) fn decide(scene: &Scene, materials: &[Option<Artifact>], double: bool) -> Vec<Decision> {
    let mut asked: Vec<Vec<String>> = vec![Vec::new(); Effect::ALL.len()];
    let mut ask = |effect: Effect, who: String| {
        let list = &mut asked[effect as usize];
        if !list.contains(&who) {
            list.push(who);
        }
    };
    surfaces(scene, materials, &mut ask);
    environment(scene, materials, &mut ask);
    if scene.camera.lens_radius > 0.0 {
        ask(ThinLens, format!("camera: lens_radius = {}", scene.camera.lens_radius));
    }
    if scene.conventions.shared_cubes {
        ask(SharedCubes, "convention".into());
    }
    match scene.filter {
        Filter::Box => {}
        Filter::Tent => ask(TentFilter, "filter = tent".into()),
        Filter::Middle => ask(MiddleFilter, "filter = middle".into()),
    }
    if let Some(bounce) = scene.integrator.roulette_from {
        ask(Roulette, format!("integrator: roulette = {bounce}"));
    }
    if double {
        ask(DoublePrecision, "precision: reference".into());
    }
    Effect::ALL.iter().zip(asked).map(|(effect, asked_by)| Decision { effect: *effect, asked_by }).collect()
}

fn who(scene: &Scene, index: usize) -> String {
    format!("material `{}`", scene.materials[index].name)
}

fn surfaces(scene: &Scene, materials: &[Option<Artifact>], ask: &mut dyn FnMut(Effect, String)) {
    let mut used = vec![false; materials.len()];
    for instance in &scene.instances {
        used[instance.material.0 as usize] = true;
        let mesh = &scene.meshes[instance.mesh.0 as usize];
        if !mesh.normals.is_empty() {
            ask(Normals, format!("mesh `{}`", mesh.name));
        }
    }
    if scene.conventions.trusted_normals && !scene.instances.is_empty() {
        ask(TrustedNormals, "convention".into());
    }
    if !scene.instances.is_empty() {
        ask(Surfaces, format!("{} placed meshes", scene.instances.len()));
    }
    if accel::shares_meshes(scene) {
        ask(Instances, "meshes that are placed more than once".into());
    }
    let mut wants_uv = false;
    for (index, material) in materials.iter().enumerate() {
        let Some(code) = material.as_ref().filter(|_| used[index]) else { continue };
        let artifact = code;
        let who = who(scene, index);
        if let Some(by) = scene.materials[index].displacement {
            let asked = format!("{who}: displacement = {}", scene.materials[by.0 as usize].name);
            // A bump gives normals to meshes that have none.
            ask(Normals, asked.clone());
            ask(Displacement, asked);
        }
        for lobe in &artifact.lobes {
            if let Some(effect) = Effect::of_lobe(lobe) {
                ask(effect, who.clone());
            }
        }
        if artifact.emission != Radiance::None && scene.conventions.two_sided_emission {
            ask(TwoSidedEmission, who.clone());
        }
        match artifact.emission {
            _ if !scene.materials[index].sampled_light => {}
            Radiance::None => {}
            Radiance::Constant(_) => ask(Lights, who.clone()),
            Radiance::Varying => {
                ask(Lights, who.clone());
                ask(VaryingLights, who.clone());
            }
        }
        let state = &artifact.state;
        let asks = [
            (state.derivatives, Derivatives),
            (state.surface_area, SurfaceArea),
            (state.object_space, ObjectSpace),
            (state.camera_space, CameraSpace),
            (state.raytype, RayType),
            (state.other_spaces, OtherSpaces),
            (artifact.has_holdout, Holdout),
            (!artifact.sites.is_empty(), Messages),
        ];
        for (_, effect) in asks.into_iter().filter(|(asked, _)| *asked) {
            ask(effect, who.clone());
        }
        textures(artifact, &who, ask);
        inputs(artifact, &who, ask);
        for global in &artifact.globals {
            match *global {
                "dPdu" | "dPdv" => {
                    ask(Tangents, format!("{who}: {global}"));
                    wants_uv = true;
                }
                "u" | "v" => wants_uv = true,
                _ => {}
            }
        }
    }
    if wants_uv {
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh.0 as usize];
            if !mesh.uvs.is_empty() {
                ask(Uvs, format!("mesh `{}`", mesh.name));
            }
        }
    }
}

/// Texture files, and the samples that are taken of them.
fn textures(artifact: &Artifact, who: &str, ask: &mut dyn FnMut(Effect, String)) {
    for texture in &artifact.textures {
        let who = format!("{who}: {}", texture.file);
        for interp in &texture.interps {
            match *interp {
                "cubic" | "smartcubic" => ask(TextureCubic, who.clone()),
                "closest" => ask(TextureClosest, who.clone()),
                _ => {}
            }
        }
        ask(Textures, who);
    }
}

/// What the renderer supplies beside the globals.
fn inputs(artifact: &Artifact, who: &str, ask: &mut dyn FnMut(Effect, String)) {
    for slot in &artifact.inputs.userdata {
        let attribute = asked(&slot.name).map(|(name, _)| name);
        let effect = if attribute.is_some() { Attributes } else { Userdata };
        ask(effect, format!("{who}: {}", attribute.unwrap_or(&slot.name)));
    }
    for slot in &artifact.inputs.interactive {
        ask(Interactive, format!("{who}: {}", slot.name));
    }
}

fn environment(scene: &Scene, materials: &[Option<Artifact>], ask: &mut dyn FnMut(Effect, String)) {
    let Some(id) = scene.environment else { return };
    let Some(code) = &materials[id.0 as usize] else { return };
    let who = who(scene, id.0 as usize);
    match code.background {
        Radiance::None => {}
        // Without surfaces nothing is gained by a second way to the same picture.
        Radiance::Constant(_) if !scene.instances.is_empty() => ask(Environment, who),
        Radiance::Constant(_) | Radiance::Varying => {
            if code.state.derivatives {
                ask(Derivatives, who.clone());
            }
            if code.state.camera_space {
                ask(CameraSpace, who.clone());
            }
            if code.state.raytype {
                ask(RayType, who.clone());
            }
            if !code.sites.is_empty() {
                ask(Messages, who.clone());
            }
            if code.state.other_spaces {
                ask(OtherSpaces, who.clone());
            }
            textures(code, &who, ask);
            inputs(code, &who, ask);
            ask(Environment, who.clone());
            ask(VaryingEnvironment, who.clone());
            // What depends on how rays came there can't be tabulated by direction alone.
            let tabulated = !code.state.raytype || scene.conventions.tabulated_environment;
            if !scene.instances.is_empty() && tabulated {
                ask(EnvironmentSampling, who);
            }
        }
    }
}
