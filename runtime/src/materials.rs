//! A scene's materials, compiled, or taken from packages of compiled shaders.
//!
//! In: a scene. Out: an artifact per material that is used. Of the compiler it sees the facade only.

use crate::package::{self, Package, take};
use crate::roads::Road;
use crate::scene::{FromPackage, Location, Material, ParamValue, Scene};
use crate::supplies::Supplies;
use crate::textures::{self, Library};
use crate::{attributes, displace, shader_group, vertex_data};
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::{Artifact, Binding, Entry, Failure, Group, Includes, Options, compile};
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A material that can't be had.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// It does not compile.
    #[error("material `{material}`:\n{failure}")]
    Compile {
        /// Its name in the scene.
        material: String,
        /// What the compiler says.
        failure: Box<Failure>,
    },
    /// Its package can't be had, or does not fit the scene.
    #[error("{at}: material `{material}`: {cause}")]
    Package {
        /// Where the scene says so.
        at: Location,
        /// Its name in the scene.
        material: String,
        /// What is wrong.
        cause: Box<package::Error>,
    },
    /// Its shader is for something else.
    #[error("material `{material}`: `{shader}` is a {kind} shader, but {role}")]
    Kind {
        /// Its name in the scene.
        material: String,
        /// Its shader's name.
        shader: String,
        /// `surface`, `displacement` or `volume`.
        kind: String,
        /// What is wanted instead.
        role: &'static str,
    },
}

/// The compiled materials of a scene.
#[derive(Debug)]
pub struct Compiled {
    /// One per material; `None` where neither a surface nor the environment has it.
    pub artifacts: Vec<Option<Artifact>>,
    /// One per material: what moves the vertices of surfaces that have it, [`displace::OUTPUTS`] of its displacement shader.
    pub displacements: Vec<Option<Artifact>>,
    /// By material: values of interactive parameters that the scene gives. Only code from packages reads such values in every
    /// render.
    pub values: Vec<Supplies>,
    /// As `values`, of `displacements`.
    pub displacement_values: Vec<Supplies>,
    /// Shaders that were compiled.
    pub compiled: u32,
    /// Shaders that came compiled, in packages.
    pub from_packages: u32,
    /// The texture files.
    pub textures: Arc<Library>,
    /// Warnings, each with the text of its finding.
    pub warnings: Vec<String>,
}

impl Compiled {
    /// The point clouds that materials on surfaces and around them look into.
    pub fn cloud_names(&self) -> BTreeSet<&str> {
        self.artifacts.iter().flatten().flat_map(|a| a.point_clouds.iter().map(String::as_str)).collect()
    }

    /// The texture files that can be looked up, each once, with the materials' artifacts that do.
    pub fn texture_files(&self) -> BTreeSet<&str> {
        let artifacts = self.artifacts.iter().chain(&self.displacements).flatten();
        artifacts.flat_map(|a| a.textures.iter().map(|t| t.file.as_str())).collect()
    }
}

/// What a material's shader is run for.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    /// Surfaces and the environment.
    Light,
    /// The vertices of surfaces that have another material, whose index this is.
    Displacement(usize),
}

impl Role {
    /// What is wrong with a shader of this kind.
    fn refuses(self, kind: &str) -> Option<&'static str> {
        match (self, kind) {
            (Role::Light, "displacement" | "volume") => Some("surfaces and the environment take surface shaders"),
            (Role::Displacement(_), "surface" | "volume") => Some("vertices are moved by displacement shaders"),
            _ => None,
        }
    }
}

/// What is compiled: which material, and for what. Each once, in the scene's order.
fn jobs(scene: &Scene) -> Vec<(usize, Role)> {
    let mut placed = vec![false; scene.materials.len()];
    for instance in &scene.instances {
        placed[instance.material.0 as usize] = true;
    }
    let mut jobs = Vec::new();
    for (index, material) in scene.materials.iter().enumerate() {
        if placed[index] || scene.environment.is_some_and(|id| id.0 as usize == index) {
            jobs.push((index, Role::Light));
        }
        if let Some(displacement) = material.displacement.filter(|_| placed[index]) {
            jobs.push((displacement.0 as usize, Role::Displacement(index)));
        }
    }
    jobs
}

/// Compiles every material that is used, in parallel. The first error in the scene's order is reported.
pub fn compile_all(scene: &Scene) -> Result<Compiled, Error> {
    compile_for(scene, false, Road::default(), false)
}

