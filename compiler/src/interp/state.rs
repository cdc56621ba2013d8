//! What the renderer tells a shader about the point (specification ch. 6 and 7.10).
//!
//! In: [`Globals`]. Out: the values of the globals and of the built-ins that read state. kernels/globals.h is its twin.

use super::ops::IDENTITY;
use crate::ir::{Const, Global, Input, Source};

/// A space's two matrices, row-major for row vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    /// To common space.
    pub to_common: [f64; 16],
    /// From common space.
    pub from_common: [f64; 16],
}

impl Default for Space {
    fn default() -> Space {
        Space { to_common: IDENTITY, from_common: IDENTITY }
    }
}

/// The point that is shaded. Positions and directions are in common space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Globals {
    /// Position.
    pub p: [f64; 3],
    /// From the viewer to P.
    pub i: [f64; 3],
    /// Shading normal.
    pub n: [f64; 3],
    /// Geometric normal.
    pub ng: [f64; 3],
    /// Surface coordinate.
    pub u: f64,
    /// Surface coordinate.
    pub v: f64,
    /// Tangent.
    pub dpdu: [f64; 3],
    /// Tangent.
    pub dpdv: [f64; 3],
    /// The point a light is asked about.
    pub ps: [f64; 3],
    /// Time.
    pub time: f64,
    /// Duration of the shutter.
    pub dtime: f64,
    /// Velocity.
    pub dpdtime: [f64; 3],
    /// Of the object, in common units squared.
    pub surfacearea: f64,
    /// The viewer is on the back.
    pub backfacing: bool,
    /// Bits `RAY_*` of kernels/globals.h.
    pub raytype: i32,
    /// The number of the point among those that are shaded together.
    pub shading_index: i32,
    /// The object's space.
    pub object_space: Space,
    /// The shader's own space.
    pub shader_space: Space,
    /// The camera's space.
    pub camera_space: Space,
    /// Userdata that the geometry has here, by name.
    pub userdata: Vec<(String, Const)>,
    /// Values of interactive parameters, by the name of their [`Input`]; the others keep their defaults.
    pub interactive: Vec<(String, Const)>,
    /// Who looks textures up.
    pub textures: Option<crate::textures::TextureAccess>,
    /// Screen, NDC, raster, then the renderer's own in the order of their names.
    pub other_spaces: Vec<Space>,
    /// Derivatives of P by the pixel's x and y.
    pub dp: [[f64; 3]; 2],
    /// Derivatives of I.
    pub di: [[f64; 3]; 2],
    /// Derivatives of Ps.
    pub dps: [[f64; 3]; 2],
    /// Derivatives of u.
    pub du: [f64; 2],
    /// Derivatives of v.
    pub dv: [f64; 2],
    /// Raster space and common space turn opposite ways.
    pub flip_handedness: bool,
}

impl Globals {
    /// The value of a global; closures have none.
    pub(super) fn value(&self, global: Global) -> Option<Const> {
        use Global::*;
        Some(match global {
            P => Const::Triple(self.p),
            I => Const::Triple(self.i),
            N => Const::Triple(self.n),
            Ng => Const::Triple(self.ng),
            U => Const::Float(self.u),
            V => Const::Float(self.v),
            DPdu => Const::Triple(self.dpdu),
            DPdv => Const::Triple(self.dpdv),
            Ps => Const::Triple(self.ps),
            Time => Const::Float(self.time),
            DTime => Const::Float(self.dtime),
            DPdtime => Const::Triple(self.dpdtime),
            Ci => return None,
            DPdx => Const::Triple(self.dp[0]),
            DPdy => Const::Triple(self.dp[1]),
            DIdx => Const::Triple(self.di[0]),
            DIdy => Const::Triple(self.di[1]),
            DPsdx => Const::Triple(self.dps[0]),
            DPsdy => Const::Triple(self.dps[1]),
            DUdx => Const::Float(self.du[0]),
            DUdy => Const::Float(self.du[1]),
            DVdx => Const::Float(self.dv[0]),
            DVdy => Const::Float(self.dv[1]),
        })
    }

    /// The value of an input; `None` where there is none of its type.
    pub(super) fn input(&self, input: &Input) -> Option<Const> {
        let list = match input.source {
            Source::Userdata | Source::HasUserdata => &self.userdata,
            Source::Interactive | Source::HasInteractive => &self.interactive,
        };
        let found = list.iter().find(|(name, _)| *name == input.name).map(|(_, c)| c);
        match input.source {
            Source::HasUserdata | Source::HasInteractive => Some(Const::Int(found.is_some().into())),
            _ => {
                let fits = |c: &&Const| match (c, input.len) {
                    (Const::Array(items), Some(len)) => {
                        items.len() == len as usize && items.iter().all(|c| c.ty() == Some(input.ty))
                    }
                    (Const::Array(_), None) | (_, Some(_)) => false,
                    (c, None) => c.ty() == Some(input.ty),
                };
                found.filter(fits).or(input.default.as_ref()).cloned()
            }
        }
    }

    /// Spaces as `lower` numbers them: 0 common, 1 object, 2 shader, 3 camera, from 4 on the others.
    fn space(&self, number: i32) -> Space {
        match number {
            1 => self.object_space,
            2 => self.shader_space,
            3 => self.camera_space,
            n => {
                let other = usize::try_from(n - 4).ok().and_then(|i| self.other_spaces.get(i));
                other.copied().unwrap_or_default()
            }
        }
    }
}

/// The value of the row `name`; `None` when it reads no state.
pub(super) fn call(name: &str, args: &[Const], globals: &Globals) -> Option<Const> {
    Some(match (name, args) {
        ("surfacearea", []) => Const::Float(globals.surfacearea),
        ("flip_handedness", []) => Const::Int(globals.flip_handedness.into()),
        ("backfacing", []) => Const::Int(globals.backfacing.into()),
        ("shading_index", []) => Const::Int(globals.shading_index),
        ("trace_hit", [Const::Triple(from), Const::Triple(direction)]) => {
            let along: f64 = from.iter().zip(direction).map(|(a, b)| a * b).sum();
            Const::Int(i32::from(globals.u / along > 0.5))
        }
        // There is no scene.
        ("trace_any", _) => Const::Int(0),
        ("raytype_bit", [Const::Int(bit)]) => Const::Int((globals.raytype & bit != 0).into()),
        ("space_matrix", [Const::Int(number)]) => Const::Matrix(globals.space(*number).to_common),
        ("space_matrix_inverse", [Const::Int(number)]) => Const::Matrix(globals.space(*number).from_common),
        _ => return None,
    })
}
