//! Moves the vertices of meshes as their displacement shaders say, before anything is built from them.
//!
//! In: a scene, the artifacts of its displacement shaders. Out: the scene with a mesh of its own for each placed mesh that is
//! displaced. A shader sees the vertices in common space, with dPdu and dPdv averaged over the triangles around, and
//! u and v; what it leaves in P is where the vertex goes. Where P stayed everywhere, N is the new shading normal (a bump);
//! else normals are those of the displaced surface. The subdivision of the mesh is the detail there is: nothing is subdivided.
//! It must not know how rays find surfaces.

use crate::accel::row_major;
use crate::assemble;
use crate::device::{self, Arg, Buffer, Device, Program};
use crate::materials::Compiled;
use crate::precision::Precision;
use crate::scene::{DAffine3, DVec3, Mesh, MeshId, Scene, Vec3};
use crate::shade::{Real, Records, numbers};
use crate::supplies::Supplies;
use crate::told::Heard;
use crate::wavefront::MESSAGE_WORDS;
use crate::{attributes, points, preamble, programs, roads, textures, vertex_data};
use oslcl_compiler::Artifact;
use std::borrow::Cow;
use std::collections::HashMap;

/// Outputs of the grid function that `apply` takes, in this order.
pub const OUTPUTS: [&str; 2] = ["P", "N"];

/// Reals per vertex that the kernel reads: VERTEX_REALS of kernels/stages/displace.cl.
const VERTEX_REALS: usize = 16;

/// Work-items of a group.
const GROUP: usize = 64;

/// Vertices of a launch: bounds the device memory.
const BAND: usize = 1 << 20;

/// Why a surface can't be displaced.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// No program comes out.
    #[error(transparent)]
    Road(#[from] roads::Error),
    /// The generated code includes an unknown header.
    #[error(transparent)]
    Assemble(#[from] assemble::Error),
    /// What came back as messages is none.
    #[error(transparent)]
    Messages(#[from] oslcl_compiler::messages::Damaged),
    /// The point clouds can't be held.
    #[error(transparent)]
    Points(#[from] points::Error),
    /// The textures can't be held.
    #[error(transparent)]
    Textures(#[from] textures::Error),
    /// The shader moved a vertex to no place.
    #[error(
        "mesh `{mesh}`: its displacement shader `{shader}` moves vertex {vertex} to a place that is not finite\n  \
         help: look for divisions by zero or roots of negative numbers at P = ({}, {}, {})", at.x, at.y, at.z
    )]
    NotFinite {
        /// The mesh.
        mesh: String,
        /// The shader.
        shader: String,
        /// Which vertex.
        vertex: usize,
        /// Where it was, world space.
        at: DVec3,
    },
}

/// Displaces all that has a displacement shader. A scene where nothing
/// is displaced comes back as it is. What the shaders say is added to `heard`.
pub(crate) fn apply<'a>(
    scene: &'a Scene,
    compiled: &Compiled,
    device: &Device,
    precision: Precision,
    heard: &mut Heard,
) -> Result<Cow<'a, Scene>, Error> {
    let artifacts = &compiled.displacements;
    let shader_of = |material: usize| artifacts.get(material).and_then(Option::as_ref);
    if scene.instances.iter().all(|i| shader_of(i.material.0 as usize).is_none()) {
        return Ok(Cow::Borrowed(scene));
    }
    let _span = tracing::info_span!("displace").entered();
    let files = artifacts.iter().flatten().flat_map(|a| a.textures.iter().map(|t| t.file.as_str()));
    let packed = textures::pack(&compiled.textures, files)?;
    let packed_messages = packed.messages;
    let packed = device.upload("textures", &packed.words)?;
    let given = compiled.displacement_values.iter().flat_map(Supplies::strings);
    let names = artifacts.iter().flatten().flat_map(|a| a.point_clouds.iter().map(String::as_str));
    let clouds = points::pack(compiled.textures.points(), names)?;
    let strings = packed_messages.into_iter().chain(attributes::strings(scene)).chain(given).chain(clouds.strings);
    let strings: Vec<String> = strings.collect();
    let clouds = device.upload("point clouds", &clouds.words)?;
    let mut programs = HashMap::new();
    let mut out = scene.clone();
    for index in 0..scene.instances.len() {
        let instance = &scene.instances[index];
        let Some(artifact) = shader_of(instance.material.0 as usize) else { continue };
        if !programs.contains_key(&artifact.entry) {
            programs.insert(artifact.entry.clone(), build(device, artifact, precision)?);
        }
        let mesh = &scene.meshes[instance.mesh.0 as usize];
        let by = scene.materials[instance.material.0 as usize].displacement.map_or(0, |m| m.0 as usize);
        let job = Job {
            mesh,
            instance: index,
            transform: instance.transform,
            eye: scene.camera.origin,
            artifact,
            values: &compiled.displacement_values[instance.material.0 as usize],
            textures: &packed,
            clouds: &clouds,
            speaker: &scene.materials[by].name,
            strings: &strings,
        };
        let moved = match precision.is_double() {
            true => job.run::<f64>(device, &programs[&artifact.entry], scene, heard)?,
            false => job.run::<f32>(device, &programs[&artifact.entry], scene, heard)?,
        };
        out.meshes.push(moved);
        out.instances[index].mesh = MeshId(out.meshes.len() as u32 - 1);
    }
    Ok(Cow::Owned(out))
}

