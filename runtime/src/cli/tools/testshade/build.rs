//! The shader group that testshade's arguments describe.
//!
//! In: [`Args`]. Out: a [`Group`] and what changes later. It must not know how groups run.

use super::super::super::args::SourceArgs;
use super::super::super::sources::{self, Folders};
use super::super::super::{Error, report};
use super::args::{Args, Setup, Value};
use oslcl_compiler::diag::Diagnostic;
use oslcl_compiler::{
    Binding, Bound, ColorSystem, Connection, Group, Hints, Layer, Master, Options, ParseError, suggest,
};
use oslcl_runtime::{grid, shader_file};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Finds shaders by name: each is compiled once.
pub struct Shaders {
    folders: Vec<PathBuf>,
    from_source: bool,
    options: Options,
    known: std::cell::RefCell<HashMap<String, Arc<Master>>>,
}

impl Shaders {
    /// Looks beside the working folder and in `searchpath:shader`.
    pub fn new(args: &Args) -> Shaders {
        let path = args.options.iter().find(|(name, _)| name == "searchpath:shader").map_or("", |(_, path)| path);
        let folders = path.split(':').filter(|p| !p.is_empty()).map(PathBuf::from);
        let folders = std::iter::once(PathBuf::new()).chain(folders).collect();
        let options = Options {
            spaces: grid::SPACES.map(str::to_owned).into(),
            unknown_noise_runs: true,
            range_checks: args.option("range_checking") != Some("0"),
            finite_checks: args.debug_nan,
            unassigned_checks: args.debug_uninit,
            color_system: args.colorspace.as_deref().and_then(ColorSystem::by_name).unwrap_or_default(),
            ..Options::default()
        };
        Shaders { folders, from_source: args.from_source, options, known: Default::default() }
    }

    /// The shader of this name.
    pub fn get(&self, name: &str) -> Result<Arc<Master>, Error> {
        if let Some(master) = self.known.borrow().get(name) {
            return Ok(master.clone());
        }
        let master = Arc::new(self.load(name)?);
        self.known.borrow_mut().insert(name.to_owned(), master.clone());
        Ok(master)
    }

    fn load(&self, name: &str) -> Result<Master, Error> {
        let stem = name.strip_suffix(".osl").or(name.strip_suffix(".oso")).unwrap_or(name);
        // `--inbuffer` asks to compile the source here.
        let file = if self.from_source { format!("{stem}.osl") } else { stem.to_owned() };
        let path = shader_file::find(&file, &self.folders);
        let source = sources::read_or_shipped(path.as_deref().unwrap_or(Path::new(name)))?;
        compile(&source.text, &source.name, &self.options)
    }
}

/// Compiles a source, with its folder's includes.
fn compile(text: &str, name: &str, options: &Options) -> Result<Master, Error> {
    let settings = SourceArgs { include: Vec::new(), define: Vec::new(), closures: Vec::new() };
    let options = Options { file_name: name.to_owned(), ..options.clone() };
    let master = report::checked(text, &options, &Folders::new(&settings))?;
    // Closures are printed here, whoever's they are: of one that nothing maps hears who writes OSL, not who runs a compiled file.
    let is_compiled = Path::new(name).extension().is_some_and(|e| e == "oso");
    let warnings: Vec<Diagnostic> =
        master.warnings().iter().filter(|d| !is_compiled || d.code != "W2009").cloned().collect();
    report::show(master.sources(), &warnings);
    Ok(master)
}

/// What the arguments describe.
pub struct Built {
    /// The group.
    pub group: Group,
    /// Values that change after the first iteration, by layer.
    pub later: Vec<(String, Value)>,
}

