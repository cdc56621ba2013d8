//! The C preprocessor that OSL relies on (OSL specification ch. 3).
//!
//! In: the main file's text, options, and other files through [`Includes`]. Out: [`Preprocessed`]: one text without
//! directives, comments or macros, and the way back from its bytes to the files as the user wrote them.
//! It must not know OSL's grammar.
//!
//! Not as in C: a backslash-newline joins lines between tokens and inside words, numbers and string literals only. `#line` is
//! followed by what findings name; the text that they show is that of the file itself.

mod condition;
mod directives;
mod expand;
mod lexer;

use crate::diag::Diagnostic;
use crate::source::{FileId, SourceMap, Span};
use std::sync::Arc;

/// Where `#include` finds text. The crate itself reads no files.
pub trait Includes {
    /// The file that `path` names when included by the file called `from` (`None`: by the compiler itself), with the
    /// name to show and to compare by. `system` tells `<path>` from `"path"`, which looks beside `from` first.
    fn read(&self, path: &str, from: Option<&str>, system: bool) -> Option<(String, Arc<str>)>;
}

/// Settings of the preprocessor.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `-D`: name and replacement; a replacement of `1` is C's default.
    pub defines: Vec<(String, String)>,
    /// `-U`: names to leave undefined, of the predefined ones too.
    pub undefines: Vec<String>,
    /// Do not include `stdosl.h` before the first line.
    pub without_stdosl: bool,
    /// A file to include behind `stdosl.h`, before the first line.
    pub prelude: Option<&'static str>,
}

/// The text after preprocessing, and the way back.
#[derive(Clone, Debug, Default)]
pub struct Preprocessed {
    /// Tokens with the white space that separates them.
    pub text: String,
    /// For each token: where it starts in `text`, and its place in the source. Ascending.
    places: Vec<(u32, Span)>,
    /// Lines (file, line from 1) whose warnings `#pragma osl nowarn` silences.
    pub nowarn: Vec<(FileId, u32)>,
    /// `#pragma warning` and the like.
    pub warnings: Vec<Diagnostic>,
}

/// Most bytes of output: more is taken for a macro that grows without bound.
pub const MAX_OUTPUT: usize = 16 << 20;

impl Preprocessed {
    /// The source place of bytes `start..end` of the text. What a macro made maps to the macro's use.
    pub fn span(&self, start: usize, end: usize) -> Span {
        let first = self.place_at(start);
        let last = self.place_at(end.saturating_sub(1).max(start));
        first.to(last)
    }

    /// The place just behind the last token before byte `at` of the text: where something is missing.
    pub fn behind(&self, at: usize) -> Span {
        let i = self.places.partition_point(|p| (p.0 as usize) < at);
        match i.checked_sub(1).map(|i| self.places[i].1) {
            Some(s) => Span { file: s.file, start: s.end.saturating_sub(1).max(s.start), end: s.end },
            None => self.span(at, at),
        }
    }

    /// The text with a `# line "file"` marker wherever the next line is not the one that follows in its file.
    pub fn with_line_markers(&self, sources: &SourceMap) -> String {
        let mut out = String::with_capacity(self.text.len());
        let mut expected: Option<(FileId, u32)> = None;
        let mut start = 0;
        for line in self.text.split_inclusive('\n') {
            let first = start + line.len() - line.trim_start().len();
            if !line.trim().is_empty() {
                let span = self.place_at(first);
                let (name, number) = sources.shown(span);
                let here = (span.file, number);
                if expected != Some(here) {
                    out.push_str(&format!("# {number} \"{name}\"\n"));
                }
                expected = Some((here.0, here.1 + 1));
                out.push_str(line);
            }
            start += line.len();
        }
        if !out.is_empty() && !out.ends_with('\n') {
            out.push('\n');
        }
        out
    }

    fn place_at(&self, at: usize) -> Span {
        let i = self.places.partition_point(|p| p.0 as usize <= at);
        match self.places.get(i.saturating_sub(1)) {
            Some(p) => p.1,
            None => Span { file: FileId(0), start: 0, end: 0 },
        }
    }

    fn push(&mut self, text: &str, span: Span) {
        self.places.push((self.text.len() as u32, span));
        self.text.push_str(text);
    }
}

/// Preprocesses a file. All files read are added to `sources`, the main one first.
///
/// Errors: `E0001` include not found, `E0002` includes nested too deeply (a cycle), `E0003` bad directive, `E0004`
/// unterminated conditional, `E0005` unterminated comment or string, `E0006` bad macro use, `E0007` output too large,
/// `E0008` `#error` or `#pragma error`, `E0009` bad `#if` expression.
pub fn preprocess(
    name: &str,
    text: impl Into<Arc<str>>,
    options: &Options,
    includes: &dyn Includes,
    sources: &mut SourceMap,
) -> Result<Preprocessed, Vec<Diagnostic>> {
    let main = sources.add(name, text);
    let mut run = directives::Run::new(options, includes, sources);
    if !options.without_stdosl {
        run.include_implicitly("stdosl.h");
    }
    if let Some(prelude) = options.prelude {
        run.include_implicitly(prelude);
    }
    run.file(main);
    run.finish()
}
