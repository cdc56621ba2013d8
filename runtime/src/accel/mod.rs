//! Geometry for the device: camera-relative triangles, trees of two levels in one array, shapes and lights.
//!
//! In: a scene's meshes and instances, and which materials emit. Out: [`Geometry`], arrays as kernels/geometry.h,
//! kernels/surface.h and kernels/lights.h read them. It must not know shaders, kernels or devices.
//!
//! A mesh that is placed once is transformed on the host, in f64, and joins one common tree; only meshes that are placed more
//! often keep their object space and get instances. Without such meshes there is no top level at all.

mod alias;
mod bvh;
mod edges;
mod lights;

pub use alias::AliasTable;
pub use lights::{Emission, Lights};

use crate::choices::{Choices, TreeQuality};
use crate::plan::Effect;
use crate::scene::{Instance, Mesh, MeshId, Scene};
use glam::{DAffine3, DMat3, DVec3};

/// What geometry can't be built from.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// More than the kernels' stack holds.
    #[error("the tree over the scene's triangles is {depth} levels deep, at most {most} are possible")]
    TooDeep {
        /// Levels.
        depth: u32,
        /// Limit.
        most: u32,
    },
    /// Indices are 32 bits wide.
    #[error("the scene has {count} triangles, at most {most} are possible")]
    TooMany {
        /// Triangles.
        count: u64,
        /// Limit.
        most: u64,
    },
}

/// Most triangles, placed or shared: three corners and instance marks have to fit 32-bit indices.
const MAX_TRIANGLES: u64 = 1 << 29;

/// Bits below the shape in a triangle's last word, as in kernels/surface.h.
const FLAT_EDGES_BITS: u32 = 3;

/// Bits of a shape's flags, as in kernels/surface.h.
const HAS_NORMALS: u32 = 1;
const HAS_UVS: u32 = 2;
const EMITS: u32 = 4;

/// Arrays for the device. Positions are relative to the camera unless said otherwise.
#[derive(Debug, Default)]
pub struct Geometry {
    /// 16 floats a node; node 0 is where every ray starts.
    pub nodes: Vec<f32>,
    /// 12 numbers a triangle in leaf order: its corners, each with a coordinate of the unit normal behind it. In object space for
    /// instanced meshes.
    pub triangles: Vec<f64>,
    /// Triangle number of each of those.
    pub triangle_ids: Vec<u32>,
    /// By triangle number: indices of the three corners' attributes; and the shape (unused for instanced meshes) above 3 bits, one
    /// for each corner whose opposite edge is flat.
    pub corners: Vec<u32>,
    /// 3 floats a vertex; empty when no mesh has normals.
    pub normals: Vec<f32>,
    /// 2 floats a vertex; empty when no mesh has texture coordinates.
    pub uvs: Vec<f32>,
    /// 3 words a shape, one shape per instance of the scene: queue of the material, flags, first light less first triangle number.
    pub shapes: Vec<u32>,
    /// What the corners' indices count from, by shape: where the attributes of its mesh begin.
    pub first_vertices: Vec<u32>,
    /// Area of each shape, world units squared.
    pub areas: Vec<f64>,
    /// 32 numbers a shape: object to common space and back, row-major for row vectors.
    pub object_spaces: Vec<f64>,
    /// 24 numbers an instance: world to object, object to world, three rows of four. Empty without instancing.
    pub instances: Vec<f64>,
    /// 2 words an instance: root of its tree, shape.
    pub instance_roots: Vec<u32>,
    /// Emissive triangles.
    pub lights: Lights,
}

impl Geometry {
    /// Whether there are two levels.
    pub fn has_instances(&self) -> bool {
        !self.instance_roots.is_empty()
    }

    /// Calls `f` with the bytes of all numbers, in a fixed order.
    pub fn visit_bytes(&self, f: &mut dyn FnMut(&[u8])) {
        let floats = [&self.nodes, &self.normals, &self.uvs];
        floats.into_iter().flatten().for_each(|x| f(&x.to_le_bytes()));
        let doubles = [&self.triangles, &self.areas, &self.object_spaces, &self.instances, &self.lights.reals];
        doubles.into_iter().flatten().for_each(|x| f(&x.to_le_bytes()));
        let ids = [&self.triangle_ids, &self.corners, &self.shapes, &self.first_vertices, &self.instance_roots];
        ids.into_iter().chain([&self.lights.words]).flatten().for_each(|x| f(&x.to_le_bytes()));
    }

