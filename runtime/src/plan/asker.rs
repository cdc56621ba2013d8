//! Who asks for an effect.
//!
//! In: names. Out: [`Asker`], a value to print. It must not know where files have what: `places` finds that.

use crate::scene::{Location, MaterialId};
use std::fmt;

/// A part of the scene that calls for an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asker {
    /// What it is.
    pub part: Part,
    /// What of it, such as a setting with its value, a texture's file, a parameter; may be empty.
    pub why: String,
    /// Where the part, or what of it asks, stands in the scene's file.
    pub at: Option<Location>,
    /// Where its shader asks.
    pub shader: Vec<ShaderPlace>,
}

/// A place in a shader that asks for an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderPlace {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The parameters that decide about it; only in plans that explain themselves.
    pub deciders: Vec<Decider>,
}

/// A parameter that decides whether a place in a shader asks, or for how much.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decider {
    /// Its name.
    pub param: String,
    /// Its value; `None`: it is an array, or not known before the shader runs.
    pub value: Option<String>,
    /// A value at which the place would not ask.
    pub off_at: Option<String>,
    /// Where the scene gives it its value, or where the shader declares it: the file.
    pub file: String,
    /// The line there, from 1.
    pub line: u32,
    /// Whether the scene gives it its value.
    pub set: bool,
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
    fn new(part: Part, why: impl Into<String>) -> Asker {
        Asker { part, why: why.into(), at: None, shader: Vec::new() }
    }

    pub(super) fn of_material(id: MaterialId, name: &str) -> Asker {
        Asker::new(Part::Material(id, name.to_owned()), "")
    }

    pub(super) fn mesh(name: &str, why: impl Into<String>) -> Asker {
        Asker::new(Part::Mesh(name.to_owned()), why)
    }

    pub(super) fn setting(table: &'static str, why: impl Into<String>) -> Asker {
        Asker::new(Part::Settings(table), why)
    }

    /// The part in words.
    pub fn who(&self) -> String {
        match &self.part {
            Part::Material(_, name) => format!("material `{name}`"),
            Part::Mesh(name) => format!("mesh `{name}`"),
            Part::Settings(table) => (*table).to_owned(),
        }
    }

    /// The same part, for this reason.
    pub(super) fn because(&self, why: impl Into<String>) -> Asker {
        Asker { why: why.into(), ..self.clone() }
    }
}

impl fmt::Display for Asker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.who())?;
        if let Some(Location { file, line, .. }) = self.at.as_ref().filter(|at| at.line > 0) {
            write!(f, " ({}:{line})", file.display())?;
        }
        if !self.why.is_empty() {
            write!(f, ": {}", self.why)?;
        }
        match self.shader.as_slice() {
            [] => Ok(()),
            [ShaderPlace { file, line, .. }] => write!(f, " by {file}:{line}"),
            [ShaderPlace { file, line, .. }, more @ ..] => write!(f, " by {file}:{line} and {} more", more.len()),
        }
    }
}

impl fmt::Display for Decider {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.param)?;
        if let Some(value) = &self.value {
            write!(f, " = {value}")?;
        }
        write!(f, " ({}:{}", self.file, self.line)?;
        match &self.off_at {
            Some(end) => write!(f, "; {end} leaves it out)"),
            None => f.write_str(")"),
        }
    }
}