/// The shader's text with the kernel behind it, built.
fn build(device: &Device, artifact: &Artifact, precision: Precision) -> Result<Program, Error> {
    let text = format!(
        "{}{}\n#define DISPLACE_ENTRY {}\n#include \"stages/displace.cl\"\n",
        preamble::text(artifact),
        preamble::code(artifact),
        artifact.entry
    );
    let source = assemble::assemble(&format!("{}.cl", artifact.entry), &text)?;
    let module = roads::module(artifact, precision);
    Ok(programs::build_one(device, &artifact.name, &source, precision.build_options(), module.as_slice())?)
}

/// A float of the device as an argument of kernels.
trait Scalar: Real {
    fn arg(value: f64) -> Arg<'static>;
}

impl Scalar for f32 {
    fn arg(value: f64) -> Arg<'static> {
        Arg::F32(value as f32)
    }
}

impl Scalar for f64 {
    fn arg(value: f64) -> Arg<'static> {
        Arg::F64(value)
    }
}

/// One placed mesh to displace.
struct Job<'a> {
    mesh: &'a Mesh,
    instance: usize,
    transform: DAffine3,
    eye: DVec3,
    artifact: &'a Artifact,
    values: &'a Supplies,
    textures: &'a Buffer,
    clouds: &'a Buffer,
    /// Name of the displacement's material.
    speaker: &'a str,
    /// What its messages may hold beside its own strings.
    strings: &'a [String],
}

/// A vertex as the shader sees it, world space.
#[derive(Clone, Copy)]
struct Vertex {
    p: DVec3,
    n: DVec3,
    dpdu: DVec3,
    dpdv: DVec3,
    /// How far u and v go on the way to a neighbour.
    step: [f64; 2],
}

