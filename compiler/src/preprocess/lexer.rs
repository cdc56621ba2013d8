//! Cuts one file into preprocessing tokens, lazily. Comments and joined lines become white space.

use crate::diag::Diagnostic;
use crate::source::{FileId, Span};
use std::rc::Rc;
use std::sync::Arc;

/// What a token is, as far as the preprocessor cares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Ident,
    Number,
    Str,
    /// `'a'`: a value in `#if`, an error of the parser elsewhere.
    Char,
    Punct,
    /// End of a line that is not joined.
    Newline,
    /// End of the file.
    End,
}

/// The spelling: a piece of a source file, or made by `#`, `##` or the compiler.
#[derive(Clone, Debug)]
pub(super) enum Text {
    Piece { file: Rc<FileText>, start: u32, end: u32 },
    Made(Rc<str>),
}

/// A file's text with its handle, shared by its tokens.
#[derive(Debug)]
pub(super) struct FileText {
    pub id: FileId,
    pub text: Arc<str>,
}

/// A preprocessing token.
#[derive(Clone, Debug)]
pub(super) struct Token {
    pub kind: Kind,
    pub text: Text,
    /// Where the user sees it: for macro output the macro's use.
    pub span: Span,
    /// White space (or a comment) stood before it.
    pub spaced: bool,
    /// Came out of its own macro: never expanded again.
    pub painted: bool,
}

impl Token {
    pub fn str(&self) -> &str {
        match &self.text {
            Text::Piece { file, start, end } => &file.text[*start as usize..*end as usize],
            Text::Made(s) => s,
        }
    }

    pub fn is(&self, punct: &str) -> bool {
        self.kind == Kind::Punct && self.str() == punct
    }

    pub fn made(kind: Kind, text: &str, span: Span) -> Token {
        Token { kind, text: Text::Made(text.into()), span, spaced: false, painted: false }
    }
}

/// Walks over a file.
pub(super) struct Lexer {
    pub file: Rc<FileText>,
    at: usize,
    /// Findings, taken by the owner.
    pub problems: Vec<Diagnostic>,
    /// In skipped groups a stray quote is no error.
    pub lenient: bool,
}

/// Punctuators of more than one byte that matter to OSL or to `#if`, longest first.
const LONG: [&str; 26] = [
    "...", "[[", "]]", "<<=", ">>=", "##", "&&", "||", "==", "!=", "<=", ">=", "<<", ">>", "++", "--", "+=", "-=",
    "*=", "/=", "%=", "&=", "|=", "^=", "->", "::",
];

impl Lexer {
    pub fn new(file: Rc<FileText>) -> Lexer {
        Lexer { file, at: 0, problems: Vec::new(), lenient: false }
    }

    pub fn span(&self, start: usize, end: usize) -> Span {
        Span { file: self.file.id, start: start as u32, end: end as u32 }
    }

    fn rest(&self) -> &[u8] {
        &self.file.text.as_bytes()[self.at..]
    }

    /// Length of a backslash-newline here, or 0.
    fn splice(&self) -> usize {
        match self.rest() {
            [b'\\', b'\n', ..] => 2,
            [b'\\', b'\r', b'\n', ..] => 3,
            _ => 0,
        }
    }

    /// Skips blanks, joined lines and comments; true when there were any.
    fn skip_space(&mut self) -> bool {
        let start = self.at;
        loop {
            let splice = self.splice();
            if splice > 0 {
                self.at += splice;
                continue;
            }
            match self.rest() {
                [b' ' | b'\t' | 0x0b | 0x0c | b'\r', ..] => self.at += 1,
                [b'/', b'/', ..] => self.skip_line_comment(),
                [b'/', b'*', ..] => match self.file.text[self.at + 2..].find("*/") {
                    Some(n) => self.at += n + 4,
                    None => {
                        let span = self.span(self.at, self.at + 2);
                        self.problems
                            .push(Diagnostic::error("E0005", span, "this comment is never closed").help("add `*/`"));
                        self.at = self.file.text.len();
                    }
                },
                _ => return self.at > start,
            }
        }
    }

    fn skip_line_comment(&mut self) {
        loop {
            let Some(n) = self.rest().iter().position(|&b| b == b'\n') else {
                self.at = self.file.text.len();
                return;
            };
            let line = &self.rest()[..n];
            let joined = line.ends_with(b"\\") || line.ends_with(b"\\\r");
            self.at += n;
            if !joined {
                return;
            }
            self.at += 1;
        }
    }