    /// Triangles in memory.
    pub fn triangle_count(&self) -> usize {
        self.corners.len() / 4
    }
}

/// Whether a scene places some mesh more than once.
pub fn shares_meshes(scene: &Scene) -> bool {
    shared_meshes(scene).next().is_some()
}

/// The meshes that a scene places more than once; again for each placement after the first.
pub fn shared_meshes(scene: &Scene) -> impl Iterator<Item = MeshId> + '_ {
    let mut seen = vec![false; scene.meshes.len()];
    // What is displaced gets a mesh of its own.
    let displaced = |i: &&Instance| scene.materials[i.material.0 as usize].displacement.is_some();
    let shared = scene.instances.iter().filter(move |i| !displaced(i)).map(|i| i.mesh);
    shared.filter(move |m| std::mem::replace(&mut seen[m.0 as usize], true))
}

/// What geometry says of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialUse {
    /// What its surfaces emit.
    pub emission: Emission,
    /// Number of its queue.
    pub queue: u32,
}

/// Builds the arrays. `materials` has one element per material of the scene.
pub fn build(scene: &Scene, materials: &[MaterialUse], choices: &Choices) -> Result<Geometry, Error> {
    let _span = tracing::info_span!("accel").entered();
    let mut uses = vec![0u32; scene.meshes.len()];
    for instance in &scene.instances {
        uses[instance.mesh.0 as usize] += 1;
    }
    let count: u64 =
        scene.meshes.iter().zip(&uses).filter(|(_, n)| **n > 0).map(|(m, _)| m.triangles.len() as u64).sum();
    if count > MAX_TRIANGLES {
        return Err(Error::TooMany { count, most: MAX_TRIANGLES });
    }
    let mut builder = Builder::new(scene, materials, choices.tree);
    builder.shapes();
    builder.place(&uses, choices.overrides.forces(Effect::Instances))?;
    let mut geometry = builder.out;
    geometry.lights.finish(&geometry.triangle_ids, choices.lights);
    tracing::info!(triangles = geometry.triangle_count(), nodes = geometry.nodes.len() / 16, "geometry built");
    Ok(geometry)
}

struct Builder<'a> {
    scene: &'a Scene,
    materials: &'a [MaterialUse],
    tree: TreeQuality,
    out: Geometry,
    any_normals: bool,
    any_uvs: bool,
    vertices: u32,
}

/// A bottom level: its root and its box in its own space.
struct Bottom {
    root: u32,
    depth: u32,
    lo: DVec3,
    hi: DVec3,
}

