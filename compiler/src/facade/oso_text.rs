//! The facade's part about `.oso`: OSL to the text of a compiled shader, such a text to a [`Master`], queries.
//!
//! In: texts. Out: texts, masters, queries, or a [`Failure`].

use super::{Failure, Front, Master, Options, Silenced, Target, WithEmbedded, checked, on_large_stack, tell};
use crate::diag::Diagnostic;
use crate::oso::{parse, query, read, text, write};
use crate::preprocess::{self, Includes};
use crate::source::SourceMap;
use crate::{lower, oso};
use std::sync::Arc;

pub use crate::oso::query::{Param as QueryParam, Query};

/// A shader as `.oso` text, and what was said on the way.
#[derive(Clone, Debug)]
pub struct Oso {
    /// The shader's name.
    pub name: String,
    /// The file.
    pub text: String,
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
    /// What the warnings point into: the main file, then all that it includes.
    pub sources: Arc<SourceMap>,
}

/// The settings of an `.oso` file that are not the compiler's.
#[derive(Clone, Debug, Default)]
pub struct OsoOptions {
    /// Options of the command line, for a comment.
    pub command_line: String,
    /// Append the preprocessed source.
    pub embed_source: bool,
}

/// Runs work that fills a source map; its findings as a failure.
fn with_sources<T: Send>(
    work: impl FnOnce(&mut SourceMap) -> Result<T, Vec<Diagnostic>> + Send,
) -> Result<(T, Arc<SourceMap>), Failure> {
    let done = on_large_stack(|| {
        let mut sources = SourceMap::default();
        let result = work(&mut sources);
        (result, Arc::new(sources))
    });
    match done {
        Ok((Ok(value), sources)) => Ok((value, sources)),
        Ok((Err(list), sources)) => Err(Failure { diagnostics: tell(&sources, &Silenced::new(), list), sources }),
        Err(d) => Err(Failure { diagnostics: vec![d], sources: Arc::default() }),
    }
}

/// Compiles OSL to `.oso`. What has no lowering yet is written all the same: the file says what the source says.
pub fn to_oso(
    source: &str,
    options: &Options,
    oso_options: &OsoOptions,
    includes: &(dyn Includes + Sync),
) -> Result<Oso, Failure> {
    let ((name, text, warnings), sources) = with_sources(|sources| {
        let front = checked(source, options, Target::Oso, includes, sources)?;
        let comments = vec![
            format!("Compiled by oslc (oslcl {})", env!("CARGO_PKG_VERSION")),
            format!("options: {}", oso_options.command_line),
        ];
        let module = write::write(&front.checked, sources, comments)?;
        let line = |file: &str, line: u32| sources.line_of(file, line).to_owned();
        let mut text = text::to_text(&module, &line);
        if oso_options.embed_source {
            text += &format!("%preprocessed_source\n{}\n", front.text);
        }
        Ok((module.name, text, front.warnings))
    })?;
    Ok(Oso { name, text, warnings, sources })
}

/// The text of an OSL file after the preprocessor, with `# line "file"` markers.
pub fn preprocessed(
    source: &str,
    options: &Options,
    includes: &(dyn Includes + Sync),
) -> Result<(String, Arc<SourceMap>), Failure> {
    with_sources(|sources| {
        let settings = super::preprocess_options(options);
        let pre = preprocess::preprocess(&options.file_name, source, &settings, &WithEmbedded(includes), sources)?;
        Ok(pre.with_line_markers(sources))
    })
}

/// Asks an `.oso` text, or OSL, what `oslinfo` tells.
pub fn query_shader(source: &str, options: &Options, includes: &(dyn Includes + Sync)) -> Result<Query, Failure> {
    let (query, _) = with_sources(|sources| {
        let module = if oso::is_oso(source) {
            let file = sources.add(&*options.file_name, source);
            parse::parse(source, file)?
        } else {
            let front = checked(source, options, Target::Oso, includes, sources)?;
            write::write(&front.checked, sources, Vec::new())?
        };
        Ok(query::query(&module))
    })?;
    Ok(query)
}

/// The front half for an `.oso` text.
pub(super) fn front(source: &str, options: &Options, sources: &mut SourceMap) -> Front {
    let file = sources.add(&*options.file_name, source);
    let module = parse::parse(source, file)?;
    let names: Vec<Arc<str>> = module.files.iter().map(|f| Arc::from(f.as_str())).collect();
    let origin = |op: &oso::Op| op.at.and_then(|(f, line)| Some((op.span.start, names.get(f as usize)?.clone(), line)));
    sources.set_origins(file, module.ops.iter().filter_map(origin).collect());
    let told = |list| tell(sources, &Silenced::new(), list);
    let checked = read::read(&module).map_err(told)?;
    let shader = lower::lower_for(&checked, &super::settings(options)).map_err(told)?;
    let warnings = told(checked.warnings);
    Ok((shader, checked.info, warnings, Silenced::new()))
}

impl Master {
    /// A compiled shader from the text of an `.oso` file, of this compiler or of the reference implementation's.
    /// [`Master::new`] takes such a text too. Uses the options' `file_name`.
    pub fn from_oso(text: &str, options: &Options) -> Result<Master, Failure> {
        Master::of(|sources| front(text, options, sources))
    }
}