    /// The next token; [`Kind::End`] for ever at the end.
    pub fn next(&mut self) -> Token {
        let spaced = self.skip_space();
        let start = self.at;
        let Some(&first) = self.rest().first() else { return self.token(Kind::End, start, spaced) };
        let kind = match first {
            b'\n' => {
                self.at += 1;
                Kind::Newline
            }
            b'a'..=b'z' | b'A'..=b'Z' | b'_' | 0x80.. => {
                self.take_while(|b| b.is_ascii_alphanumeric() || b == b'_' || b >= 0x80);
                Kind::Ident
            }
            b'0'..=b'9' => self.number(),
            b'.' if self.rest().get(1).is_some_and(u8::is_ascii_digit) => self.number(),
            b'"' => return self.string(spaced),
            b'\'' if self.character() > 0 => {
                self.at += self.character();
                Kind::Char
            }
            _ => {
                let long = LONG.iter().find(|p| self.rest().starts_with(p.as_bytes()));
                self.at += long.map_or(1, |p| p.len());
                Kind::Punct
            }
        };
        match kind {
            Kind::Ident | Kind::Number => self.joined(kind, start, spaced),
            _ => self.token(kind, start, spaced),
        }
    }

    /// A word that may go on behind a backslash-newline.
    fn joined(&mut self, kind: Kind, start: usize, spaced: bool) -> Token {
        let mut whole = String::new();
        let mut piece = start;
        loop {
            let splice = self.splice();
            let goes_on = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | 0x80..);
            let mine = |b: &u8| goes_on(b) || kind == Kind::Number && *b == b'.';
            if splice == 0 || !self.rest().get(splice).is_some_and(mine) {
                break;
            }
            whole.push_str(&self.file.text[piece..self.at]);
            self.at += splice;
            piece = self.at;
            self.take_while(|b| mine(&b));
        }
        let mut token = self.token(kind, start, spaced);
        if piece != start {
            whole.push_str(&self.file.text[piece..self.at]);
            token.text = Text::Made(whole.into());
        }
        token
    }

    fn token(&self, kind: Kind, start: usize, spaced: bool) -> Token {
        let text = Text::Piece { file: self.file.clone(), start: start as u32, end: self.at as u32 };
        Token { kind, text, span: self.span(start, self.at), spaced, painted: false }
    }

    fn take_while(&mut self, f: impl Fn(u8) -> bool) {
        self.at += self.rest().iter().take_while(|&&b| f(b)).count();
    }

    /// A preprocessing number (C11 6.4.8): digits, letters, dots, and signs after an exponent letter. The sign rule
    /// follows OSL's lexer in that hex digits take none, so that `0xe+1` is a sum.
    fn number(&mut self) -> Kind {
        let hex = matches!(self.rest(), [b'0', b'x' | b'X', ..]);
        loop {
            self.take_while(|b| b.is_ascii_alphanumeric() || b == b'.' || b == b'_');
            let exponent = !hex && matches!(self.file.text.as_bytes()[self.at - 1], b'e' | b'E');
            if exponent && matches!(self.rest().first(), Some(b'+' | b'-')) {
                self.at += 1;
            } else {
                return Kind::Number;
            }
        }
    }

    /// Length of a character constant here; 0 when there is only a lone quote.
    fn character(&self) -> usize {
        let text = &self.file.text[self.at + 1..];
        let escaped = text.starts_with('\\');
        let mut letters = text.char_indices().skip(if escaped { 1 } else { 0 });
        match (letters.next(), letters.next()) {
            (Some((_, c)), Some((end, '\''))) if c != '\n' && (escaped || c != '\'') => end + 2,
            _ => 0,
        }
    }

    fn string(&mut self, spaced: bool) -> Token {
        let start = self.at;
        let mut joined = String::new();
        let mut piece = start;
        self.at += 1;
        loop {
            let splice = self.splice();
            if splice > 0 {
                joined.push_str(&self.file.text[piece..self.at]);
                self.at += splice;
                piece = self.at;
                continue;
            }
            match self.rest() {
                [b'"', ..] => {
                    self.at += 1;
                    break;
                }
                // The escaped byte may start a longer character; its tail is taken as ordinary bytes.
                [b'\\', next, ..] if *next != b'\n' => self.at += if next.is_ascii() { 2 } else { 1 },
                [b'\n', ..] | [] => {
                    if !self.lenient {
                        let span = self.span(start, self.at);
                        let problem = Diagnostic::error("E0005", span, "this string is never closed").help("add `\"`");
                        self.problems.push(problem);
                    }
                    break;
                }
                _ => self.at += 1,
            }
        }
        let mut token = self.token(Kind::Str, start, spaced);
        if piece != start {
            joined.push_str(&self.file.text[piece..self.at]);
            token.text = Text::Made(joined.into());
        }
        token
    }
}
