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
    let material = &scene.materials[id.0 as usize];
    let in_group = || in_group(&material.source, &control.param).filter(|_| material.group);
    let set = match set {
        Some(at) => Some((at.file.display().to_string(), at.line as u32)),
        // The text of a group stands where it does in its file.
        None => in_group().map(|line| (material.path.display().to_string(), line)),
    };
    let is_set = set.is_some();
    let (file, line) = set.unwrap_or_else(|| (control.file.clone(), control.line));
    Decider {
        param: control.param.clone(),
        value: control.value.clone(),
        off_at: control.off_at.clone(),
        file,
        line,
        set: is_set,
    }
}

/// The line of a group's text that gives a parameter (`layer.param`, or `param` of the only layer) its value.
fn in_group(text: &str, param: &str) -> Option<u32> {
    let mut found = None;
    let mut pending: Vec<(&str, u32)> = Vec::new();
    let (mut start, mut line, mut quoted) = (0, 1, false);
    let mut first_line = 1;
    for (at, c) in text.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '\n' => line += 1,
            ';' if !quoted => {
                let words: Vec<&str> = text[start..at].split_whitespace().collect();
                match words.as_slice() {
                    // `param TYPE NAME VALUES`, and the type may be left out.
                    ["param", rest @ ..] => pending.extend(rest.iter().take(2).map(|name| (*name, first_line))),
                    ["shader", _, layer, ..] => {
                        let layer = layer.trim_matches('"');
                        let name = param.strip_prefix(layer).and_then(|p| p.strip_prefix('.')).unwrap_or(param);
                        found = pending.iter().find(|(p, _)| *p == name).map(|(_, line)| *line).or(found);
                        pending.clear();
                    }
                    _ => {}
                }
                start = at + 1;
                first_line = line;
            }
            c if !c.is_whitespace() && text[start..at].trim().is_empty() => first_line = line,
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_in_the_text_of_a_group() {
        let text = "param float a 1;\n  param string b \"x;y\";\nshader s one;\n\nparam a 2; shader s \"two\"; shader s three;";
        assert_eq!(in_group(text, "one.a"), Some(1));
        assert_eq!(in_group(text, "one.b"), Some(2));
        assert_eq!(in_group(text, "two.a"), Some(5));
        assert_eq!(in_group(text, "three.a"), None);
    }
}
