//! Diagnostics for people: boxes and colours on a terminal, one plain block each elsewhere.
//!
//! In: the compiler's diagnostics and the sources that they point into. Out: text on standard error. It must not know which
//! command failed.

use super::sources::Folders;
use super::{Error, terminal};
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, Severity, SourceCode,
    SourceSpan, SpanContents,
};
use oslcl_compiler::diag::{self, Diagnostic};
use oslcl_compiler::source::{FileId, SourceMap, Span};
use oslcl_compiler::{Failure, Master, Options, Output};
use std::fmt::{self, Display};

/// Runs the front half of the compiler and shows its findings, warnings too.
pub fn master(text: &str, options: &Options, includes: &Folders) -> Result<Master, Error> {
    let master = checked(text, options, includes)?;
    show(master.sources(), master.warnings());
    Ok(master)
}

/// Runs the front half of the compiler and shows its errors.
pub fn checked(text: &str, options: &Options, includes: &Folders) -> Result<Master, Error> {
    Master::new(text, options, includes).map_err(|failure| {
        let error = report(&failure);
        for refused in includes.refused() {
            terminal::say(&format!("  note: {refused}\n"));
        }
        error
    })
}

/// Runs the back half of the compiler and shows its findings, warnings too.
pub fn instance(master: &Master, options: &Options) -> Result<Output, Error> {
    let output = master.instance(options).map_err(|failure| report(&failure))?;
    // Those of the front half come first and were shown.
    show(&output.sources, &output.warnings[master.warnings().len().min(output.warnings.len())..]);
    Ok(output)
}

/// Shows a failure.
pub fn report(failure: &Failure) -> Error {
    show(&failure.sources, &failure.diagnostics);
    Error::Reported
}

/// Shows diagnostics.
pub fn show(sources: &SourceMap, diagnostics: &[Diagnostic]) {
    terminal::say(&rendered(sources, diagnostics));
}

/// Diagnostics as they are shown.
pub fn rendered(sources: &SourceMap, diagnostics: &[Diagnostic]) -> String {
    if terminal::is_fancy() {
        fancy(sources, diagnostics, GraphicalTheme::unicode())
    } else {
        plain(sources, diagnostics)
    }
}

/// The file that a diagnostic without a place is about, as a prefix of its message.
fn about(sources: &SourceMap, diagnostic: &Diagnostic) -> String {
    if !diagnostic.labels.is_empty() || sources.is_empty() {
        return String::new();
    }
    format!("{}: ", sources.file(FileId(0)).name)
}

fn plain(sources: &SourceMap, diagnostics: &[Diagnostic]) -> String {
    let one = |d| about(sources, d) + &diag::render_plain(sources, std::slice::from_ref(d));
    diagnostics.iter().map(one).collect()
}

fn fancy(sources: &SourceMap, diagnostics: &[Diagnostic], theme: GraphicalTheme) -> String {
    let handler = GraphicalReportHandler::new_themed(theme);
    let mut out = String::new();
    for diagnostic in diagnostics {
        // Rendering fails only for labels outside their source; then the plain form still says it all.
        if handler.render_report(&mut out, &Report::new(sources, diagnostic)).is_err() {
            out.push_str(&plain(sources, std::slice::from_ref(diagnostic)));
        }
    }
    out
}

/// A diagnostic as miette takes it. Labels in other files than the first one's are reports of their own, below it.
#[derive(Debug)]
struct Report {
    message: String,
    code: Option<&'static str>,
    severity: Severity,
    help: Option<String>,
    source: Option<Source>,
    labels: Vec<LabeledSpan>,
    elsewhere: Vec<Report>,
}

