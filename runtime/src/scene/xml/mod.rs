//! Scene files of the reference implementation's `testrender`: XML to [`Scene`]. docs/testrender.md is the format's manual.
//!
//! In: a path, or the XML itself. Out: a scene with all models loaded, and warnings, or the first error. It must not know the
//! compiler: shader groups stay text.

mod group;
mod node;

use super::error::{Error, Location, MeshFile};
use super::value::Text;
use super::{
    Camera, Conventions, Film, Filter, Integrator, Material, MaterialId, Mesh, Place, Scene, geometry, obj, shapes,
};
use glam::{DAffine3, DVec3};
use node::Element;
use std::collections::HashMap;
use std::path::Path;

/// A scene and what is odd about its file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// How finely its environment is to be tabulated, in columns.
    pub environment_columns: u32,
    /// Whole lines, each with its place.
    pub warnings: Vec<String>,
}

/// Most bounces of a path.
const MAX_BOUNCES: u32 = Integrator::DEEPEST - 1;
/// Columns of the environment's table unless the file says otherwise.
const BACKGROUND_COLUMNS: u32 = 1024;
/// Rows of a sphere's vertices unless the file says otherwise.
const SPHERE_ROWS: u32 = 64;

/// Loads a scene file for a picture of this size; the file's `Option`s override `integrator`.
pub fn load(path: &Path, film: Film, integrator: Integrator) -> Result<Loaded, Error> {
    let source = std::fs::read_to_string(path).map_err(|cause| Error::Unreadable {
        what: "scene",
        path: path.to_path_buf(),
        cause: cause.to_string(),
    })?;
    parse(&source, path, film, integrator)
}

/// Reads a scene's XML; files are looked for beside `path`, which need not exist.
pub fn parse(source: &str, path: &Path, film: Film, integrator: Integrator) -> Result<Loaded, Error> {
    let text = Text { path, source };
    let document = roxmltree::Document::parse(source).map_err(|error| {
        let at = error.pos();
        // The parser's own sentence ends with the place.
        let cause = error.to_string();
        let cause = cause.rsplit_once(" at ").map_or(cause.as_str(), |(cause, _)| cause).to_owned();
        let at = Location { file: path.to_path_buf(), line: at.row as usize, column: at.col as usize };
        Error::Xml { at, cause }
    })?;
    let root = Element::new(document.root_element(), text);
    if root.name() != "World" {
        let cause = format!("the outermost element must be <World>, not <{}>", root.name());
        return Err(Error::Conflict { at: root.at(), cause });
    }
    let mut builder = Builder {
        scene: Scene::new(camera(None, film)?, film),
        named: HashMap::new(),
        latest: None,
        environment_columns: BACKGROUND_COLUMNS,
        folder: path.parent().unwrap_or(Path::new("")),
        warnings: Vec::new(),
    };
    builder.scene.integrator = integrator;
    builder.scene.filter = Filter::Tent;
    builder.scene.conventions = Conventions {
        two_sided_emission: true,
        trusted_normals: true,
        shared_cubes: true,
        tabulated_environment: true,
        unknown_params_warn: true,
    };
    builder.scene.places.note(Place::Setting("conventions"), root.at());
    for element in root.children() {
        builder.element(&element)?;
    }
    builder.finish(&root)
}

/// A scene in the making.
struct Builder<'a> {
    scene: Scene,
    /// Groups with a name of their own.
    named: HashMap<String, MaterialId>,
    /// The material of the last group that made one: shapes that follow have it.
    latest: Option<MaterialId>,
    environment_columns: u32,
    folder: &'a Path,
    warnings: Vec<String>,
}

