//! A shader on its way into a package.
//!
//! In: its source, values for parameters, names of parameters that stay open. Out: a [`Shader`]. What only a scene knows is left
//! to the render: attributes and data of vertices come as userdata, whether a scene has them or not. It must not know where
//! sources come from.

use super::facts::Recorder;
use super::{Form, Shader};
use crate::{displace, grid, shade};
use oslcl_compiler::attributes::Attributes;
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::reflect::{Param, ShaderInfo};
use oslcl_compiler::types::{Base, Extent, Type};
use oslcl_compiler::{
    Binding, Entry, Failure, Includes, Master, Options, Output, SourceMap, TextureAccess, Userdata, suggest,
};
use std::sync::Arc;

/// Stands for every parameter that can stay open.
pub const ALL: &str = "*";

/// A shader after the front half of the compiler.
pub struct Front {
    options: Options,
    master: Master,
    /// As points without a scene have it: they know other spaces.
    points: Master,
}

/// What is decided when a shader is compiled.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Values of parameters.
    pub bound: Vec<(String, Binding)>,
    /// Parameters whose values are read at run time, beside those whose declaration says so ([`keep`]).
    pub kept: Vec<String>,
    /// Who answers `gettextureinfo`.
    pub textures: TextureAccess,
}

/// A shader, and what was said on the way behind the front half.
pub struct Made {
    /// The shader.
    pub shader: Shader,
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
    /// What they point into.
    pub sources: Arc<SourceMap>,
}

impl Front {
    /// Reads a source. Of the options `file_name`, macros and closures count.
    pub fn new(source: &str, options: &Options, includes: &(dyn Includes + Sync)) -> Result<Front, Failure> {
        let at_points = Options { spaces: grid::SPACES.map(str::to_owned).into(), ..options.clone() };
        let master = Master::new(source, options, includes)?;
        let points = Master::new(source, &at_points, includes)?;
        Ok(Front { options: options.clone(), master, points })
    }

    /// The shader as it is in scenes.
    pub fn master(&self) -> &Master {
        &self.master
    }

    /// Compiles all that a package has of the shader.
    pub fn compile(&self, settings: &Settings) -> Result<Made, Failure> {
        let info = self.master.info();
        let recorder = Arc::new(Recorder::new(settings.textures.0.clone()));
        let userdata: Vec<Userdata> = info.params.iter().filter_map(userdata).collect();
        let coordinates = userdata.iter().filter(|d| d.same_as.is_some()).map(|d| d.name.clone()).collect();
        let options = Options {
            bindings: settings.bound.clone(),
            textures: Some(TextureAccess(recorder.clone())),
            spirv: true,
            userdata: Some(userdata),
            attributes: Attributes { open: true, ..Attributes::default() },
            interactive: true,
            interactive_names: settings.kept.clone(),
            ..self.options.clone()
        };
        let moves = Entry::Grid(displace::OUTPUTS.map(str::to_owned).to_vec());
        let main_entry = if info.kind == "displacement" { moves.clone() } else { Entry::Material };
        let before_geometry = info.kind == "displacement";
        let main_options = Options { entry: main_entry, before_geometry, ..options.clone() };
        let (output, no_spirv) = with_spirv(&self.master, main_options)?;
        let main = Form { artifact: output.artifact, no_spirv };
        // What can be both may still be no use as the other one.
        let mover = match info.kind.as_str() {
            "shader" => {
                with_spirv(&self.master, Options { entry: moves, before_geometry: true, ..options.clone() }).ok()
            }
            _ => None,
        };
        let at_points = Options {
            entry: Entry::Grid(shade::default_outputs(info)),
            // As for a shader without a scene: nothing has data at its vertices.
            userdata: None,
            attributes: Attributes { open: true, exact: true, ..Attributes::default() },
            ..options
        };
        let (points, no_points) = match with_spirv(&self.points, at_points) {
            Ok(made) => (Some(form(made)), None),
            Err(failure) => (None, Some(first_error(&failure))),
        };
        let declared = info.params.iter().filter(|p| p.is_interactive()).map(|p| p.name.clone());
        let mut kept: Vec<String> = declared.chain(settings.kept.iter().cloned()).collect();
        kept.sort();
        kept.dedup();
        let shader = Shader {
            source: self.options.file_name.clone(),
            main,
            mover: mover.map(form),
            points,
            no_points,
            bound: settings.bound.clone(),
            kept,
            coordinates,
            facts: recorder.facts(),
        };
        Ok(Made { shader, warnings: output.warnings, sources: output.sources })
    }
}

