//! The compiler as one call: source text to artifact.
//!
//! In: source, [`Options`], other files through [`Includes`]. Out: [`Output`] or [`Failure`], both with the sources that
//! their diagnostics point into. Work runs on a thread of its own whose stack is large enough for the deepest input that
//! the parser accepts. It must not know files, the environment or time.

mod group;
mod host;
mod oso_text;
mod text;
mod uses;

use crate::artifact::Artifact;
use crate::attributes::Attributes;
use crate::diag::{self, Diagnostic};
use crate::dictionary::Documents;
use crate::ir::{self, Const, Shader, Ty};
use crate::preprocess::{self, Includes};
use crate::reflect::ShaderInfo;
use crate::source::{FileId, SourceMap};
use crate::textures::TextureAccess;
use crate::{check, interp, lower, oso, parse, vendor};
use std::fmt;
use std::sync::Arc;

pub use crate::backend::Entry;
pub use crate::lower::ColorSystem;
pub use crate::passes::link::{Connection, Hints, Lazy, Userdata};
pub use group::{Bound, Group, Layer};
pub use host::HostRun;
pub use oso_text::{Oso, OsoOptions, Query, QueryParam, preprocessed, query_shader, to_oso};
pub use text::{ParseError, TextError};

/// A value for a parameter. It converts as OSL converts: int to float, a number to a triple or a matrix's diagonal.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Binding {
    /// A whole number.
    Int(i64),
    /// A number.
    Float(f64),
    /// A string.
    Str(String),
    /// A triple (3), a matrix (16, row-major) or an array of numbers, triples or matrices, one behind the other.
    Floats(Vec<f64>),
    /// An array of strings.
    Strs(Vec<String>),
}

impl Binding {
    /// The value as the numbers of a slot, one per real; a string by its id. `None` when it does not fit the slot's type.
    pub fn numbers(&self, slot: &crate::artifact::Slot) -> Option<Vec<f64>> {
        self.numbers_as(slot.resolved)
    }

    /// The value as the numbers of a type, as OSL converts it: elements in order, triples as 3, matrices as 16; a string by its
    /// id. An unsized array gets the length of the value. `None` when it does not fit.
    pub fn numbers_as(&self, declared: crate::types::Type) -> Option<Vec<f64>> {
        use crate::types::{Base, Extent};
        let ty = match declared.base {
            Base::Int => Ty::Int,
            Base::Float => Ty::Float,
            Base::Matrix => Ty::Matrix,
            Base::String => Ty::Str,
            base if base.is_triple() => Ty::Triple,
            _ => return None,
        };
        let constant = self.constant();
        let len = match declared.extent {
            Extent::Scalar => None,
            Extent::Fixed(n) => Some(n),
            Extent::Unsized => Some(crate::passes::length_of(&constant, ty)?),
        };
        let mut out = Vec::new();
        ir::numbers(&crate::passes::fitted(&constant, ty, len)?, &mut out);
        Some(out)
    }

    fn constant(&self) -> Const {
        match self {
            Binding::Int(v) => i32::try_from(*v).map_or(Const::Float(*v as f64), Const::Int),
            Binding::Float(v) => Const::Float(*v),
            Binding::Str(s) => Const::Str(s.clone()),
            Binding::Floats(v) => Const::Array(v.iter().map(|f| Const::Float(*f)).collect()),
            Binding::Strs(v) => Const::Array(v.iter().map(|s| Const::Str(s.clone())).collect()),
        }
    }
}