/// As [`compile_all`]; `interactive`: values of interactive parameters of materials on surfaces and around them are read at
/// run time; `explain`: artifacts say which parameters decide about what they use.
pub(crate) fn compile_for(scene: &Scene, interactive: bool, road: Road, explain: bool) -> Result<Compiled, Error> {
    let _span = tracing::info_span!("materials").entered();
    let jobs = jobs(scene);
    let settings = textures::Settings { search: scene.textures.clone(), ..textures::Settings::default() };
    let library = Arc::new(Library::new(settings));
    let packages = packages(scene, &jobs)?;
    let settings = Settings { scene, library: &library, packages: &packages, interactive, road, explain };
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<_, Error>>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let (Some(slot), Some((material, role))) = (results.get(index), jobs.get(index)) else { break };
            let output = settings.one(*material, *role);
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(output);
        }
    };
    // A scene may have thousands of materials: a thread each would be too many.
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(results.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    let none = vec![None; scene.materials.len()];
    let values = vec![Supplies::default(); scene.materials.len()];
    let mut compiled = Compiled {
        artifacts: none.clone(),
        displacements: none,
        values: values.clone(),
        displacement_values: values,
        compiled: 0,
        from_packages: 0,
        textures: library.clone(),
        warnings: Vec::new(),
    };
    for (result, (index, role)) in results.into_iter().zip(jobs) {
        let material = scene.materials[index].name.clone();
        match result.into_inner().unwrap_or_else(PoisonError::into_inner) {
            // A thread that panicked took the whole scope with it.
            None => {}
            Some(Ok(Made { output, left_out, supplies })) => {
                match supplies {
                    Some(_) => compiled.from_packages += 1,
                    None => compiled.compiled += 1,
                }
                let supplies = supplies.unwrap_or_default();
                if let Some(role) = role.refuses(&output.artifact.kind) {
                    let Artifact { name, kind, .. } = output.artifact;
                    return Err(Error::Kind { material, shader: name, kind, role });
                }
                let plain =
                    |d: &Diagnostic| oslcl_compiler::diag::render_plain(&output.sources, std::slice::from_ref(d));
                compiled.warnings.extend(left_out.iter().map(|m| format!("warning: material `{material}`: {m}\n")));
                compiled.warnings.extend(output.warnings.iter().map(plain));
                let missing = missing(&library, &output.artifact);
                compiled.warnings.extend(missing.map(|m| format!("warning: material `{material}`: {m}\n")));
                if !output.artifact.volumes.is_empty() {
                    let volumes = output.artifact.volumes.join(", ");
                    compiled.warnings.push(format!(
                        "warning: material `{material}`: media are not simulated yet, light passes as through a vacuum ({volumes})\n"
                    ));
                }
                match role {
                    Role::Light => {
                        compiled.artifacts[index] = Some(output.artifact);
                        compiled.values[index] = supplies;
                    }
                    Role::Displacement(of) => {
                        compiled.displacements[of] = Some(output.artifact);
                        compiled.displacement_values[of] = supplies;
                    }
                }
            }
            Some(Err(error)) => return Err(error),
        }
    }
    Ok(compiled)
}

/// What is wrong with texture files and point clouds that a shader needs: the file, the shader, the cause.
pub(crate) fn missing<'a>(library: &'a Library, artifact: &'a Artifact) -> impl Iterator<Item = String> + 'a {
    let needed = artifact.textures.iter().filter(|t| t.must_exist);
    let textures = needed.filter_map(|t| {
        let cause = library.complaint(&t.file)?;
        Some(format!("texture `{}` of shader `{}` counts as black: {cause}", t.file, artifact.name))
    });
    textures.chain(library.points().complaints(&artifact.point_clouds, &artifact.name))
}

/// The packages of the materials that are used, each read once.
fn packages(scene: &Scene, jobs: &[(usize, Role)]) -> Result<HashMap<PathBuf, Package>, Error> {
    let mut packages: HashMap<PathBuf, Package> = HashMap::new();
    for (index, _) in jobs {
        let material = &scene.materials[*index];
        let Some(from) = &material.package else { continue };
        if !packages.contains_key(&material.path) {
            let package = Package::read(&material.path).map_err(|e| unfit(material, &from.at, e))?;
            packages.insert(material.path.clone(), package);
        }
    }
    Ok(packages)
}

fn unfit(material: &Material, at: &Location, cause: package::Error) -> Error {
    Error::Package { at: at.clone(), material: material.name.clone(), cause: Box::new(cause) }
}

/// A material's shader, ready for the renderer.
struct Made {
    output: oslcl_compiler::Output,
    /// What was left out on the way there.
    left_out: Vec<String>,
    /// Values of a shader from a package; `None` of one that was compiled.
    supplies: Option<Supplies>,
}

/// What decides all of a scene's artifacts.
struct Settings<'a> {
    scene: &'a Scene,
    library: &'a Arc<Library>,
    packages: &'a HashMap<PathBuf, Package>,
    interactive: bool,
    road: Road,
    explain: bool,
}

