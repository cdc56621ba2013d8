//! Shader groups: layers, the connections between them, and the back half of the compiler for them.
//!
//! In: [`Master`]s, values and connections. Out: [`Output`] or [`Failure`]. A [`Master`] alone goes the same road, as a
//! group of one layer.

use super::host::{self, HostRun};
use super::{Binding, Entry, Failure, Master, Options, Output, Silenced, Values, on_large_stack, tell};
use crate::artifact::Artifact;
use crate::attributes::Attributes;
use crate::backend::{opencl_c, spirv};
use crate::diag::Diagnostic;
use crate::dictionary::Documents;
use crate::interp;
use crate::ir::{Const, Inst, Shader};
use crate::messages::PLACE;
use crate::passes::{self, Rays, Target, link};
use crate::source::{FileId, SourceMap};
use crate::textures::TextureAccess;
use link::{Connection, Hints};
use std::sync::Arc;

/// A shader in a group.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Its name, of which a group has each once.
    pub name: String,
    /// The shader.
    pub master: Arc<Master>,
    /// Values of its parameters; the others keep their defaults, or are connected.
    pub bindings: Vec<Bound>,
}

/// A value for a parameter of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Flattened path (`s.x` for field x of struct parameter s).
    pub name: String,
    /// The value.
    pub value: Binding,
    /// What else is said of the parameter.
    pub hints: Hints,
}

/// Layers in order and the connections between them.
///
/// Its outputs are named `layer.param`, or `param`: the last layer that has an output of this name is meant.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// Its name; may be empty.
    pub name: String,
    /// Earlier ones feed later ones.
    pub layers: Vec<Layer>,
    /// What feeds what.
    pub connections: Vec<Connection>,
    /// When not empty, these layers run in this order, with what they need of others, and not the last one.
    pub entry_layers: Vec<String>,
}

impl Group {
    /// Binds parameters, connects layers, optimises, and writes code. Uses the options' `bindings` (named `layer.param`),
    /// `entry` and `line_directives`.
    pub fn instance(&self, options: &Options) -> Result<Output, Failure> {
        self.parts(options)?.instance(options)
    }

    /// Runs the group on the host in f64 on many points: for each the values of the outputs, or of `Ci`, as the reals that
    /// [`Entry::Grid`] stores. Uses the options' `bindings`.
    pub fn evaluate_all(
        &self,
        options: &Options,
        outputs: &[String],
        points: &[interp::Globals],
    ) -> Result<Vec<Values>, Failure> {
        self.parts(options)?.evaluate_all(options, outputs, points)
    }

    /// Runs the group on the host, in f64 and with strings as texts, on points `0..count`: all that it computes and says. It
    /// takes shaders whose strings a device cannot build, too. Uses the options' `bindings`.
    pub fn run_on_host(
        &self,
        options: &Options,
        outputs: &[String],
        count: u32,
        point: &(dyn Fn(u32) -> interp::Globals + Sync),
    ) -> Result<HostRun, Failure> {
        self.parts(options)?.run_on_host(options, outputs, count, point)
    }

    /// The layers with the options' values.
    fn parts(&self, options: &Options) -> Result<Parts<'_>, Failure> {
        let mut parts = Parts {
            name: &self.name,
            layers: Vec::new(),
            connections: &self.connections,
            entry_layers: &self.entry_layers,
            textures: options.textures.clone(),
            documents: options.documents.clone(),
            attributes: options.attributes.clone(),
            ray_types: options.ray_types,
            before_geometry: options.before_geometry,
        };
        for layer in &self.layers {
            let settings = layer.bindings.iter().map(|b| link::Setting {
                name: b.name.clone(),
                value: b.value.constant(),
                hints: b.hints,
            });
            parts.layers.push(Part { name: &layer.name, master: &layer.master, settings: settings.collect() });
        }
        for (name, value) in &options.bindings {
            let split = name.split_once('.');
            let found = split.and_then(|(layer, param)| {
                let part = parts.layers.iter_mut().rev().find(|p| p.name == layer)?;
                Some((part, param))
            });
            let Some((part, param)) = found else {
                let message = format!("the group has no layer of which `{name}` is a parameter");
                let d = Diagnostic::global("E4001", message).help("write LAYER.PARAM");
                return Err(Failure { diagnostics: vec![d], sources: Arc::default() });
            };
            part.settings.push(setting(param, value));
        }
        Ok(parts)
    }
}

fn setting(name: &str, value: &Binding) -> link::Setting {
    link::Setting { name: name.to_owned(), value: value.constant(), hints: Hints::default() }
}

/// A layer on its way through the back half.
struct Part<'a> {
    name: &'a str,
    master: &'a Master,
    settings: Vec<link::Setting>,
}

/// A group on its way through the back half.
pub(super) struct Parts<'a> {
    name: &'a str,
    layers: Vec<Part<'a>>,
    connections: &'a [Connection],
    entry_layers: &'a [String],
    textures: Option<TextureAccess>,
    attributes: Attributes,
    documents: Option<Documents>,
    ray_types: Option<u32>,
    before_geometry: bool,
}

