//! Effects that the user wants on or off, whatever the scene calls for.
//!
//! In: names as users write them. Out: [`Overrides`], and the scene as it is without what is off or with what is on. It must not
//! know artifacts or devices.

use super::Effect::{self, *};
use crate::scene::{Filter, Instance, Material, MaterialId, Mesh, MeshId, Scene, Vec3};
use glam::DAffine3;
use std::borrow::Cow;

/// Some effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct EffectSet(u128);

impl EffectSet {
    /// Whether an effect is one of them.
    pub fn contains(self, effect: Effect) -> bool {
        self.0 & 1 << effect as u32 != 0
    }

    /// Adds an effect.
    pub fn insert(&mut self, effect: Effect) {
        self.0 |= 1 << effect as u32;
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromIterator<Effect> for EffectSet {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> EffectSet {
        let mut out = EffectSet::default();
        effects.into_iter().for_each(|e| out.insert(e));
        out
    }
}

/// What the user can't decide about effects.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OverrideError {
    /// No effect has the name.
    #[error("there is no effect `{name}`{}\n  help: effects are {}", .suggestion.as_ref().map_or(String::new(), |s| format!(": did you mean `{s}`?")), Effect::choosable().map(|e| e.name()).collect::<Vec<_>>().join(", "))]
    Unknown {
        /// What was written.
        name: String,
        /// The name nearest to it.
        suggestion: Option<String>,
    },
    /// It is how another renderer does things.
    #[error("`{name}` can be neither forced nor left out: it is how testrender does things, which its scenes (.xml) alone ask for", name = .0.name())]
    Convention(Effect),
    /// It is to be on and off.
    #[error("`--force {name}` and `--without {name}`: an effect is on or off, not both", name = .0.name())]
    Both(Effect),
    /// It is to be on without what it can't do without.
    #[error("`--force {on}` and `--without {off}`: `{on}` needs `{off}`", on = .effect.name(), off = .need.name())]
    Needs {
        /// The effect that is forced.
        effect: Effect,
        /// What is left out.
        need: Effect,
    },
}

/// What the user decides against the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Overrides {
    /// On, and all that they need.
    force: EffectSet,
    /// Off, and all that needs them.
    without: EffectSet,
}

impl Overrides {
    /// Forces some effects on, each with what it needs, and others off, each with what needs it. Off counts more.
    pub fn new(force: impl IntoIterator<Item = Effect>, without: impl IntoIterator<Item = Effect>) -> Overrides {
        Overrides { force: force.into_iter().collect(), without: without.into_iter().collect() }.closed()
    }

    /// The same with another effect left out, and what needs it.
    pub fn and_without(self, effect: Effect) -> Overrides {
        let mut out = self;
        out.without.insert(effect);
        out.closed()
    }

    /// The same with another effect forced on, and what it needs, unless that is left out.
    pub fn and_force(self, effect: Effect) -> Overrides {
        let mut out = self;
        out.force.insert(effect);
        out.closed()
    }

    /// With all that the sets imply.
    fn closed(self) -> Overrides {
        let mut out = self;
        // Needs come before what needs them in no particular order: repeat until nothing is added. Sets only grow.
        loop {
            let before = out;
            for effect in Effect::ALL {
                for need in effect.needs() {
                    if out.force.contains(*effect) {
                        out.force.insert(*need);
                    }
                    if out.without.contains(*need) {
                        out.without.insert(*effect);
                    }
                }
            }
            if out == before {
                return out;
            }
        }
    }

    /// As [`Overrides::new`], by name; nothing may be both on and off.
    pub fn by_name(force: &[String], without: &[String]) -> Result<Overrides, OverrideError> {
        let find = |name: &String| match Effect::ALL.iter().find(|e| e.name() == name) {
            Some(effect) if effect.is_convention() => Err(OverrideError::Convention(*effect)),
            Some(effect) => Ok(*effect),
            None => Err(OverrideError::Unknown {
                name: name.clone(),
                suggestion: oslcl_compiler::suggest::closest(name, Effect::choosable().map(|e| e.name()))
                    .map(str::to_owned),
            }),
        };
        let all = |names: &[String]| names.iter().map(find).collect::<Result<Vec<_>, _>>();
        let (force, without) = (all(force)?, all(without)?);
        for effect in &force {
            if without.contains(effect) {
                return Err(OverrideError::Both(*effect));
            }
            let needs = Overrides::new([*effect], []);
            if let Some(need) = without.iter().find(|e| needs.forces(**e)) {
                return Err(OverrideError::Needs { effect: *effect, need: *need });
            }
        }
        Ok(Overrides::new(force, without))
    }

    /// Whether the user wants an effect on.
    pub fn forces(&self, effect: Effect) -> bool {
        self.force.contains(effect) && !self.without.contains(effect)
    }

    /// Whether the user wants an effect off.
    pub fn removes(&self, effect: Effect) -> bool {
        self.without.contains(effect)
    }

