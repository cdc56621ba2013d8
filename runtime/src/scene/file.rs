//! Scene files: TOML to [`Scene`]. docs/scene.md is the format's manual.
//!
//! In: a path. Out: a scene with all meshes and shaders loaded, or the first error. It must not know the compiler.

use super::error::{Error, Location, MeshFile, suggest};
use super::value::{Table, Text, Value};
use super::{Attributes, Camera, Film, Instance, Integrator, Material, MaterialId, Mesh, MeshId, Place, Scene};
use super::{geometry, material, obj, ply, shapes, transform};
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::DeTable;

/// Loads a scene file and all that it names.
pub fn load(path: &Path) -> Result<Scene, Error> {
    let source = std::fs::read_to_string(path).map_err(|cause| Error::Unreadable {
        what: "scene",
        path: path.to_path_buf(),
        cause: cause.to_string(),
    })?;
    parse(&source, path)
}

/// Reads a scene's text; files are looked for beside `path`, which need not exist.
pub fn parse(source: &str, path: &Path) -> Result<Scene, Error> {
    let text = Text { path, source };
    let document = DeTable::parse(source).map_err(|error| Error::Syntax {
        at: text.at(error.span().map_or(0, |span| span.start)),
        cause: error.message().to_string(),
    })?;
    let root = Table::root(text, &document);
    root.only(&[
        "camera",
        "film",
        "integrator",
        "materials",
        "meshes",
        "instances",
        "environment",
        "textures",
        "attributes",
    ])?;
    let mut builder = Builder {
        scene: Scene::new(camera(&root.need("camera")?.table()?)?, Film::default()),
        materials: BTreeMap::new(),
        meshes: BTreeMap::new(),
    };
    builder.scene.attributes = material::attributes(&root)?;
    for (table, key, place) in
        [("camera", "lens_radius", "camera.lens_radius"), ("integrator", "roulette", "integrator.roulette")]
    {
        if let Some(value) = root.get(table).map(|t| t.table()).transpose()?.and_then(|t| t.get(key)) {
            builder.scene.places.note(Place::Setting(place), value.at());
        }
    }
    if let Some(film) = root.get("film") {
        builder.scene.film = self::film(&film.table()?)?;
    }
    if let Some(integrator) = root.get("integrator") {
        builder.scene.integrator = self::integrator(&integrator.table()?)?;
    }
    if let Some(materials) = root.get("materials") {
        for (name, value) in materials.table()?.entries() {
            let id = builder.read_material(&value.table()?, name)?;
            builder.materials.insert(name.to_string(), id);
        }
        for (name, value) in materials.table()?.entries() {
            if let Some(displacement) = value.table()?.get("displacement") {
                let id = builder.materials[name];
                builder.scene.places.note(Place::Displacement(id), displacement.at());
                builder.scene.materials[id.0 as usize].displacement = Some(builder.material(&displacement)?);
            }
        }
    }
    for table in root.get("meshes").map_or(Ok(Vec::new()), |meshes| meshes.tables())? {
        builder.mesh(&table)?;
    }
    for table in root.get("instances").map_or(Ok(Vec::new()), |instances| instances.tables())? {
        builder.instance(&table)?;
    }
    let here = path.parent().unwrap_or(Path::new(""));
    builder.scene.textures.push(here.to_path_buf());
    if let Some(folders) = root.get("textures") {
        for folder in folders.items().ok_or_else(|| folders.wrong_type("a list of folders"))? {
            builder.scene.textures.push(here.join(folder.string()?));
        }
    }
    if let Some(environment) = root.get("environment") {
        builder.scene.places.note(Place::Environment, environment.at());
        builder.scene.environment = Some(match environment.raw().as_str() {
            Some(_) => builder.material(&environment)?,
            None => {
                let table =
                    environment.table().map_err(|_| environment.wrong_type("the name of a material or a table"))?;
                builder.read_material(&table, "environment")?
            }
        });
    }
    Ok(builder.scene)
}

