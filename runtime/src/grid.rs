//! The points that a shader is run over without a scene: those of OSL's testshade.
//!
//! In: how many points, and testshade's settings of them. Out: the patch as the device's kernel takes it, and the same points
//! as the interpreter takes them. It must not know devices.
//!
//! u and v run from 0 to 1 over the grid (0.5 where it is one point wide), P = (u, v, 1), N = Ng = (0, 0, 1), dPdu and dPdv
//! along x and y, I = 0, surfacearea = 1. kernels/stages/shade.cl is the twin of [`Grid::globals`].

use glam::{DMat4, DVec3, DVec4};
use oslcl_compiler::attributes::{Attribute, Attributes, Value};
use oslcl_compiler::{Globals, Space};

/// The names of the spaces that a grid knows beyond those of every renderer, in the order of `other_spaces` from its fourth
/// on (kernels/globals.h).
pub const SPACES: [&str; 1] = ["myspace"];

/// Points of a grid, and how they lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Across, at least 1.
    pub width: u32,
    /// Down, at least 1.
    pub height: u32,
    /// Points in the middles of the grid's cells, not from edge to edge.
    pub center: bool,
    /// Derivatives of u that differ from point to point: (1 - u, u).
    pub vary_udxdy: bool,
    /// Derivatives of v that differ from point to point: (1 - v, v).
    pub vary_vdxdy: bool,
    /// Derivatives of P that differ from point to point: (1 - u, 1 - v, u / 2) and (1 - v, 1 - u, v / 2).
    pub vary_pdxdy: bool,
    /// Scale of u and v.
    pub scale_uv: [f32; 2],
    /// Offset of u and v, after the scale.
    pub offset_uv: [f32; 2],
    /// Bits `RAY_*` of kernels/globals.h.
    pub raytype: u32,
    /// Object space to common space, row-major for row vectors, as all matrices here.
    pub object_to_common: [f64; 16],
    /// Shader space to common space.
    pub shader_to_common: [f64; 16],
    /// The space "myspace" to common space.
    pub myspace_to_common: [f64; 16],
}

/// A turn about z, then a shift, as a matrix for row vectors.
fn turned(quarter_turns: f64, shift: [f64; 2]) -> [f64; 16] {
    let (s, c) = (quarter_turns * std::f64::consts::FRAC_PI_2).sin_cos();
    [c, s, 0., 0., -s, c, 0., 0., 0., 0., 1., 0., shift[0], shift[1], 0., 1.]
}

impl Default for Grid {
    fn default() -> Grid {
        let mut scaled = [0.0; 16];
        for (i, s) in [1.0, 2.0, 1.0, 1.0].into_iter().enumerate() {
            scaled[5 * i] = s;
        }
        Grid {
            width: 1,
            height: 1,
            center: false,
            vary_udxdy: false,
            vary_vdxdy: false,
            vary_pdxdy: false,
            scale_uv: [1.0; 2],
            offset_uv: [0.0; 2],
            raytype: 1,
            object_to_common: turned(1.0, [0.0, 1.0]),
            shader_to_common: turned(0.5, [1.0, 0.0]),
            myspace_to_common: scaled,
        }
    }
}

/// testshade's camera: in the origin, along z, 90 degrees wide, with these planes.
const NEAR: f64 = 0.1;
const FAR: f64 = 1000.0;

fn space(to_common: &[f64; 16]) -> Space {
    // Row vectors and rows against glam's column vectors and columns: the same numbers in the same order.
    let from_common = DMat4::from_cols_array(to_common).inverse().to_cols_array();
    Space { to_common: *to_common, from_common }
}

fn from_common(from_common: &DMat4) -> Space {
    Space { to_common: from_common.inverse().to_cols_array(), from_common: from_common.to_cols_array() }
}

impl Grid {
    /// A grid with the default settings.
    pub fn new(width: u32, height: u32) -> Grid {
        Grid { width, height, ..Grid::default() }
    }