impl Job<'_> {
    /// The displaced mesh, in object space.
    fn run<T: Scalar>(
        &self,
        device: &Device,
        program: &Program,
        scene: &Scene,
        heard: &mut Heard,
    ) -> Result<Mesh, Error> {
        let vertices = self.vertices();
        let mut reals: Vec<T> = Vec::with_capacity(vertices.len() * VERTEX_REALS);
        for (i, v) in vertices.iter().enumerate() {
            let triples = [v.p, v.n, v.dpdu, v.dpdv].map(|t| t.to_array());
            reals.extend(triples.iter().flatten().map(|x| T::from_f64(*x)));
            let uv = self.mesh.uvs.get(i).copied().unwrap_or_default();
            reals.extend([f64::from(uv.x), f64::from(uv.y), v.step[0], v.step[1]].map(T::from_f64));
        }
        let mut spaces: Vec<T> = Vec::with_capacity(160);
        let camera = scene.camera.to_world();
        for map in [self.transform, self.transform.inverse(), camera, camera.inverse()] {
            spaces.extend(row_major(&map).map(T::from_f64));
        }
        spaces.extend(scene.camera.other_spaces(scene.film).into_iter().map(T::from_f64));
        let (spaces, inputs) = (device.upload("spaces", &spaces)?, device.upload("vertices", &reals)?);
        let kernel = program.kernel(device, "displace")?;
        let band = vertices.len().min(BAND);
        let outputs = device.buffer("displaced vertices", (band * 6 * size_of::<T>()) as u64)?;
        let interactive: Vec<T> = numbers(&self.values.interactive(self.artifact));
        let interactive = match interactive.is_empty() {
            true => None,
            false => Some(device.upload("interactive parameters", &interactive)?),
        };
        let userdata = vertex_data::at_vertices(scene, self.instance, self.artifact);
        let userdata: Vec<T> = userdata.iter().flat_map(|slots| numbers::<T>(slots)).collect();
        let userdata = match userdata.is_empty() {
            true => None,
            false => Some(device.upload("userdata", &userdata)?),
        };
        let mut records = match self.artifact.sites.is_empty() {
            true => None,
            false => Some(Records::new(device, MESSAGE_WORDS)?),
        };
        let decoder = self.artifact.decoder(self.strings);
        let mut results: Vec<f64> = Vec::with_capacity(vertices.len() * 6);
        while results.len() < vertices.len() * 6 {
            let first = results.len() / 6;
            let count = band.min(vertices.len() - first);
            let [x, y, z] = self.eye.to_array().map(T::arg);
            let mut args = vec![
                Arg::U32(first as u32),
                Arg::U32(count as u32),
                x,
                y,
                z,
                Arg::Buffer(&spaces),
                Arg::Buffer(&inputs),
                Arg::Buffer(&outputs),
            ];
            if !self.artifact.textures.is_empty() {
                args.push(Arg::Buffer(self.textures));
            }
            if let Some(records) = &mut records {
                // What has no room is not written: nothing older may stand there.
                device.clear(&mut records.buffer)?;
                records.reset(device)?;
            }
            args.extend(records.iter().map(|r| Arg::Buffer(&r.buffer)));
            args.extend(interactive.iter().map(Arg::Buffer));
            if !self.artifact.point_clouds.is_empty() {
                args.push(Arg::Buffer(self.clouds));
            }
            args.extend(userdata.iter().map(Arg::Buffer));
            kernel.launch(device, &args, count.next_multiple_of(GROUP), GROUP)?;
            if let Some(records) = &mut records {
                let (words, lost) = records.take_what_fits(device)?;
                heard.lost_bytes += 4 * lost;
                for message in decoder.messages(&words)? {
                    heard.add(self.speaker, message);
                }
            }
            results.extend(device.read::<T>(&outputs, count * 6)?.into_iter().map(Into::<f64>::into));
        }
        self.moved(&vertices, &results)
    }

    /// The mesh's vertices in world space.
    fn vertices(&self) -> Vec<Vertex> {
        let zero = Vertex { p: DVec3::ZERO, n: DVec3::ZERO, dpdu: DVec3::ZERO, dpdv: DVec3::ZERO, step: [0.0; 2] };
        let mut out = vec![zero; self.mesh.positions.len()];
        for (v, p) in out.iter_mut().zip(&self.mesh.positions) {
            v.p = self.transform.transform_point3(p.as_dvec3());
        }
        let flat = self.mesh.normals.is_empty();
        for triangle in &self.mesh.triangles {
            let corners = triangle.map(|i| i as usize);
            let [a, b, c] = corners.map(|i| out[i].p);
            let (e1, e2) = (b - a, c - a);
            let uv = corners.map(|i| self.mesh.uvs.get(i).copied().unwrap_or_default().as_dvec2());
            let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
            let det = d1.x * d2.y - d1.y * d2.x;
            for i in corners {
                if det != 0.0 {
                    out[i].dpdu += (e1 * d2.y - e2 * d1.y) / det;
                    out[i].dpdv += (e2 * d1.x - e1 * d2.x) / det;
                }
                if flat {
                    out[i].n += e1.cross(e2);
                }
            }
        }
        let mut count = vec![0.0; out.len()];
        let mut reach = vec![0.0; out.len()];
        for triangle in &self.mesh.triangles {
            for k in 0..3 {
                let [i, next] = [triangle[k], triangle[(k + 1) % 3]].map(|i| i as usize);
                let edge = out[i].p.distance(out[next].p);
                count[i] += 1.0;
                reach[i] += edge / 2.0;
                reach[next] += edge / 2.0;
            }
        }
        let to_world = self.transform.matrix3.inverse().transpose();
        for (i, v) in out.iter_mut().enumerate() {
            if let Some(n) = self.mesh.normals.get(i) {
                v.n = to_world * n.as_dvec3();
            }
            v.n = v.n.normalize_or_zero();
            v.dpdu /= f64::max(count[i], 1.0);
            v.dpdv /= f64::max(count[i], 1.0);
            // Without usable coordinates any tangents do.
            if v.dpdu.cross(v.dpdv).length_squared() == 0.0 || !(v.dpdu + v.dpdv).is_finite() {
                (v.dpdu, v.dpdv) = if v.n == DVec3::ZERO { (DVec3::X, DVec3::Y) } else { v.n.any_orthonormal_pair() };
            }
            let edge = reach[i] / f64::max(count[i], 1.0);
            v.step = [v.dpdu, v.dpdv].map(|d| if d.length() > 0.0 { edge / d.length() } else { 0.0 });
        }
        out
    }

    /// The mesh with what the shader returned: per vertex how far P moved, and N.
    fn moved(&self, vertices: &[Vertex], results: &[f64]) -> Result<Mesh, Error> {
        let to_object = self.transform.inverse();
        let mut mesh = self.mesh.clone();
        let triple = |i: usize| DVec3::new(results[i], results[i + 1], results[i + 2]);
        let mut still = true;
        for (i, v) in vertices.iter().enumerate() {
            let by = triple(6 * i);
            let to = to_object.transform_point3(v.p + by).as_vec3();
            if !to.is_finite() {
                return Err(Error::NotFinite {
                    mesh: mesh.name,
                    shader: self.artifact.name.clone(),
                    vertex: i,
                    at: v.p,
                });
            }
            if by != DVec3::ZERO {
                still = false;
                mesh.positions[i] = to;
            }
        }
        if !still {
            if !mesh.normals.is_empty() {
                mesh.normals = smooth_normals(&mesh, self.mesh);
            }
            return Ok(mesh);
        }
        let to_object = self.transform.matrix3.transpose();
        mesh.normals = (0..vertices.len())
            .map(|i| (to_object * triple(6 * i + 3)).normalize_or_zero().as_vec3())
            .map(|n| if n.is_finite() { n } else { Vec3::ZERO })
            .collect();
        Ok(mesh)
    }
}

/// Normals of a displaced mesh: sums of the triangles' area vectors over vertices that had one place and one normal before,
/// so that seams of texture coordinates stay smooth and hard edges hard.
fn smooth_normals(mesh: &Mesh, before: &Mesh) -> Vec<Vec3> {
    let key = |i: usize| {
        let (p, n) = (before.positions[i], before.normals.get(i).copied().unwrap_or_default());
        // Adding zero makes -0 and 0 the same.
        [p.x, p.y, p.z, n.x, n.y, n.z].map(|x| (x + 0.0).to_bits())
    };
    let mut sums: HashMap<[u32; 6], DVec3> = HashMap::new();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| i as usize);
        let [a, b, c] = corners.map(|i| mesh.positions[i].as_dvec3());
        for i in corners {
            *sums.entry(key(i)).or_default() += (b - a).cross(c - a);
        }
    }
    let normal = |i: usize| sums.get(&key(i)).copied().unwrap_or_default().normalize_or_zero().as_vec3();
    (0..mesh.positions.len()).map(normal).collect()
}
