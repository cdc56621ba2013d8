//! Source files and positions in them.
//!
//! In: the text of every file that a compilation reads. Out: [`Span`]s that name bytes of those files, and the lookup
//! from a span to file, line and column. Knows nothing of tokens or syntax.

use std::sync::Arc;

/// Handle of a file in a [`SourceMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// A half-open byte range `start..end` of one source file, as the user wrote it (before preprocessing).
///
/// What comes from a macro carries the span of the macro's use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The smallest span that holds both; `self` when they lie in different files.
    pub fn to(self, other: Span) -> Span {
        if self.file != other.file {
            return self;
        }
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// One file: its name as the user or an `#include` gave it, and its text.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Path or a name such as `<stdosl.h>`.
    pub name: String,
    /// The whole text.
    pub text: Arc<str>,
    /// The `#include` that brought it in.
    pub included_at: Option<Span>,
    line_starts: Vec<u32>,
    /// For compiled files: which file and line their bytes came from, ascending by the first byte.
    origins: Vec<(u32, Arc<str>, u32)>,
    /// What `#line` says, ascending: from which line on lines count from what, in a file of what name.
    renumbered: Vec<(u32, u32, Arc<str>)>,
}

/// A position for people: lines and columns count from 1, columns in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// File name.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// All files of one compilation.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
}

impl SourceMap {
    /// Adds a file and returns its handle.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> FileId {
        let text = text.into();
        let line_starts = std::iter::once(0)
            .chain(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i as u32 + 1))
            .collect();
        let (origins, renumbered) = (Vec::new(), Vec::new());
        self.files.push(SourceFile { name: name.into(), text, included_at: None, line_starts, origins, renumbered });
        FileId(self.files.len() as u32 - 1)
    }

    /// Adds a file that the `#include` at `span` asks for.
    pub fn add_included(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>, span: Span) -> FileId {
        let id = self.add(name, text);
        self.files[id.0 as usize].included_at = Some(span);
        id
    }

    /// Adds all files of another map; their handles grow by what is returned.
    pub fn append(&mut self, other: &SourceMap) -> u32 {
        let by = self.files.len() as u32;
        for file in &other.files {
            let mut file = file.clone();
            if let Some(span) = &mut file.included_at {
                span.file.0 += by;
            }
            self.files.push(file);
        }
        by
    }

    /// Tells what file and line the bytes of a compiled file came from: a list that ascends by the first byte.
    pub fn set_origins(&mut self, id: FileId, origins: Vec<(u32, Arc<str>, u32)>) {
        self.files[id.0 as usize].origins = origins;
    }

    /// The file and line that a place in a compiled file came from.
    pub fn origin(&self, span: Span) -> Option<(&str, u32)> {
        let origins = &self.file(span.file).origins;
        let (_, file, line) = &origins[origins.partition_point(|o| o.0 <= span.start).checked_sub(1)?];
        (*line > 0).then_some((file, *line))
    }

    /// The line behind the end of `span` counts as line `line` of the file `name`, or of the one that lines already count to.
    pub fn renumber(&mut self, span: Span, line: u32, name: Option<&str>) {
        let (shown, _) = self.shown(span);
        let last = self.file(span.file).line_starts.partition_point(|&s| s < span.end) as u32;
        let entry = (last + 1, line, name.unwrap_or(shown).into());
        self.files[span.file.0 as usize].renumbered.push(entry);
    }

    /// Whether `#line` directives give lines of a file other numbers.
    pub fn is_renumbered(&self, id: FileId) -> bool {
        !self.file(id).renumbered.is_empty()
    }

    /// File and line (from 1) where a span starts: of a compiled file those that it came from, of others as [`SourceMap::shown`].
    pub fn place(&self, span: Span) -> (&str, u32) {
        self.origin(span).unwrap_or_else(|| self.shown(span))
    }

    /// The file and line (from 1) where a span starts, as people should be told: `#line` directives are followed.
    pub fn shown(&self, span: Span) -> (&str, u32) {
        let (file, line) = (self.file(span.file), self.line(span));
        let last = file.renumbered.partition_point(|(from, ..)| *from <= line).checked_sub(1);
        match last.map(|i| &file.renumbered[i]) {
            Some((from, number, name)) => (name, number.saturating_add(line - from)),
            None => (&file.name, line),
        }
    }

    /// The `#include`s that lead to a place, innermost first.
    pub fn includers(&self, span: Span) -> impl Iterator<Item = Span> {
        std::iter::successors(self.file(span.file).included_at, |s| self.file(s.file).included_at)
    }

    /// The file behind a handle of this map.
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// Number of files.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Whether no file was added yet.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// The names of all files, the main one first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|f| f.name.as_str())
    }

    /// The text of a line (from 1) of the first file with this name; empty when there is none.
    pub fn line_of(&self, name: &str, line: u32) -> &str {
        match self.files.iter().position(|f| f.name == name) {
            Some(index) if line > 0 => self.line_text(FileId(index as u32), line),
            _ => "",
        }
    }

    /// Where a span starts, as people should be told.
    pub fn locate(&self, span: Span) -> Location {
        let file = self.file(span.file);
        let (shown, number) = self.shown(span);
        let line = file.line_starts.partition_point(|&s| s <= span.start) - 1;
        let start = file.line_starts[line] as usize;
        let end = (span.start as usize).min(file.text.len());
        let column = file.text.get(start..end).map_or(0, |t| t.chars().count());
        Location { file: shown.to_owned(), line: number, column: column as u32 + 1 }
    }

    /// The line, from 1, on which a span starts in its file, whatever `#line` says.
    pub fn line(&self, span: Span) -> u32 {
        self.file(span.file).line_starts.partition_point(|&s| s <= span.start) as u32
    }

    /// The text of the line (from 1) of a file, without its end; empty when there is no such line.
    pub fn line_text(&self, id: FileId, line: u32) -> &str {
        let file = self.file(id);
        let Some(&start) = file.line_starts.get(line as usize - 1) else { return "" };
        file.text[start as usize..].lines().next().unwrap_or("")
    }
}
