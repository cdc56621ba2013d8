//! Packages of compiled shaders on the command line: made by `oslcl compile -o NAME.oslpak`, shown by `oslcl info`, taken apart by
//! `oslcl compile NAME.oslpak`.
//!
//! In: arguments. Out: the package, or what is in one.

use super::args::{CompileArgs, EmitArg, InfoArgs};
use super::sources::{self, Folders};
use super::{Error, compile, emit, info, params, report, terminal};
use oslcl_compiler::{Binding, suggest};
use oslcl_runtime::files::{self, Output};
use oslcl_runtime::package::make::{self, Front, Settings};
use oslcl_runtime::package::{self, Form, Package, Parameter, Shader, file};
use oslcl_runtime::shader_file;
use oslcl_runtime::shader_group::{self, Request};
use oslcl_runtime::textures::{self, Library};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The package that a path speaks of, and which shader of it.
pub(super) fn named(path: &Path) -> Option<(PathBuf, Option<String>)> {
    let text = path.to_string_lossy();
    let (file, shader) = shader_file::in_package(&text)?;
    Some((PathBuf::from(file), shader.map(str::to_owned)))
}

/// The shader that such a path names.
pub(super) fn shader(file: &Path, name: Option<&str>) -> Result<Shader, Error> {
    Ok(Package::read(file)?.shader(name)?)
}

/// What the command line says about parameters of some shaders: `[SHADER:]TEXT`.
struct Told<'a> {
    shader: Option<&'a str>,
    text: &'a str,
    /// Some shader took it.
    used: AtomicBool,
}

impl<'a> Told<'a> {
    /// `in_name`: what of the text is a name.
    fn of(text: &'a str, in_name: impl Fn(&str) -> usize) -> Told<'a> {
        let (shader, text) = match text[..in_name(text)].split_once(':') {
            Some((shader, _)) => (Some(shader), &text[shader.len() + 1..]),
            None => (None, text),
        };
        Told { shader, text, used: AtomicBool::new(false) }
    }

    fn is_for(&self, shader: &str) -> bool {
        self.shader.is_none_or(|name| name == shader)
    }

    fn take(&self) {
        self.used.store(true, Ordering::Relaxed);
    }

    fn is_left(&self) -> bool {
        !self.used.load(Ordering::Relaxed)
    }
}

/// What is asked of all shaders.
struct Wishes<'a> {
    values: Vec<Told<'a>>,
    open: Vec<Told<'a>>,
}

impl Wishes<'_> {
    fn bound(&self, shader: &str, front: &Front) -> Result<Vec<(String, Binding)>, Error> {
        let mut out = Vec::new();
        for value in self.values.iter().filter(|v| v.is_for(shader)) {
            value.take();
            let name = value.text.split('=').next().unwrap_or_default().trim();
            let Some((layer, param)) = front.find(name) else { continue };
            // A value is read by the type of its parameter.
            let text = value.text.trim_start().replacen(name, &param, 1);
            let bound = params::bindings(&[text], layer.info)?;
            out.extend(bound.into_iter().map(|(param, value)| (layer.full(&param), value)));
        }
        Ok(out)
    }

    fn kept(&self, shader: &str, front: &Front) -> Result<Vec<String>, Error> {
        let mut kept = Vec::new();
        for wish in self.open.iter().filter(|w| w.is_for(shader)) {
            match front.keep(wish.text).map_err(Error::Usage)? {
                Some(names) => kept.extend(names),
                // Another shader may have it.
                None if wish.shader.is_none() => continue,
                None => {
                    let (text, params) = (wish.text, front.params());
                    let help = make::suggestion(text, params.iter().map(String::as_str));
                    return Err(Error::Usage(format!(
                        "--interactive {shader}:{text}: shader `{shader}` has no parameter `{text}`{help}"
                    )));
                }
            }
            wish.take();
        }
        kept.sort();
        kept.dedup();
        Ok(kept)
    }

    /// Complains about what no shader took.
    fn check(&self, shaders: &[Shader]) -> Result<(), Error> {
        for (what, told) in
            self.values.iter().map(|v| ("--param", v)).chain(self.open.iter().map(|o| ("--interactive", o)))
        {
            if !told.is_left() {
                continue;
            }
            let near = |name: &str, known: Vec<&str>| match suggest::closest(name, known.into_iter()) {
                Some(near) => format!("\n  help: did you mean `{near}`?"),
                None => String::new(),
            };
            return Err(Error::Usage(match told.shader {
                Some(name) => {
                    let help = near(name, shaders.iter().map(|s| s.name.as_str()).collect());
                    format!("{what} {name}:{}: no shader of the package is called `{name}`{help}", told.text)
                }
                None => {
                    let params = shaders.iter().flat_map(|s| s.params.iter().map(|p| p.name.as_str()));
                    let help = near(told.text, params.collect());
                    format!("{what} {}: no shader of the package has this parameter{help}", told.text)
                }
            }));
        }
        Ok(())
    }
}

