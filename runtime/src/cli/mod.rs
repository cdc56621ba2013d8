//! The commands of `oslcl`.
//!
//! In: parsed arguments. Out: files and text; [`Error`] says why not. Each command is one file with `run`. What a program
//! that embeds oslcl needs lies in the library, not here.

pub mod args;
mod bench;
mod cache;
mod check;
mod choices;
mod compare;
mod compile;
mod devices;
mod emit;
mod info;
mod package;
mod params;
mod plan;
mod render;
mod report;
mod shade;
mod shade_compare;
mod sources;
pub mod terminal;
pub mod tools;

use args::{Cli, Command};
use oslcl_runtime::device;
use std::io;
use std::path::PathBuf;

/// Why a command ends without success.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The arguments make no sense together.
    #[error("{0}")]
    Usage(String),
    /// An OSL source can't be had.
    #[error(transparent)]
    Source(#[from] sources::Error),
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] device::Error),
    /// No program comes out.
    #[error(transparent)]
    Road(#[from] oslcl_runtime::roads::Error),
    /// A shader can't be run over a grid.
    #[error(transparent)]
    Shade(#[from] oslcl_runtime::shade::Error),
    /// A point cloud can't be written.
    #[error(transparent)]
    Points(#[from] oslcl_runtime::points::WriteError),
    /// A package can't be used.
    #[error(transparent)]
    Package(#[from] oslcl_runtime::package::Error),
    /// A scene's material can't be had.
    #[error(transparent)]
    Material(#[from] oslcl_runtime::materials::Error),
    /// A scene can't be loaded.
    #[error(transparent)]
    Scene(#[from] oslcl_runtime::scene::Error),
    /// A scene can't be rendered.
    #[error("{}: {cause}", scene.display())]
    Render {
        /// The scene.
        scene: PathBuf,
        /// Why.
        cause: Box<oslcl_runtime::render::Error>,
    },
    /// A picture can't be written.
    #[error(transparent)]
    Film(#[from] oslcl_runtime::film::Error),
    /// A file can't be written.
    #[error(transparent)]
    Write(#[from] oslcl_runtime::files::Error),
    /// The folder of kept programs can't be looked after.
    #[error("{}: {cause}", folder.display())]
    Cache {
        /// The folder.
        folder: PathBuf,
        /// Why.
        cause: io::Error,
    },
    /// Pictures that can't be compared.
    #[error("{0}")]
    Compare(String),
    /// Standard output takes no more.
    #[error("cannot write to standard output: {0}")]
    Print(io::Error),
    /// All was said already, such as diagnostics.
    #[error("failed")]
    Reported,
}

/// Carries out what the arguments ask for.
pub fn run(cli: &Cli) -> Result<(), Error> {
    match &cli.command {
        Command::Compile(args) => compile::run(args),
        Command::Check(args) => check::run(args),
        Command::Info(args) => info::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Devices => devices::run(),
        Command::Shade(args) => shade::run(args),
        Command::Render(args) => render::run(args),
        Command::Plan(args) => plan::run(args, cli.verbose > 0),
        Command::Bench(command) => bench::run(command),
        Command::Cache(command) => cache::run(command),
        Command::BuildPrograms(args) => cache::build_programs(args),
        Command::InstallTools(args) => tools::install(&args.folder),
    }
}
