//! What testshade's options give shaders beside the points: userdata, changed parameters, and when layers run.
//!
//! In: [`Args`] and what they build. Out: [`Supplies`] and [`Lazy`].

use super::args::{Args, Value};
use super::build::Built;
use oslcl_compiler::attributes::{Attribute, Attributes, Value as Constant};
use oslcl_compiler::types::{Base, Extent, Type};
use oslcl_compiler::{Binding, Lazy, Userdata};
use oslcl_runtime::shade::{Given, PointData, Supplies};

/// The userdata of the reference's tool and that of `--userdata`.
pub fn of(args: &Args) -> Supplies {
    let mut supplies = Supplies::of_testshade();
    supplies.userdata.extend(args.userdata.iter().map(|value| PointData {
        declared: Userdata { name: value.name.clone(), ty: type_of(value), sometimes: false, same_as: None },
        given: Given::Constant(value.value.clone()),
    }));
    supplies
}

/// The type that an option gives, else that of its value.
fn type_of(value: &Value) -> Type {
    let given = value.ty.as_deref().unwrap_or(match &value.value {
        Binding::Int(_) => "int",
        Binding::Str(_) => "string",
        Binding::Floats(list) if list.len() == 3 => "vector",
        Binding::Floats(list) if list.len() == 16 => "matrix",
        _ => "float",
    });
    let (base, length) =
        given.split_once('[').map_or((given, None), |(b, n)| (b, n.trim_end_matches(']').parse().ok()));
    let base = match base {
        "int" => Base::Int,
        "color" => Base::Color,
        "point" => Base::Point,
        "vector" => Base::Vector,
        "normal" => Base::Normal,
        "matrix" => Base::Matrix,
        "string" => Base::String,
        _ => Base::Float,
    };
    Type { base, extent: length.map_or(Extent::Scalar, Extent::Fixed) }
}

/// What `getattribute` finds: the grid's attributes, and the data of `--userdata` where there is none of the name.
pub fn attributes(args: &Args, mut known: Attributes) -> Attributes {
    for value in &args.userdata {
        let floats = |list: &[f64]| list.iter().map(|v| Constant::Float(*v)).collect();
        let constant = match &value.value {
            Binding::Int(v) => i32::try_from(*v).map_or(Constant::Float(*v as f64), Constant::Int),
            Binding::Float(v) => Constant::Float(*v),
            Binding::Str(s) => Constant::Str(s.clone()),
            Binding::Floats(list) => match (list.as_slice(), type_of(value).extent) {
                ([x, y, z], Extent::Scalar) => Constant::Triple([*x, *y, *z]),
                _ => Constant::Array(floats(list)),
            },
            Binding::Strs(list) => Constant::Array(list.iter().map(|s| Constant::Str(s.clone())).collect()),
        };
        let ty = type_of(value);
        let length = if let Extent::Fixed(n) = ty.extent { format!("[{n}]") } else { String::new() };
        let ty = format!("{}{length}", ty.base.keyword());
        // The first that fits counts: data comes after attributes.
        known.list.push(Attribute { object: String::new(), name: value.name.clone(), ty, value: constant });
    }
    known
}

/// The values of `--reparam`, by the names of interactive parameters.
pub fn later(built: &Built) -> impl Iterator<Item = (String, Binding)> {
    built.later.iter().map(|(layer, value)| (format!("{layer}.{}", value.name), value.value.clone()))
}

/// `--options lazylayers=0` and the like.
pub fn lazy(args: &Args) -> Lazy {
    let mut lazy = Lazy::default();
    for (name, value) in &args.options {
        let on = value != "0";
        match name.as_str() {
            "lazylayers" => lazy.layers = on,
            "lazyglobals" => lazy.globals = on,
            "lazyunconnected" => lazy.unconnected = on,
            "lazyerror" => lazy.errors = on,
            "lazytrace" => lazy.traces = on,
            _ => {}
        }
    }
    lazy
}