/// Settings of a compilation.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Name of the source, for diagnostics and for includes beside it.
    pub file_name: String,
    /// `-D`: names and replacements.
    pub defines: Vec<(String, String)>,
    /// `-U`: names to leave undefined.
    pub undefines: Vec<String>,
    /// Values of parameters by flattened name (`a.x` for field x of struct parameter a). The others keep their defaults.
    pub bindings: Vec<(String, Binding)>,
    /// The names of the spaces that the renderer knows beyond those of every renderer, in the order of `other_spaces` from
    /// its fourth on (kernels/globals.h).
    pub spaces: Vec<String>,
    /// What linear RGB is.
    pub color_system: ColorSystem,
    /// Unknown kinds of noise are reported when the shader runs, as by the reference implementation; otherwise they are errors.
    pub unknown_noise_runs: bool,
    /// Indices out of range are reported when the shader runs, as by the reference implementation; either way they count as
    /// the nearest one. It costs time at each index that is no constant.
    pub range_checks: bool,
    /// Variables that get a NaN or an infinity are reported when the shader runs. It costs time at each assignment.
    pub finite_checks: bool,
    /// Variables that are read before they are assigned are reported when the shader runs.
    pub unassigned_checks: bool,
    /// What vendors' closures look like, before our own mappings: OSL texts, see [`crate::vendor`].
    pub closures: Vec<vendor::Mapping>,
    /// What to write.
    pub entry: Entry,
    /// It runs before there is anything that rays could meet, as displacement shaders do: `trace` finds nothing, with a warning.
    pub before_geometry: bool,
    /// What the renderer's geometry may have at a point, for parameters with `lockgeom = 0`; those that it has nothing for
    /// are constants. `None`: nobody knows; a shader alone then computes with their defaults at run time.
    pub userdata: Option<Vec<Userdata>>,
    /// Whether interactive parameters are read at run time, from what [`Artifact::inputs`] lists; otherwise their values are
    /// constants like any other.
    pub interactive: bool,
    /// Parameters that are interactive whatever their declaration says: `param`, or `layer.param` of a group.
    pub interactive_names: Vec<String>,
    /// Whether `isconnected` says that a parameter which may read userdata is connected.
    pub userdata_is_connected: bool,
    /// When the layers of a group run.
    pub lazy: Lazy,
    /// Write `#line` directives that lead from the code back to the OSL source.
    pub line_directives: bool,
    /// Say which parameters decide about what the shader uses ([`crate::artifact::Use::controls`]). It costs some optimisations more for each.
    pub explain: bool,
    /// Write SPIR-V beside OpenCL C ([`Artifact::spirv`]).
    pub spirv: bool,
    /// Who answers `gettextureinfo`, and looks textures up for [`Master::evaluate`].
    pub textures: Option<TextureAccess>,
    /// What `getattribute` finds.
    pub attributes: Attributes,
    /// Who reads the files of dictionaries.
    pub documents: Option<Documents>,
    /// The types (bits of [`crate::attributes::RAY_TYPES`]) that every ray which meets the shader has, and no others: `raytype`
    /// is a constant then. `None`: only the ray tells.
    pub ray_types: Option<u32>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            file_name: "shader.osl".to_owned(),
            defines: Vec::new(),
            undefines: Vec::new(),
            bindings: Vec::new(),
            spaces: Vec::new(),
            color_system: ColorSystem::default(),
            unknown_noise_runs: false,
            range_checks: false,
            finite_checks: false,
            unassigned_checks: false,
            closures: Vec::new(),
            entry: Entry::Material,
            before_geometry: false,
            userdata: None,
            interactive: false,
            interactive_names: Vec::new(),
            userdata_is_connected: false,
            lazy: Lazy::default(),
            line_directives: false,
            explain: false,
            spirv: false,
            textures: None,
            attributes: Attributes::default(),
            documents: None,
            ray_types: None,
        }
    }
}

/// A compiled shader and what was said on the way.
#[derive(Clone, Debug)]
pub struct Output {
    /// The result.
    pub artifact: Artifact,
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
    /// What the warnings point into.
    pub sources: Arc<SourceMap>,
}

/// Why there is no result: at least one error.
#[derive(Clone, Debug, thiserror::Error)]
pub struct Failure {
    /// Errors, and the warnings said on the way.
    pub diagnostics: Vec<Diagnostic>,
    /// What they point into.
    pub sources: Arc<SourceMap>,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(diag::render_plain(&self.sources, &self.diagnostics).trim_end())
    }
}

/// No files beside the embedded headers.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoIncludes;

impl Includes for NoIncludes {
    fn read(&self, _path: &str, _from: Option<&str>, _system: bool) -> Option<(String, Arc<str>)> {
        None
    }
}

/// Headers that come with the compiler.
const EMBEDDED: &[(&str, &str)] = &[
    ("stdosl.h", include_str!("../../../shaders-osl/stdosl.h")),
    CLOSURE_MAPPINGS[0],
    ("color2.h", include_str!("../../../shaders-osl/color2.h")),
    ("color4.h", include_str!("../../../shaders-osl/color4.h")),
    ("matrix33.h", include_str!("../../../shaders-osl/matrix33.h")),
    ("oslutil.h", include_str!("../../../shaders-osl/oslutil.h")),
    ("vector2.h", include_str!("../../../shaders-osl/vector2.h")),
    ("vector4.h", include_str!("../../../shaders-osl/vector4.h")),
    (OSO_FUNCTIONS, include_str!("../../../shaders-osl/oso_functions.h")),
];

