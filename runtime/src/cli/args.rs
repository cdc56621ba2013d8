//! The command line as clap sees it: names, help texts, and values parsed to types.
//!
//! In: nothing. Out: [`Cli`], which the commands of this folder carry out. It must not know how.

use clap::{Args, Parser, Subcommand, ValueEnum};
use oslcl_runtime::scene::{Film, Integrator};
use std::path::PathBuf;

/// Compiles Open Shading Language materials and renders scenes with them on any OpenCL device.
#[derive(Debug, Parser)]
#[command(name = "oslcl", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "A first picture:  oslcl render scenes/gallery.toml -o gallery.png\n\
                        Your own shader:  oslcl check my.osl && oslcl shade my.osl -o Cout=out.exr")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say more of what happens: -v timings of each stage, -vv everything.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a picture.
    Render(RenderArgs),
    /// Compile OSL files to OpenCL C (.cl) and reflection (.json), or what --emit says.
    Compile(CompileArgs),
    /// Check OSL files for errors and warnings; writes nothing.
    Check(CheckArgs),
    /// Show a shader's parameters and metadata.
    Info(InfoArgs),
    /// Show which effects a scene needs, who asked for them, and what they add (-v: all askers, parameters and kernels).
    Plan(PlanArgs),
    /// List the OpenCL devices.
    Devices,
    /// Compare a picture with a reference: means, relative MSE, worst tile.
    Compare(CompareArgs),
    /// Run a shader over a grid of points and write its output parameters.
    Shade(ShadeArgs),
    /// Make a report of what things cost, that anyone can make again.
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Look after the built programs that are kept for the next start.
    #[command(subcommand)]
    Cache(CacheCommand),
    /// Build programs that another process asks for on standard input.
    #[command(hide = true)]
    BuildPrograms(BuildProgramsArgs),
    /// Make links through which this program answers as oslc, oslinfo and the like (also: `oslcl oslc ...`).
    InstallTools(InstallToolsArgs),
}

/// The reports.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// What each choice between accuracy and time costs and buys on a scene: a table, CSV and plots.
    Accuracy(AccuracyArgs),
    /// How long scenes take to their first ray: cold, warm, after an edit.
    Startup(StartupArgs),
    /// What it saves to simulate only what a scene calls for: ten scenes, as planned and with every effect on.
    Effects(EffectsArgs),
}

/// Arguments of `oslcl bench effects`.
#[derive(Debug, Args)]
pub struct EffectsArgs {
    /// The page; sections of other devices that it has already stay.
    #[arg(short, long, value_name = "FILE", default_value = "effects.md")]
    pub output: PathBuf,
    /// Timed renders of each scene, both ways in turn.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,
    /// Samples per pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=i64::from(Integrator::MOST_SAMPLES)))]
    pub spp: u32,
    /// Size of the picture in pixels [default: 256x256].
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// OpenCL device: its number in `oslcl devices` or a part of its name.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
}

/// Arguments of `oslcl bench accuracy`.
#[derive(Debug, Args)]
pub struct AccuracyArgs {
    /// The scene.
    pub scene: PathBuf,
    /// Folder for the report, the CSV and the plots.
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    /// Samples per pixel of each variation [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Integrator::MOST_SAMPLES)))]
    pub spp: Option<u32>,
    /// Renders of each variation; confidence comes from them.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub seeds: u32,
    /// Samples per pixel of the reference [default: 64 times those of a variation].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=i64::from(Integrator::MOST_SAMPLES)))]
    pub reference_spp: Option<u32>,
    /// Folder where references are kept for the next time [default: in the user's cache].
    #[arg(long, value_name = "DIR")]
    pub references: Option<PathBuf>,
    /// Size of the picture in pixels [default: the scene's].
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// OpenCL device: its number in `oslcl devices` or a part of its name.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Built programs.
    #[command(flatten)]
    pub cache: CacheArgs,
}

/// Arguments of `oslcl bench startup`.
#[derive(Debug, Args)]
pub struct StartupArgs {
    /// The scenes.
    #[arg(default_value = "scenes/gallery.toml")]
    pub scenes: Vec<PathBuf>,
    /// File for the report, in Markdown; sections of other devices that it has already stay.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Starts of each kind that can be repeated; the quickest counts.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub repeat: u32,
    /// OpenCL device: its number in `oslcl devices` or a part of its name.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Built programs, of the starts that this command makes.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Start one scene in this process and print its times: how the command measures.
    #[arg(long, hide = true)]
    pub start: Option<StartArg>,
}

/// What is different from the scene as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StartArg {
    /// Nothing.
    Plain,
    /// A parameter's value.
    Parameter,
    /// A material's source.
    Edited,
}