impl Builder<'_> {
    fn element(&mut self, element: &Element<'_, '_>) -> Result<(), Error> {
        const KNOWN: [&str; 7] = ["Camera", "Option", "ShaderGroup", "Sphere", "Quad", "Model", "Background"];
        match element.name() {
            "Camera" => {
                self.knows(element, &["eye", "dir", "look_at", "up", "fov"]);
                self.scene.camera = camera(Some(element), self.scene.film)?;
            }
            "Option" => self.option(element)?,
            "ShaderGroup" => self.group(element)?,
            "Sphere" => {
                self.knows(element, &["center", "radius", "resolution"]);
                let center = element.need("center")?.vector()?;
                let radius = element.need("radius")?;
                if radius.number()? <= 0.0 {
                    return Err(radius.out_of_range("greater than 0"));
                }
                let rows = element.whole("resolution", SPHERE_ROWS, 2, 4096)?;
                let sphere = shapes::rows_sphere(center.as_vec3(), radius.number()? as f32, rows);
                self.place(element, sphere)?;
            }
            "Quad" => {
                self.knows(element, &["corner", "edge_x", "edge_y", "resolution"]);
                let [corner, x, y] = ["corner", "edge_x", "edge_y"].map(|key| element.need(key)?.vector());
                let (corner, x, y) = (corner?, x?, y?);
                let cells = element.whole("resolution", 1, 1, 4096)?;
                self.place(element, shapes::parallelogram([corner, x, y].map(|v| v.as_vec3()), cells))?;
            }
            "Model" => self.model(element)?,
            "Background" => {
                self.knows(element, &["resolution"]);
                // 0: not tabulated at all.
                let resolution = element.whole("resolution", BACKGROUND_COLUMNS, 0, 8192)?;
                self.scene.conventions.tabulated_environment = resolution > 0;
                self.environment_columns = resolution.clamp(32, 8192).next_power_of_two();
                self.scene.environment = Some(self.latest(element)?);
                self.scene.places.note(Place::Environment, element.at());
            }
            name => self.warnings.push(element.unknown_element(name, &KNOWN)),
        }
        Ok(())
    }

    /// Notes the attributes of an element that mean nothing.
    fn knows(&mut self, element: &Element<'_, '_>, known: &[&str]) {
        self.warnings.extend(element.unknown_attributes(known));
    }

    fn option(&mut self, element: &Element<'_, '_>) -> Result<(), Error> {
        for value in element.attributes() {
            let most = match value.key {
                "max_bounces" => MAX_BOUNCES,
                "rr_depth" => Integrator::DEEPEST,
                "aa" => 1 << 12,
                _ => {
                    self.warnings.push(element.unknown_attribute(&value, &["max_bounces", "rr_depth", "aa"]));
                    continue;
                }
            };
            let Some(number) = value.text.trim().strip_prefix("int").and_then(|n| n.trim().parse::<i64>().ok()) else {
                return Err(value.wrong_type("a whole number with its type, such as \"int 4\""));
            };
            if number < 0 {
                return Err(value.out_of_range("at least 0"));
            }
            let number = u32::try_from(number).unwrap_or(u32::MAX).min(most);
            let integrator = &mut self.scene.integrator;
            match value.key {
                "max_bounces" => integrator.max_depth = number + 1,
                "rr_depth" => {
                    integrator.roulette_from = Some(number + 1);
                    self.scene.places.note(Place::Setting("integrator.roulette"), value.at());
                }
                _ => integrator.samples = number.max(1) * number.max(1),
            }
        }
        Ok(())
    }

    fn group(&mut self, element: &Element<'_, '_>) -> Result<(), Error> {
        self.knows(element, &["name", "type", "is_light", "commands"]);
        let name = element.get("name").map(|v| v.text);
        let (source, mut warnings) = group::text(element)?;
        self.warnings.append(&mut warnings);
        let label = match name {
            Some(name) => name.to_owned(),
            None => format!("group at line {}", element.at().line),
        };
        let path = element.at().file;
        let sampled_light = element.get("is_light").is_some_and(|v| matches!(v.text, "1" | "on" | "yes"));
        let material = Material { group: true, sampled_light, ..Material::new(&label, path, source) };
        let known = name.and_then(|name| self.named.get(name).copied());
        let kind = element.get("type").map_or("surface", |v| v.text);
        match (known, kind) {
            // The same name again: another part of the same material.
            (Some(id), "displacement") => {
                let displacement = self.scene.add_material(material);
                self.scene.places.note(Place::Displacement(id), element.at());
                self.scene.materials[id.0 as usize].displacement = Some(displacement);
            }
            (Some(id), "surface") => {
                let Material { displacement, sampled_light, .. } = self.scene.materials[id.0 as usize];
                self.scene.materials[id.0 as usize] = Material { displacement, sampled_light, ..material };
                self.scene.places.note(Place::Material(id), element.at());
            }
            (Some(_), kind) => {
                let cause = format!("a group of type \"{kind}\" cannot be added to the material `{label}`");
                return Err(Error::Conflict { at: element.at(), cause });
            }
            (None, _) => {
                let id = self.scene.add_material(material);
                self.scene.places.note(Place::Material(id), element.at());
                self.latest = Some(id);
                if let Some(name) = name {
                    self.named.insert(name.to_owned(), id);
                }
            }
        }
        Ok(())
    }

    fn latest(&self, element: &Element<'_, '_>) -> Result<MaterialId, Error> {
        self.latest.ok_or_else(|| {
            let cause = format!("<{}> stands before any <ShaderGroup>, so that it has no material", element.name());
            Error::Conflict { at: element.at(), cause }
        })
    }

    fn place(&mut self, element: &Element<'_, '_>, mesh: Mesh) -> Result<(), Error> {
        let material = self.latest(element)?;
        self.place_with(mesh, material, element)
    }

    fn place_with(&mut self, mut mesh: Mesh, material: MaterialId, element: &Element<'_, '_>) -> Result<(), Error> {
        let at = element.at();
        if mesh.name.is_empty() || element.name() != "Model" {
            mesh.name = format!("{} at line {}", element.name(), at.line);
        }
        geometry::check(&mesh, &at.file)?;
        let mesh = self.scene.add_mesh(mesh);
        self.scene.places.note(Place::Mesh(mesh), at);
        self.scene.place(mesh, DAffine3::IDENTITY, material);
        Ok(())
    }

    /// The objects of an OBJ file: materials are those of the groups that are named as the file's, or if none is, as its objects.
    fn model(&mut self, element: &Element<'_, '_>) -> Result<(), Error> {
        self.knows(element, &["filename"]);
        let path = self.folder.join(element.need("filename")?.text);
        let bytes = std::fs::read(&path).map_err(|cause| Error::UnreadablePart {
            at: element.at(),
            what: "model",
            path: path.clone(),
            cause: cause.to_string(),
        })?;
        let objects = obj::objects(&bytes, &path)?;
        if objects.is_empty() {
            return Err(Error::NoTriangles { at: MeshFile { path, line: None } });
        }
        let of = |name: &Option<String>| name.as_ref().and_then(|name| self.named.get(name)).copied();
        let by_material = objects.iter().any(|o| of(&o.material).is_some());
        let chosen: Vec<Option<MaterialId>> = objects
            .iter()
            .map(|o| if by_material { of(&o.material) } else { self.named.get(&o.mesh.name).copied() })
            .collect();
        for (object, chosen) in objects.into_iter().zip(chosen) {
            let material = match chosen {
                Some(material) => material,
                None => self.latest(element)?,
            };
            let mut mesh = object.mesh;
            geometry::tidy(&mut mesh, &path)?;
            self.place_with(mesh, material, element)?;
        }
        Ok(())
    }

    fn finish(mut self, root: &Element<'_, '_>) -> Result<Loaded, Error> {
        let needs = |what: &str| Error::Conflict { at: root.at(), cause: format!("there is no {what} in the scene") };
        if self.scene.materials.is_empty() {
            return Err(needs("<ShaderGroup>"));
        }
        if self.scene.instances.is_empty() {
            return Err(needs("<Sphere>, <Quad> or <Model>"));
        }
        self.scene.textures.push(self.folder.to_path_buf());
        Ok(Loaded { scene: self.scene, environment_columns: self.environment_columns, warnings: self.warnings })
    }
}