    /// The scene as these decisions leave it: without the settings and objects of what is off; and where surfaces or an
    /// environment are wanted and there are none, with one that nobody sees.
    pub fn apply<'a>(&self, scene: &'a Scene) -> Cow<'a, Scene> {
        let mut out = Cow::Borrowed(scene);
        if !self.without.is_empty() {
            self.remove(&mut out);
        }
        if self.forces(Environment) && out.environment.is_none() {
            let black = nothing(out.to_mut());
            out.to_mut().environment = Some(black);
        }
        if self.forces(Surfaces) && out.instances.is_empty() {
            let scene = out.to_mut();
            let material = nothing(scene);
            // A triangle without area, which no ray meets, in front of the camera.
            let at = scene.camera.target - scene.camera.origin;
            let positions = vec![Vec3::ZERO; 3];
            scene.meshes.push(Mesh {
                name: NOTHING.to_owned(),
                positions,
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            });
            scene.instances.push(Instance {
                mesh: MeshId(scene.meshes.len() as u32 - 1),
                transform: DAffine3::from_translation(scene.camera.origin + at),
                material,
                attributes: Vec::new(),
            });
        }
        out
    }

    fn remove(&self, out: &mut Cow<'_, Scene>) {
        if self.removes(Surfaces) && !out.instances.is_empty() {
            out.to_mut().instances.clear();
        }
        if self.removes(Environment) && out.environment.is_some() {
            out.to_mut().environment = None;
        }
        if self.removes(ThinLens) && out.camera.lens_radius > 0.0 {
            out.to_mut().camera.lens_radius = 0.0;
        }
        if self.removes(Roulette) && out.integrator.roulette_from.is_some() {
            out.to_mut().integrator.roulette_from = None;
        }
        if self.removes(Effect::of_filter(out.filter).unwrap_or(Surfaces)) && out.filter != Filter::Box {
            out.to_mut().filter = Filter::Box;
        }
        if self.removes(TwoSidedEmission) && out.conventions.two_sided_emission {
            out.to_mut().conventions.two_sided_emission = false;
        }
        if self.removes(Displacement) && out.materials.iter().any(|m| m.displacement.is_some()) {
            out.to_mut().materials.iter_mut().for_each(|m| m.displacement = None);
        }
        if self.removes(Instances) && crate::accel::shares_meshes(out) {
            copy_meshes(out.to_mut());
        }
    }
}

/// Name of what is there for an effect that is on without need.
const NOTHING: &str = "nothing (forced)";

/// A material that neither scatters nor emits.
fn nothing(scene: &mut Scene) -> MaterialId {
    scene.materials.push(Material::from_source(NOTHING, "surface nothing() { Ci = 0; }"));
    MaterialId(scene.materials.len() as u32 - 1)
}

/// Gives each placement a mesh of its own.
fn copy_meshes(scene: &mut Scene) {
    let mut seen = vec![false; scene.meshes.len()];
    for instance in &mut scene.instances {
        let index = instance.mesh.0 as usize;
        if std::mem::replace(&mut seen[index], true) {
            scene.meshes.push(scene.meshes[index].clone());
            instance.mesh = MeshId(scene.meshes.len() as u32 - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_forced_brings_what_it_needs_and_what_is_off_takes_what_needs_it() {
        let on = Overrides::new([EnvironmentSampling], []);
        assert!(on.forces(EnvironmentSampling) && on.forces(Environment) && on.forces(Surfaces));
        let off = Overrides::new([TextureCubic], [Textures]);
        assert!(off.removes(TextureCubic) && !off.forces(TextureCubic) && !off.forces(Textures));
    }

    #[test]
    fn a_misspelt_name_gets_the_nearest() {
        let error = Overrides::by_name(&["thin_lense".to_owned()], &[]).expect_err("no such effect").to_string();
        assert!(error.starts_with("there is no effect `thin_lense`: did you mean `thin_lens`?\n"), "{error}");
        assert!(error.contains("surfaces, thin_lens, tent_filter"), "{error}");
    }

    #[test]
    fn every_effect_can_be_chosen_or_says_why_not() {
        for effect in Effect::ALL {
            let name = [effect.name().to_owned()];
            for result in [Overrides::by_name(&name, &[]), Overrides::by_name(&[], &name)] {
                match result {
                    Ok(_) => assert!(!effect.is_convention()),
                    Err(e) => assert!(e.to_string().contains("which its scenes (.xml) alone ask for"), "{e}"),
                }
            }
        }
    }

    #[test]
    fn nothing_is_both_on_and_off() {
        let by_name = |force: &str, without: &str| Overrides::by_name(&[force.to_owned()], &[without.to_owned()]);
        let refused = |force, without| by_name(force, without).expect_err("a contradiction").to_string();
        let both = "`--force uvs` and `--without uvs`: an effect is on or off, not both";
        assert_eq!(refused("uvs", "uvs"), both);
        let need =
            "`--force environment_sampling` and `--without environment`: `environment_sampling` needs `environment`";
        assert_eq!(refused("environment_sampling", "environment"), need);
        assert!(by_name("environment", "environment_sampling").is_ok());
    }
}