/// The files of all layers, and what of their warnings is silenced.
pub(super) struct Files {
    pub(super) sources: Arc<SourceMap>,
    nowarn: Silenced,
    /// For each layer where its files begin.
    first: Vec<u32>,
}

impl<'a> Parts<'a> {
    /// A master alone.
    pub fn one(master: &'a Master, options: &Options) -> Parts<'a> {
        let settings = options.bindings.iter().map(|(name, value)| setting(name, value)).collect();
        let textures = options.textures.clone();
        Parts {
            name: "",
            layers: vec![Part { name: "", master, settings }],
            connections: &[],
            entry_layers: &[],
            textures,
            documents: options.documents.clone(),
            attributes: options.attributes.clone(),
            ray_types: options.ray_types,
            before_geometry: options.before_geometry,
        }
    }

    fn files(&self) -> Files {
        if let [only] = self.layers.as_slice() {
            let master = only.master;
            return Files { sources: master.sources.clone(), nowarn: master.nowarn.clone(), first: vec![0] };
        }
        let mut sources = SourceMap::default();
        let mut files = Files { sources: Arc::default(), nowarn: Silenced::new(), first: Vec::new() };
        let mut seen: Vec<(&Master, u32)> = Vec::new();
        for part in &self.layers {
            let known = seen.iter().find(|(m, _)| std::ptr::eq(*m, part.master)).map(|(_, first)| *first);
            let first = known.unwrap_or_else(|| {
                let first = sources.append(&part.master.sources);
                let lines = part.master.nowarn.iter().map(|(file, line)| (FileId(file.0 + first), *line));
                files.nowarn.extend(lines);
                seen.push((part.master, first));
                first
            });
            files.first.push(first);
        }
        files.sources = Arc::new(sources);
        files
    }

    pub(super) fn settings<'b>(&'b self, target: Target, files: &'b Files, grid: bool) -> passes::Settings<'b> {
        passes::Settings {
            target,
            textures: self.textures.as_ref(),
            attributes: Some(&self.attributes),
            documents: self.documents.as_ref(),
            sources: Some(&files.sources),
            grid,
            ray_types: self.ray_types,
            rays: match grid {
                _ if self.before_geometry => Rays::Nothing,
                true => Rays::Pretended,
                false => Rays::Scene,
            },
        }
    }

    /// Joins the layers; the names that the outputs have in the joined shader come with it.
    pub(super) fn link(
        &self,
        files: &Files,
        options: &Options,
        outputs: &[String],
    ) -> Result<(Shader, Vec<String>), Vec<Diagnostic>> {
        let mut parts = Vec::with_capacity(self.layers.len());
        for (part, first_file) in self.layers.iter().zip(&files.first) {
            // The shader of a master is there until it is dropped.
            let Some(shader) = part.master.shader.as_deref() else { return Err(Vec::new()) };
            parts.push(link::Part {
                name: part.name,
                shader,
                first_file: *first_file,
                settings: part.settings.clone(),
            });
        }
        let (mut shader, outputs) = link::link(&link::Request {
            name: self.name,
            parts,
            connections: self.connections,
            entry_layers: self.entry_layers,
            outputs,
            userdata: options.userdata.as_deref(),
            interactive: options.interactive,
            interactive_names: &options.interactive_names,
            userdata_is_connected: options.userdata_is_connected,
            lazy: options.lazy,
        })?;
        tell_places(&mut shader, &files.sources);
        Ok((shader, outputs))
    }

    /// Joins the layers and optimises for a device: the shader, what to write of it, the outputs as asked for, warnings.
    #[allow(clippy::type_complexity)]
    fn optimised<'b>(
        &self,
        files: &Files,
        options: &'b Options,
    ) -> Result<(Shader, Entry, &'b [String], Vec<Diagnostic>), Vec<Diagnostic>> {
        let asked = match &options.entry {
            Entry::Material => &[][..],
            Entry::Grid(names) => names,
        };
        let (mut shader, outputs) = self.link(files, options, asked)?;
        let entry = match &options.entry {
            Entry::Material => Entry::Material,
            Entry::Grid(_) => Entry::Grid(outputs.clone()),
        };
        let warnings = passes::optimise_with(
            &mut shader,
            &[],
            &outputs,
            &self.settings(Target::Device, files, matches!(options.entry, Entry::Grid(_))),
        )?;
        Ok((shader, entry, asked, warnings))
    }

    /// The IR that back ends get, as text.
    pub fn ir(&self, options: &Options) -> Result<String, Failure> {
        let files = self.files();
        match on_large_stack(|| self.optimised(&files, options).map(|(shader, ..)| crate::ir::print(&shader))) {
            Ok(Ok(text)) => Ok(text),
            Ok(Err(list)) => {
                Err(Failure { diagnostics: tell(&files.sources, &files.nowarn, list), sources: files.sources })
            }
            Err(d) => Err(Failure { diagnostics: vec![d], sources: files.sources }),
        }
    }