impl Report {
    fn new(sources: &SourceMap, d: &Diagnostic) -> Report {
        let file = d.labels.first().map(|l| l.span.file);
        let mut labels = Vec::new();
        let mut elsewhere = Vec::new();
        for (index, label) in d.labels.iter().enumerate() {
            let text = (!label.text.is_empty()).then(|| label.text.clone());
            if Some(label.span.file) != file {
                elsewhere.push(Report {
                    message: label.text.clone(),
                    code: None,
                    severity: Severity::Advice,
                    help: None,
                    source: Some(Source::of(sources, label.span)),
                    labels: vec![labelled(sources, label.span, None, true)],
                    elsewhere: Vec::new(),
                });
            } else {
                labels.push(labelled(sources, label.span, text, index == 0));
            }
        }
        let severity = if d.is_error() { Severity::Error } else { Severity::Warning };
        Report {
            message: about(sources, d) + &d.message,
            code: Some(d.code),
            severity,
            help: d.help.clone(),
            source: d.labels.first().map(|l| Source::of(sources, l.span)),
            labels,
            elsewhere,
        }
    }
}

/// A file's text, with the name and the lines that `#line` gives it where a label stands.
#[derive(Debug)]
struct Source {
    name: String,
    text: String,
    /// The label's line, and what it counts as.
    line: (usize, usize),
}

impl Source {
    fn of(sources: &SourceMap, span: Span) -> Source {
        let (name, line) = sources.shown(span);
        let text = sources.file(span.file).text.to_string();
        Source { name: name.to_owned(), text, line: (sources.line(span) as usize, line as usize) }
    }
}

impl SourceCode for Source {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        // Before line 1 there is none, whatever stands before the `#line`.
        let shown = before.min(self.line.1.saturating_sub(1));
        let found = if shown > 0 || before == 0 {
            self.text.read_span(span, shown, after)?
        } else {
            let before_it = self.text.get(..span.offset()).unwrap_or_default();
            let start = before_it.rfind('\n').map_or(0, |at| at + 1);
            let line = SourceSpan::from((start, span.offset() + span.len() - start));
            self.text.read_span(&line, 0, after)?
        };
        let line = (found.line() + self.line.1).saturating_sub(self.line.0);
        let (data, at) = (found.data(), *found.span());
        let (name, column, lines) = (self.name.clone(), found.column(), found.line_count());
        Ok(Box::new(MietteSpanContents::new_named(name, data, at, line, column, lines)))
    }
}

/// A label that lies inside its source: what is missing at the end is shown on the last character.
fn labelled(sources: &SourceMap, span: Span, text: Option<String>, primary: bool) -> LabeledSpan {
    let length = sources.file(span.file).text.len();
    let start = (span.start as usize).min(length.saturating_sub(1));
    let end = (span.end as usize).clamp(start, length);
    let at = (start, end - start);
    if primary { LabeledSpan::new_primary_with_span(text, at) } else { LabeledSpan::new_with_span(text, at) }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Report {}

impl miette::Diagnostic for Report {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.code.map(|c| Box::new(c) as Box<dyn Display>)
    }

    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|s| s as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(self.labels.iter().cloned()))
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn miette::Diagnostic> + 'a>> {
        Some(Box::new(self.elsewhere.iter().map(|r| r as &dyn miette::Diagnostic)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_show_file_line_code_and_help() {
        let mut sources = SourceMap::default();
        let main = sources.add("a.osl", "surface a()\n{\n  foo();\n}");
        let header = sources.add("b.h", "int foo;");
        let at = |file, start, end| Span { file, start, end };
        let d = Diagnostic::error("E2001", at(main, 16, 19), "no function `foo`")
            .here("called here")
            .label(at(header, 4, 7), "a variable of this name")
            .help("spell it right");
        let text = fancy(&sources, &[d], GraphicalTheme::unicode_nocolor());
        for part in ["E2001", "no function `foo`", "a.osl:3:3", "called here", "b.h", "a variable", "spell it right"] {
            assert!(text.contains(part), "`{part}` is not in:\n{text}");
        }
    }

    #[test]
    fn a_label_behind_the_end_is_shown() {
        let mut sources = SourceMap::default();
        for source in ["", "x", "x\n"] {
            let file = sources.add("a.osl", source);
            let end = source.len() as u32;
            let d = Diagnostic::error("E1001", Span { file, start: end, end: end + 1 }, "something is missing");
            let text = fancy(&sources, &[d], GraphicalTheme::unicode_nocolor());
            assert!(text.contains("something is missing"), "{text}");
        }
    }
}
