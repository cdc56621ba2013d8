//! Shoots rays at geometry on the device, without materials or film: kernels/geometry.h and kernels/surface.h alone.
//!
//! In: a mesh and where it is placed. Out: counts of leaks and of surfaces that meet their own rays.

use super::Run;
use glam::{DAffine3, DVec3};
use oslcl_runtime::accel::{self, Emission, MaterialUse};
use oslcl_runtime::assemble::assemble_with;
use oslcl_runtime::device::{Arg, Buffer, Error, Program};
use oslcl_runtime::plan::Constant;
use oslcl_runtime::render;
use oslcl_runtime::scene::{Mesh, Scene};

/// Work-items of a group.
const GROUP: usize = 64;
/// Rays that one work-item shoots.
const TURNS: usize = 16;

/// A mesh on the device.
pub struct Target<'a> {
    run: &'a Run<'a>,
    program: Program,
    buffers: Vec<Buffer>,
    triangles: usize,
    instance: u32,
    middle: DVec3,
}

/// What rays from within a closed mesh did.
#[derive(Clone, Copy, Debug)]
pub struct Shots {
    /// Rays that met nothing.
    pub leaks: u32,
    /// All rays.
    pub rays: u32,
}

/// What rays from a convex mesh's surface did.
#[derive(Clone, Copy, Debug)]
pub struct Leaves {
    /// Rays that left and met the mesh again.
    pub self_hits: u32,
    /// Rays that went in and met nothing.
    pub leaks: u32,
    /// Pairs of rays.
    pub pairs: u32,
    /// Points with a shading state that is not finite, or without a unit normal.
    pub broken: u32,
}

impl<'a> Target<'a> {
    /// Places a closed mesh around the origin by `place` in front of a camera at `camera`; `instanced`: as one of two copies that share
    /// their triangles, the other far away.
    pub fn new(
        run: &'a Run<'a>,
        mesh: &Mesh,
        place: DAffine3,
        camera: DVec3,
        instanced: bool,
    ) -> Result<Target<'a>, Box<dyn std::error::Error>> {
        let mut scene = crate::scenes::empty();
        scene.camera.origin = camera;
        scene.camera.target = camera + DVec3::Y * place.matrix3.y_axis.length().max(1e-9 * camera.length());
        let material = crate::scenes::material(&mut scene, "surface d() { Ci = diffuse(N); }", &[]);
        let id = crate::scenes::mesh(&mut scene, mesh.clone());
        crate::scenes::place(&mut scene, id, material, place);
        if instanced {
            let mut far = place;
            far.translation += DVec3::X * 1e3 * place.matrix3.x_axis.length();
            crate::scenes::place(&mut scene, id, material, far);
        }
        Target::of_scene(run, &scene, place.translation - camera, instanced)
    }

    fn of_scene(
        run: &'a Run<'a>,
        scene: &Scene,
        middle: DVec3,
        instanced: bool,
    ) -> Result<Target<'a>, Box<dyn std::error::Error>> {
        let (plan, _) = render::plan(scene, &run.choices())?;
        let uses = vec![MaterialUse { emission: Emission::None, queue: 0 }; scene.materials.len()];
        let g = accel::build(scene, &uses, &run.choices())?;
        let mut text = "#define HAS_SURFACES\n#define HAS_TANGENTS\n".to_owned();
        run.choices().macros().iter().for_each(|name| text.push_str(&format!("#define {name}\n")));
        if instanced {
            text.push_str("#define HAS_INSTANCES\n");
        }
        text.push_str(include_str!("rays.cl"));
        let text = assemble_with("rays.cl", &text, &[("layout.h", &plan.layout.header())])?;
        let program = Program::build(run.device, "rays.cl", &text, run.precision.build_options())?;
        let device = run.device;
        let mut buffers = vec![
            device.upload("nodes", &g.nodes)?,
            run.upload("triangles", &g.triangles)?,
            device.upload("triangle_ids", &g.triangle_ids)?,
            device.upload("corners", &g.corners)?,
            device.upload("shapes", &g.shapes)?,
            run.upload("constants", &vec![0.0; Constant::total()])?,
        ];
        if instanced {
            buffers.push(run.upload("instances", &g.instances)?);
            buffers.push(device.upload("instance_roots", &g.instance_roots)?);
        }
        Ok(Target { run, program, buffers, triangles: g.triangle_ids.len(), instance: u32::from(instanced), middle })
    }

    fn launch(&self, kernel: &str, more: &[Arg<'_>], items: usize, words: usize) -> Result<Vec<u32>, Error> {
        let device = self.run.device;
        let out = device.upload("counts", &vec![0u32; words])?;
        let mut args: Vec<Arg<'_>> = self.buffers.iter().map(Arg::Buffer).collect();
        args.extend([Arg::U32(self.triangles as u32), Arg::U32(self.instance)]);
        args.extend_from_slice(more);
        args.push(Arg::Buffer(&out));
        self.program.kernel(device, kernel)?.launch(device, &args, items.next_multiple_of(GROUP), GROUP)?;
        device.read(&out, words)
    }

    fn middle(&self) -> [Arg<'static>; 3] {
        self.middle.to_array().map(|v| self.run.real(v))
    }

    /// Shoots about `rays` rays from within: at edges, middles of edges, corners and insides of the triangles. They start
    /// between the middle and the part `reach` of the way to the surface. `axial`: along the axes instead.
    pub fn shoot(&self, rays: usize, reach: f64, axial: bool, seed: u32) -> Result<Shots, Error> {
        let ([x, y, z], reach) = (self.middle(), self.run.real(reach));
        let rest = [Arg::U32(u32::from(axial)), Arg::U32(TURNS as u32), Arg::U32(seed)];
        let args = [&[x, y, z, reach][..], &rest].concat();
        let words = self.launch("shoot", &args, rays.div_ceil(TURNS), 2)?;
        Ok(Shots { leaks: words[0], rays: words[1] })
    }

    /// Sends pairs of rays off a convex mesh's surface, one on each side; cosines down to `grazing`.
    pub fn leave(&self, pairs: usize, grazing: f64, seed: u32) -> Result<Leaves, Error> {
        let [x, y, z] = self.middle();
        let words = self.launch("leave", &[x, y, z, self.run.real(grazing), Arg::U32(seed)], pairs, 4)?;
        Ok(Leaves { self_hits: words[0], leaks: words[1], pairs: words[2], broken: words[3] })
    }
}

impl Run<'_> {
    /// A kernel's argument of type `real`.
    pub fn real(&self, x: f64) -> Arg<'static> {
        if self.precision.is_double() { Arg::F64(x) } else { Arg::F32(x as f32) }
    }

    /// A buffer of reals.
    pub fn upload(&self, label: &str, data: &[f64]) -> Result<Buffer, Error> {
        if self.precision.is_double() {
            return self.device.upload(label, data);
        }
        let data: Vec<f32> = data.iter().map(|v| *v as f32).collect();
        self.device.upload(label, &data)
    }

    /// The reals of a buffer.
    pub fn read(&self, buffer: &Buffer, count: usize) -> Result<Vec<f64>, Error> {
        if self.precision.is_double() {
            return self.device.read(buffer, count);
        }
        Ok(self.device.read::<f32>(buffer, count)?.into_iter().map(f64::from).collect())
    }
}