fn form((output, no_spirv): (Output, Option<String>)) -> Form {
    Form { artifact: output.artifact, no_spirv }
}

/// The artifact with SPIR-V, or without, and why.
fn with_spirv(master: &Master, options: Options) -> Result<(Output, Option<String>), Failure> {
    match master.instance(&options) {
        Ok(output) => Ok((output, None)),
        // Errors of that back end alone.
        Err(failure) if failure.diagnostics.iter().all(|d| !d.is_error() || d.code.starts_with("E43")) => {
            let output = master.instance(&Options { spirv: false, ..options })?;
            Ok((output, Some(first_error(&failure))))
        }
        Err(failure) => Err(failure),
    }
}

fn first_error(failure: &Failure) -> String {
    failure.diagnostics.iter().find(|d| d.is_error()).map_or_else(|| failure.to_string(), |d| d.message.clone())
}

/// The userdata that a parameter reads, whatever geometry it will lie on: it may be there or not. `u v s t` are the surface's
/// coordinates, with their derivatives, as they are wherever a mesh has some ([`super::take`] sees to it).
fn userdata(param: &Param) -> Option<Userdata> {
    if !param.reads_userdata() {
        return None;
    }
    let Type { base, extent } = param.resolved;
    let ty = match extent {
        Extent::Scalar if base.is_triple() => Type::scalar(Base::Color),
        Extent::Scalar if base == Base::Float => param.resolved,
        Extent::Fixed(2..) if base == Base::Float => param.resolved,
        // Vertices have numbers only, and those as floats.
        _ => return None,
    };
    let same_as = match param.name.as_str() {
        _ if ty != Type::scalar(Base::Float) => None,
        "u" | "s" => Some("u".to_owned()),
        "v" | "t" => Some("v".to_owned()),
        _ => None,
    };
    Some(Userdata { name: param.name.clone(), ty, sometimes: same_as.is_none(), same_as })
}

/// Why a parameter can't stay open; `None`: it can.
fn fixed(param: &Param) -> Option<&'static str> {
    match param.resolved.base {
        _ if param.output => Some("it is an output"),
        Base::Closure => Some("it is a closure"),
        Base::Struct(_) => Some("it is a struct"),
        _ if param.resolved.extent == Extent::Unsized => Some("its length is not known"),
        _ => None,
    }
}

/// The parameters that [`ALL`] stands for. Strings are not among them: names of textures and the like decide the code; nor is
/// what geometry may have data for.
fn open(info: &ShaderInfo) -> impl Iterator<Item = &str> {
    let may = |p: &&Param| fixed(p).is_none() && p.resolved.base != Base::String && !p.reads_userdata();
    info.params.iter().filter(may).map(|p| p.name.as_str())
}

/// The parameters of a shader that a name stands for; `Ok(None)`: it has none of this name. A name that it has but that can't stay
/// open is an error.
pub fn keep(info: &ShaderInfo, name: &str) -> Result<Option<Vec<String>>, String> {
    if name == ALL {
        return Ok(Some(open(info).map(str::to_owned).collect()));
    }
    let Some(param) = info.params.iter().find(|p| p.name == name) else { return Ok(None) };
    match fixed(param) {
        None => Ok(Some(vec![name.to_owned()])),
        Some(cause) => Err(format!("parameter `{name}` of shader `{}` can't be interactive: {cause}", info.name)),
    }
}

/// A help line for a name that is no parameter of a shader; it starts on a new line, or is empty.
pub fn suggestion(info: &ShaderInfo, name: &str) -> String {
    let names = || info.params.iter().map(|p| p.name.as_str());
    match suggest::closest(name, names()) {
        Some(near) => format!("\n  help: did you mean `{near}`?"),
        None if info.params.is_empty() => "\n  help: it has none".to_owned(),
        None => format!("\n  help: it has {}", names().collect::<Vec<_>>().join(", ")),
    }
}
