//! Where the parts of a scene stand in its file.
//!
//! In: what the readers of this folder note. Out: a place for a part, where there is one. Scenes from Rust have none.

use super::{Location, MaterialId, MeshId};
use std::collections::HashMap;

/// A part of a scene that has a place.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// A material.
    Material(MaterialId),
    /// The value of a parameter of a material, by the name that the file gives it.
    Param(MaterialId, String),
    /// What names the material's displacement.
    Displacement(MaterialId),
    /// The list of the material's interactive parameters.
    Interactive(MaterialId),
    /// A mesh.
    Mesh(MeshId),
    /// What names the environment's material.
    Environment,
    /// A setting by its name in the file (`camera.lens_radius`), or `conventions`: what the file's format implies.
    Setting(&'static str),
}

/// The places of a scene's parts.
#[derive(Clone, Debug, Default)]
pub struct Places(HashMap<Place, Location>);

impl Places {
    /// Where a part stands.
    pub fn get(&self, place: &Place) -> Option<&Location> {
        self.0.get(place)
    }

    /// Notes where a part stands.
    pub fn note(&mut self, place: Place, at: Location) {
        self.0.insert(place, at);
    }
}