/// Builds the group.
pub fn build(args: &Args, shaders: &Shaders) -> Result<Built, Error> {
    let usage = |message: String| Error::Usage(format!("testshade: {message}"));
    if let Some(name) = args.colorspace.as_ref().filter(|n| ColorSystem::by_name(n).is_none()) {
        let known = ColorSystem::names().join(", ");
        return Err(usage(format!("option `--colorspace`: there is no colour space \"{name}\"; known are {known}")));
    }
    let mut group = Group { name: args.group_name.clone().unwrap_or_default(), ..Group::default() };
    let mut later = Vec::new();
    let mut layer_name = None;
    let mut pending: Vec<Bound> = Vec::new();
    let mut expressions = 0;
    for step in &args.setup {
        let (name, layer, master) = match step {
            Setup::Layer(name) => {
                layer_name = Some(name.clone());
                continue;
            }
            Setup::Param(value) => {
                pending.push(bound(value));
                continue;
            }
            Setup::Connect([from_layer, from, to_layer, to]) => {
                group.connections.push(Connection {
                    from_layer: from_layer.clone(),
                    from: from.clone(),
                    to_layer: to_layer.clone(),
                    to: to.clone(),
                });
                continue;
            }
            Setup::Reparam(layer, value) => {
                later.push((layer.clone(), value.clone()));
                continue;
            }
            Setup::Group(text) => {
                group = from_text(&group.name, text, args, shaders)?;
                continue;
            }
            Setup::Shader(name, layer) => (name.clone(), layer.clone(), shaders.get(name)?),
            Setup::Expression(code) => {
                let name = format!("expr_{expressions}");
                expressions += 1;
                let text = expression(&name, code);
                if args.verbose {
                    super::terminal::print(&format!("Expression-based shader text is:\n---\n{text}---\n"))?;
                }
                let master = Arc::new(compile(&text, &format!("{name}.osl"), &shaders.options)?);
                (name, None, master)
            }
        };
        let name = layer.or(layer_name.take()).unwrap_or_else(|| format!("{name}_{}", group.layers.len()));
        group.layers.push(Layer { name, master, bindings: std::mem::take(&mut pending) });
    }
    if let Some(first) = pending.first() {
        let message = format!("`{}` belongs to no shader: -param stands before the shader that it is for", first.name);
        return Err(usage(message));
    }
    if group.layers.is_empty() {
        return Err(usage("no shader or group was named".to_owned()));
    }
    // Outputs that are asked for run their layers alone.
    if args.entry_outputs.is_empty() {
        group.entry_layers = args.entries.clone();
    }
    let layer_of = |output: &String| output.split_once('.').map(|(layer, _)| layer.to_owned());
    group.entry_layers.extend(args.entry_outputs.iter().filter_map(layer_of));
    for (layer, value) in &later {
        check_later(&group, layer, value).map_err(usage)?;
    }
    Ok(Built { group, later })
}

/// Whether a value that `-reparam` gives has a parameter that it fits; else what is wrong with it.
fn check_later(group: &Group, layer: &str, value: &Value) -> Result<(), String> {
    let name = &value.name;
    let Some(found) = group.layers.iter().find(|l| l.name == layer) else {
        let near = near(layer, group.layers.iter().map(|l| l.name.as_str()));
        return Err(format!("option `-reparam`: the group has no layer `{layer}`{near}"));
    };
    let params = &found.master.info().params;
    let Some(param) = params.iter().find(|p| p.name == *name) else {
        let near = near(name, params.iter().map(|p| p.name.as_str()));
        return Err(format!("option `-reparam`: layer `{layer}` has no parameter `{name}`{near}"));
    };
    match &value.value {
        Binding::Str(text) if !param.ty.starts_with("string") => Err(format!(
            "option `-reparam`: parameter `{name}` of layer `{layer}` is {}, which `{text}` is not",
            param.ty
        )),
        _ => Ok(()),
    }
}

fn near<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    suggest::closest(name, known).map_or_else(String::new, |near| format!("; did you mean `{near}`?"))
}

fn bound(value: &Value) -> Bound {
    let hints = Hints { lockgeom: None, interpolated: value.interpolated, interactive: value.interactive };
    Bound { name: value.name.clone(), value: value.value.clone(), hints }
}

/// A shader around statements that set `result` and `alpha`.
fn expression(name: &str, code: &str) -> String {
    format!(
        "shader {name} (\n    float s = u [[ int interpolated=1 ]],\n    float t = v [[ int interpolated=1 ]],\n    \
         output color result = 0,\n    output float alpha = 1,\n  )\n{{\n    {code}\n    ;\n}}\n"
    )
}

/// A whole group: its text, or the file that holds it.
fn from_text(name: &str, text: &str, args: &Args, shaders: &Shaders) -> Result<Group, Error> {
    let (text, place) = match std::fs::read_to_string(text) {
        Ok(read) => (read, text.to_owned()),
        Err(_) => (text.to_owned(), "shader group".to_owned()),
    };
    if args.verbose {
        super::terminal::print(&format!("Processing group specification:\n---\n{text}\n---\n"))?;
    }
    Group::parse(name, &text, &mut |name| shaders.get(name)).map_err(|e| match e {
        ParseError::Text(e) => Error::Usage(format!("{place}:{e}")),
        ParseError::Shader { cause, .. } => cause,
    })
}
