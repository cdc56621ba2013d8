//! A scene as data: what a scene file says, checked and loaded, before anything is planned or uploaded.
//!
//! In: the readers of this folder build it, or a program that embeds the renderer. Out: read by `plan`, `accel`, `render`.
//! It must not know OpenCL, kernels, or the compiler. World space is right-handed; any axis may point up.

mod build;
mod error;
mod file;
mod geometry;
mod material;
mod mtl;
mod obj;
mod places;
mod ply;
pub mod shapes;
mod shipped;
mod transform;
mod value;
pub mod xml;

pub use error::{Error, Location, MeshFile};
pub use file::{load, parse};
/// The vectors and maps that scenes are made of.
pub use glam::{DAffine3, DVec3, Vec2, Vec3};
pub use places::{Place, Places};
pub use shipped::{names, shipped};

use std::path::PathBuf;

/// Everything that is rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// The picture.
    pub film: Film,
    /// Paths and samples.
    pub integrator: Integrator,
    /// Shared geometry.
    pub meshes: Vec<Mesh>,
    /// Placed geometry.
    pub instances: Vec<Instance>,
    /// Materials.
    pub materials: Vec<Material>,
    /// The material whose shader gives the radiance of rays that leave the scene; black without one.
    pub environment: Option<MaterialId>,
    /// Where renderers differ.
    pub conventions: Conventions,
    /// How a pixel is made of the samples around its middle.
    pub filter: Filter,
    /// Folders that textures are looked for in, in order; then names are taken as they are.
    pub textures: Vec<PathBuf>,
    /// Folders that the shaders of groups are looked for in, in order; then beside the group's own file.
    pub shaders: Vec<PathBuf>,
    /// What `getattribute` finds anywhere, also as those of the object `global`.
    pub attributes: Attributes,
    /// Where its parts stand in its file.
    pub places: Places,
}

/// Named values for `getattribute`.
pub type Attributes = Vec<(String, ParamValue)>;

/// Index into [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(pub u32);

/// Index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// A perspective camera, pinhole or thin lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Position, world space.
    pub origin: DVec3,
    /// Point in the middle of the picture, world space.
    pub target: DVec3,
    /// Up in the picture; not parallel to the view direction.
    pub up: DVec3,
    /// Horizontal field of view in degrees, in (0, 180).
    pub hfov_degrees: f64,
    /// Lens radius in world units; 0: pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus along the view direction, world units, > 0; used when `lens_radius` > 0.
    pub focus_distance: f64,
}

/// Size of the picture in pixels, both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Film {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// What renderers do not agree on. The default is ours; what `testrender` does, that of the reference implementation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conventions {
    /// Surfaces emit on both sides, not on the front side alone.
    pub two_sided_emission: bool,
    /// Shading normals are taken as they are, and light goes where they send it, even into the surface that has them; otherwise
    /// they are bent to the viewer's side, and such light is lost.
    pub trusted_normals: bool,
    /// Random numbers are those of the reference's renderer: Sobol's points scrambled after Owen, a cube for each event of a path.
    pub shared_cubes: bool,
    /// The environment is sampled directly even if its shader asks for the type of rays; only rays of the camera have one then.
    pub tabulated_environment: bool,
    /// Values in a group's text for parameters that a shader does not have are left out with a warning; otherwise they are errors.
    pub unknown_params_warn: bool,
}

/// The weight of samples around the middle of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// All of the pixel counts alike.
    #[default]
    Box,
    /// Falls off linearly from the middle to those of the pixels around, in x and in y.
    Tent,
    /// The middle alone: edges are jagged.
    Middle,
}

/// How paths are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Edges of the longest path, at least 1: d edges are at most d - 1 surface scattering events.
    pub max_depth: u32,
    /// Bounce after which Russian roulette may end a path; `None`: never.
    pub roulette_from: Option<u32>,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// An indexed triangle mesh in its object space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// For messages and profiles.
    pub name: String,
    /// Vertex positions, all finite.
    pub positions: Vec<Vec3>,
    /// Shading normals per vertex (unit, or zero where unknown), or empty: flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates per vertex, or empty: barycentrics 0..1 per triangle.
    pub uvs: Vec<Vec2>,
    /// Indices into the above, all in range. Front side: counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// More data per vertex, for parameters with `lockgeom = 0` of these names.
    pub data: Vec<VertexData>,
    /// What `getattribute` finds on it.
    pub attributes: Attributes,
}

/// Named numbers of a mesh's vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexData {
    /// Name of the parameters that read it.
    pub name: String,
    /// Numbers per vertex: 1 is a float, 3 a color, point, vector or normal, others arrays of floats.
    pub channels: u32,
    /// All numbers, those of a vertex together.
    pub values: Vec<f32>,
}

/// A mesh placed in the world with a material.
#[derive(Clone, Debug)]
pub struct Instance {
    /// What.
    pub mesh: MeshId,
    /// Object to world; invertible.
    pub transform: DAffine3,
    /// Its material.
    pub material: MaterialId,
    /// What `getattribute` finds on it, before what its mesh, its material and the scene have.
    pub attributes: Attributes,
}

/// A shader with parameter values.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the scene file.
    pub name: String,
    /// The OSL file, for messages and relative includes.
    pub path: PathBuf,
    /// OSL source text; empty of a shader in a package.
    pub source: String,
    /// `path` is a package of compiled shaders; which of them.
    pub package: Option<FromPackage>,
    /// Parameter values by name.
    pub params: Vec<(String, ParamValue)>,
    /// The material whose displacement shader moves the vertices of what has this one.
    pub displacement: Option<MaterialId>,
    /// Rays are sent to what of it emits; otherwise paths find it by chance alone.
    pub sampled_light: bool,
    /// `source` is the text of a shader group, whose shaders are shipped ones or lie beside `path`.
    pub group: bool,
    /// Parameters (`layer.param` in a group) whose values a [`crate::session::Session`] can change, beside those whose
    /// declaration says so.
    pub interactive: Vec<String>,
    /// What `getattribute` finds on what has the material.
    pub attributes: Attributes,
}

/// A compiled shader in a package, and where the scene names it.
#[derive(Clone, Debug)]
pub struct FromPackage {
    /// Its name; `None`: the only one.
    pub shader: Option<String>,
    /// Where it is named.
    pub at: Location,
    /// Where parameters get their values.
    pub params_at: Vec<(String, Location)>,
}

impl FromPackage {
    /// Where a parameter gets its value.
    pub fn param_at(&self, name: &str) -> &Location {
        self.params_at.iter().rev().find(|(n, _)| n == name).map_or(&self.at, |(_, at)| at)
    }
}

/// A parameter value; how it fits the declared type is for the compiler to check.
#[derive(Clone, Debug, PartialEq)]
pub enum ParamValue {
    /// int (also fits float).
    Int(i64),
    /// float.
    Float(f64),
    /// string.
    Str(String),
    /// Triples, matrices and arrays of numbers.
    Floats(Vec<f64>),
    /// Arrays of strings.
    Strs(Vec<String>),
}