/// What vendors' closures look like: headers whose functions stand for the vendors' declarations.
pub(crate) const CLOSURE_MAPPINGS: &[(&str, &str)] =
    &[("stdcycles.h", include_str!("../../../shaders-osl/stdcycles.h"))];

/// Built-in functions that `.oso` has no operations for, as OSL.
const OSO_FUNCTIONS: &str = "oso_functions.h";

/// The caller's files and the embedded ones. `stdosl.h` is always ours: it fits the table of built-ins. The other
/// headers can be replaced by files of the same name.
struct WithEmbedded<'a>(&'a dyn Includes);

impl Includes for WithEmbedded<'_> {
    fn read(&self, path: &str, from: Option<&str>, system: bool) -> Option<(String, Arc<str>)> {
        let name = path.rsplit('/').next().unwrap_or(path);
        let embedded = EMBEDDED.iter().find(|(n, _)| *n == name);
        let ours = || embedded.map(|(n, text)| (format!("<{n}>"), Arc::from(*text)));
        if name == "stdosl.h" {
            return ours();
        }
        self.0.read(path, from, system).or_else(ours)
    }
}

thread_local! {
    /// The present thread has a large stack already.
    static LARGE: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Runs work that recurses as deep as its input nests.
fn on_large_stack<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Diagnostic> {
    // Whoever wants to know whether anything was compiled looks for this.
    let _span = tracing::debug_span!("compiler").entered();
    if LARGE.get() {
        return Ok(work());
    }
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().name("oslcl-compiler".to_owned()).stack_size(parse::STACK_BYTES);
        let large = || {
            LARGE.set(true);
            work()
        };
        let handle = thread
            .spawn_scoped(scope, large)
            .map_err(|e| Diagnostic::global("E4298", format!("cannot start the compiler's thread: {e}")))?;
        // A panic in there is a defect of ours: it goes on here, with its own message.
        handle.join().map_or_else(|panic| std::panic::resume_unwind(panic), Ok)
    })
}

/// Runs work that compiles many shaders. Each compilation needs a thread with a large stack, and starts one unless it runs in
/// here: small shaders compile a good deal faster so.
pub fn batch<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    on_large_stack(work).map_err(|d| Failure { diagnostics: vec![d], sources: Arc::default() })
}

/// A shader after the front half of the compiler: source to IR, done once. The back half, done once per set of bound
/// parameters, is [`Master::instance`].
#[derive(Clone, Debug)]
pub struct Master {
    /// `None` only while it is dropped.
    shader: Option<Box<Shader>>,
    info: ShaderInfo,
    warnings: Vec<Diagnostic>,
    nowarn: Silenced,
    sources: Arc<SourceMap>,
}

/// Most `#include`s that are named with a finding.
const MAX_INCLUDERS: usize = 8;

/// What is said at them.
const INCLUDED: &str = "included here";

/// Lines whose warnings are silenced.
type Silenced = Vec<(FileId, u32)>;

/// Leaves out what is silenced, and says of findings in included files who included them.
fn tell(sources: &SourceMap, nowarn: &Silenced, list: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let silenced =
        |d: &Diagnostic| d.labels.first().is_some_and(|l| nowarn.contains(&(l.span.file, sources.line(l.span))));
    let mut out = Vec::with_capacity(list.len());
    for mut d in list.into_iter().filter(|d| d.is_error() || !silenced(d)) {
        // A circle of includes is named whole in its message.
        let told = d.labels.iter().any(|l| l.text == INCLUDED);
        if let Some(first) = d.labels.first().filter(|_| d.code != "E0002" && !told).map(|l| l.span) {
            for span in sources.includers(first).take(MAX_INCLUDERS) {
                d = d.label(span, INCLUDED);
            }
        }
        if let Some((file, line)) = d.labels.first().and_then(|l| sources.origin(l.span)) {
            let origin = format!("it comes from {file}:{line}");
            d.help = Some(match d.help.take() {
                Some(help) if help.contains(&origin) => help,
                Some(help) => format!("{help}; {origin}"),
                None => origin,
            });
        }
        out.push(d);
    }
    out
}

impl Drop for Master {
    fn drop(&mut self) {
        // Blocks nest as deep as the source does; freeing them recurses.
        if let Some(shader) = self.shader.take() {
            let _ = on_large_stack(move || drop(shader));
        }
    }
}

