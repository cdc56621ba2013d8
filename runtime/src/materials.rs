//! A scene's materials, compiled.
//!
//! In: a scene. Out: an artifact per material that is used. Of the compiler it sees the facade only.

use crate::scene::{Material, ParamValue, Scene};
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::{Artifact, Binding, Failure, Includes, Options, compile};
use std::path::Path;
use std::sync::Arc;

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
    let results: Vec<Option<Result<_, Failure>>> = std::thread::scope(|scope| {
        let threads: Vec<_> = scene
            .materials
            .iter()
            .zip(used)
            .map(|(material, used)| used.then(|| scope.spawn(move || compile_one(material))))
            .collect();
        // A panic in there is a defect of ours: it goes on here, with its own message.
        let join = |t: std::thread::ScopedJoinHandle<'_, _>| t.join().unwrap_or_else(|p| std::panic::resume_unwind(p));
        threads.into_iter().map(|t| t.map(join)).collect()
    });
    let mut compiled = Compiled { artifacts: Vec::new(), warnings: Vec::new() };
    for (result, material) in results.into_iter().zip(&scene.materials) {
        compiled.artifacts.push(match result {
            None => None,
            Some(Ok(output)) if ["displacement", "volume"].contains(&output.artifact.kind.as_str()) => {
                let Artifact { name, kind, .. } = output.artifact;
                return Err(Error::Kind { material: material.name.clone(), shader: name, kind });
            }
            Some(Ok(output)) => {
                let plain =
                    |d: &Diagnostic| oslcl_compiler::diag::render_plain(&output.sources, std::slice::from_ref(d));
                compiled.warnings.extend(output.warnings.iter().map(plain));
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