fn camera(table: &Table<'_>) -> Result<Camera, Error> {
    table.only(&["origin", "target", "up", "hfov", "lens_radius", "focus_distance"])?;
    let mut camera = Camera::look_at(table.need("origin")?.vector()?, table.need("target")?.vector()?);
    if let Some(up) = table.get("up") {
        camera.up = up.vector()?;
    }
    if let Some(value) = table.get("hfov") {
        camera.hfov_degrees = value.number()?;
        if !(camera.hfov_degrees > 0.0 && camera.hfov_degrees < 180.0) {
            return Err(value.out_of_range("an angle between 0 and 180 degrees"));
        }
    }
    if let Some(value) = table.get("lens_radius") {
        camera.lens_radius = value.number()?;
        if camera.lens_radius < 0.0 {
            return Err(value.out_of_range("at least 0"));
        }
    }
    if let Some(value) = table.get("focus_distance") {
        camera.focus_distance = value.number()?;
        if camera.focus_distance <= 0.0 {
            return Err(value.out_of_range("greater than 0"));
        }
    }
    camera.check().map_err(|cause| Error::Camera { at: table.at(), cause })?;
    Ok(camera)
}

fn film(table: &Table<'_>) -> Result<Film, Error> {
    table.only(&["width", "height"])?;
    let side = |key: &str| table.need(key)?.whole(1, u64::from(Film::LARGEST)).map(|n| n as u32);
    Ok(Film { width: side("width")?, height: side("height")? })
}

fn integrator(table: &Table<'_>) -> Result<Integrator, Error> {
    table.only(&["samples", "max_depth", "roulette", "seed"])?;
    let mut integrator = Integrator::default();
    if let Some(value) = table.get("samples") {
        integrator.samples = value.whole(1, u64::from(Integrator::MOST_SAMPLES))? as u32;
    }
    if let Some(value) = table.get("max_depth") {
        integrator.max_depth = value.whole(1, u64::from(Integrator::DEEPEST))? as u32;
    }
    if let Some(value) = table.get("roulette") {
        integrator.roulette_from = match value.raw().as_bool() {
            Some(false) => None,
            Some(true) => return Err(value.out_of_range("a bounce or false")),
            None => Some(value.whole(1, u64::from(Integrator::DEEPEST))? as u32),
        };
    }
    if let Some(value) = table.get("seed") {
        integrator.seed = value.whole(0, u64::MAX)?;
    }
    Ok(integrator)
}

/// A scene in the making, with its names. A mesh's name stands for one or several meshes: an OBJ has one per material.
struct Builder {
    scene: Scene,
    materials: BTreeMap<String, MaterialId>,
    meshes: BTreeMap<String, Vec<(MeshId, Option<MaterialId>)>>,
}

impl Builder {
    /// Adds the material of a table.
    fn read_material(&mut self, table: &Table<'_>, name: &str) -> Result<MaterialId, Error> {
        let id = self.scene.add_material(material::read(table, name)?);
        self.scene.places.note(Place::Material(id), table.at());
        if let Some(params) = table.get("params") {
            for (name, value) in params.table()?.entries() {
                self.scene.places.note(Place::Param(id, name.to_string()), value.at());
            }
        }
        if let Some(names) = table.get("interactive") {
            self.scene.places.note(Place::Interactive(id), names.at());
        }
        Ok(id)
    }

    fn material(&self, value: &Value<'_>) -> Result<MaterialId, Error> {
        let name = value.string()?;
        self.materials.get(name).copied().ok_or_else(|| Error::UnknownName {
            at: value.at(),
            what: "material",
            name: name.to_string(),
            help: suggest(name, self.materials.keys().map(String::as_str)),
        })
    }