/// What the front half yields: the IR, the reflection, the warnings.
type Front = Result<(Shader, ShaderInfo, Vec<Diagnostic>, Silenced), Vec<Diagnostic>>;

/// The checked tree of a source, with what was said on the way.
struct Parsed {
    checked: check::Checked,
    /// Of the front half, silenced ones left out.
    warnings: Vec<Diagnostic>,
    nowarn: Silenced,
    /// After the preprocessor.
    text: String,
}

fn preprocess_options(options: &Options) -> preprocess::Options {
    preprocess::Options {
        defines: options.defines.clone(),
        undefines: options.undefines.clone(),
        ..preprocess::Options::default()
    }
}

/// Parses and checks. After syntax errors the checker looks at what could be read.
fn tree(
    pre: &preprocess::Preprocessed,
    options: &Options,
    includes: &dyn Includes,
    sources: &mut SourceMap,
) -> Result<check::Checked, Vec<Diagnostic>> {
    let parse::Parsed { mut file, errors } = parse::recover(pre);
    if errors.is_empty() {
        let header = || includes.read("stdosl.h", Some(&options.file_name), false);
        let embedded = WithEmbedded(includes);
        let said = vendor::complete(&mut file, &pre.text, &options.closures, &header, &embedded, sources)?;
        let mut checked = check::check(&file)?;
        checked.warnings.extend(said);
        return Ok(checked);
    }
    let mut all = errors;
    if !file.items.is_empty()
        && let Err(found) = check::check(&file)
    {
        // What is missing may have stood where nothing could be read.
        all.extend(found.into_iter().filter(|d| !matches!(d.code, "E2009" | "E2015" | "W2007")));
    }
    Err(all)
}

fn in_order(mut list: Vec<Diagnostic>) -> Vec<Diagnostic> {
    list.sort_by_key(|d| d.labels.first().map(|l| (l.span.file, l.span.start)));
    list
}

/// What a source is compiled to.
#[derive(Clone, Copy, PartialEq)]
enum Target {
    Ir,
    Oso,
}

/// Whether a label points into the functions that stand before sources compiled to `.oso`.
fn in_prelude(sources: &SourceMap, label: &diag::Label) -> bool {
    sources.file(label.span.file).name.trim_matches(['<', '>']) == OSO_FUNCTIONS
}

fn checked(
    source: &str,
    options: &Options,
    target: Target,
    includes: &dyn Includes,
    sources: &mut SourceMap,
) -> Result<Parsed, Vec<Diagnostic>> {
    let mut settings = preprocess_options(options);
    if target == Target::Oso {
        settings.prelude = Some(OSO_FUNCTIONS);
    }
    let pre = preprocess::preprocess(&options.file_name, source, &settings, &WithEmbedded(includes), sources)
        .map_err(|list| tell(sources, &Silenced::new(), list))?;
    let mut checked = match tree(&pre, options, includes, sources) {
        Ok(checked) => checked,
        Err(mut found) => {
            found.retain(|d| d.is_error() || !d.labels.iter().any(|l| in_prelude(sources, l)));
            // What was said before belongs to the errors too.
            let mut all = tell(sources, &Silenced::new(), pre.warnings);
            all.extend(tell(sources, &pre.nowarn, found));
            return Err(in_order(all));
        }
    };
    // That functions of the prelude hide the built-ins, or the user's hide them, is as it should be.
    checked.warnings.retain(|d| !d.labels.iter().any(|l| in_prelude(sources, l)));
    // Who runs an .oso file decides what its closures look like.
    checked.warnings.retain(|d| target == Target::Ir || d.code != "W2009");
    // What the author of a file says by `#warning` is not silenced.
    let mut warnings = tell(sources, &Silenced::new(), pre.warnings);
    warnings.extend(tell(sources, &pre.nowarn, std::mem::take(&mut checked.warnings)));
    Ok(Parsed { checked, warnings, nowarn: pre.nowarn, text: pre.text })
}

fn settings(options: &Options) -> lower::Settings {
    lower::Settings {
        spaces: options.spaces.clone(),
        color_system: options.color_system.clone(),
        unknown_noise_runs: options.unknown_noise_runs,
        range_checks: options.range_checks,
        finite_checks: options.finite_checks,
        unassigned_checks: options.unassigned_checks,
    }
}