/// Compiles all files into one package. When one has errors, there is none.
pub(super) fn pack(args: &CompileArgs, to: &Path) -> Result<(), Error> {
    if !args.emit.is_empty() {
        return Err(Error::Usage(format!(
            "--emit does not go with a package: `{}` holds OpenCL C and SPIR-V\n  help: `oslcl compile {} --emit ...` writes forms \
             of what is in it",
            to.display(),
            to.display()
        )));
    }
    for path in &args.files {
        let (_, path) = called(path);
        if let Some((file, _)) = named(path) {
            return Err(Error::Usage(format!(
                "`{}` is a package: packages are made of sources, not of other packages\n  help: `oslcl compile {}` takes it apart",
                path.display(),
                file.display()
            )));
        }
    }
    let name_end = |text: &str| text.find('=').unwrap_or(text.len());
    let wishes = Wishes {
        values: args.param.iter().map(|text| Told::of(text, name_end)).collect(),
        open: args.interactive.iter().map(|text| Told::of(text, str::len)).collect(),
    };
    if let Some(told) = wishes.values.iter().find(|v| v.shader.is_none() && args.files.len() > 1) {
        return Err(Error::Usage(format!(
            "--param {}: of several files, say whose parameter it is, as in --param SHADER:{}",
            told.text, told.text
        )));
    }
    // Better to hear of it now than after the work.
    files::probe(to)?;
    let mut shaders: Vec<(PathBuf, Shader)> = Vec::new();
    compile::each(
        args.files.len(),
        |index, said| one(&args.files[index], args, &wishes, said),
        &mut |index, shader: Shader| {
            let path = args.files[index].clone();
            if let Some((other, _)) = shaders.iter().find(|(_, s)| s.name == shader.name) {
                return Err(Error::Usage(format!(
                    "`{}` and `{}` are both called `{}`: a package has each name once\n  help: give one another, as in \
                     NAME={}",
                    other.display(),
                    path.display(),
                    shader.name,
                    path.display()
                )));
            }
            shaders.push((path, shader));
            Ok(())
        },
    )?;
    let shaders: Vec<Shader> = shaders.into_iter().map(|(_, shader)| shader).collect();
    wishes.check(&shaders)?;
    let bytes = package::bytes(&shaders);
    let names: Vec<&str> = shaders.iter().map(|s| s.name.as_str()).collect();
    let line = format!(
        "{}: {} ({:.1} KiB): {}\n",
        to.display(),
        counted(names.len(), "shader"),
        bytes.len() as f64 / 1024.0,
        names.join(", ")
    );
    files::replace(&[Output { path: to.to_owned(), bytes }])?;
    terminal::print(&line)
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// `NAME=FILE`: what scenes shall call the shader of a file, where it says so; the file.
fn called(path: &Path) -> (Option<&str>, &Path) {
    let split = path.to_str().filter(|_| !path.exists()).and_then(|text| text.split_once('='));
    match split {
        Some((name, file)) if !name.is_empty() && !name.contains(['/', '\\', ':']) => (Some(name), Path::new(file)),
        _ => (None, path),
    }
}

/// Compiles a file for a package. Findings are added to `said`.
fn one(path: &Path, args: &CompileArgs, wishes: &Wishes<'_>, said: &mut String) -> Result<Shader, Error> {
    let (alias, path) = called(path);
    let source = sources::read_or_shipped(path)?;
    let options = sources::options(&source, &args.source)?;
    let folders = Folders::new(&args.source);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let front = match path.extension().is_some_and(|e| e == shader_group::EXTENSION) {
        true => Front::of_group(&Request {
            name: alias.unwrap_or(&stem),
            text: &source.text,
            path,
            folders: &args.source.include,
            options: &options,
            includes: &folders,
        }),
        false => Front::new(&source.text, &options, &folders),
    };
    let front = front.map_err(|f| compile::failed(&f, &folders, said))?;
    let beside = path.parent().map(Path::to_owned).into_iter().collect();
    let library = Arc::new(Library::new(textures::Settings { search: beside, ..textures::Settings::default() }));
    let name = alias.unwrap_or(front.name());
    let settings = Settings {
        bound: wishes.bound(name, &front)?,
        kept: wishes.kept(name, &front)?,
        textures: library.access(),
        name: alias.map(str::to_owned),
    };
    let made = front.compile(&settings).map_err(|f| {
        let error = compile::failed(&f, &folders, said);
        if !settings.kept.is_empty() {
            said.push_str(&format!("  note: these parameters are left open: {}\n", settings.kept.join(", ")));
        }
        error
    })?;
    said.push_str(&report::rendered(&made.sources, &made.warnings));
    if let Some(cause) = &made.shader.main.no_spirv {
        said.push_str(&format!("note: {}: OpenCL C alone, no SPIR-V: {cause}\n", path.display()));
    }
    Ok(made.shader)
}

/// Writes shaders of packages as `oslcl compile` writes those of OSL files.
pub(super) fn unpack(args: &CompileArgs, file: &Path, name: Option<&str>) -> Result<(), Error> {
    if !args.param.is_empty() || !args.interactive.is_empty() {
        return Err(Error::Usage("a package is compiled: --param and --interactive come too late".to_owned()));
    }
    let package = Package::read(file)?;
    let names: Vec<String> = name.map_or_else(|| package.names().map(str::to_owned).collect(), |n| vec![n.to_owned()]);
    let folder = args.output.clone().unwrap_or_else(|| file.parent().unwrap_or(Path::new("")).to_owned());
    let mut outputs = Vec::new();
    for name in &names {
        let shader = package.shader(Some(name))?;
        for kind in emit::KINDS.into_iter().filter(|k| args.emits(*k)) {
            if matches!(kind, EmitArg::Spirv | EmitArg::Bitcode)
                && let Some(cause) = &shader.main.no_spirv
            {
                return Err(package::Error::NoSpirv { shader: name.clone(), cause: cause.clone() }.into());
            }
            let precision = args.precision.into();
            let job = emit::Job { from: emit::From::Package, artifact: &shader.main.artifact, precision, device: None };
            let files = job.write(kind).map_err(|e| match e {
                emit::Error::Compile(failure) => report::report(&failure),
                emit::Error::Other(error) => error,
            })?;
            outputs.extend(
                files.into_iter().map(|(ending, bytes)| Output { path: folder.join(format!("{name}{ending}")), bytes }),
            );
        }
    }
    std::fs::create_dir_all(&folder).map_err(|e| files::Error { path: folder.clone(), cause: e.into() })?;
    files::replace(&outputs)?;
    let written: Vec<String> = outputs.iter().map(|o| o.path.display().to_string()).collect();
    terminal::print(&format!("{}: {}\n", file.display(), written.join(" ")))
}

/// Whether a package can be read, with all of its shaders or one.
pub(super) fn check(file: &Path, name: Option<&str>) -> Result<(), Error> {
    let package = Package::read(file)?;
    let names: Vec<&str> = name.map_or_else(|| package.names().collect(), |n| vec![n]);
    names.into_iter().try_for_each(|name| package.shader(Some(name)).map(|_| ()))?;
    Ok(())
}

/// Prints what is in a package, or one of its shaders.
pub(super) fn show(args: &InfoArgs, file: &Path, name: Option<&str>) -> Result<(), Error> {
    let package = Package::read(file)?;
    let names: Vec<String> = name.map_or_else(|| package.names().map(str::to_owned).collect(), |n| vec![n.to_owned()]);
    let shaders = names.iter().map(|n| package.shader(Some(n))).collect::<Result<Vec<_>, _>>()?;
    if args.json {
        let json = json(&package, &shaders);
        // Serialising to memory fails only for maps with keys that are no strings, and there are none here.
        return terminal::print(&format!("{}\n", serde_json::to_string_pretty(&json).unwrap_or_default()));
    }
    let mut out = format!(
        "{}: {}, format {}, interface {}, made by oslcl {}\n",
        file.display(),
        counted(package.names().count(), "shader"),
        file::FORMAT,
        oslcl_compiler::artifact::ABI_VERSION,
        package.made_by()
    );
    for shader in &shaders {
        let called = if shader.name == shader.info().name { String::new() } else { format!("{}: ", shader.name) };
        let _ = write!(out, "\n{called}{}", info::text(shader.info(), &|param| note(shader, param)));
        describe(&mut out, shader);
    }
    terminal::print(&out)
}

/// What stands behind a parameter's default; of a group those of its last layer are shown.
fn note(shader: &Shader, param: &str) -> String {
    match shader.param(&shader.full_name(param)) {
        Some(p) if p.open => " (interactive)".to_owned(),
        Some(Parameter { given: true, value: Some(value), .. }) => format!(" (compiled as {})", package::shown(value)),
        _ => String::new(),
    }
}

/// What a shader needs and has, in a line each.
fn describe(out: &mut String, shader: &Shader) {
    let artifact = &shader.main.artifact;
    let mut line = |what: &str, list: Vec<String>| {
        if !list.is_empty() {
            let _ = writeln!(out, "  {what:<11}{}", list.join(", "));
        }
    };
    out_of(&mut line, artifact);
    if !shader.layers.is_empty() {
        line("layers", shader.layers.clone());
        let open = shader.params.iter().filter(|p| p.open);
        line("open", open.map(|p| format!("{} {}", p.words, p.name)).collect());
    }
    line("from", vec![shader.source.clone()]);
    line("messages", if artifact.sites.is_empty() { vec![] } else { vec![counted(artifact.sites.len(), "call")] });
    let spirv = |form: &Form| form.no_spirv.clone().map_or("yes".to_owned(), |cause| format!("no: {cause}"));
    line("SPIR-V", vec![spirv(&shader.main)]);
    if let Some(cause) = &shader.no_points {
        line("no points", vec![cause.clone()]);
    }
}

fn out_of(line: &mut dyn FnMut(&str, Vec<String>), artifact: &oslcl_compiler::Artifact) {
    line("lobes", artifact.lobes.clone());
    line("volumes", artifact.volumes.clone());
    let effects = [
        (artifact.emission != oslcl_compiler::Radiance::None, "emission"),
        (artifact.background != oslcl_compiler::Radiance::None, "background"),
        (artifact.has_transparent, "transparency"),
        (artifact.has_holdout, "holdout"),
        (artifact.state.derivatives, "derivatives"),
        (artifact.state.raytype, "types of rays"),
    ];
    line("effects", effects.iter().filter(|(on, _)| *on).map(|(_, name)| (*name).to_owned()).collect());
    line("reads", artifact.globals.iter().map(|g| (*g).to_owned()).collect());
    line("noise", artifact.noise.clone());
    line("textures", artifact.textures.iter().map(|t| format!("{:?}", t.file)).collect());
    line("userdata", artifact.inputs.userdata.iter().map(|s| s.name.clone()).collect());
}

fn json(package: &Package, shaders: &[Shader]) -> serde_json::Value {
    let one = |shader: &Shader| {
        let mut artifact = serde_json::to_value(&shader.main.artifact).unwrap_or_default();
        if let Some(fields) = artifact.as_object_mut() {
            // Long, and a file of its own (`oslcl compile NAME.oslpak`).
            fields.remove("code");
        }
        let open: Vec<&str> = shader.params.iter().filter(|p| p.open).map(|p| p.name.as_str()).collect();
        let given = shader.params.iter().filter(|p| p.given);
        let bound: BTreeMap<&str, &Binding> =
            given.filter_map(|p| Some((p.name.as_str(), p.value.as_ref()?))).collect();
        serde_json::json!({
            "name": shader.name,
            "source": shader.source,
            "layers": shader.layers,
            "interactive": open,
            "bound": bound,
            "no_spirv": shader.main.no_spirv,
            "no_points": shader.no_points,
            "artifact": artifact,
        })
    };
    serde_json::json!({
        "package": package.path().to_string_lossy(),
        "format": file::FORMAT,
        "abi_version": oslcl_compiler::artifact::ABI_VERSION,
        "oslcl": package.made_by(),
        "shaders": shaders.iter().map(one).collect::<Vec<_>>(),
    })
}
