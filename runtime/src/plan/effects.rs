//! The effects that a scene can call for, and who asked for them.
//!
//! In: a scene and its materials' artifacts. Out: [`Decision`]s. Pure: it must not know devices.

use super::asker::Asker;
use super::overrides::Overrides;
use crate::accel;
use crate::choices::{Choices, Lobes, TextureFilter};
use crate::preamble;
use crate::scene::{Filter, MaterialId, Scene};
use oslcl_compiler::attributes::asked;
use oslcl_compiler::{Artifact, Radiance, reflect};

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
    Traces: "traces", "rays that shaders trace themselves";
    TraceSets: "trace_sets", "sets of objects that such rays are for";
    TraceNames: "trace_names", "names of the objects that such rays meet";
    PointClouds: "point_clouds", "point clouds that shaders look into";
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
    SplitLobes: "split_lobes", "a path for each lobe of the first hit";
    Adaptive: "adaptive", "pixels that have had enough samples are left alone";
    DoublePrecision: "double_precision", "64-bit arithmetic";
}

use Effect::*;

impl Effect {
    /// Its macro in the kernels.
    pub fn macro_name(self) -> String {
        format!("HAS_{}", self.name().to_uppercase())
    }

    /// Other effects that it can't do without.
    pub fn needs(self) -> &'static [Effect] {
        match self {
            VaryingLights | TwoSidedEmission => &[Lights],
            VaryingEnvironment => &[Environment],
            EnvironmentSampling => &[VaryingEnvironment, Surfaces],
            TextureCubic | TextureClosest => &[Textures],
            TraceSets | TraceNames => &[Traces],
            Surfaces | ThinLens | TentFilter | MiddleFilter | Environment | Derivatives | CameraSpace | OtherSpaces
            | Interactive | Messages | PointClouds | Textures | Adaptive | DoublePrecision => &[],
            _ => &[Surfaces],
        }
    }

    /// What is wrong with the picture of a scene that needs it and is rendered without.
    pub fn missed(self) -> &'static str {
        match self {
            Surfaces => "nothing is there but the environment",
            ThinLens => "all distances are in focus",
            TentFilter | MiddleFilter => "pixels are the mean over their square",
            Lights => "emissive surfaces are found by chance only: the same light with far more noise",
            VaryingLights => "emissive surfaces that differ from point to point are found by chance only: more noise",
            TwoSidedEmission => "surfaces emit on their front side alone",
            Environment => "what lies outside the scene is black",
            VaryingEnvironment => "the environment is black: its shader is not asked",
            EnvironmentSampling => "the environment is found by chance only: the same light with more noise",
            Roulette => "paths end at the greatest depth alone: the same light, later",
            Instances => "each placement has a copy of its mesh: the same picture but for rounding, with more memory",
            Displacement => "vertices stay where the mesh has them",
            Normals => "surfaces are faceted",
            Uvs => "u and v are those of each triangle, from 0 to 1",
            Tangents => "dPdu and dPdv are 0",
            Derivatives => "derivatives are 0: textures are not filtered, filterwidth() is 0",
            SurfaceArea => "surfacearea() is 0",
            ObjectSpace => "object and shader space are world space",
            CameraSpace => "camera space is world space",
            OtherSpaces => "screen, NDC and raster space are world space",
            RayType => "raytype() is 0 for all rays",
            Userdata => "parameters have their defaults, not what the vertices have",
            Attributes => "getattribute() finds no attributes of objects",
            Interactive => "parameters keep the values of the scene",
            Messages => "what shaders print is not heard",
            Traces => "trace() finds nothing",
            TraceSets => "trace() meets all objects, whatever its set",
            TraceNames => "what trace() meets has no name",
            PointClouds => "point clouds are empty",
            Textures => "texture lookups find no file",
            TextureCubic => "textures are interpolated linearly",
            TextureClosest => "textures are interpolated linearly",
            Holdout => "there is no alpha channel: holdouts are black",
            LobeTransparent => "surfaces block what should pass straight through them",
            LobeRefraction => "no light is refracted through the surfaces",
            LobeThinFilm => "there are no colours of thin films",
            SplitLobes => "one lobe at random of the first hit is followed: the same light, in another time",
            Adaptive => "all pixels get as many samples: the same light, later",
            DoublePrecision => "arithmetic has 32 bits",
            _ => "this part of the reflection is black",
        }
    }

    /// Whether a picture without it is right in the mean, and only takes longer to get there.
    pub fn keeps_mean(self) -> bool {
        matches!(self, Lights | VaryingLights | EnvironmentSampling | Roulette | Instances | SplitLobes | Adaptive)
    }

    /// The effect of a filter of the film; `None`: the box, which is always there.
    pub fn of_filter(filter: Filter) -> Option<Effect> {
        match filter {
            Filter::Box => None,
            Filter::Tent => Some(TentFilter),
            Filter::Middle => Some(MiddleFilter),
        }
    }

    /// Whether it is how another renderer does things, which only scenes of its format ask for: nobody can force it or leave it out.
    pub fn is_convention(self) -> bool {
        matches!(self, SharedCubes | TrustedNormals)
    }

    /// Whether only programs of materials that ask for it know of it, by what their code says (`crate::preamble`).
    pub fn is_of_materials(self) -> bool {
        matches!(self, Userdata | Attributes | Interactive | Traces | TraceSets | TraceNames | PointClouds)
    }

    /// All that can be forced or left out.
    pub fn choosable() -> impl Iterator<Item = Effect> {
        Effect::ALL.iter().copied().filter(|e| !e.is_convention())
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
    /// Who asked for it; nobody: off, unless it is forced.
    pub asked_by: Vec<Asker>,
    /// On by the user's wish, whoever asked.
    pub forced: bool,
    /// Off by the user's wish, whoever asked.
    pub removed: bool,
}

