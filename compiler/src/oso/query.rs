//! What `oslinfo` tells of a shader: parameters with the fields of structs as parameters of their own, raw values, metadata.
//!
//! In: a module. Out: [`Query`]. It must not know how it is printed.

use super::read_call::meta;
use super::{Element, HintArg, Literal, Module, SymbolKind};
use crate::reflect::{Metadata, Value};
use crate::types::{Base, Extent};
use serde::Serialize;

/// A shader as `oslinfo` sees it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Query {
    /// `surface`, `displacement`, `volume` or `shader`.
    pub kind: String,
    /// Name.
    pub name: String,
    /// Metadata in order.
    pub metadata: Vec<Metadata>,
    /// Parameters in order; those of a struct's fields follow the struct.
    pub params: Vec<Param>,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Param {
    /// Name; of a field, `struct.field`.
    pub name: String,
    /// Type in OSL's words; of a struct, `struct NAME`.
    #[serde(rename = "type")]
    pub ty: String,
    /// Declared `output`.
    pub output: bool,
    /// An array whose length the default or the renderer tells.
    pub unsized_array: bool,
    /// Whether values print in brackets: arrays, triples and matrices.
    #[serde(skip)]
    pub brackets: bool,
    /// The names of a struct's fields.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Vec<String>>,
    /// All default values, triples and matrices taken apart; `None` when the default is computed.
    pub default: Option<Vec<Value>>,
    /// Metadata in order.
    pub metadata: Vec<Metadata>,
}

/// Asks a module.
pub fn query(module: &Module) -> Query {
    let mut params = Vec::new();
    for symbol in &module.symbols {
        if !symbol.kind.is_param() {
            continue;
        }
        let base = symbol.ty.base();
        let zero = match base {
            Some(Base::Int) => Value::Int(0),
            Some(Base::String) => Value::Str(String::new()),
            _ => Value::Float(0.0),
        };
        let mut values: Vec<Value> = symbol
            .values
            .iter()
            .map(|v| match v {
                Literal::Int(i) if base == Some(Base::Int) => Value::Int(*i),
                Literal::Int(i) => Value::Float(f64::from(*i)),
                Literal::Float(f) => Value::Float(*f),
                Literal::Str(s) => Value::Str(s.clone()),
            })
            .collect();
        let known = !values.is_empty() && symbol.hint("initexpr").is_none() && base.is_some();
        match symbol.ty.extent {
            Extent::Fixed(n) if known => values.resize(n as usize * symbol.ty.components(), zero),
            Extent::Scalar if known => values.resize(symbol.ty.components(), zero),
            _ => {}
        }
        let fields = match symbol.ty.element {
            Element::Struct(_) => {
                let hint = symbol.hint("structfields");
                Some(hint.map_or(Vec::new(), |h| h.args.iter().map(|a| HintArg::text(a).to_owned()).collect()))
            }
            Element::Base(_) => None,
        };
        params.push(Param {
            name: symbol.name.clone(),
            ty: symbol.ty.spelling(),
            output: symbol.kind == SymbolKind::OutputParam,
            unsized_array: symbol.ty.extent == Extent::Unsized,
            brackets: symbol.ty.extent != Extent::Scalar || symbol.ty.components() > 1,
            fields,
            default: known.then_some(values),
            metadata: symbol.hints.iter().filter_map(meta).collect(),
        });
    }
    Query {
        kind: module.kind.clone(),
        name: module.name.clone(),
        metadata: module.hints.iter().filter_map(meta).collect(),
        params,
    }
}