impl Settings<'_> {
    fn one(&self, index: usize, role: Role) -> Result<Made, Error> {
        let material = &self.scene.materials[index];
        match &material.package {
            Some(from) => self.taken(index, role, from),
            None => compile_one(self, index, role)
                .map_err(|failure| Error::Compile { material: material.name.clone(), failure: Box::new(failure) }),
        }
    }

    /// The artifact of a shader that is in a package.
    fn taken(&self, index: usize, role: Role, from: &FromPackage) -> Result<Made, Error> {
        let material = &self.scene.materials[index];
        let told = |(at, cause): take::Misfit| unfit(material, &at, cause);
        let of = match role {
            Role::Light => index,
            Role::Displacement(of) => of,
        };
        let wanted = take::Wanted {
            scene: self.scene,
            material: index,
            of,
            moves: role != Role::Light,
            road: self.road,
            library: self.library,
            changes: self.interactive,
        };
        // All that are used were read.
        let package = &self.packages[&material.path];
        let shader = package.shader(from.shader.as_deref()).map_err(|e| told((from.at.clone(), e)))?;
        let (artifact, supplies) = take::take(&shader, from, &wanted).map_err(told)?;
        let output = oslcl_compiler::Output { artifact, warnings: Vec::new(), sources: Arc::default() };
        Ok(Made { output, left_out: Vec::new(), supplies: Some(supplies) })
    }
}

fn compile_one(settings: &Settings<'_>, index: usize, role: Role) -> Result<Made, Failure> {
    let Settings { scene, library, .. } = *settings;
    let material = &scene.materials[index];
    let (interactive, of) = match role {
        Role::Light => (settings.interactive, index),
        // Vertices are moved once, before anything else.
        Role::Displacement(of) => (false, of),
    };
    let entry = match role {
        Role::Light => Entry::Material,
        Role::Displacement(_) => Entry::Grid(displace::OUTPUTS.map(str::to_owned).to_vec()),
    };
    let options = Options {
        file_name: material.path.to_string_lossy().into_owned(),
        bindings: material.params.iter().map(|(name, value)| (name.clone(), binding(value))).collect(),
        entry,
        before_geometry: matches!(role, Role::Displacement(_)),
        textures: Some(library.access()),
        spirv: settings.road == Road::Spirv,
        explain: settings.explain,
        userdata: Some(vertex_data::declared(scene, of)),
        attributes: attributes::of_material(scene, of),
        interactive,
        interactive_names: if interactive { material.interactive.clone() } else { Vec::new() },
        ..Options::default()
    };
    if material.group {
        return of_group(material, scene, options);
    }
    let output = compile(&material.source, &options, &Beside)?;
    Ok(Made { output, left_out: Vec::new(), supplies: None })
}

/// Values for the material are named `layer.param`, or `param` for one of the last layer.
fn of_group(material: &Material, scene: &Scene, mut options: Options) -> Result<Made, Failure> {
    let mut group = shader_group::read(&shader_group::Request {
        name: &material.name,
        text: &material.source,
        path: &material.path,
        folders: &scene.shaders,
        options: &Options::default(),
        includes: &Beside,
    })?;
    let bound = options.bindings.iter_mut().map(|(name, _)| name);
    for name in bound.chain(&mut options.interactive_names) {
        *name = shader_group::full_name(name, group.layers.iter().map(|l| l.name.as_str()));
    }
    let left_out = if scene.conventions.unknown_params_warn { drop_unknown(&mut group) } else { Vec::new() };
    Ok(Made { output: group.instance(&options)?, left_out, supplies: None })
}

/// Takes away values for parameters that shaders do not have, and says which.
fn drop_unknown(group: &mut Group) -> Vec<String> {
    let mut dropped = Vec::new();
    for layer in &mut group.layers {
        let info = layer.master.info();
        layer.bindings.retain(|bound| {
            let root = bound.name.split('.').next().unwrap_or_default();
            let known = info.params.iter().any(|p| p.name == root);
            if !known {
                dropped
                    .push(format!("shader `{}` has no parameter `{}`; its value is left out", info.name, bound.name));
            }
            known
        });
    }
    dropped
}

pub(crate) fn binding(value: &ParamValue) -> Binding {
    match value {
        ParamValue::Int(v) => Binding::Int(*v),
        ParamValue::Float(v) => Binding::Float(*v),
        ParamValue::Str(s) => Binding::Str(s.clone()),
        ParamValue::Floats(v) => Binding::Floats(v.clone()),
        ParamValue::Strs(v) => Binding::Strs(v.clone()),
    }
}

/// Includes that lie beside the including file.
struct Beside;

impl Includes for Beside {
    fn read(&self, path: &str, from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        let folder = Path::new(from?).parent()?;
        let file = folder.join(path);
        let text = std::fs::read_to_string(&file).ok()?;
        Some((file.to_string_lossy().into_owned(), Arc::from(text)))
    }
}