    fn mesh(&mut self, table: &Table<'_>) -> Result<(), Error> {
        table.only(&["name", "file", "shape", "size", "segments", "material", "transform", "place", "attributes"])?;
        let name = table.need("name")?;
        if self.meshes.contains_key(name.string()?) {
            return Err(Error::Duplicate { at: name.at(), what: "meshes", name: name.string()?.to_string() });
        }
        let material = table.get("material").map(|value| self.material(&value)).transpose()?;
        let (mut parts, path) = match (table.get("file"), table.get("shape")) {
            (Some(file), None) => {
                for key in ["size", "segments"] {
                    if let Some(value) = table.get(key) {
                        let cause = format!("`{}` has a file, so that `{key}` means nothing", table.name);
                        return Err(Error::Conflict { at: value.at(), cause });
                    }
                }
                self.file(&file, name.string()?, material)?
            }
            (None, Some(shape)) => {
                (vec![(generate(table, &shape)?, material)], PathBuf::from(format!("mesh {}", name.string()?)))
            }
            (None, None) => {
                let cause = format!("`{}` needs a `file` or a `shape`", table.name);
                return Err(Error::Conflict { at: table.at(), cause });
            }
            (Some(_), Some(shape)) => {
                let cause = format!("`{}` has both `file` and `shape`", table.name);
                return Err(Error::Conflict { at: shape.at(), cause });
            }
        };
        let mut placed = Vec::new();
        for (mesh, material) in &mut parts {
            geometry::tidy(mesh, &path)?;
            mesh.name = name.string()?.to_string();
            mesh.attributes = material::attributes(table)?;
            let id = self.scene.add_mesh(std::mem::take(mesh));
            self.scene.places.note(Place::Mesh(id), table.at());
            // Materials of a mesh's own file stand where the mesh does.
            if let Some(material) = material
                && self.scene.places.get(&Place::Material(*material)).is_none()
            {
                self.scene.places.note(Place::Material(*material), table.at());
            }
            placed.push((id, *material));
        }
        let map = transform::read(table)?;
        if table.get("place").map_or(Ok(true), |value| value.boolean())? {
            self.place(&placed, map, None, &Attributes::new(), table.at(), name.string()?)?;
        } else if let Some(value) = table.get("transform") {
            let cause = format!("`{}` is not placed, so that its transform means nothing", table.name);
            return Err(Error::Conflict { at: value.at(), cause });
        }
        self.meshes.insert(name.string()?.to_string(), placed);
        Ok(())
    }

    /// The meshes of a file, each with its material.
    #[allow(clippy::type_complexity)]
    fn file(
        &mut self,
        file: &Value<'_>,
        name: &str,
        material: Option<MaterialId>,
    ) -> Result<(Vec<(Mesh, Option<MaterialId>)>, PathBuf), Error> {
        let path = file.text.path.parent().unwrap_or(Path::new("")).join(file.string()?);
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        if extension != "ply" && extension != "obj" {
            return Err(Error::UnknownFormat { at: file.at(), path });
        }
        let bytes = std::fs::read(&path).map_err(|cause| Error::UnreadablePart {
            at: file.at(),
            what: "mesh",
            path: path.clone(),
            cause: cause.to_string(),
        })?;
        if extension == "ply" {
            return Ok((vec![(ply::parse(&bytes, &path)?, material)], path));
        }
        let obj = obj::parse(&bytes, &path)?;
        if obj.parts.is_empty() {
            return Err(Error::NoTriangles { at: MeshFile { path, line: None } });
        }
        if material.is_some() {
            return Ok((vec![(obj::merge(obj.parts), material)], path));
        }
        if let Some(error) = obj.library_error {
            return Err(error);
        }
        let mut ids = BTreeMap::new();
        let mut parts = Vec::new();
        for (mesh, index) in obj.parts {
            let id = index.and_then(|index| obj.materials.get(index).map(|m| (index, m))).map(|(index, found)| {
                *ids.entry(index).or_insert_with(|| {
                    let name = format!("{name}:{}", found.name);
                    self.scene.add_material(Material { name, ..found.clone() })
                })
            });
            parts.push((mesh, id));
        }
        Ok((parts, path))
    }