fn front(source: &str, options: &Options, includes: &dyn Includes, sources: &mut SourceMap) -> Front {
    if oso::is_oso(source) {
        return oso_text::front(source, options, sources);
    }
    let front = checked(source, options, Target::Ir, includes, sources)?;
    let shader = lower::lower_for(&front.checked, &settings(options))
        .map_err(|list| in_order([tell(sources, &front.nowarn, list), front.warnings.clone()].concat()))?;
    Ok((shader, front.checked.info, front.warnings, front.nowarn))
}

impl Master {
    /// Preprocesses, parses, checks and lowers a source. Uses the options' `file_name`, `defines`, `undefines`,
    /// `spaces` and `color_system`.
    /// Takes the text of an `.oso` file too.
    pub fn new(source: &str, options: &Options, includes: &(dyn Includes + Sync)) -> Result<Master, Failure> {
        Master::of(|sources| front(source, options, includes, sources))
    }

    /// A master of what the front half yields.
    fn of(front: impl FnOnce(&mut SourceMap) -> Front + Send) -> Result<Master, Failure> {
        let (result, sources) = match on_large_stack(|| {
            let mut sources = SourceMap::default();
            let result = front(&mut sources);
            let result = result.map(|(shader, info, warnings, nowarn)| (Box::new(shader), info, warnings, nowarn));
            (result, Arc::new(sources))
        }) {
            Ok(done) => done,
            Err(d) => return Err(Failure { diagnostics: vec![d], sources: Arc::default() }),
        };
        match result {
            Ok((shader, info, warnings, nowarn)) => {
                Ok(Master { shader: Some(shader), info, warnings, nowarn, sources })
            }
            Err(diagnostics) => Err(Failure { diagnostics, sources }),
        }
    }

    /// Parameters, defaults and metadata.
    pub fn info(&self) -> &ShaderInfo {
        &self.info
    }

    /// Warnings of the front half.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// The files that diagnostics point into.
    pub fn sources(&self) -> &Arc<SourceMap> {
        &self.sources
    }

    /// Binds parameters, optimises, and writes code. Uses the options' `bindings`, `entry` and `line_directives`.
    pub fn instance(&self, options: &Options) -> Result<Output, Failure> {
        group::Parts::one(self, options).instance(options)
    }
}

impl Master {
    /// Binds parameters and optimises: the IR that the back ends get, as text. Uses the options as [`Master::instance`] does.
    pub fn ir(&self, options: &Options) -> Result<String, Failure> {
        group::Parts::one(self, options).ir(options)
    }
}

/// The reals of output parameters, by name, in the order asked for.
pub type Values = Vec<(String, Vec<f64>)>;

impl Master {
    /// Binds parameters, optimises, and runs the shader on the host in f64 on one point: the value of each output parameter
    /// (flattened name), or of `Ci`, as the reals that [`Entry::Grid`] stores. Uses the options' `bindings`.
    pub fn evaluate(
        &self,
        options: &Options,
        outputs: &[String],
        globals: &interp::Globals,
    ) -> Result<Values, Failure> {
        let mut points = self.evaluate_all(options, outputs, std::slice::from_ref(globals))?;
        Ok(points.pop().unwrap_or_default())
    }

    /// Runs the shader on the host; see [`Group::run_on_host`].
    pub fn run_on_host(
        &self,
        options: &Options,
        outputs: &[String],
        count: u32,
        point: &(dyn Fn(u32) -> interp::Globals + Sync),
    ) -> Result<HostRun, Failure> {
        group::Parts::one(self, options).run_on_host(options, outputs, count, point)
    }

    /// As [`Master::evaluate`], for many points.
    pub fn evaluate_all(
        &self,
        options: &Options,
        outputs: &[String],
        points: &[interp::Globals],
    ) -> Result<Vec<Values>, Failure> {
        group::Parts::one(self, options).evaluate_all(options, outputs, points)
    }
}

/// Compiles a source to an artifact.
pub fn compile(source: &str, options: &Options, includes: &(dyn Includes + Sync)) -> Result<Output, Failure> {
    Master::new(source, options, includes)?.instance(options)
}

/// Parameters, defaults and metadata of a shader.
pub fn inspect(source: &str, options: &Options, includes: &(dyn Includes + Sync)) -> Result<ShaderInfo, Failure> {
    Master::new(source, options, includes).map(|m| m.info.clone())
}

/// Checks a source as far as no parameter values are needed; the warnings.
pub fn check_only(
    source: &str,
    options: &Options,
    includes: &(dyn Includes + Sync),
) -> Result<(Vec<Diagnostic>, Arc<SourceMap>), Failure> {
    Master::new(source, options, includes).map(|m| (m.warnings.clone(), m.sources.clone()))
}
