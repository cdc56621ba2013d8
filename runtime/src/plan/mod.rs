//! Decides what is simulated, before anything is built: effects, stages, buffers, macros.
//!
//! In: a scene and the artifacts of its materials. Out: [`Plan`], which the wavefront carries out and `oslcl plan` prints.
//! Pure: it must not know devices, and can be tested without one.

mod asker;
mod effects;
mod layout;
mod overrides;
mod places;
mod stages;

pub use asker::{Asker, Decider, Part, ShaderPlace};
pub use effects::{Decision, Effect};
pub use layout::{BufferId, Constant, Counter, Layout, Setting};
pub use overrides::{EffectSet, OverrideError, Overrides};
pub use stages::{ProgramPlan, Stage};

use crate::accel::{Emission, MaterialUse};
use crate::choices::{Choices, Follow};
use crate::preamble;
use crate::scene::{MaterialId, Scene};
use oslcl_compiler::{Artifact, Radiance};
use std::collections::BTreeSet;

/// What a scene needs.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Every effect, on or off.
    pub decisions: Vec<Decision>,
    /// Where everything lies.
    pub layout: Layout,
    /// What accuracy is bought with time.
    pub choices: Choices,
    /// The programs to build.
    pub programs: Vec<ProgramPlan>,
    /// What geometry has to know of each material of the scene.
    pub materials: Vec<MaterialUse>,
    /// Radiance of an environment that is the same in all directions.
    pub constant_environment: [f64; 3],
    /// Materials on surfaces, in the order of their queues.
    pub surface_materials: Vec<MaterialId>,
    /// Of each material of the scene where its interactive parameters begin in their buffer.
    pub interactive: Vec<u32>,
}

impl Plan {
    /// Plans a scene. `scene`: as [`Overrides::apply`] leaves what is `written`. `materials`: one element per material of the
    /// scene, `None` where nothing uses it.
    pub fn new(written: &Scene, scene: &Scene, materials: &[Option<Artifact>], choices: &Choices) -> Plan {
        let mut decisions = effects::decide(written, materials, choices);
        places::find(written, materials, &mut decisions);
        if scene.instances.is_empty() {
            // Nothing but the environment's stage is there to carry the paths on.
            let asked = &mut decisions[Effect::VaryingEnvironment as usize];
            (asked.forced, asked.removed) = (true, false);
        }
        let on: BTreeSet<Effect> = decisions.iter().filter(|d| d.is_on()).map(|d| d.effect).collect();
        let surface_materials = surface_materials(scene);
        let asks = on.contains(&Effect::VaryingLights);
        let varies = |m: &MaterialId| asks && sampled(scene, materials, *m) == Radiance::Varying;
        let varying: Vec<MaterialId> = surface_materials.iter().copied().filter(varies).collect();
        let has_lights = on.contains(&Effect::Lights);
        let layout = Layout::new(on, surface_materials.len() as u32, varying.len() as u32, choices.path_state);
        let uses = (0..materials.len() as u32)
            .map(MaterialId)
            .map(|m| MaterialUse {
                emission: match sampled(scene, materials, m) {
                    _ if !has_lights => Emission::None,
                    Radiance::None => Emission::None,
                    Radiance::Varying if !asks => Emission::None,
                    Radiance::Constant(rgb) => Emission::Constant(rgb),
                    Radiance::Varying => Emission::Varying { queue: layout.light_queue(place(&varying, m)) },
                },
                queue: place(&surface_materials, m),
            })
            .collect();
        let constant_environment = match scene.environment.and_then(|m| materials[m.0 as usize].as_ref()) {
            Some(code) => match code.background {
                Radiance::Constant(rgb) => rgb,
                _ => [0.0; 3],
            },
            None => [0.0; 3],
        };
        let mut plan = Plan {
            decisions,
            layout,
            choices: choices.settled(),
            programs: Vec::new(),
            materials: uses,
            constant_environment,
            surface_materials,
            interactive: Vec::new(),
        };
        let mut next = 0;
        for artifact in materials {
            plan.interactive.push(next);
            next += artifact.as_ref().map_or(0, |a| a.inputs.interactive_slots);
        }
        plan.programs = stages::programs(&plan, scene, materials);
        plan
    }