    pub fn instance(&self, options: &Options) -> Result<Output, Failure> {
        let files = self.files();
        let work = || {
            let (shader, entry, asked, warnings) = self.optimised(&files, options)?;
            let lines = options.line_directives.then_some(&*files.sources);
            let mut code = opencl_c::emit(&shader, &entry, lines)?;
            let spirv = options.spirv.then(|| spirv::emit(&shader, &entry, &code.entry)).transpose()?;
            for (output, name) in code.outputs.iter_mut().zip(asked) {
                output.name.clone_from(name);
            }
            let info = self.layers.last().map(|l| l.master.info.clone());
            let info = info.ok_or_else(|| vec![Diagnostic::global("E4015", "the group has no layers")])?;
            let uses = self.uses(&shader, &files, options, asked);
            Ok((Artifact { spirv, uses, ..Artifact::new(&shader, code, info) }, warnings))
        };
        let sources = files.sources.clone();
        match on_large_stack(work) {
            Ok(Ok((artifact, later))) => {
                let mut warnings = self.warnings(&files);
                warnings.extend(tell(&sources, &files.nowarn, later));
                Ok(Output { artifact, warnings, sources })
            }
            Ok(Err(list)) => Err(Failure { diagnostics: tell(&sources, &files.nowarn, list), sources }),
            Err(d) => Err(Failure { diagnostics: vec![d], sources }),
        }
    }

    /// The front half's warnings of all layers, of each master once.
    fn warnings(&self, files: &Files) -> Vec<Diagnostic> {
        let mut warnings: Vec<Diagnostic> = Vec::new();
        for (i, (part, first)) in self.layers.iter().zip(&files.first).enumerate() {
            if files.first[..i].contains(first) {
                continue;
            }
            for warning in &part.master.warnings {
                let mut warning = warning.clone();
                link::shift_diagnostic(&mut warning, *first);
                warnings.push(warning);
            }
        }
        warnings
    }

    pub fn run_on_host(
        &self,
        options: &Options,
        asked: &[String],
        count: u32,
        point: &(dyn Fn(u32) -> interp::Globals + Sync),
    ) -> Result<HostRun, Failure> {
        let files = self.files();
        let work = || {
            let (mut shader, outputs) = self.link(&files, options, asked)?;
            passes::optimise_with(&mut shader, &[], &outputs, &self.settings(Target::Host, &files, true))?;
            let point = |i| {
                let globals = point(i);
                let textures = globals.textures.clone().or_else(|| self.textures.clone());
                interp::Globals { textures, ..globals }
            };
            let mut run = host::run(&shader, &outputs, count, &point)?;
            for (output, name) in run.outputs.iter_mut().zip(asked) {
                output.name.clone_from(name);
            }
            Ok(run)
        };
        let sources = files.sources.clone();
        match on_large_stack(work) {
            Ok(Ok(run)) => Ok(run),
            Ok(Err(diagnostics)) => Err(Failure { diagnostics, sources }),
            Err(d) => Err(Failure { diagnostics: vec![d], sources }),
        }
    }

    pub fn evaluate_all(
        &self,
        options: &Options,
        asked: &[String],
        points: &[interp::Globals],
    ) -> Result<Vec<Values>, Failure> {
        let files = self.files();
        let work = || {
            let (mut shader, outputs) = self.link(&files, options, asked)?;
            passes::optimise_with(&mut shader, &[], &outputs, &self.settings(Target::Device, &files, true))?;
            let with = |g: &interp::Globals| interp::Globals {
                textures: g.textures.clone().or_else(|| self.textures.clone()),
                ..g.clone()
            };
            points.iter().map(|globals| outcome(&shader, &outputs, asked, &with(globals))).collect()
        };
        let sources = files.sources.clone();
        match on_large_stack(work) {
            Ok(Ok(values)) => Ok(values),
            Ok(Err(diagnostics)) => Err(Failure { diagnostics, sources }),
            Err(d) => Err(Failure { diagnostics: vec![d], sources }),
        }
    }
}

/// The named outputs of one run.
fn outcome(
    shader: &Shader,
    outputs: &[String],
    asked: &[String],
    globals: &interp::Globals,
) -> Result<Values, Vec<Diagnostic>> {
    let outcome = interp::run(shader, globals).map_err(|e| vec![Diagnostic::global("E4297", e.to_string())])?;
    let mut values = Vec::with_capacity(outputs.len());
    for (name, asked) in outputs.iter().zip(asked) {
        let mut reals = Vec::new();
        host::reals(shader, (globals, &outcome), name, &mut reals).map_err(|d| vec![d])?;
        values.push((asked.clone(), reals));
    }
    Ok(values)
}

/// Puts the file and line of a call where its report has [`PLACE`].
fn tell_places(shader: &mut Shader, sources: &SourceMap) {
    for value in &mut shader.values {
        if let Inst::Const(Const::Str(text)) = &mut value.inst
            && text.contains(PLACE)
        {
            let (file, line) = sources.place(value.span);
            *text = text.replace(PLACE, &format!("{file}:{line}"));
        }
    }
}