impl StartArg {
    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            StartArg::Plain => "plain",
            StartArg::Parameter => "parameter",
            StartArg::Edited => "edited",
        }
    }
}

/// What `oslcl cache` does.
#[derive(Debug, Subcommand)]
pub enum CacheCommand {
    /// Show where the kept programs are, how many, and how large.
    Stats(CacheDirArgs),
    /// Remove all kept programs.
    Clear(CacheDirArgs),
    /// Check all kept programs and remove those that are damaged; the exit code is 1 when there were any.
    Verify(CacheDirArgs),
}

/// Where built programs are kept.
#[derive(Debug, Args)]
pub struct CacheDirArgs {
    /// Folder of the built programs [default: oslcl/programs in the user's cache].
    #[arg(long, value_name = "DIR", env = "OSLCL_CACHE_DIR", hide_env_values = true)]
    pub cache_dir: Option<PathBuf>,
    /// Most that they may take, with K, M or G at the end or in bytes; the least recently used go first.
    #[arg(long, value_name = "SIZE", env = "OSLCL_CACHE_SIZE", hide_env_values = true, default_value = "1G",
          value_parser = parse_bytes)]
    pub cache_size: u64,
}

/// Whether and where built programs are kept for the next start.
#[derive(Debug, Args)]
pub struct CacheArgs {
    /// Where.
    #[command(flatten)]
    pub place: CacheDirArgs,
    /// Build every program anew and keep none.
    #[arg(long)]
    pub no_cache: bool,
}

/// Arguments of `oslcl build-programs`.
#[derive(Debug, Args)]
pub struct BuildProgramsArgs {
    /// OpenCL device: its number in `oslcl devices` or a part of its name.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Where they are put.
    #[command(flatten)]
    pub place: CacheDirArgs,
}

/// How exact the arithmetic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrecisionArg {
    /// 32-bit floats with relaxed rules (-cl-fast-relaxed-math): fastest.
    Fast,
    /// 32-bit floats.
    Standard,
    /// 64-bit floats: the reference that the others are measured against.
    Reference,
}

/// How materials' code gets into programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RoadArg {
    /// As OpenCL C: every device.
    Opencl,
    /// As SPIR-V, linked with the renderer's kernels: devices that take it, and PoCL where LLVM's tools are installed.
    Spirv,
}

impl CompileArgs {
    /// Whether a form is among what is written.
    pub fn emits(&self, form: EmitArg) -> bool {
        match self.emit.as_slice() {
            [] => matches!(form, EmitArg::Opencl | EmitArg::Json),
            forms => forms.contains(&form),
        }
    }
}

/// What `oslcl compile` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EmitArg {
    /// NAME.cl: OpenCL C, which a driver builds as it stands.
    Opencl,
    /// NAME.spv: a SPIR-V module; NAME.spv.cl: the OpenCL C that it is linked with.
    Spirv,
    /// NAME.bc: both of these linked as LLVM bitcode (SPIR 1.2), by clang, llvm-spirv and llvm-link.
    Bitcode,
    /// NAME.bin: the device's binary of the program that `oslcl shade` runs.
    Binary,
    /// NAME.ir: the intermediate representation that the code is written from.
    Ir,
    /// NAME.json: parameters, effects, interface.
    Json,
}

/// Where OSL files look for includes, and macros.
#[derive(Debug, Args)]
pub struct SourceArgs {
    /// Folder to search for #include files; may be repeated.
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    pub include: Vec<PathBuf>,
    /// Define a preprocessor macro; may be repeated.
    #[arg(short = 'D', long = "define", value_name = "NAME[=VALUE]")]
    pub define: Vec<String>,
    /// OSL file whose functions say what another renderer's closures look like; may be repeated.
    #[arg(long = "closures", value_name = "FILE")]
    pub closures: Vec<PathBuf>,
}

/// Choices between accuracy and time: a profile, then single settings.
#[derive(Debug, Args)]
pub struct ChoiceArgs {
    /// Where the settings start from: draft, standard or reference.
    #[arg(long, value_name = "PROFILE", default_value = "standard")]
    pub profile: String,
    /// A setting of docs/accuracy.md, such as sampler=independent; may be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// How exact the arithmetic is; the same as --set precision=... [default: the profile's, standard].
    #[arg(long, value_enum)]
    pub precision: Option<PrecisionArg>,
    /// Simulate an effect (`oslcl plan` lists them) that the scene does not call for: the picture stays the same; may be repeated.
    #[arg(long, value_name = "EFFECT")]
    pub force: Vec<String>,
    /// Leave an effect out that the scene calls for: a warning says what will be wrong; may be repeated.
    #[arg(long, value_name = "EFFECT")]
    pub without: Vec<String>,
}