    /// What `getattribute` finds: testshade's camera, and the one option that it answers.
    pub fn attributes(&self) -> Attributes {
        let float = |v: f64| Value::Float(v);
        let floats = |v: &[f64]| Value::Array(v.iter().map(|x| Value::Float(*x)).collect());
        let aspect = f64::from(self.width) / f64::from(self.height);
        let size = [self.width, self.height].map(|n| Value::Int(i32::try_from(n).unwrap_or(i32::MAX)));
        let camera = [
            ("resolution", "int[2]", Value::Array(size.to_vec())),
            ("projection", "string", Value::Str("perspective".to_owned())),
            ("fov", "float", float(90.0)),
            ("pixelaspect", "float", float(1.0)),
            ("clip", "float[2]", floats(&[NEAR, FAR])),
            ("clip_near", "float", float(NEAR)),
            ("clip_far", "float", float(FAR)),
            ("shutter", "float[2]", floats(&[0.0, 1.0])),
            ("shutter_open", "float", float(0.0)),
            ("shutter_close", "float", float(1.0)),
            ("screen_window", "float[4]", floats(&[-aspect, -1.0, aspect, 1.0])),
        ];
        let mut list: Vec<Attribute> = Vec::new();
        let mut add = |object: &str, name: String, ty: &str, value: Value| {
            list.push(Attribute { object: object.to_owned(), name, ty: ty.to_owned(), value });
        };
        for (name, ty, value) in camera {
            // testshade's renderer does not look at the object.
            add("", format!("camera:{name}"), ty, value);
        }
        // The reference's own digits of pi.
        #[allow(clippy::approx_constant)]
        add("options", "blahblah".to_owned(), "float", float(3.14159));
        Attributes { list, ..Attributes::default() }
    }

    /// Screen, NDC and raster space of the camera, then those of [`SPACES`].
    fn other_spaces(&self) -> Vec<Space> {
        let depth = FAR - NEAR;
        let screen = DMat4::from_cols(
            DVec4::X,
            DVec4::Y,
            DVec4::new(0.0, 0.0, FAR / depth, 1.0),
            DVec4::new(0.0, 0.0, -FAR * NEAR / depth, 0.0),
        );
        let to_ndc = DMat4::from_translation(DVec3::new(0.5, 0.5, 0.0)) * DMat4::from_scale(DVec3::new(0.5, 0.5, 1.0));
        let ndc = to_ndc * screen;
        let raster = DMat4::from_scale(DVec3::new(self.width.into(), self.height.into(), 1.0)) * ndc;
        vec![from_common(&screen), from_common(&ndc), from_common(&raster), space(&self.myspace_to_common)]
    }

    /// Bits `GRID_*` of kernels/stages/shade.cl.
    pub(crate) fn flags(&self) -> u32 {
        let bits = [self.center, self.vary_udxdy, self.vary_vdxdy, self.vary_pdxdy];
        bits.iter().enumerate().map(|(i, on)| u32::from(*on) << i).sum()
    }

    /// The argument `patch` of kernels/stages/shade.cl.
    pub(crate) fn patch(&self) -> [f32; 4] {
        [self.scale_uv[0], self.scale_uv[1], self.offset_uv[0], self.offset_uv[1]]
    }

    /// The argument `spaces` of kernels/stages/shade.cl.
    pub(crate) fn spaces(&self) -> Vec<f64> {
        let mut spaces = vec![space(&self.object_to_common), space(&self.shader_to_common), Space::default()];
        spaces.extend(self.other_spaces());
        spaces.iter().flat_map(|s| s.to_common.into_iter().chain(s.from_common)).collect()
    }

