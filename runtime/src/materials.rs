//! A scene's materials, compiled.
//!
//! In: a scene. Out: an artifact per material that is used. Of the compiler it sees the facade only.

use crate::scene::{Material, ParamValue, Scene};
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::{Artifact, Binding, Failure, Includes, Options, compile};
use std::path::Path;
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
    /// Its shader is for something else.
    #[error(
        "material `{material}`: `{shader}` is a {kind} shader, but surfaces and the environment take surface shaders"
    )]
    Kind {
        /// Its name in the scene.
        material: String,
        /// Its shader's name.
        shader: String,
        /// `displacement` or `volume`.
        kind: String,
    },
}

/// The compiled materials of a scene.
#[derive(Debug)]
pub struct Compiled {
    /// One per material; `None` where neither a surface nor the environment has it.
    pub artifacts: Vec<Option<Artifact>>,
    /// Warnings, each with the text of its finding.
    pub warnings: Vec<String>,
}

/// Compiles every material that is used, in parallel. The first error in the scene's order is reported.
pub fn compile_all(scene: &Scene) -> Result<Compiled, Error> {
    let _span = tracing::info_span!("materials").entered();
    let mut used = vec![false; scene.materials.len()];
    for id in scene.instances.iter().map(|i| i.material).chain(scene.environment) {
        used[id.0 as usize] = true;
    }
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<_, Failure>>>> = used.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(slot) = results.get(index) else { break };
            if used[index] {
                *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(compile_one(&scene.materials[index]));
            }
        }
    };
    // A scene may have thousands of materials: a thread each would be too many.
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()).min(results.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    let mut compiled = Compiled { artifacts: Vec::new(), warnings: Vec::new() };
    for (result, material) in results.into_iter().zip(&scene.materials) {
        compiled.artifacts.push(match result.into_inner().unwrap_or_else(PoisonError::into_inner) {
            None => None,
            Some(Ok(output)) if ["displacement", "volume"].contains(&output.artifact.kind.as_str()) => {
                let Artifact { name, kind, .. } = output.artifact;
                return Err(Error::Kind { material: material.name.clone(), shader: name, kind });
            }
            Some(Ok(output)) => {
                let plain =
                    |d: &Diagnostic| oslcl_compiler::diag::render_plain(&output.sources, std::slice::from_ref(d));
                compiled.warnings.extend(output.warnings.iter().map(plain));
                if !output.artifact.volumes.is_empty() {
                    let volumes = output.artifact.volumes.join(", ");
                    let name = &material.name;
                    compiled.warnings.push(format!(
                        "warning: material `{name}`: media are not simulated yet, light passes as through a vacuum ({volumes})\n"
                    ));
                }
                Some(output.artifact)
            }
            Some(Err(failure)) => {
                return Err(Error::Compile { material: material.name.clone(), failure: Box::new(failure) });
            }
        });
    }
    Ok(compiled)
}

fn compile_one(material: &Material) -> Result<oslcl_compiler::Output, Failure> {
    let options = Options {
        file_name: material.path.to_string_lossy().into_owned(),
        bindings: material.params.iter().map(|(name, value)| (name.clone(), binding(value))).collect(),
        ..Options::default()
    };
    compile(&material.source, &options, &Beside)
}

fn binding(value: &ParamValue) -> Binding {
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
