//! A package's shader as a scene's material: values for what is open, and a check that what is built into the code fits the scene.
//!
//! In: a shader, the scene, who runs it. Out: an artifact and the values that it reads at run time, or what does not fit, with its
//! place in the scene. It must not compile anything.

use super::make::suggestion;
use super::{Error, Form, Shader};
use crate::attributes;
use crate::materials::binding;
use crate::roads::Road;
use crate::scene::{FromPackage, Location, Material, Scene};
use crate::supplies::Supplies;
use crate::textures::Library;
use crate::vertex_data;
use oslcl_compiler::attributes::asked;
use oslcl_compiler::types::{Base, Type};
use oslcl_compiler::{Artifact, Binding};

/// What does not fit, and where the scene says so.
pub(crate) type Misfit = (Location, Error);

/// Who runs a shader.
pub(crate) struct Wanted<'a> {
    pub scene: &'a Scene,
    /// The material that names the shader.
    pub material: usize,
    /// The material of the surfaces that it runs on.
    pub of: usize,
    /// Vertices are moved, not light scattered.
    pub moves: bool,
    pub road: Road,
    pub library: &'a Library,
    /// Values change between renders.
    pub changes: bool,
}

/// The artifact, and the values of its interactive parameters.
pub(crate) fn take(shader: &Shader, from: &FromPackage, wanted: &Wanted<'_>) -> Result<(Artifact, Supplies), Misfit> {
    let material = &wanted.scene.materials[wanted.material];
    let mut supplies = Supplies::default();
    for (name, value) in &material.params {
        let value = binding(value);
        let open = accept(shader, name, &value).map_err(|e| (from.param_at(name).clone(), e))?;
        supplies.interactive.extend(open.map(|full| (full, value)));
    }
    let here = |error| (from.at.clone(), error);
    if wanted.changes && !wanted.moves {
        changeable(shader, material).map_err(here)?;
    }
    coordinates(shader, wanted).map_err(here)?;
    for fact in &shader.facts {
        if let Some(cause) = fact.changed(wanted.library) {
            return Err(here(Error::Fact { shader: shader.name.clone(), cause }));
        }
    }
    // Where a shader moves nothing, the one that it has says what it is instead.
    let form = if wanted.moves { shader.mover().unwrap_or(&shader.main) } else { &shader.main };
    environment(shader, form, wanted).map_err(here)?;
    Ok((on_road(shader, form, wanted.road).map_err(here)?, supplies))
}

/// The artifact with what the road takes, and no more.
pub(crate) fn on_road(shader: &Shader, form: &Form, road: Road) -> Result<Artifact, Error> {
    let mut artifact = form.artifact.clone();
    match (road, &form.no_spirv) {
        (Road::OpenClC, _) => artifact.spirv = None,
        (Road::Spirv, None) => {}
        (Road::Spirv, Some(cause)) => {
            return Err(Error::NoSpirv { shader: shader.name.clone(), cause: cause.clone() });
        }
    }
    Ok(artifact)
}

/// The full name of a parameter whose value is for the render to supply; `None`: the code has this value already.
pub(crate) fn accept(shader: &Shader, name: &str, value: &Binding) -> Result<Option<String>, Error> {
    let full = shader.full_name(name);
    let Some(param) = shader.param(&full) else { return Err(no_parameter(shader, name)) };
    let named = || (shader.name.clone(), name.to_owned());
    let refused = || {
        let (shader, name) = named();
        let value =
            param.value.as_ref().filter(|_| param.name == full).map_or(String::new(), |v| format!("{} ", shown(v)));
        Error::Baked { shader, name, value }
    };
    let (Some(ty), true) = (param.ty, param.name == full) else {
        // The types of fields are not kept: the same words are the same value.
        return if param.name == full && param.value.as_ref() == Some(value) { Ok(None) } else { Err(refused()) };
    };
    let Some(numbers) = value.numbers_as(ty) else {
        let (shader, name) = named();
        return Err(Error::Misfit { shader, name, ty: param.words.clone() });
    };
    if param.open {
        return Ok(Some(full));
    }
    let own = param.value.as_ref().and_then(|v| v.numbers_as(ty));
    if own.is_some_and(|own| are_same(ty, &own, &numbers)) { Ok(None) } else { Err(refused()) }
}

fn no_parameter(shader: &Shader, name: &str) -> Error {
    let help = suggestion(name, shader.params.iter().map(|p| p.name.as_str()));
    Error::NoParameter { shader: shader.name.clone(), name: name.to_owned(), help }
}

/// Floats are the same when 32 bits can't tell them apart: what code holds is rounded to that.
fn are_same(ty: Type, a: &[f64], b: &[f64]) -> bool {
    let exact = matches!(ty.base, Base::Int | Base::String);
    let same = |(x, y): (&f64, &f64)| x == y || !exact && *x as f32 == *y as f32;
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// A value as a scene file writes it.
pub fn shown(value: &Binding) -> String {
    let number = |v: &f64| if *v as f32 as f64 == *v { (*v as f32).to_string() } else { v.to_string() };
    match value {
        Binding::Int(v) => v.to_string(),
        Binding::Float(v) => number(v),
        Binding::Str(s) => format!("{s:?}"),
        Binding::Floats(v) => format!("[{}]", v.iter().map(number).collect::<Vec<_>>().join(", ")),
        Binding::Strs(v) => format!("{v:?}"),
    }
}

/// What shall change between renders must be open.
fn changeable(shader: &Shader, material: &Material) -> Result<(), Error> {
    for name in &material.interactive {
        match shader.params.iter().find(|p| p.name == shader.full_name(name)) {
            None => return Err(no_parameter(shader, name)),
            Some(param) if !param.open => {
                return Err(Error::NotKept { shader: shader.name.clone(), name: name.clone() });
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// Parameters that are coordinates in the code must be those in the scene.
fn coordinates(shader: &Shader, wanted: &Wanted<'_>) -> Result<(), Error> {
    if shader.coordinates.is_empty() {
        return Ok(());
    }
    let declared = vertex_data::declared(wanted.scene, wanted.of);
    for name in &shader.coordinates {
        let found = declared.iter().find(|d| d.name == *name && d.ty == Type::scalar(Base::Float));
        if found.is_some_and(|d| d.same_as.is_some()) {
            continue;
        }
        let mut on = wanted.scene.instances.iter().filter(|i| i.material.0 as usize == wanted.of);
        let meshes = &wanted.scene.meshes;
        let lack = match on.find(|i| meshes[i.mesh.0 as usize].uvs.is_empty()) {
            Some(without) => format!("mesh `{}` has none", meshes[without.mesh.0 as usize].name),
            None if found.is_some() => format!("a mesh has data of its own called `{name}`"),
            None => "the environment has none".to_owned(),
        };
        return Err(Error::Coordinate { shader: shader.name.clone(), name: name.clone(), lack });
    }
    Ok(())
}

/// Around the scene nobody fills a shader's userdata.
fn environment(shader: &Shader, form: &Form, wanted: &Wanted<'_>) -> Result<(), Error> {
    if wanted.scene.environment.is_none_or(|id| id.0 as usize != wanted.of) {
        return Ok(());
    }
    let known = attributes::around(wanted.scene, wanted.of);
    for slot in &form.artifact.inputs.userdata {
        if let Some((name, _)) = asked(&slot.name)
            && known.answer(&slot.name).is_some()
        {
            return Err(Error::EnvironmentAttribute { shader: shader.name.clone(), name: name.to_owned() });
        }
    }
    Ok(())
}