    /// Columns and rows of the map by which the environment is sampled.
    pub fn environment_map(&self) -> (u32, u32) {
        (self.choices.environment_map, self.choices.environment_map / 2)
    }

    /// Whether an effect is on.
    pub fn has(&self, effect: Effect) -> bool {
        self.decisions.iter().any(|d| d.effect == effect && d.is_on())
    }

    /// Whether an effect is on because the scene calls for it.
    pub fn is_asked(&self, effect: Effect) -> bool {
        self.decisions.iter().any(|d| d.effect == effect && d.is_asked())
    }

    /// Whether the user has an effect off.
    pub fn is_removed(&self, effect: Effect) -> bool {
        self.choices.overrides.removes(effect)
    }

    /// Whether materials' kernels take paths on to the next surfaces: where a light's shader has to be asked, paths wait for it.
    pub fn follows(&self) -> bool {
        self.choices.follow == Follow::On && !self.shades_lights()
    }

    /// Whether the light that a path is sent can need a shader's answer.
    fn shades_lights(&self) -> bool {
        self.has(Effect::VaryingLights) || self.has(Effect::EnvironmentSampling)
    }

    /// Whether some material has several lobes, of which paths follow one.
    pub fn chooses_lobes(&self) -> bool {
        self.programs.iter().any(|p| preamble::chooses_lobes(&p.code))
    }

    /// What will be wrong because of what the user has off, and what is on in vain.
    pub fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        self.decisions.iter().filter_map(Decision::warning).chain(self.in_vain())
    }

    /// A note about effects that are forced and yet add no code (at most buffers that nothing reads).
    fn in_vain(&self) -> Option<String> {
        let vain = self.decisions.iter().filter(|d| d.is_on() && !d.is_asked() && d.effect.is_of_materials());
        let names: Vec<String> = vain.map(|d| format!("`{}`", d.effect.name())).collect();
        let names = match names.as_slice() {
            [] => return None,
            [one] => one.clone(),
            [most @ .., last] => format!("{} and {last}", most.join(", ")),
        };
        Some(format!("note: forcing {names} adds no code: only materials that ask for it bring it\n"))
    }

    /// The macros that every program has: `HAS_` and the name of each effect that is on.
    pub fn macros(&self) -> Vec<String> {
        let on = self.decisions.iter().filter(|d| d.is_on() && !d.effect.is_of_materials());
        let mut out: Vec<String> = on.map(|d| d.effect.macro_name()).collect();
        if self.shades_lights() {
            out.push("HAS_SHADED_LIGHTS".to_owned());
        }
        out.extend(self.choices.macros());
        if self.has(Effect::EnvironmentSampling) {
            let (width, height) = self.environment_map();
            out.push(format!("ENVIRONMENT_WIDTH {width}u"));
            out.push(format!("ENVIRONMENT_HEIGHT {height}u"));
        }
        out
    }
}

/// Where a material stands in a list; 0 for one that no surface has.
fn place(list: &[MaterialId], material: MaterialId) -> u32 {
    list.iter().position(|m| *m == material).unwrap_or(0) as u32
}

/// The emission that rays are sent to.
fn sampled(scene: &Scene, materials: &[Option<Artifact>], material: MaterialId) -> Radiance {
    let index = material.0 as usize;
    let code = materials[index].as_ref().filter(|_| scene.materials[index].sampled_light);
    code.map_or(Radiance::None, |code| code.emission)
}

/// Materials that some surface has, each once.
fn surface_materials(scene: &Scene) -> Vec<MaterialId> {
    let used: BTreeSet<u32> = scene.instances.iter().map(|i| i.material.0).collect();
    used.into_iter().map(MaterialId).collect()
}
