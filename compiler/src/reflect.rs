//! What tools ask of a shader: its name, parameters, defaults and metadata.
//!
//! Made by [`crate::check`], carried by the artifact, written as JSON. Shapes: floats are numbers, triples arrays of 3,
//! matrices arrays of 16 (row-major), arrays nest one level more.

use crate::types::Type;
use serde::Serialize;

/// A constant of reflection.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Field {
    /// Name.
    pub name: String,
    /// Type, in OSL's words.
    #[serde(rename = "type")]
    pub ty: String,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Param {
    /// Name.
    pub name: String,
    /// Type in OSL's words, such as `color` or `float[4]` or `float[]`.
    #[serde(rename = "type")]
    pub ty: String,
    /// The type itself.
    #[serde(skip)]
    pub resolved: Type,
    /// Declared `output`.
    pub output: bool,
    /// Default when it is a constant expression.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub default: Option<Value>,
    /// Fields when it is a struct.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<Field>,
    /// Metadata in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub metadata: Vec<Metadata>,
}

/// A shader as tools see it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShaderInfo {
    /// Name.
    pub name: String,
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: String,
    /// Metadata in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub metadata: Vec<Metadata>,
    /// Parameters in order.
    pub params: Vec<Param>,
}