impl<'a> Builder<'a> {
    fn new(scene: &'a Scene, materials: &'a [MaterialUse], tree: TreeQuality) -> Builder<'a> {
        Builder {
            scene,
            materials,
            tree,
            out: Geometry::default(),
            any_normals: scene.meshes.iter().any(|m| !m.normals.is_empty()),
            any_uvs: scene.meshes.iter().any(|m| !m.uvs.is_empty()),
            vertices: 0,
        }
    }

    /// World transform relative to the camera.
    fn relative(&self, instance: &Instance) -> DAffine3 {
        DAffine3::from_translation(-self.scene.camera.origin) * instance.transform
    }

    fn mesh(&self, instance: &Instance) -> &'a Mesh {
        &self.scene.meshes[instance.mesh.0 as usize]
    }

    /// One shape per instance: words, area and spaces. Lights follow when the triangles have numbers.
    fn shapes(&mut self) {
        for instance in &self.scene.instances {
            let mesh = self.mesh(instance);
            let mut flags = 0;
            if !mesh.normals.is_empty() {
                flags |= HAS_NORMALS;
            }
            if !mesh.uvs.is_empty() {
                flags |= HAS_UVS;
            }
            self.out.shapes.extend([self.materials[instance.material.0 as usize].queue, flags, 0]);
            let area = corners_of(mesh, &instance.transform).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
            self.out.areas.push(area);
            self.out.first_vertices.push(0);
            self.out.object_spaces.extend(row_major(&instance.transform));
            self.out.object_spaces.extend(row_major(&instance.transform.inverse()));
        }
    }

    /// Numbers the triangles of a mesh and copies its attributes. Returns the first number.
    fn number(&mut self, mesh: &Mesh, shape: u32, transform: Option<&DAffine3>) -> u32 {
        let first = (self.out.corners.len() / 4) as u32;
        let base = self.vertices;
        let mirrored = transform.is_some_and(|t| t.matrix3.determinant() < 0.0);
        for ([a, b, c], flat) in mesh.triangles.iter().zip(edges::flat(mesh)) {
            let (b, c, flat) =
                if mirrored { (c, b, flat & 1 | (flat & 2) << 1 | (flat & 4) >> 1) } else { (b, c, flat) };
            self.out.corners.extend([base + a, base + b, base + c, shape << FLAT_EDGES_BITS | flat]);
        }
        let count = mesh.positions.len();
        self.vertices += count as u32;
        if self.any_normals {
            let turn = transform.map_or(DMat3::IDENTITY, |t| t.matrix3.inverse().transpose());
            for i in 0..count {
                let n = mesh.normals.get(i).map_or(DVec3::ZERO, |n| (turn * n.as_dvec3()).normalize_or_zero());
                self.out.normals.extend(n.as_vec3().to_array());
            }
        }
        if self.any_uvs {
            for i in 0..count {
                self.out.uvs.extend(mesh.uvs.get(i).copied().unwrap_or_default().to_array());
            }
        }
        first
    }

    /// Adds the lights of a shape whose triangles have the numbers from `first` on.
    fn light(&mut self, shape: u32, first: u32, device_instance: u32) {
        let instance = &self.scene.instances[shape as usize];
        let emission = self.materials[instance.material.0 as usize].emission;
        if emission == Emission::None {
            return;
        }
        let words = &mut self.out.shapes[3 * shape as usize..][..3];
        words[1] |= EMITS;
        words[2] = (self.out.lights.len() as u32).wrapping_sub(first);
        let transform = self.relative(instance);
        let mesh = self.mesh(instance);
        for (k, corners) in corners_of(mesh, &transform).enumerate() {
            self.out.lights.add(corners, emission, instance.material, first + k as u32, device_instance);
        }
    }

    /// Builds the trees; `two_levels` also where one would do.
    fn place(&mut self, uses: &[u32], two_levels: bool) -> Result<(), Error> {
        if !two_levels && uses.iter().all(|n| *n <= 1) {
            self.common(uses)?;
            return Ok(());
        }
        // The top level comes first, so that node 0 is its root: it is built into an array of its own and put in front.
        let mut bottoms: Vec<Option<Bottom>> = Vec::new();
        let mut firsts = vec![0u32; uses.len()];
        let common = self.common(uses)?;
        for mesh in 0..uses.len() {
            bottoms.push(if uses[mesh] > 1 {
                let data = &self.scene.meshes[mesh];
                for (shape, instance) in self.scene.instances.iter().enumerate() {
                    if instance.mesh.0 as usize == mesh {
                        self.out.first_vertices[shape] = self.vertices;
                    }
                }
                firsts[mesh] = self.number(data, 0, None);
                let corners: Vec<[DVec3; 3]> = corners_of(data, &DAffine3::IDENTITY).collect();
                Some(self.bottom(&corners, firsts[mesh])?)
            } else {
                None
            });
        }
        // Instance 0 is what needs no transform.
        let mut boxes = Vec::new();
        let identity = DAffine3::IDENTITY;
        self.instance(&identity, common.as_ref().map_or(0, |b| b.root), 0);
        let mut names = Vec::new();
        let mut deepest = 0;
        if let Some(b) = &common {
            boxes.push((b.lo, b.hi));
            names.push(0);
            deepest = b.depth;
        }
        for (shape, instance) in self.scene.instances.iter().enumerate() {
            let Some(bottom) = &bottoms[instance.mesh.0 as usize] else { continue };
            let transform = self.relative(instance);
            let number = (self.out.instance_roots.len() / 2) as u32;
            let (lo, hi) = transformed_box(&transform, bottom.lo, bottom.hi);
            boxes.push((lo, hi));
            names.push(number);
            deepest = deepest.max(bottom.depth);
            self.instance(&transform, bottom.root, shape as u32);
            self.light(shape as u32, firsts[instance.mesh.0 as usize], number);
        }
        let mut top = Vec::new();
        let tree = bvh::over_boxes(&boxes, &mut top)?;
        bvh::check_depth(tree.depth + deepest)?;
        self.put_on_top(top, &names);
        Ok(())
    }

    /// The tree over all meshes that are placed once; `None` when there are none.
    fn common(&mut self, uses: &[u32]) -> Result<Option<Bottom>, Error> {
        let mut corners = Vec::new();
        for (shape, instance) in self.scene.instances.iter().enumerate() {
            if uses[instance.mesh.0 as usize] != 1 {
                continue;
            }
            let transform = self.relative(instance);
            let mesh = self.mesh(instance);
            self.out.first_vertices[shape] = self.vertices;
            let first = self.number(mesh, shape as u32, Some(&transform));
            corners.extend(corners_of(mesh, &transform));
            self.light(shape as u32, first, 0);
        }
        if corners.is_empty() { Ok(None) } else { self.bottom(&corners, 0).map(Some) }
    }

    /// A tree over triangles with the numbers from `first` on.
    fn bottom(&mut self, corners: &[[DVec3; 3]], first: u32) -> Result<Bottom, Error> {
        let first_leaf = self.out.triangle_ids.len() as u32;
        let tree = bvh::over_triangles(corners, first_leaf, self.tree, &mut self.out.nodes)?;
        for &k in &tree.order {
            let [a, b, c] = corners[k as usize];
            // From the corner's side: zeros get the signs of the reference's renderer, on which the frame around an axis-parallel
            // normal depends.
            let normal = (a - b).cross(a - c).normalize_or_zero().to_array();
            self.out.triangles.extend([a, b, c].iter().zip(normal).flat_map(|(v, n)| [v.x, v.y, v.z, n]));
            self.out.triangle_ids.push(first + k);
        }
        let all = corners.iter().flatten();
        let lo = all.clone().fold(DVec3::INFINITY, |m, p| m.min(*p));
        let hi = all.fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
        Ok(Bottom { root: tree.root, depth: tree.depth, lo, hi })
    }

    fn instance(&mut self, transform: &DAffine3, root: u32, shape: u32) {
        for t in [&transform.inverse(), transform] {
            for r in 0..3 {
                let row = t.matrix3.row(r);
                self.out.instances.extend([row.x, row.y, row.z, t.translation[r]]);
            }
        }
        self.out.instance_roots.extend([root, shape]);
    }

    /// Puts the top level in front of the other nodes and moves their indices.
    fn put_on_top(&mut self, mut top: Vec<f32>, names: &[u32]) {
        let shift = (top.len() / bvh::NODE_FLOATS) as u32;
        for node in top.chunks_mut(bvh::NODE_FLOATS) {
            for [.., index, count] in [0, 1].map(bvh::child_places) {
                if node[count].to_bits() > 0 {
                    node[index] = f32::from_bits(names[node[index].to_bits() as usize]);
                }
            }
        }
        for node in self.out.nodes.chunks_mut(bvh::NODE_FLOATS) {
            for [.., index, count] in [0, 1].map(bvh::child_places) {
                if node[count].to_bits() == 0 {
                    node[index] = f32::from_bits(node[index].to_bits() + shift);
                }
            }
        }
        for root in self.out.instance_roots.iter_mut().step_by(2) {
            *root += shift;
        }
        top.append(&mut self.out.nodes);
        self.out.nodes = top;
    }
}

