//! A shader, or a group of them, on its way into a package.
//!
//! In: its source, values for parameters, names of parameters that stay open. Out: a [`Shader`]. What only a scene knows is left
//! to the render: attributes and data of vertices come as userdata, whether a scene has them or not. It must not know where
//! sources come from.

use super::facts::Recorder;
use super::{Form, Parameter, Shader, as_binding};
use crate::shader_group::{self, Request};
use crate::{displace, grid, shade};
use oslcl_compiler::attributes::Attributes;
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::reflect::{Param, ShaderInfo};
use oslcl_compiler::types::{Base, Extent, Type};
use oslcl_compiler::{
    Artifact, Binding, Bound, Entry, Failure, Group, Hints, Includes, Master, Options, Output, SourceMap,
    TextureAccess, Userdata, suggest,
};
use std::sync::Arc;

/// Stands for every parameter that can stay open.
pub const ALL: &str = "*";

/// A shader or a group after the front half of the compiler.
pub struct Front {
    options: Options,
    name: String,
    scene: Source,
    /// As points without a scene have it: they know other spaces.
    points: Source,
}

enum Source {
    One(Box<Master>),
    Group(Group),
}

impl Source {
    fn instance(&self, options: &Options) -> Result<Output, Failure> {
        match self {
            Source::One(master) => master.instance(options),
            Source::Group(group) => group.instance(options),
        }
    }
}

/// A layer of a group, or a shader alone, which has no name.
#[derive(Clone, Copy)]
pub struct Layer<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its parameters.
    pub info: &'a ShaderInfo,
    given: &'a [Bound],
}

impl Layer<'_> {
    /// The full name of one of its parameters.
    pub fn full(&self, param: &str) -> String {
        if self.name.is_empty() { param.to_owned() } else { format!("{}.{param}", self.name) }
    }

    fn hints(&self, param: &Param) -> Hints {
        self.given.iter().rev().find(|b| b.name == param.name).map_or(Hints::default(), |b| b.hints)
    }

    /// Whether geometry may have data for a parameter.
    fn reads_userdata(&self, param: &Param) -> bool {
        let hints = self.hints(param);
        hints.interpolated || hints.lockgeom.map_or(param.reads_userdata(), |locked| !locked)
    }
}

/// What is decided when a shader is compiled.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Values of parameters, by full names ([`Layer::full`]).
    pub bound: Vec<(String, Binding)>,
    /// Parameters whose values are read at run time, beside those whose declaration says so ([`Front::keep`]).
    pub kept: Vec<String>,
    /// Who answers `gettextureinfo`.
    pub textures: TextureAccess,
    /// What scenes call the shader; `None`: as OSL does.
    pub name: Option<String>,
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
        let scene = Master::new(source, options, includes)?;
        let points = Master::new(source, &at_points(options), includes)?;
        let name = scene.info().name.clone();
        let [scene, points] = [scene, points].map(|master| Source::One(Box::new(master)));
        Ok(Front { options: options.clone(), name, scene, points })
    }

    /// Reads a group.
    pub fn of_group(request: &Request<'_>) -> Result<Front, Failure> {
        let scene = shader_group::read(request)?;
        let options = at_points(request.options);
        let points = shader_group::read(&Request { options: &options, ..*request })?;
        let options = Options { file_name: request.path.to_string_lossy().into_owned(), ..request.options.clone() };
        let name = request.name.to_owned();
        let [scene, points] = [scene, points].map(Source::Group);
        Ok(Front { options, name, scene, points })
    }

    /// The shader's name in OSL, or the group's.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The layers in order, or the shader alone.
    pub fn layers(&self) -> Vec<Layer<'_>> {
        match &self.scene {
            Source::One(master) => vec![Layer { name: "", info: master.info(), given: &[] }],
            Source::Group(group) => {
                let layers = group.layers.iter();
                layers.map(|l| Layer { name: &l.name, info: l.master.info(), given: &l.bindings }).collect()
            }
        }
    }

    /// The layer that a name of a parameter speaks of, and the parameter's name in it.
    pub fn find(&self, name: &str) -> Option<(Layer<'_>, String)> {
        let layers = self.layers();
        if let [only] = layers.as_slice()
            && only.name.is_empty()
        {
            return Some((*only, name.to_owned()));
        }
        let full = shader_group::full_name(name, layers.iter().map(|l| l.name));
        let (layer, param) = full.split_once('.')?;
        Some((*layers.iter().find(|l| l.name == layer)?, param.to_owned()))
    }

    /// Whether a connection gives all of a parameter its value.
    fn is_connected(&self, full: &str) -> bool {
        let Source::Group(group) = &self.scene else { return false };
        group.connections.iter().any(|c| full.split_once('.') == Some((&c.to_layer, &c.to)))
    }

    /// Compiles all that a package has of the shader.
    pub fn compile(&self, settings: &Settings) -> Result<Made, Failure> {
        let layers = self.layers();
        let none = || Failure {
            diagnostics: vec![Diagnostic::global("E4015", "the group has no layers")],
            sources: Arc::default(),
        };
        let info = layers.last().ok_or_else(none)?.info;
        let recorder = Arc::new(Recorder::new(settings.textures.0.clone()));
        let userdata = self.userdata(&layers);
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
        let (output, no_spirv) = with_spirv(&self.scene, main_options)?;
        let main = Form { artifact: output.artifact, no_spirv };
        // What can be both may still be no use as the other one.
        let (mover, no_mover) = match info.kind.as_str() {
            "shader" => {
                tried(with_spirv(&self.scene, Options { entry: moves, before_geometry: true, ..options.clone() }))
            }
            _ => (None, None),
        };
        let at_points = Options {
            entry: Entry::Grid(shade::default_outputs(info)),
            // As for a shader without a scene: nothing has data at its vertices.
            userdata: None,
            attributes: Attributes { open: true, ..Attributes::default() },
            ..options
        };
        let (points, no_points) = tried(with_spirv(&self.points, at_points));
        let shader = Shader {
            name: settings.name.clone().unwrap_or_else(|| self.name.clone()),
            source: self.options.file_name.clone(),
            params: layers.iter().flat_map(|layer| parameters(layer, settings, &main.artifact)).collect(),
            main,
            mover,
            no_mover,
            points,
            no_points,
            layers: layers.iter().map(|l| l.name.to_owned()).filter(|name| !name.is_empty()).collect(),
            coordinates,
            facts: recorder.facts(),
        };
        Ok(Made { shader, warnings: output.warnings, sources: output.sources })
    }

    /// What geometry may have for parameters, each once.
    fn userdata(&self, layers: &[Layer<'_>]) -> Vec<Userdata> {
        let mut out = Vec::new();
        for layer in layers {
            let reads = layer
                .info
                .params
                .iter()
                .filter(|p| layer.reads_userdata(p) && !self.is_connected(&layer.full(&p.name)));
            for data in reads.filter_map(userdata) {
                if !out.contains(&data) {
                    out.push(data);
                }
            }
        }
        out
    }

    /// The full names of the parameters that a name stands for; `Ok(None)`: there is none of this name. A name that there is but
    /// that can't stay open is an error.
    pub fn keep(&self, name: &str) -> Result<Option<Vec<String>>, String> {
        if name == ALL {
            let all = self.layers();
            let open = all.iter().flat_map(|l| open(l).map(|p| l.full(p)).collect::<Vec<_>>());
            return Ok(Some(open.filter(|full| !self.is_connected(full)).collect()));
        }
        let Some((layer, param)) = self.find(name) else { return Ok(None) };
        let Some(param) = layer.info.params.iter().find(|p| p.name == param) else { return Ok(None) };
        let full = layer.full(&param.name);
        let connected = self.is_connected(&full).then_some("a connection gives its value");
        match fixed(param).or(connected) {
            None => Ok(Some(vec![full])),
            Some(cause) => Err(format!("parameter `{full}` of shader `{}` can't be interactive: {cause}", self.name)),
        }
    }

    /// The full names of all parameters.
    pub fn params(&self) -> Vec<String> {
        let all = self.layers();
        all.iter().flat_map(|l| l.info.params.iter().map(|p| l.full(&p.name)).collect::<Vec<_>>()).collect()
    }
}

