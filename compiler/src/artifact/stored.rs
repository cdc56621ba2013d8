//! Artifacts in files: all that [`Artifact`] has, where its JSON form leaves out what tools do not ask for.
//!
//! In: an artifact, or what a serde format that is not for people (CBOR and the like) read back. Out: the other one, equal in
//! every field. It must not know files.

use super::Artifact;
use crate::backend::spirv::Spirv;
use crate::ir::Global;
use crate::types::Type;
use serde::de::{Deserializer, Error as _};
use serde::{Deserialize, Serialize};

/// An artifact with what its JSON form lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stored {
    artifact: Artifact,
    /// In the order of [`types_of`].
    types: Vec<Type>,
    spirv: Option<Spirv>,
}

/// The types that the JSON form only names.
fn types_of(artifact: &mut Artifact) -> impl Iterator<Item = &mut Type> {
    let Artifact { inputs, info, .. } = artifact;
    let slots = inputs.userdata.iter_mut().chain(&mut inputs.interactive).map(|s| &mut s.resolved);
    slots.chain(info.params.iter_mut().map(|p| &mut p.resolved))
}

impl From<Artifact> for Stored {
    fn from(mut artifact: Artifact) -> Stored {
        let spirv = artifact.spirv.take();
        let types = types_of(&mut artifact).map(|ty| *ty).collect();
        Stored { artifact, types, spirv }
    }
}

/// Parts of a stored artifact that do not belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the artifact lists {types} types for {places} parameters and inputs")]
pub struct Inconsistent {
    types: usize,
    places: usize,
}

impl TryFrom<Stored> for Artifact {
    type Error = Inconsistent;

    fn try_from(stored: Stored) -> Result<Artifact, Inconsistent> {
        let Stored { mut artifact, types, spirv } = stored;
        let places = types_of(&mut artifact).count();
        if places != types.len() {
            return Err(Inconsistent { types: types.len(), places });
        }
        types_of(&mut artifact).zip(types).for_each(|(place, ty)| *place = ty);
        artifact.spirv = spirv;
        Ok(artifact)
    }
}

/// Names of globals, which are the compiler's own.
pub(super) fn globals<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<&'static str>, D::Error> {
    let names = Vec::<String>::deserialize(from)?;
    let own = |name: &String| {
        let found = Global::ALL.into_iter().find(|g| g.name() == name).map(|g| g.name());
        found.ok_or_else(|| D::Error::custom(format!("`{name}` is no global of OSL")))
    };
    names.iter().map(own).collect()
}