impl Decision {
    /// Whether it is on.
    pub fn is_on(&self) -> bool {
        !self.removed && (self.forced || !self.asked_by.is_empty())
    }

    /// Whether it is on because the scene calls for it.
    pub fn is_asked(&self) -> bool {
        !self.removed && !self.asked_by.is_empty()
    }

    /// What will be wrong when the user has removed what the scene calls for.
    pub fn warning(&self) -> Option<String> {
        if !self.removed || self.asked_by.is_empty() {
            return None;
        }
        let all: Vec<String> = self.asked_by.iter().map(Asker::to_string).collect();
        let who = all[..all.len().min(3)].join(", ");
        let more = if all.len() > 3 { format!(" and {} more", all.len() - 3) } else { String::new() };
        Some(format!(
            "warning: without `{}`: {} (asked for by {who}{more})\n",
            self.effect.name(),
            self.effect.missed()
        ))
    }
}

/// Decides every effect. `materials` has one element per material of the scene, `None` for those that nothing uses.
pub(super) fn decide(scene: &Scene, materials: &[Option<Artifact>], choices: &Choices) -> Vec<Decision> {
    let double = choices.precision.is_double();
    let mut asked: Vec<Vec<Asker>> = vec![Vec::new(); Effect::ALL.len()];
    let mut ask = |effect: Effect, who: Asker| {
        let list = &mut asked[effect as usize];
        if !list.contains(&who) {
            list.push(who);
        }
    };
    surfaces(scene, materials, &mut ask);
    environment(scene, materials, &mut ask);
    removed_before_compiling(scene, materials, &choices.overrides, &mut ask);
    if scene.camera.lens_radius > 0.0 {
        ask(ThinLens, Asker::setting("camera", format!("lens_radius = {}", scene.camera.lens_radius)));
    }
    if scene.conventions.shared_cubes {
        ask(SharedCubes, Asker::setting("conventions", "shared_cubes"));
    }
    match scene.filter {
        Filter::Box => {}
        Filter::Tent => ask(TentFilter, Asker::setting("film", "filter = tent")),
        Filter::Middle => ask(MiddleFilter, Asker::setting("film", "filter = middle")),
    }
    if let Some(bounce) = scene.integrator.roulette_from {
        ask(Roulette, Asker::setting("integrator", format!("roulette = {bounce}")));
    }
    if choices.lobes == Lobes::All {
        for instance in &scene.instances {
            let index = instance.material.0 as usize;
            if materials[index].as_ref().is_some_and(|m| preamble::chooses_lobes(preamble::code(m))) {
                ask(SplitLobes, who(scene, index).because("lobes = all, of which it has several"));
            }
        }
    }
    if let Some(threshold) = choices.adaptive {
        ask(Adaptive, Asker::setting("adaptive", threshold.error().to_string()));
    }
    if double {
        ask(DoublePrecision, Asker::setting("precision", "reference"));
    }
    overrule_filters(choices.texture_filter, &mut asked);
    let overrides = &choices.overrides;
    let decide = |(effect, asked_by): (&Effect, Vec<Asker>)| Decision {
        effect: *effect,
        asked_by,
        forced: overrides.forces(*effect),
        removed: overrides.removes(*effect),
    };
    Effect::ALL.iter().zip(asked).map(decide).collect()
}

/// Where the user says how textures are interpolated, what shaders say does not count.
fn overrule_filters(filter: TextureFilter, asked: &mut [Vec<Asker>]) {
    let forced = match filter {
        TextureFilter::Shader => return,
        TextureFilter::Bilinear => None,
        TextureFilter::Closest => Some((TextureClosest, "closest")),
        TextureFilter::Bicubic => Some((TextureCubic, "bicubic")),
    };
    asked[TextureClosest as usize].clear();
    asked[TextureCubic as usize].clear();
    if let Some((effect, value)) = forced.filter(|_| !asked[Textures as usize].is_empty()) {
        asked[effect as usize].push(Asker::setting("texture_filter", value));
    }
}

