//! Why a package can't be had, or a shader of it not be used.
//!
//! In: made by the files of this folder. Out: printed as they are.

use std::io;
use std::path::PathBuf;

/// Why there is no shader. Where a package is at fault, it is named.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system does not give the file.
    #[error("cannot read the package `{}`: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// A file of another kind.
    #[error("`{}` is no package of shaders: {begins}\n  help: `oslcl compile -o NAME.oslpak A.osl B.osl` makes one", path.display())]
    NotPackage {
        /// The file.
        path: PathBuf,
        /// What it is like.
        begins: String,
    },
    /// A package in another format.
    #[error("the package `{}` has format {found}; this oslcl reads {known}: compile it again", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Its format.
        found: u32,
        /// Ours.
        known: u32,
    },
    /// A package with artifacts of another interface.
    #[error("the package `{}` is made for interface {found}; this oslcl reads {known}: compile it again", path.display())]
    Abi {
        /// The file.
        path: PathBuf,
        /// Its interface.
        found: u32,
        /// Ours.
        known: u32,
    },
    /// The file ends too early.
    #[error("the package `{}` is cut off: it has {bytes} bytes of at least {wanted}", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// What it should be.
        wanted: u64,
    },
    /// The file goes on behind its end.
    #[error("the package `{}` is damaged: {more} bytes stand behind its end", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// How many.
        more: u64,
    },
    /// The checksum does not fit.
    #[error("the package `{}` is damaged: its checksum does not fit", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// The checksum fits, but what it covers is not what this version writes.
    #[error("the package `{}` is not understood: {cause}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
    /// A name that the package does not have. `help` starts on a new line.
    #[error("the package `{}` has no shader `{name}`{help}", path.display())]
    NoShader {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
        /// A better name, or all.
        help: String,
    },
    /// No name, and several shaders.
    #[error(
        "the package `{}` has {} shaders: name one, as in `{}:{}`\n  help: it has {}",
        path.display(), names.len(), path.display(), names.first().map_or("NAME", |n| n), names.join(", ")
    )]
    WhichShader {
        /// The file.
        path: PathBuf,
        /// Their names.
        names: Vec<String>,
    },
    /// A value for a parameter that the shader does not have. `help` is empty or starts on a new line.
    #[error("shader `{shader}` has no parameter `{name}`{help}")]
    NoParameter {
        /// The shader.
        shader: String,
        /// The parameter.
        name: String,
        /// A better name, or all.
        help: String,
    },
    /// Another value for a parameter than the code has.
    #[error(
        "parameter `{name}` of shader `{shader}` has its value {value}in the package's code, and can't be given another one\n  \
         help: compile the package with `--interactive {name}`, so that scenes can set it, or with `--param {name}=VALUE`; or \
         name the .osl file in the scene"
    )]
    Baked {
        /// The shader.
        shader: String,
        /// The parameter.
        name: String,
        /// The value with a space behind it, where it is known.
        value: String,
    },
    /// A value of another type.
    #[error("the value does not fit parameter `{name}` of shader `{shader}`, which is of type {ty}")]
    Misfit {
        /// The shader.
        shader: String,
        /// The parameter.
        name: String,
        /// Its type.
        ty: String,
    },
    /// A parameter that shall change between renders, and can't.
    #[error(
        "parameter `{name}` of shader `{shader}` can't be interactive: its value is in the package's code\n  \
         help: compile the package with `--interactive {name}`"
    )]
    NotKept {
        /// The shader.
        shader: String,
        /// The parameter.
        name: String,
    },
    /// A parameter that is a texture coordinate in the code, on surfaces that have none.
    #[error(
        "parameter `{name}` of shader `{shader}` is the surface's texture coordinate in the package's code, but {lack}\n  \
         help: name the .osl file in the scene"
    )]
    Coordinate {
        /// The shader.
        shader: String,
        /// The parameter.
        name: String,
        /// What lacks what.
        lack: String,
    },
    /// An attribute of the environment, where shaders of packages get none.
    #[error(
        "shader `{shader}` asks for the attribute `{name}`: around the scene a package's code gets no attributes\n  \
         help: name the .osl file in the scene"
    )]
    EnvironmentAttribute {
        /// The shader.
        shader: String,
        /// The attribute.
        name: String,
    },
    /// A texture file is not as it was.
    #[error("shader `{shader}`: {cause}\n  help: compile the package again, with the files of the scene")]
    Fact {
        /// The shader.
        shader: String,
        /// What is different.
        cause: String,
    },
    /// There is no SPIR-V.
    #[error("shader `{shader}` has no SPIR-V in the package: {cause}\n  help: leave out `--road spirv`")]
    NoSpirv {
        /// The shader.
        shader: String,
        /// Why.
        cause: String,
    },
    /// The shader is not for what it is asked to do.
    #[error("shader `{shader}` has no code for points without a scene: {cause}")]
    NoPoints {
        /// The shader.
        shader: String,
        /// Why.
        cause: String,
    },
    /// Interactive parameters are to be left out of a render.
    #[error(
        "`--without interactive`: parameters of shader `{shader}` are read at run time by the package's code: {names}\n  \
         help: compile the package without `--interactive`"
    )]
    MustBeInteractive {
        /// The shader.
        shader: String,
        /// The parameters.
        names: String,
    },
}
