//! Small scenes made in Rust, and rendering them.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use oslcl_runtime::device::Device;
use oslcl_runtime::film::Picture;
use oslcl_runtime::precision::Precision;
use oslcl_runtime::render::{self, Options, Summary};
use oslcl_runtime::scene::{
    Camera, Conventions, Film, Filter, Instance, Integrator, Material, MaterialId, Mesh, MeshId, ParamValue, Places,
    Scene,
};

/// A scene without anything but a camera at (0, -5, 0) that looks along y, and 16 x 16 pixels.
pub fn empty() -> Scene {
    Scene {
        camera: Camera {
            origin: DVec3::new(0.0, -5.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Z,
            hfov_degrees: 20.0,
            lens_radius: 0.0,
            focus_distance: 5.0,
        },
        film: Film { width: 16, height: 16 },
        integrator: Integrator { samples: 64, max_depth: 8, roulette_from: None, seed: 1 },
        meshes: Vec::new(),
        instances: Vec::new(),
        materials: Vec::new(),
        environment: None,
        conventions: Conventions::default(),
        filter: Filter::Box,
        textures: Vec::new(),
        shaders: Vec::new(),
        attributes: Vec::new(),
        places: Places::default(),
    }
}

/// Adds a material of this source.
pub fn material(scene: &mut Scene, source: &str, params: &[(&str, ParamValue)]) -> MaterialId {
    let id = MaterialId(scene.materials.len() as u32);
    let mut material = Material::from_source(&format!("m{}", id.0), source);
    material.params = params.iter().map(|(n, v)| ((*n).to_owned(), v.clone())).collect();
    scene.materials.push(material);
    id
}

/// Adds a mesh.
pub fn mesh(scene: &mut Scene, mesh: Mesh) -> MeshId {
    scene.meshes.push(mesh);
    MeshId(scene.meshes.len() as u32 - 1)
}

/// Places a mesh.
pub fn place(scene: &mut Scene, mesh: MeshId, material: MaterialId, transform: DAffine3) {
    scene.instances.push(Instance { mesh, transform, material, attributes: Vec::new() });
}

/// The square from -1 to 1 in x and z at y = 0, its front towards -y, with texture coordinates.
pub fn wall() -> Mesh {
    Mesh {
        name: "wall".into(),
        positions: [[-1., 0., -1.], [1., 0., -1.], [1., 0., 1.], [-1., 0., 1.]].map(Vec3::from).to_vec(),
        normals: Vec::new(),
        uvs: [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(Vec2::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A sphere of radius 1 with smooth normals.
pub fn sphere() -> Mesh {
    let (across, down) = (48u32, 24u32);
    let mut positions = Vec::new();
    for j in 0..=down {
        for i in 0..across {
            let (theta, phi) =
                (std::f32::consts::PI * j as f32 / down as f32, 2.0 * std::f32::consts::PI * i as f32 / across as f32);
            positions.push(Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..down {
        for i in 0..across {
            let at = |j: u32, i: u32| j * across + i % across;
            triangles.push([at(j, i), at(j + 1, i), at(j + 1, i + 1)]);
            triangles.push([at(j, i), at(j + 1, i + 1), at(j, i + 1)]);
        }
    }
    Mesh { name: "sphere".into(), normals: positions.clone(), positions, triangles, ..Mesh::default() }
}

/// Renders a scene on the first device.
pub fn render(scene: &Scene, precision: Precision) -> (Picture, Summary) {
    let device = Device::open(None).expect("an OpenCL device");
    let options = Options { choices: precision.into(), ..Options::default() };
    render::render(scene, &device, &options, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}