/// The camera of an element; without one, that which the reference's renderer begins with.
fn camera(element: Option<&Element<'_, '_>>, film: Film) -> Result<Camera, Error> {
    let value = |key: &str| element.and_then(|e| e.get(key));
    let vector = |key: &str| value(key).map(|v| v.vector()).transpose();
    let eye = vector("eye")?.unwrap_or(DVec3::ZERO);
    let dir = match (vector("dir")?, vector("look_at")?) {
        (Some(dir), _) => dir,
        (None, Some(target)) => target - eye,
        (None, None) => DVec3::NEG_Z,
    };
    let fov = match value("fov") {
        None => 90.0,
        Some(v) => {
            let fov = v.number()?;
            if !(fov > 0.0 && fov < 180.0) {
                return Err(v.out_of_range("an angle between 0 and 180 degrees"));
            }
            fov
        }
    };
    // The reference's picture is one tangent of half the angle high (not two) at distance 1.
    let up = (fov.to_radians() / 2.0).tan() / 2.0;
    let across = up * f64::from(film.width) / f64::from(film.height);
    let mut camera = Camera::look_at(eye, eye + dir.normalize_or_zero());
    camera.up = vector("up")?.unwrap_or(DVec3::Y);
    camera.hfov_degrees = 2.0 * across.atan().to_degrees();
    if let Some(element) = element {
        camera.check().map_err(|cause| Error::Camera { at: element.at(), cause })?;
    }
    Ok(camera)
}