/// What there is to say of a layer's parameters.
fn parameters(layer: &Layer<'_>, settings: &Settings, artifact: &Artifact) -> Vec<Parameter> {
    let mut out = Vec::new();
    let own = layer.given.iter().map(|b| (layer.full(&b.name), &b.value));
    let given: Vec<(String, &Binding)> = own.chain(settings.bound.iter().map(|(name, v)| (name.clone(), v))).collect();
    for param in &layer.info.params {
        let name = layer.full(&param.name);
        let value = given.iter().rev().find(|(n, _)| *n == name).map(|(_, value)| (*value).clone());
        out.push(Parameter {
            ty: Some(param.resolved),
            words: param.ty.clone(),
            given: value.is_some(),
            value: value.or_else(|| param.default.as_ref().map(as_binding)),
            // What the artifact reads is what is open, whoever said so.
            open: artifact.inputs.interactive.iter().any(|slot| slot.name == name),
            name: name.clone(),
        });
        for (field, value) in &given {
            if field.strip_prefix(&name).is_some_and(|rest| rest.starts_with('.')) {
                let (name, value) = (field.clone(), Some((*value).clone()));
                out.push(Parameter { name, ty: None, words: String::new(), value, given: true, open: false });
            }
        }
    }
    out
}

/// The options of points without a scene.
fn at_points(options: &Options) -> Options {
    Options { spaces: grid::SPACES.map(str::to_owned).into(), ..options.clone() }
}

/// The form, or why there is none.
fn tried(made: Result<(Output, Option<String>), Failure>) -> (Option<Form>, Option<String>) {
    match made {
        Ok((output, no_spirv)) => (Some(Form { artifact: output.artifact, no_spirv }), None),
        Err(failure) => (None, Some(first_error(&failure))),
    }
}

/// The artifact with SPIR-V, or without, and why.
fn with_spirv(source: &Source, options: Options) -> Result<(Output, Option<String>), Failure> {
    match source.instance(&options) {
        Ok(output) => Ok((output, None)),
        // Errors of that back end alone.
        Err(failure) if failure.diagnostics.iter().all(|d| !d.is_error() || d.code.starts_with("E43")) => {
            let output = source.instance(&Options { spirv: false, ..options })?;
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

/// The parameters of a layer that [`ALL`] stands for. Strings are not among them: names of textures and the like decide the code;
/// nor is what geometry may have data for.
fn open<'a>(layer: &'a Layer<'a>) -> impl Iterator<Item = &'a str> {
    let may = |p: &&Param| fixed(p).is_none() && p.resolved.base != Base::String && !layer.reads_userdata(p);
    layer.info.params.iter().filter(may).map(|p| p.name.as_str())
}

/// A help line for a name that is none of these; it starts on a new line.
pub fn suggestion<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    match suggest::closest(name, known.clone()) {
        Some(near) => format!("\n  help: did you mean `{near}`?"),
        None => match known.collect::<Vec<_>>().as_slice() {
            [] => "\n  help: it has none".to_owned(),
            all => format!("\n  help: it has {}", all.join(", ")),
        },
    }
}