/// Arguments of `oslcl render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// The scene (.toml; docs/scene.md describes it).
    pub scene: PathBuf,
    /// The picture: .exr (linear) or .png (sRGB).
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Samples per pixel [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Integrator::MOST_SAMPLES)))]
    pub spp: Option<u32>,
    /// Take as many samples as this error needs: the root of the relative mean squared error, such as 0.01.
    #[arg(long, value_name = "ERROR", value_parser = parse_error, conflicts_with_all = ["spp", "time"])]
    pub target_error: Option<f64>,
    /// Size of the picture in pixels [default: the scene's].
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Longest path, counted in edges [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Integrator::DEEPEST)))]
    pub depth: Option<u32>,
    /// Stop after this many seconds, whatever samples are done.
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub time: Option<f64>,
    /// OpenCL device: its number in `oslcl devices` or a part of its name [default: the first GPU, else CPU].
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Seed of the random numbers; the same seed gives the same bits [default: the scene's].
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Choices between accuracy and time.
    #[command(flatten)]
    pub choices: ChoiceArgs,
    /// How materials' code gets into programs.
    #[arg(long, value_enum, default_value = "opencl")]
    pub road: RoadArg,
    /// Built programs.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Exposure of a .png in stops.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_hyphen_values = true,
          value_parser = parse_stops)]
    pub exposure: f64,
    /// Say nothing but errors: no progress bar, no summary, no warnings.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `oslcl compile`.
#[derive(Debug, Args)]
pub struct CompileArgs {
    /// OSL files; for a package also shader groups (.oslgroup), shipped materials by name, and NAME=FILE where scenes shall call it
    /// so. Or a package (NAME.oslpak, NAME.oslpak:SHADER) to take apart.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Folder for the files [default: next to each source]; the file itself, such as NAME.spv, where there is one source (other
    /// forms stand beside it); or NAME.oslpak: a package of all shaders, which scenes take as they take OSL files.
    #[arg(short, long, value_name = "DIR, FILE or NAME.oslpak")]
    pub output: Option<PathBuf>,
    /// Of a package: leave a parameter open, so that scenes can set it, of all shaders that have it or of one; `*` stands for all
    /// that are no strings; may be repeated.
    #[arg(long, value_name = "[SHADER:]NAME")]
    pub interactive: Vec<String>,
    /// What to write, unless it is a package; several with commas, or repeated [default: opencl,json].
    #[arg(long, value_enum, value_delimiter = ',')]
    pub emit: Vec<EmitArg>,
    /// The arithmetic of SPIR-V, bitcode and binaries.
    #[arg(long, value_enum, default_value = "standard")]
    pub precision: PrecisionArg,
    /// OpenCL device of binaries: its number in `oslcl devices` or a part of its name.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// Bind a parameter (with one file, or in a package SHADER:NAME=VALUE): a number, numbers with commas, or text; may be
    /// repeated.
    #[arg(short, long = "param", value_name = "NAME=VALUE")]
    pub param: Vec<String>,
    /// Includes and macros.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// Arguments of `oslcl check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// OSL files.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Includes and macros.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// Arguments of `oslcl info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// An OSL file, the name of a shipped material, or a package (NAME.oslpak, NAME.oslpak:SHADER).
    pub shader: PathBuf,
    /// Print JSON for tools.
    #[arg(long)]
    pub json: bool,
    /// Includes and macros.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// Arguments of `oslcl plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The scene.
    pub scene: PathBuf,
    /// Print JSON for tools.
    #[arg(long)]
    pub json: bool,
    /// Render the scene as planned and without each effect that is on, and say what each costs in time and does to the picture; with
    /// --verbose also with each effect forced on that is off.
    #[arg(long)]
    pub measure: bool,
    /// Timed renders of each kind, in turn (with --measure).
    #[arg(long, value_name = "N", default_value_t = 3, requires = "measure", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,
    /// Samples per pixel of each (with --measure).
    #[arg(long, value_name = "N", default_value_t = 4, requires = "measure", value_parser = clap::value_parser!(u32).range(1..=i64::from(Integrator::MOST_SAMPLES)))]
    pub spp: u32,
    /// Size of the picture in pixels [default: the scene's] (with --measure).
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size, requires = "measure")]
    pub size: Option<(u32, u32)>,
    /// OpenCL device: its number in `oslcl devices` or a part of its name (with --measure).
    #[arg(long, value_name = "DEVICE", requires = "measure")]
    pub device: Option<String>,
    /// Built programs.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Choices between accuracy and time.
    #[command(flatten)]
    pub choices: ChoiceArgs,
}