    fn instance(&mut self, table: &Table<'_>) -> Result<(), Error> {
        table.only(&["mesh", "transform", "material", "attributes"])?;
        let value = table.need("mesh")?;
        let name = value.string()?;
        let Some(parts) = self.meshes.get(name).cloned() else {
            let help = suggest(name, self.meshes.keys().map(String::as_str));
            return Err(Error::UnknownName { at: value.at(), what: "mesh", name: name.to_string(), help });
        };
        let material = table.get("material").map(|value| self.material(&value)).transpose()?;
        let attributes = material::attributes(table)?;
        self.place(&parts, transform::read(table)?, material, &attributes, table.at(), name)
    }

    fn place(
        &mut self,
        parts: &[(MeshId, Option<MaterialId>)],
        transform: glam::DAffine3,
        material: Option<MaterialId>,
        attributes: &Attributes,
        at: Location,
        name: &str,
    ) -> Result<(), Error> {
        for (mesh, own) in parts {
            let Some(material) = material.or(*own) else {
                return Err(Error::NoMaterial { at, mesh: name.to_string() });
            };
            let attributes = attributes.clone();
            self.scene.instances.push(Instance { mesh: *mesh, transform, material, attributes });
        }
        Ok(())
    }
}

/// The mesh of `shape = ...`.
fn generate(table: &Table<'_>, shape: &Value<'_>) -> Result<Mesh, Error> {
    let (axes, segments): (usize, &[u64]) = match shape.string()? {
        "quad" => (2, &[]),
        "cube" => (3, &[]),
        "disk" => (1, &[64]),
        "sphere" => (1, &[96, 48]),
        other => {
            let help = suggest(other, ["quad", "cube", "disk", "sphere"]);
            return Err(Error::UnknownName { at: shape.at(), what: "shape", name: other.to_string(), help });
        }
    };
    let size = size(table, axes)?;
    let segments = self::segments(table, segments)?;
    Ok(match shape.string()? {
        "quad" => shapes::quad(Vec2::new(size.x as f32, size.y as f32)),
        "cube" => shapes::cube(Vec3::new(size.x as f32, size.y as f32, size.z as f32)),
        "disk" => shapes::disk(size.x as f32, segments[0]),
        _ => shapes::sphere(size.x as f32, segments[0], segments[1]),
    })
}

/// One number for all axes, or one for each.
fn size(table: &Table<'_>, axes: usize) -> Result<DVec3, Error> {
    let Some(value) = table.get("size") else { return Ok(DVec3::ONE) };
    let size = match (value.items(), axes) {
        (Some(_), 2) => value.numbers::<2>().map(|[x, y]| DVec3::new(x, y, 1.0))?,
        (Some(_), 3) => value.vector()?,
        (Some(_), _) => return Err(value.wrong_type("a number")),
        (None, _) => DVec3::splat(value.number()?),
    };
    if size.min_element() <= 0.0 {
        return Err(value.out_of_range("greater than 0"));
    }
    Ok(size)
}

fn segments(table: &Table<'_>, default: &[u64]) -> Result<Vec<u32>, Error> {
    let mut segments: Vec<u32> = default.iter().map(|n| *n as u32).collect();
    let Some(value) = table.get("segments") else { return Ok(segments) };
    let items = match default.len() {
        0 => {
            let cause = format!("`{}` has no segments", table.name);
            return Err(Error::Conflict { at: value.at(), cause });
        }
        1 => vec![value.clone()],
        n => value
            .items()
            .filter(|items| items.len() == n)
            .ok_or_else(|| value.wrong_type(format!("a list of {n} integers: around and up")))?,
    };
    for (i, (segment, item)) in segments.iter_mut().zip(items).enumerate() {
        *segment = item.whole(if i == 0 { 3 } else { 2 }, 4096)? as u32;
    }
    Ok(segments)
}