/// What no artifact can ask for any more, because it was removed before materials were compiled.
fn removed_before_compiling(
    scene: &Scene,
    materials: &[Option<Artifact>],
    overrides: &Overrides,
    ask: &mut dyn FnMut(Effect, Asker),
) {
    if let Some(id) = scene.environment.filter(|_| overrides.removes(Environment)) {
        ask(Environment, who(scene, id.0 as usize));
    }
    if overrides.removes(Interactive) {
        for (index, code) in materials.iter().enumerate() {
            let Some(code) = code else { continue };
            let declared = |p: &&reflect::Param| p.metadata.iter().any(|m| m.name == "interactive");
            for param in code.info.params.iter().filter(declared) {
                ask(Interactive, who(scene, index).because(param.name.as_str()));
            }
            for name in &scene.materials[index].interactive {
                ask(Interactive, who(scene, index).because(name.as_str()));
            }
        }
    }
}

fn who(scene: &Scene, index: usize) -> Asker {
    Asker::of_material(MaterialId(index as u32), &scene.materials[index].name)
}

fn surfaces(scene: &Scene, materials: &[Option<Artifact>], ask: &mut dyn FnMut(Effect, Asker)) {
    let mut used = vec![false; materials.len()];
    for instance in &scene.instances {
        used[instance.material.0 as usize] = true;
        let mesh = &scene.meshes[instance.mesh.0 as usize];
        if !mesh.normals.is_empty() {
            ask(Normals, Asker::mesh(&mesh.name, "has normals"));
        }
    }
    if scene.conventions.trusted_normals && !scene.instances.is_empty() {
        ask(TrustedNormals, Asker::setting("conventions", "trusted_normals"));
    }
    if !scene.instances.is_empty() {
        let first = &scene.meshes[scene.instances[0].mesh.0 as usize].name;
        let how = format!("one of {} placed meshes", scene.instances.len());
        ask(Surfaces, Asker::mesh(first, how));
    }
    for mesh in accel::shared_meshes(scene) {
        ask(Instances, Asker::mesh(&scene.meshes[mesh.0 as usize].name, "placed more than once"));
    }
    let mut wants_uv = false;
    for (index, material) in materials.iter().enumerate() {
        let Some(code) = material.as_ref().filter(|_| used[index]) else { continue };
        let artifact = code;
        let who = who(scene, index);
        if let Some(by) = scene.materials[index].displacement {
            let asked = who.because(format!("displacement = {}", scene.materials[by.0 as usize].name));
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
        traces(scene, artifact, &who, ask);
        clouds(artifact, &who, ask);
        for global in &artifact.globals {
            match *global {
                "dPdu" | "dPdv" => {
                    ask(Tangents, who.because(*global));
                    wants_uv = true;
                }
                "u" | "v" => wants_uv = true,
                _ => {}
            }
        }
    }
    if wants_uv {
        coordinates(scene, ask);
    }
}

/// Texture files, and the samples that are taken of them.
fn textures(artifact: &Artifact, who: &Asker, ask: &mut dyn FnMut(Effect, Asker)) {
    for texture in &artifact.textures {
        let who = who.because(format!("\"{}\"", texture.file));
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

/// Rays that a shader traces, and what it asks of the surfaces that they meet. Without surfaces nothing is asked: there is none.
fn traces(scene: &Scene, artifact: &Artifact, who: &Asker, ask: &mut dyn FnMut(Effect, Asker)) {
    let traces = &artifact.traces;
    if !traces.calls || scene.instances.is_empty() {
        return;
    }
    ask(Traces, who.clone());
    for set in &traces.sets {
        ask(TraceSets, who.because(format!("\"{set}\"")));
    }
    for asked in &traces.asked {
        match asked.as_str() {
            "geom:name" => ask(TraceNames, who.because("geom:name")),
            "dPdu" | "dPdv" => ask(Tangents, who.because(format!("{asked} of what rays meet"))),
            _ => {}
        }
        if matches!(asked.as_str(), "u" | "v" | "dPdu" | "dPdv") {
            coordinates(scene, ask);
        }
    }
}

/// The texture coordinates that meshes have.
fn coordinates(scene: &Scene, ask: &mut dyn FnMut(Effect, Asker)) {
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh.0 as usize];
        if !mesh.uvs.is_empty() {
            ask(Uvs, Asker::mesh(&mesh.name, "has texture coordinates"));
        }
    }
}

/// Point clouds.
fn clouds(artifact: &Artifact, who: &Asker, ask: &mut dyn FnMut(Effect, Asker)) {
    for name in &artifact.point_clouds {
        ask(PointClouds, who.because(format!("\"{name}\"")));
    }
}

/// What the renderer supplies beside the globals.
fn inputs(artifact: &Artifact, who: &Asker, ask: &mut dyn FnMut(Effect, Asker)) {
    for slot in &artifact.inputs.userdata {
        let attribute = asked(&slot.name).map(|(name, _)| name);
        let effect = if attribute.is_some() { Attributes } else { Userdata };
        ask(effect, who.because(attribute.unwrap_or(&slot.name)));
    }
    for slot in &artifact.inputs.interactive {
        ask(Interactive, who.because(slot.name.as_str()));
    }
}

fn environment(scene: &Scene, materials: &[Option<Artifact>], ask: &mut dyn FnMut(Effect, Asker)) {
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
            traces(scene, code, &who, ask);
            clouds(code, &who, ask);
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