    /// The point in column `x`, row `y`, as the interpreter takes it.
    pub fn globals(&self, x: u32, y: u32) -> Globals {
        let [width, height] = [self.width, self.height].map(f64::from);
        let [scale_u, scale_v] = self.scale_uv.map(f64::from);
        let [offset_u, offset_v] = self.offset_uv.map(f64::from);
        let coordinate = |i: u32, n: f64, scale: f64, offset: f64| {
            let i = f64::from(i);
            let at = match (self.center, n > 1.0) {
                (true, _) => (i + 0.5) / n,
                (false, true) => i / (n - 1.0),
                (false, false) => 0.5,
            };
            scale * at + offset
        };
        let u = coordinate(x, width, scale_u, offset_u);
        let v = coordinate(y, height, scale_v, offset_v);
        let (dx, dy) = (scale_u / (width - 1.0).max(1.0), scale_v / (height - 1.0).max(1.0));
        let along = |uniform: f64, cells: f64| if self.center { cells } else { uniform };
        Globals {
            p: [u, v, 1.0],
            n: [0.0, 0.0, 1.0],
            ng: [0.0, 0.0, 1.0],
            u,
            v,
            dpdu: [1.0, 0.0, 0.0],
            dpdv: [0.0, 1.0, 0.0],
            surfacearea: 1.0,
            raytype: self.raytype as i32,
            object_space: space(&self.object_to_common),
            shader_space: space(&self.shader_to_common),
            other_spaces: self.other_spaces(),
            dp: match self.vary_pdxdy {
                true => [[1.0 - u, 1.0 - v, u / 2.0], [1.0 - v, 1.0 - u, v / 2.0]],
                false => [[dx, 0.0, 0.0], [0.0, dy, 0.0]],
            },
            du: if self.vary_udxdy { [1.0 - u, u] } else { [along(dx, scale_u / width), 0.0] },
            dv: if self.vary_vdxdy { [1.0 - v, v] } else { [0.0, along(dy, scale_v / height)] },
            ..Globals::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_as_testshade_lays_them() {
        let edges = Grid::new(5, 1).globals(1, 0);
        assert_eq!((edges.u, edges.v, edges.p), (0.25, 0.5, [0.25, 0.5, 1.0]));
        assert_eq!((edges.du, edges.dv), ([0.25, 0.0], [0.0, 1.0]));
        let middles = Grid { center: true, scale_uv: [2.0, 1.0], offset_uv: [0.0, 1.0], ..Grid::new(4, 2) };
        let middles = middles.globals(3, 0);
        assert_eq!((middles.u, middles.v), (1.75, 1.25));
        assert_eq!((middles.du, middles.dv), ([0.5, 0.0], [0.0, 0.5]));
        // testshade spreads P's derivatives from edge to edge in both.
        assert_eq!(middles.dp, [[2.0 / 3.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let varying = Grid { vary_udxdy: true, vary_vdxdy: true, vary_pdxdy: true, ..Grid::new(5, 5) }.globals(1, 3);
        assert_eq!((varying.du, varying.dv), ([0.75, 0.25], [0.25, 0.75]));
        assert_eq!(varying.dp, [[0.75, 0.25, 0.125], [0.25, 0.75, 0.375]]);
    }

    #[test]
    fn spaces_undo_themselves() {
        let grid = Grid::new(8, 4);
        let spaces = grid.spaces();
        assert_eq!(spaces.len(), 32 * (6 + SPACES.len()));
        for pair in spaces.chunks_exact(32) {
            let [there, back] = [&pair[..16], &pair[16..]].map(DMat4::from_cols_slice);
            assert!((there * back).abs_diff_eq(DMat4::IDENTITY, 1e-9), "{there} {back}");
        }
        // (0, 0, 1) lies on the camera's axis: in the middle of the raster.
        let raster = DMat4::from_cols_slice(&spaces[32 * 5 + 16..32 * 6]);
        assert_eq!(raster.project_point3(DVec3::Z).truncate().to_array(), [4.0, 2.0]);
        let object = DMat4::from_cols_array(&grid.object_to_common);
        assert!(object.transform_point3(DVec3::X).abs_diff_eq(DVec3::new(0.0, 2.0, 0.0), 1e-12));
    }
}
