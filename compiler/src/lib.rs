//! Compiles Open Shading Language to OpenCL C. docs/ARCHITECTURE.md is the map.
//!
//! [`compile`] turns source text into an [`Artifact`]: one OpenCL C function and a list of what it needs. The crate reads no
//! files, no clock and no environment: other files come through [`Includes`]. Input of any kind yields a result or
//! [diagnostics](diag), never a panic.
//!
//! ```
//! use oslcl_compiler::{Binding, NoIncludes, Options, compile};
//!
//! let source = "surface chalk(color Cs = 0.5, float gain = 1) { Ci = gain * Cs * diffuse(N); }";
//! let options = Options { bindings: vec![("gain".into(), Binding::Float(0.8))], ..Options::default() };
//! match compile(source, &options, &NoIncludes) {
//!     Ok(output) => {
//!         assert_eq!(output.artifact.lobes, ["diffuse"]);
//!         assert!(output.artifact.code.contains(&output.artifact.entry));
//!     }
//!     Err(failure) => panic!("{failure}"),
//! }
//! ```
//!
//! A [`Master`] keeps the front half's work, to write code for many sets of parameters.

#![forbid(unsafe_code)]

pub mod artifact;
pub mod ast;
pub mod attributes;
pub mod backend;
pub mod builtins;
pub mod check;
pub mod diag;
pub mod dictionary;
pub mod escape;
mod facade;
pub mod interp;
pub mod ir;
pub mod lower;
pub mod messages;
pub mod oso;
pub mod parse;
pub mod passes;
pub mod points;
pub mod preprocess;
pub mod reflect;
pub mod source;
pub mod strings;
pub mod suggest;
pub mod text;
pub mod textures;
pub mod types;
pub mod vendor;

pub use artifact::{Artifact, Radiance};
pub use diag::Diagnostic;
pub use facade::{
    Binding, Bound, ColorSystem, Connection, Entry, Failure, Group, Hints, HostRun, Layer, Lazy, Master, NoIncludes,
    Options, Oso, OsoOptions, Output, ParseError, Query, QueryParam, TextError, Userdata, Values, batch, check_only,
    compile, inspect, preprocessed, query_shader, to_oso,
};
pub use interp::{Globals, Space};
pub use passes::TextureUse;
pub use preprocess::Includes;
pub use reflect::ShaderInfo;
pub use source::SourceMap;
pub use textures::{TextureAccess, Textures};
