//! Scenes from Rust, without files: defaults, constructors, and the checks that the readers make for files.
//!
//! In: values. Out: the types of this folder. It must not know TOML.

use super::error::{Error, Location};
use super::{
    Camera, Conventions, Film, Filter, FromPackage, Instance, Integrator, Material, MaterialId, Mesh, MeshId,
    ParamValue, Scene,
};
use super::{geometry, shipped, transform};
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};
use std::path::{Path, PathBuf};

impl Scene {
    /// An empty scene in the dark.
    ///
    /// ```
    /// use oslcl_runtime::scene::{Camera, DAffine3, DVec3, Film, Material, ParamValue, Scene, shapes};
    ///
    /// let camera = Camera::look_at(DVec3::new(0.0, -4.0, 0.0), DVec3::ZERO);
    /// let mut scene = Scene::new(camera, Film { width: 320, height: 240 });
    /// let ball = scene.add_mesh(shapes::sphere(1.0, 96, 48));
    /// let red = Material::from_shipped("red", "matte")?.with("Cs", ParamValue::Floats(vec![0.8, 0.1, 0.1]));
    /// let red = scene.add_material(red);
    /// scene.place(ball, DAffine3::IDENTITY, red);
    /// let sky = scene.add_material(Material::from_shipped("sky", "flat_sky")?);
    /// scene.environment = Some(sky);
    /// scene.check()?;
    /// # Ok::<(), oslcl_runtime::scene::Error>(())
    /// ```
    pub fn new(camera: Camera, film: Film) -> Scene {
        Scene {
            camera,
            film,
            integrator: Integrator::default(),
            meshes: Vec::new(),
            instances: Vec::new(),
            materials: Vec::new(),
            environment: None,
            conventions: Conventions::default(),
            filter: Filter::Box,
            textures: Vec::new(),
            shaders: Vec::new(),
            attributes: Vec::new(),
            places: super::Places::default(),
        }
    }

    /// Adds a mesh; it is not seen before it is placed.
    pub fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.meshes.push(mesh);
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// Adds a material.
    pub fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// Places a mesh.
    pub fn place(&mut self, mesh: MeshId, transform: DAffine3, material: MaterialId) {
        self.instances.push(Instance { mesh, transform, material, attributes: Vec::new() });
    }

    /// Checks every promise of the scene's types. Scenes that [`super::load`] returns keep them already.
    pub fn check(&self) -> Result<(), Error> {
        let bad = |key: &str, expected: &str, found: String| Error::OutOfRange {
            at: Location::built(),
            key: key.to_string(),
            expected: expected.to_string(),
            found,
        };
        self.camera.check().map_err(|cause| Error::Camera { at: Location::built(), cause })?;
        let sides = 1..=Film::LARGEST;
        if !sides.contains(&self.film.width) || !sides.contains(&self.film.height) {
            let found = format!("{} x {}", self.film.width, self.film.height);
            return Err(bad("film", "1 to 65536 pixels on each side", found));
        }
        if !(1..=Integrator::MOST_SAMPLES).contains(&self.integrator.samples) {
            let found = self.integrator.samples.to_string();
            return Err(bad("integrator.samples", "an integer from 1 to 16777216", found));
        }
        if !(1..=Integrator::DEEPEST).contains(&self.integrator.max_depth) {
            let found = self.integrator.max_depth.to_string();
            return Err(bad("integrator.max_depth", "an integer from 1 to 1024", found));
        }
        for mesh in &self.meshes {
            geometry::check(mesh, Path::new(&format!("mesh {}", mesh.name)))?;
        }
        let handle = |object: &str, what, index: u32, count: usize| match (index as usize) < count {
            true => Ok(()),
            false => Err(Error::BadHandle { object: object.to_string(), what, index, count }),
        };
        for material in &self.materials {
            if let Some(id) = material.displacement {
                handle(&format!("material `{}`", material.name), "material", id.0, self.materials.len())?;
            }
        }
        for (i, instance) in self.instances.iter().enumerate() {
            let object = format!("instance {i}");
            handle(&object, "mesh", instance.mesh.0, self.meshes.len())?;
            handle(&object, "material", instance.material.0, self.materials.len())?;
            if transform::is_singular(&instance.transform) {
                return Err(Error::Singular { at: Location::built(), object });
            }
        }
        self.environment.map_or(Ok(()), |id| handle("the environment", "material", id.0, self.materials.len()))
    }
}

impl Camera {
    /// A pinhole camera with z up and a horizontal field of view of 45 degrees, in focus at the target.
    pub fn look_at(origin: DVec3, target: DVec3) -> Camera {
        Camera {
            origin,
            target,
            up: DVec3::Z,
            hfov_degrees: 45.0,
            lens_radius: 0.0,
            focus_distance: origin.distance(target),
        }
    }

    /// Camera space to world space: x to the right, y up, z along the view.
    pub fn to_world(&self) -> DAffine3 {
        let forward = (self.target - self.origin).normalize();
        let right = forward.cross(self.up).normalize();
        let axes = DMat3::from_cols(right, right.cross(forward), forward);
        DAffine3::from_mat3_translation(axes, self.origin)
    }

