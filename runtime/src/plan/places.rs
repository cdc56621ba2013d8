//! Finds where those who ask for effects stand: in the scene's file and in their shaders.
//!
//! In: who asks. Out: the same with places. It must not know why anyone asks.

use super::asker::{Asker, Decider, Part, ShaderPlace};
use super::{Decision, Effect};
use crate::scene::{MaterialId, MeshId, Place, Scene};
use oslcl_compiler::Artifact;
use oslcl_compiler::artifact::Control;
use oslcl_compiler::attributes::asked;

/// Fills in the places. `materials`: one element per material of the scene, or more.
pub(super) fn find(scene: &Scene, materials: &[Option<Artifact>], decisions: &mut [Decision]) {
    for decision in decisions {
        let effect = decision.effect;
        for asker in &mut decision.asked_by {
            place(scene, materials, effect, asker);
        }
    }
}

fn place(scene: &Scene, materials: &[Option<Artifact>], effect: Effect, asker: &mut Asker) {
    let places = &scene.places;
    let (at, users) = match &asker.part {
        Part::Material(id, _) => {
            let own = match effect {
                Effect::Displacement | Effect::Normals => Some(Place::Displacement(*id)),
                Effect::Interactive => Some(Place::Interactive(*id)),
                _ => None,
            };
            let at = own.and_then(|p| places.get(&p)).or_else(|| places.get(&Place::Material(*id)));
            (at, vec![*id])
        }
        Part::Mesh(name) => {
            let Some(mesh) = scene.meshes.iter().position(|m| m.name == *name) else { return };
            let at = places.get(&Place::Mesh(MeshId(mesh as u32)));
            (at, if effect == Effect::Uvs { materials_of(scene, name) } else { Vec::new() })
        }
        Part::Settings(_) => {
            let setting = match effect {
                Effect::ThinLens => "camera.lens_radius",
                Effect::Roulette => "integrator.roulette",
                _ => "conventions",
            };
            (places.get(&Place::Setting(setting)), Vec::new())
        }
    };
    asker.at = at.cloned();
    for id in users {
        let Some(Some(artifact)) = materials.get(id.0 as usize) else { continue };
        for used in artifact.uses.iter().filter(|u| asks(effect, &asker.why, &u.what)) {
            let deciders = used.controls.iter().map(|c| decider(scene, id, c)).collect();
            let place = ShaderPlace { file: used.file.clone(), line: used.line, deciders };
            if !asker.shader.contains(&place) {
                asker.shader.push(place);
            }
        }
    }
}

/// The materials of the meshes with this name.
fn materials_of(scene: &Scene, name: &str) -> Vec<MaterialId> {
    let placed = scene.instances.iter().filter(|i| scene.meshes[i.mesh.0 as usize].name == name);
    let mut out: Vec<MaterialId> = placed.map(|i| i.material).collect();
    out.sort();
    out.dedup();
    out
}

/// Whether a use in a shader (`Use::what`) is what asks for an effect for this reason.
fn asks(effect: Effect, why: &str, what: &str) -> bool {
    use Effect::*;
    match effect {
        Lights | VaryingLights | TwoSidedEmission => what == "emission",
        Environment | VaryingEnvironment | EnvironmentSampling => what == "background",
        Tangents => what.strip_prefix("global ") == Some(why),
        Uvs => matches!(what, "global u" | "global v" | "global dPdu" | "global dPdv"),
        Textures | TextureCubic | TextureClosest => {
            what == "texture" || what.strip_prefix("texture ").is_some_and(|file| why.trim_matches('"') == file)
        }
        Userdata => what.strip_prefix("userdata ") == Some(why),
        Attributes => what.strip_prefix("userdata ").and_then(asked).is_some_and(|(name, _)| name == why),
        Interactive => what.strip_prefix("interactive ") == Some(why),
        _ => what == effect.name(),
    }
}

/// A parameter with the place of its value: in the scene, or else of its default.
fn decider(scene: &Scene, id: MaterialId, control: &Control) -> Decider {
    let named = |name: &str| scene.places.get(&Place::Param(id, name.to_owned()));
    let last = || control.param.rsplit_once('.').filter(|_| scene.materials[id.0 as usize].group);
    let set = named(&control.param).or_else(|| last().and_then(|(_, name)| named(name)));
    let (file, line) = match set {
        Some(at) => (at.file.display().to_string(), at.line as u32),
        None => (control.file.clone(), control.line),
    };
    Decider {
        param: control.param.clone(),
        value: control.value.clone(),
        off_at: control.off_at.clone(),
        file,
        line,
        set: set.is_some(),
    }
}