/// The corners of a mesh's triangles under a transform; counter-clockwise seen from outside also when it mirrors.
fn corners_of<'a>(mesh: &'a Mesh, transform: &DAffine3) -> impl Iterator<Item = [DVec3; 3]> + use<'a> {
    let transform = *transform;
    let mirrored = transform.matrix3.determinant() < 0.0;
    mesh.triangles.iter().map(move |t| {
        let [a, b, c] = t.map(|i| transform.transform_point3(mesh.positions[i as usize].as_dvec3()));
        if mirrored { [a, c, b] } else { [a, b, c] }
    })
}

/// The box around a transformed box.
fn transformed_box(transform: &DAffine3, lo: DVec3, hi: DVec3) -> (DVec3, DVec3) {
    let mut out = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for k in 0..8 {
        let pick = |bit: u32, axis: usize| if k & bit == 0 { lo[axis] } else { hi[axis] };
        let p = transform.transform_point3(DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2)));
        out = (out.0.min(p), out.1.max(p));
    }
    // f32 transforms on the device may land a few ulps outside.
    let slack = out.0.abs().max(out.1.abs()).max_element() * 1e-6;
    (out.0 - slack, out.1 + slack)
}

/// A transform as OSL writes matrices: row vectors, translation in the last row.
pub fn row_major(t: &DAffine3) -> [f64; 16] {
    let m = &t.matrix3;
    let p = t.translation;
    [
        m.x_axis.x, m.x_axis.y, m.x_axis.z, 0.0, m.y_axis.x, m.y_axis.y, m.y_axis.z, 0.0, m.z_axis.x, m.z_axis.y,
        m.z_axis.z, 0.0, p.x, p.y, p.z, 1.0,
    ]
}