/// Arguments of `oslcl compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The picture (.exr; with limits also .tif and .png).
    pub picture: PathBuf,
    /// The reference, of the same size.
    pub reference: PathBuf,
    /// Limit: a value that is off by more than this makes its pixel a failure. With any limit, all channels are compared
    /// value by value, and the exit code is 1 when a limit is broken.
    #[arg(long, value_name = "DIFFERENCE")]
    pub fail: Option<f64>,
    /// Limit: only differences beyond this part of the value count.
    #[arg(long, value_name = "PART")]
    pub fail_relative: Option<f64>,
    /// Limit: pixels that may fail, in percent.
    #[arg(long, value_name = "PERCENT")]
    pub fail_percent: Option<f64>,
    /// Limit: this many pixels may fail in any case.
    #[arg(long, value_name = "PIXELS")]
    pub allow_failures: Option<usize>,
    /// Limit: no value at all may be off by more than this.
    #[arg(long, value_name = "DIFFERENCE")]
    pub hard_fail: Option<f64>,
}

/// What `oslcl shade --compare` compares with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompareWith {
    /// 64-bit floats on the device.
    F64,
    /// The interpreter, in 64-bit floats on the host.
    Host,
}

/// Arguments of `oslcl shade`.
#[derive(Debug, Args)]
pub struct ShadeArgs {
    /// An OSL file, the name of a shipped material, or a shader of a package (NAME.oslpak:SHADER).
    pub shader: PathBuf,
    /// Points of the grid across and down; u and v run from 0 to 1 (0.5 on a single point), P = (u, v, 1)
    /// [default: 1 1, with --compare 257 257].
    #[arg(short, long, num_args = 2, value_names = ["WIDTH", "HEIGHT"],
          value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub grid: Vec<u32>,
    /// What u and v run over instead of 0 to 1.
    #[arg(long, num_args = 4, value_names = ["U0", "U1", "V0", "V1"], default_values_t = [0.0, 1.0, 0.0, 1.0],
          allow_hyphen_values = true)]
    pub domain: Vec<f32>,
    /// Compare the values in 32 bits, fast and standard, with those in 64 bits: on the device (f64) or by the interpreter on
    /// the host (host). Prints the largest and mean errors, where they are worst, and the time per point.
    #[arg(long, value_enum, value_name = "REFERENCE", conflicts_with_all = ["output", "precision"])]
    pub compare: Option<CompareWith>,
    /// Write an output parameter to an .exr file; without any, all outputs are printed as text. May be repeated.
    #[arg(short, long = "output", value_name = "PARAM=FILE")]
    pub output: Vec<String>,
    /// Bind a parameter: a number, numbers with commas, or text; may be repeated.
    #[arg(short, long = "param", value_name = "NAME=VALUE")]
    pub param: Vec<String>,
    /// A folder to look for textures in; may be repeated.
    #[arg(long, value_name = "DIR")]
    pub textures: Vec<PathBuf>,
    /// OpenCL device: its number in `oslcl devices` or a part of its name.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
    /// How exact the arithmetic is.
    #[arg(long, value_enum, default_value = "standard")]
    pub precision: PrecisionArg,
    /// How the shader's code gets into its program.
    #[arg(long, value_enum, default_value = "opencl")]
    pub road: RoadArg,
    /// Built programs.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Includes and macros.
    #[command(flatten)]
    pub source: SourceArgs,
}

/// Arguments of `oslcl install-tools`.
#[derive(Debug, Args)]
pub struct InstallToolsArgs {
    /// The folder for the links; it is made when missing.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("expected WIDTHxHEIGHT, such as 640x480")?;
    let side = |s: &str| match s.parse::<u32>() {
        Ok(n @ 1..=Film::LARGEST) => Ok(n),
        _ => Err(format!("`{s}` is not a whole number from 1 to {}", Film::LARGEST)),
    };
    Ok((side(w)?, side(h)?))
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(s) if s.is_finite() && s > 0.0 => Ok(s),
        _ => Err(format!("`{text}` is not a positive number of seconds")),
    }
}

fn parse_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(e) if e > 0.0 && e < 1.0 => Ok(e),
        _ => Err(format!("`{text}` is not a number between 0 and 1")),
    }
}

/// A number of bytes, such as 500M.
fn parse_bytes(text: &str) -> Result<u64, String> {
    let wrong = || format!("`{text}` is not a number of bytes, such as 500M or 2G");
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'm' | 'M')) => (&text[..at], 20),
        Some((at, 'g' | 'G')) => (&text[..at], 30),
        _ => (text, 0),
    };
    let number: u64 = digits.parse().map_err(|_| wrong())?;
    number.checked_mul(1 << shift).ok_or_else(wrong)
}

fn parse_stops(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(stops) if (-100.0..=100.0).contains(&stops) => Ok(stops),
        _ => Err(format!("`{text}` is not a number of stops from -100 to 100")),
    }
}
