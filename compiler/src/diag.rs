//! Diagnostics as values: stable code, severity, message, labelled spans, help.
//!
//! Every stage returns these; only the binary renders them for a terminal. [`render_plain`] is the form that tests and
//! logs use: one `file:line:column: severity[code]: message` line per diagnostic, then the source line with a caret.

use crate::source::{SourceMap, Span};
use std::fmt::Write;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Compilation goes on and yields code.
    Warning,
    /// No code is produced.
    Error,
}

/// A span with a few words on what stands there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What stands there; may be empty for the primary label.
    pub text: String,
}

/// One finding about the user's source.
///
/// Codes are stable: `E0xxx` preprocessor, `E1xxx` syntax, `E2xxx` types and names, `E3xxx` not supported yet,
/// `E4xxx` specialisation and parameters, `W....` warnings in the same ranges. docs/errors.md lists them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable code such as `E2003`.
    pub code: &'static str,
    /// Error or warning.
    pub severity: Severity,
    /// One sentence without a final full stop.
    pub message: String,
    /// Primary place first; empty only for findings about no place in a source.
    pub labels: Vec<Label>,
    /// What the user can do, if we know.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error at a place.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        let labels = vec![Label { span, text: String::new() }];
        Diagnostic { code, severity: Severity::Error, message: message.into(), labels, help: None }
    }

    /// A warning at a place.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(code, span, message) }
    }

    /// An error about no place in a source, such as an unknown parameter name given by a scene.
    pub fn global(code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic { code, severity: Severity::Error, message: message.into(), labels: Vec::new(), help: None }
    }

    /// "`what` is not supported yet": for what is parsed and checked, but has no lowering yet.
    pub fn not_yet(code: &'static str, span: Span, what: impl std::fmt::Display) -> Self {
        Diagnostic::error(code, span, format!("{what} is not supported yet"))
    }

    /// Adds a second place.
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Sets the words at the primary place.
    pub fn here(mut self, text: impl Into<String>) -> Self {
        if let Some(first) = self.labels.first_mut() {
            first.text = text.into();
        }
        self
    }

    /// Adds advice.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Whether it stops the compilation.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

/// The plain text form of diagnostics, as tests and logs show it.
pub fn render_plain(sources: &SourceMap, diagnostics: &[Diagnostic]) -> String {
    let mut out = String::new();
    for d in diagnostics {
        let severity = if d.is_error() { "error" } else { "warning" };
        let place = d.labels.first().map(|l| (l, sources.locate(l.span)));
        if let Some((_, at)) = &place {
            let _ = write!(out, "{}:{}:{}: ", at.file, at.line, at.column);
        }
        let _ = writeln!(out, "{severity}[{}]: {}", d.code, d.message);
        if let Some((label, at)) = place {
            let line = sources.line_text(label.span.file, sources.line(label.span));
            let room = line.chars().count().saturating_sub(at.column as usize - 1).max(1);
            let width = ((label.span.end.saturating_sub(label.span.start)) as usize).clamp(1, room);
            let pad = " ".repeat(at.column as usize - 1);
            let _ =
                writeln!(out, "    {line}\n    {}", format!("{pad}{} {}", "^".repeat(width), label.text).trim_end());
        }
        for label in d.labels.iter().skip(1) {
            let at = sources.locate(label.span);
            let _ = writeln!(out, "  note: {}:{}:{}: {}", at.file, at.line, at.column, label.text);
        }
        if let Some(help) = &d.help {
            let _ = writeln!(out, "  help: {help}");
        }
    }
    out
}