    /// Screen, NDC and raster space as kernels take them: of each the map to common space and the one from it, row-major for
    /// row vectors. On the screen x runs from -1 on the left to 1 on the right and y up, as far as pixels are square; NDC runs
    /// from 0 to 1 to the right and down; raster counts pixels. The depth of all is 1 - 1 / z.
    pub(crate) fn other_spaces(&self, film: Film) -> Vec<f64> {
        let [width, height] = [film.width, film.height].map(f64::from);
        let scale = 1.0 / (self.hfov_degrees.to_radians() / 2.0).tan();
        let perspective = DMat4::from_cols(
            DVec4::new(scale, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 1.0),
            DVec4::new(0.0, 0.0, -1.0, 0.0),
        );
        let screen = perspective * DMat4::from(self.to_world().inverse());
        let ndc = DMat4::from_translation(DVec3::new(0.5, 0.5, 0.0))
            * DMat4::from_scale(DVec3::new(0.5, -0.5 * width / height, 1.0))
            * screen;
        let raster = DMat4::from_scale(DVec3::new(width, height, 1.0)) * ndc;
        // Columns of maps of column vectors are rows of those of row vectors.
        [screen, ndc, raster].iter().flat_map(|m| [m.inverse(), *m]).flat_map(|m| m.to_cols_array()).collect()
    }

    pub(super) fn check(&self) -> Result<(), &'static str> {
        let view = self.target - self.origin;
        let numbers = [self.hfov_degrees, self.lens_radius, self.focus_distance];
        if !self.origin.is_finite()
            || !view.is_finite()
            || !self.up.is_finite()
            || !numbers.iter().all(|n| n.is_finite())
        {
            return Err("one of its numbers is not finite");
        }
        // Anything that the view direction's rounding would drown counts as no distance at all.
        if view.length() <= 1e-12 * self.origin.length().max(f64::MIN_POSITIVE) {
            return Err("origin and target are the same point");
        }
        if self.up == DVec3::ZERO {
            return Err("`up` has no length");
        }
        if view.normalize().cross(self.up.normalize()).length() < 1e-6 {
            return Err("`up` is parallel to the view direction");
        }
        if !(self.hfov_degrees > 0.0 && self.hfov_degrees < 180.0) {
            return Err("the field of view is not between 0 and 180 degrees");
        }
        if self.lens_radius < 0.0 || self.focus_distance <= 0.0 {
            return Err("the lens radius is negative, or the focus distance not positive");
        }
        Ok(())
    }
}

impl Film {
    /// Most pixels on a side.
    pub const LARGEST: u32 = 65536;
}

impl Default for Film {
    fn default() -> Film {
        Film { width: 512, height: 512 }
    }
}

impl Integrator {
    /// Most samples per pixel: a float counts them exactly.
    pub const MOST_SAMPLES: u32 = 1 << 24;
    /// Longest path in edges.
    pub const DEEPEST: u32 = 1024;
}

impl Default for Integrator {
    fn default() -> Integrator {
        Integrator { samples: 64, max_depth: 8, roulette_from: Some(4), seed: 0 }
    }
}

impl Material {
    /// A material of a shipped shader.
    pub fn from_shipped(name: &str, shader: &str) -> Result<Material, Error> {
        match shipped::shipped(shader) {
            Some(_) => Ok(Material::of_shipped(name, shader)),
            None => Err(Error::UnknownName {
                at: Location::built(),
                what: "shipped shader",
                name: shader.to_string(),
                help: super::error::suggest(shader, shipped::names()),
            }),
        }
    }

    /// A material of OSL source text.
    pub fn from_source(name: &str, source: &str) -> Material {
        let path = PathBuf::from(format!("{name}.osl"));
        Material::new(name, path, source.to_string())
    }

    /// A shader of a package, which a render reads; without a name the only one.
    pub fn from_package(name: &str, package: &Path, shader: Option<&str>) -> Material {
        let from = FromPackage { shader: shader.map(str::to_owned), at: Location::built(), params_at: Vec::new() };
        Material { package: Some(from), ..Material::new(name, package.to_path_buf(), String::new()) }
    }

    /// One of source text from this file, with nothing set.
    pub(super) fn new(name: &str, path: PathBuf, source: String) -> Material {
        Material {
            name: name.to_string(),
            path,
            source,
            package: None,
            params: Vec::new(),
            displacement: None,
            sampled_light: true,
            group: false,
            interactive: Vec::new(),
            attributes: Vec::new(),
        }
    }

    /// The same with a parameter set.
    pub fn with(mut self, name: &str, value: ParamValue) -> Material {
        self.params.retain(|(n, _)| n != name);
        self.params.push((name.to_string(), value));
        self
    }

    /// The same with vertices moved by another material's displacement shader.
    pub fn displaced_by(mut self, displacement: MaterialId) -> Material {
        self.displacement = Some(displacement);
        self
    }

    /// For names that are known to be shipped; others make an empty shader, which the compiler refuses.
    pub(super) fn of_shipped(name: &str, shader: &str) -> Material {
        let path = PathBuf::from(format!("shaders-osl/{shader}.osl"));
        let source = shipped::shipped(shader).unwrap_or_default().to_string();
        Material::new(name, path, source)
    }
}
