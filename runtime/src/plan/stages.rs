//! The stages of the wavefront, and the programs that hold them.
//!
//! In: the effects that are on. Out: which programs to build, from which texts, with which kernels.

use super::{Effect, Plan};
use crate::choices::TextureFilter;
use crate::scene::{MaterialId, Scene};
use crate::{preamble, vertex_data};
use oslcl_compiler::{Artifact, Radiance};

/// A stage: one kernel, one file in kernels/stages/ with its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // The kernel's file says what each does.
pub enum Stage {
    RayGen,
    Trace,
    SelectBsdf,
    FollowPath,
    Environment,
    SampleLight,
    TraceShadow,
    ShadeLight,
    EnvironmentLight,
    SampleNext,
    Accumulate,
    Resolve,
    LightPower,
    EnvironmentMap,
}

impl Stage {
    /// Name of the kernel, of its file, and in profiles.
    pub fn name(self) -> &'static str {
        match self {
            Stage::RayGen => "ray_gen",
            Stage::Trace => "trace",
            Stage::SelectBsdf => "select_bsdf",
            Stage::FollowPath => "follow_path",
            Stage::Environment => "environment",
            Stage::SampleLight => "sample_light",
            Stage::TraceShadow => "trace_shadow",
            Stage::ShadeLight => "shade_light",
            Stage::EnvironmentLight => "environment_light",
            Stage::SampleNext => "sample_next",
            Stage::Accumulate => "accumulate",
            Stage::Resolve => "resolve",
            Stage::LightPower => "light_power",
            Stage::EnvironmentMap => "environment_map",
        }
    }
}

/// A program to build.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramPlan {
    /// Whose code it holds; `None` for the renderer's own stages.
    pub material: Option<MaterialId>,
    /// Name for messages.
    pub label: String,
    /// Kernels.
    pub stages: Vec<Stage>,
    /// Macros: names, or names and values.
    pub macros: Vec<String>,
    /// Generated code in front of the stages; empty for the renderer's own.
    pub code: String,
}

/// Every program of a plan: one per stage, one per material.
pub(super) fn programs(plan: &Plan, scene: &Scene, materials: &[Option<Artifact>]) -> Vec<ProgramPlan> {
    let mut stages = vec![Stage::RayGen, Stage::Trace, Stage::Accumulate, Stage::Resolve];
    // Without lights to ask, `select_bsdf` goes on to the next edge itself; `follow_path` does all of it.
    if plan.layout.queue("scatter").is_some() && !plan.follows() {
        stages.extend([Stage::SampleLight, Stage::TraceShadow, Stage::SampleNext]);
    }
    let mut out: Vec<ProgramPlan> = stages
        .into_iter()
        .map(|stage| ProgramPlan {
            material: None,
            label: stage.name().to_owned(),
            stages: vec![stage],
            macros: plan.macros(),
            code: String::new(),
        })
        .collect();
    for &id in &plan.surface_materials {
        let Some(code) = &materials[id.0 as usize] else { continue };
        let mut stages = vec![if plan.follows() { Stage::FollowPath } else { Stage::SelectBsdf }];
        let mut macros = of_artifact(plan, code);
        if code.emission != Radiance::None {
            macros.push("MATERIAL_EMITS".to_owned());
        }
        let is_sampled = scene.materials[id.0 as usize].sampled_light;
        if code.emission == Radiance::Varying && is_sampled && plan.has(Effect::VaryingLights) {
            stages.extend([Stage::ShadeLight, Stage::LightPower]);
        }
        out.push(of_material(plan, scene, materials, id, stages, macros));
    }
    if let (true, Some(id)) = (plan.has(Effect::VaryingEnvironment), scene.environment)
        && let Some(code) = &materials[id.0 as usize]
    {
        let mut stages = vec![Stage::Environment];
        if plan.has(Effect::EnvironmentSampling) {
            stages.extend([Stage::EnvironmentLight, Stage::EnvironmentMap]);
        }
        out.push(of_material(plan, scene, materials, id, stages, of_artifact(plan, code)));
    }
    out
}

/// The plan's macros, but of lobes and inputs only those that this material has, or that are forced; and what its code has to
/// do without.
fn of_artifact(plan: &Plan, code: &Artifact) -> Vec<String> {
    let forced: Vec<String> = plan.decisions.iter().filter(|d| d.forced).map(|d| d.effect.macro_name()).collect();
    let of_others = |m: &String| m.starts_with("HAS_LOBE_") && !forced.contains(m);
    let mut out: Vec<String> = plan.macros().into_iter().filter(|m| !of_others(m)).collect();
    let mut lobes = Vec::new();
    let traces = [Effect::Traces, Effect::TraceSets, Effect::TraceNames];
    let overruled = plan.choices.texture_filter != TextureFilter::Shader;
    for own in preamble::macros(code) {
        // How textures are interpolated says the plan then.
        if overruled && matches!(own.as_str(), "HAS_TEXTURE_CUBIC" | "HAS_TEXTURE_CLOSEST") {
            continue;
        }
        // Off also where there is nothing to meet.
        let on = |e: &Effect| [*e, Effect::Traces, Effect::Surfaces].iter().all(|e| plan.has(*e));
        if traces.iter().any(|e| e.macro_name() == own && !on(e)) {
            continue;
        }
        if own == Effect::PointClouds.macro_name() && !plan.has(Effect::PointClouds) {
            continue;
        }
        let removed = Effect::ALL.iter().find(|e| e.macro_name() == own && plan.is_removed(**e));
        match removed {
            Some(Effect::TextureCubic | Effect::TextureClosest) => continue,
            Some(Effect::LobeThinFilm) => {
                out.push("WITHOUT_LOBE_THIN_FILM".to_owned());
                continue;
            }
            // The code names the constructor.
            Some(lobe) if own.starts_with("HAS_LOBE_") => lobes.push(format!("1u << {}", lobe.name().to_uppercase())),
            Some(Effect::Textures) => out.push("WITHOUT_TEXTURES".to_owned()),
            _ => {}
        }
        if !out.contains(&own) {
            out.push(own);
        }
    }
    if !code.textures.is_empty() {
        out.extend(plan.choices.texture_macros());
    }
    if !lobes.is_empty() {
        out.push(format!("WITHOUT_LOBES ({})", lobes.join(" | ")));
    }
    out
}

fn of_material(
    plan: &Plan,
    scene: &Scene,
    materials: &[Option<Artifact>],
    id: MaterialId,
    stages: Vec<Stage>,
    mut macros: Vec<String>,
) -> ProgramPlan {
    let name = &scene.materials[id.0 as usize].name;
    let label = format!("material `{name}`");
    // Programs are made of materials that have an artifact.
    let Some(code) = &materials[id.0 as usize] else {
        return ProgramPlan { material: Some(id), label, stages, macros, code: String::new() };
    };
    if code.inputs.interactive_slots > 0 {
        macros.push(format!("MATERIAL_INTERACTIVE {}u", plan.interactive[id.0 as usize]));
    }
    macros.push(format!("MATERIAL_ENTRY {}", code.entry));
    if !code.sites.is_empty() && plan.has(Effect::Messages) {
        macros.push(format!("MATERIAL_NUMBER {}u", id.0));
    }
    ProgramPlan {
        material: Some(id),
        label,
        stages,
        macros,
        code: preamble::code(code).to_owned()
            + &vertex_data::code(code, materials, &|slot| {
                plan.has(if vertex_data::is_attribute(slot) { Effect::Attributes } else { Effect::Userdata })
            }),
    }
}
