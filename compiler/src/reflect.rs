//! What tools ask of a shader: its name, parameters, defaults and metadata.
//!
//! Made by [`crate::check`], carried by the artifact, written as JSON. Shapes: floats are numbers, triples arrays of 3,
//! matrices arrays of 16 (row-major), arrays nest one level more.

use crate::types::{Traits, Type};
use serde::{Deserialize, Serialize};

/// A constant of reflection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// int
    Int(i32),
    /// float
    Float(f64),
    /// string
    Str(String),
    /// Triples, matrices, arrays.
    List(Vec<Value>),
}

/// One metadatum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    /// Key.
    pub name: String,
    /// Declared type, in OSL's words.
    #[serde(rename = "type")]
    pub ty: String,
    /// Value; `None` when it is no constant expression.
    pub value: Option<Value>,
}

/// A struct's field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Field {
    /// Name.
    pub name: String,
    /// Type, in OSL's words.
    #[serde(rename = "type")]
    pub ty: String,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Param {
    /// Name.
    pub name: String,
    /// Type in OSL's words, such as `color` or `float[4]` or `float[]`.
    #[serde(rename = "type")]
    pub ty: String,
    /// The type itself.
    #[serde(skip, default = "Type::nothing")]
    pub resolved: Type,
    /// Declared `output`.
    pub output: bool,
    /// Default when it is a constant expression.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub default: Option<Value>,
    /// Fields when it is a struct.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<Field>,
    /// Metadata in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub metadata: Vec<Metadata>,
}

/// A shader as tools see it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShaderInfo {
    /// Name.
    pub name: String,
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: String,
    /// Metadata in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub metadata: Vec<Metadata>,
    /// Parameters in order.
    pub params: Vec<Param>,
}

impl Param {
    /// Whether it reads what geometry has under its name: its metadata says `lockgeom = 0` or `interpolated = 1`, and not
    /// that it is interactive.
    pub fn reads_userdata(&self) -> bool {
        let (varying, traits) = hints(&self.metadata, false);
        varying && !traits.interactive
    }

    /// Whether its metadata says `interactive = 1`.
    pub fn is_interactive(&self) -> bool {
        hints(&self.metadata, false).1.interactive
    }
}

/// What a parameter's metadata says that changes how it gets its value: whether that may vary (`lockgeom = 0`, `interpolated`,
/// `interactive`), and the rest. `open`: it is an unsized array.
pub(crate) fn hints(metadata: &[Metadata], open: bool) -> (bool, Traits) {
    let int = |name: &str| {
        metadata.iter().rev().find_map(|m| match m.value {
            Some(Value::Int(v)) if m.name == name => Some(v),
            _ => None,
        })
    };
    let interactive = int("interactive").is_some_and(|v| v != 0);
    let varying = interactive || int("lockgeom") == Some(0) || int("interpolated").is_some_and(|v| v != 0);
    (varying, Traits { interactive, unconnectable: int("allowconnect") == Some(0), open })
}
