//! Who asks for an effect.
//!
//! In: names. Out: [`Asker`], a value to print or to find in a file. It must not know where files have what.

use crate::scene::MaterialId;
use std::fmt;

/// A part of the scene that calls for an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asker {
    /// What it is.
    pub part: Part,
    /// What of it, such as a setting with its value, a texture's file, a parameter; may be empty.
    pub why: String,
}

/// A part of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// A material: its number and name.
    Material(MaterialId, String),
    /// A mesh, by name.
    Mesh(String),
    /// A table of settings: `camera`, `film`, `integrator`; or `precision`, which the scene does not decide.
    Settings(&'static str),
}

impl Asker {
    pub(super) fn of_material(id: MaterialId, name: &str) -> Asker {
        Asker { part: Part::Material(id, name.to_owned()), why: String::new() }
    }

    pub(super) fn mesh(name: &str, why: impl Into<String>) -> Asker {
        Asker { part: Part::Mesh(name.to_owned()), why: why.into() }
    }

    pub(super) fn setting(table: &'static str, why: impl Into<String>) -> Asker {
        Asker { part: Part::Settings(table), why: why.into() }
    }

    /// The same part, for this reason.
    pub(super) fn because(&self, why: impl Into<String>) -> Asker {
        Asker { why: why.into(), ..self.clone() }
    }
}

impl fmt::Display for Asker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.part {
            Part::Material(_, name) => write!(f, "material `{name}`")?,
            Part::Mesh(name) => write!(f, "mesh `{name}`")?,
            Part::Settings(table) => f.write_str(table)?,
        }
        if self.why.is_empty() { Ok(()) } else { write!(f, ": {}", self.why) }
    }
}
