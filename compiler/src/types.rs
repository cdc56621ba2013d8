//! OSL's types as the checker and the reflection see them.
//!
//! The IR has simpler ones ([`crate::ir::Ty`]): structs are flattened to their fields before it.

use serde::{Deserialize, Serialize};

/// Handle of a struct declared by the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct StructId(pub u32);

/// A type without array length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Base {
    /// Result of functions that return nothing.
    Void,
    /// 32-bit two's complement.
    Int,
    /// The working precision.
    Float,
    /// Linear RGB.
    Color,
    /// Position.
    Point,
    /// Direction.
    Vector,
    /// Surface normal.
    Normal,
    /// 4x4, row-major, row vectors: `p * M`.
    Matrix,
    /// Interned string.
    String,
    /// `closure color`.
    Closure,
    /// A struct.
    Struct(StructId),
}

impl Base {
    /// color, point, vector or normal.
    pub fn is_triple(self) -> bool {
        matches!(self, Base::Color | Base::Point | Base::Vector | Base::Normal)
    }

    /// point, vector or normal.
    pub fn is_point_like(self) -> bool {
        matches!(self, Base::Point | Base::Vector | Base::Normal)
    }

    /// OSL's keyword; `struct` for structs.
    pub fn keyword(self) -> &'static str {
        match self {
            Base::Void => "void",
            Base::Int => "int",
            Base::Float => "float",
            Base::Color => "color",
            Base::Point => "point",
            Base::Vector => "vector",
            Base::Normal => "normal",
            Base::Matrix => "matrix",
            Base::String => "string",
            Base::Closure => "closure color",
            Base::Struct(_) => "struct",
        }
    }
}

/// How many elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Extent {
    /// No array.
    Scalar,
    /// `[n]`, n >= 1.
    Fixed(u32),
    /// `[]`: parameters only; known after binding or inlining.
    Unsized,
}

/// A full type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Type {
    /// Element type.
    pub base: Base,
    /// Array or not.
    pub extent: Extent,
}

impl Type {
    /// A type that is no array.
    pub const fn scalar(base: Base) -> Type {
        Type { base, extent: Extent::Scalar }
    }

    /// Of what has no value yet.
    pub(crate) const fn nothing() -> Type {
        Type::scalar(Base::Void)
    }

    /// Whether it is an array, sized or not.
    pub fn is_array(self) -> bool {
        self.extent != Extent::Scalar
    }
}

/// What a parameter's declaration says beside its type and default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traits {
    /// `[[ int interactive = 1 ]]`: can be changed without compiling again.
    pub interactive: bool,
    /// `[[ int allowconnect = 0 ]]`: no connection may set it.
    pub unconnectable: bool,
    /// An unsized array, whose length binding and connections give.
    pub open: bool,
}

/// A float as an int: towards zero; the smallest int for what no int holds, and for NaN.
pub fn truncated(x: f64) -> i32 {
    if (-2_147_483_648.0..2_147_483_648.0).contains(&x) { x as i32 } else { i32::MIN }
}
