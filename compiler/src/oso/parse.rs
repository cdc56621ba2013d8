//! Reads the text of an `.oso` file.
//!
//! In: text. Out: a [`Module`] whose symbols are bound and whose jumps are checked to lie in their section, or located errors.
//! It must not know what operations mean.

use super::{
    Access, Element, Hint, HintArg, Literal, MAGIC, MAIN, MAX_OPS, Module, Op, SymId, SymType, Symbol, SymbolKind,
};
use crate::diag::Diagnostic;
use crate::escape::unescape;
use crate::source::{FileId, Span};
use crate::types::{Base, Extent};
use std::collections::HashMap;

/// Most symbols and array elements: more is taken for a mistake.
const MAX_ITEMS: usize = 4_000_000;

/// Reads a file; `file` is its handle in a source map, for the errors.
pub fn parse(text: &str, file: FileId) -> Result<Module, Vec<Diagnostic>> {
    let mut parser = Parser {
        file,
        module: Module {
            comments: Vec::new(),
            kind: String::new(),
            name: String::new(),
            hints: Vec::new(),
            symbols: Vec::new(),
            sections: Vec::new(),
            ops: Vec::new(),
            files: Vec::new(),
        },
        names: HashMap::new(),
        state: State::Version,
        at: (None, 0),
        errors: Vec::new(),
    };
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let span = Span { file, start: start as u32, end: (start + line.trim_end().len()) as u32 };
        parser.line(line.trim_end(), span);
        start += line.len();
        if parser.errors.len() >= 20 || matches!(parser.state, State::Ended) {
            break;
        }
    }
    parser.finish(text.len() as u32)
}

enum State {
    Version,
    Shader,
    Symbols,
    Code,
    Ended,
}

struct Parser {
    file: FileId,
    module: Module,
    names: HashMap<String, SymId>,
    state: State,
    /// File and line that the next operation has, unless it says something else.
    at: (Option<u32>, u32),
    errors: Vec<Diagnostic>,
}

/// A token of a line.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Value(Literal),
    Hint(Hint),
}

impl Parser {
    fn error(&mut self, span: Span, message: impl Into<String>) {
        self.errors.push(Diagnostic::error("E5001", span, message));
    }

    fn line(&mut self, line: &str, span: Span) {
        let bare = line.trim_start();
        if bare.is_empty() {
            return;
        }
        if let Some(comment) = bare.strip_prefix('#') {
            if matches!(self.state, State::Shader) {
                self.module.comments.push(comment.trim().to_owned());
            }
            return;
        }
        if let State::Version = self.state {
            return self.version(bare, span);
        }
        if bare == "%preprocessed_source" {
            self.state = State::Ended;
            return;
        }
        let tokens = match tokens(line, span) {
            Ok(tokens) => tokens,
            Err(d) => return self.errors.push(*d),
        };
        match self.state {
            State::Shader => self.shader(tokens, span),
            State::Symbols | State::Code => match tokens.first() {
                Some(Token::Word(w)) if w == "code" => self.section(&tokens, span),
                _ if matches!(self.state, State::Symbols) => self.symbol(tokens, span),
                _ => self.operation(tokens, span),
            },
            State::Version | State::Ended => {}
        }
    }

    fn version(&mut self, line: &str, span: Span) {
        let line = line.strip_prefix('\u{feff}').unwrap_or(line);
        self.state = State::Shader;
        let mut words = line.split_whitespace();
        if words.next() != Some(MAGIC) {
            return self.error(span, format!("this is no .oso file: its first line does not start with `{MAGIC}`"));
        }
        match words.next().and_then(|v| v.parse::<f64>().ok()) {
            Some(version) if (1.0..2.0).contains(&version) => {}
            Some(version) => self.error(span, format!("version {version} of the .oso format is not known (1.x is)")),
            None => self.error(span, "the version of the .oso format is missing"),
        }
    }

    fn shader(&mut self, tokens: Vec<Token>, span: Span) {
        self.state = State::Symbols;
        let mut tokens = tokens.into_iter();
        match (tokens.next(), tokens.next()) {
            (Some(Token::Word(kind)), Some(Token::Word(name))) => {
                self.module.kind = kind;
                self.module.name = name;
            }
            _ => return self.error(span, "expected the shader's kind and name, such as `surface chalk`"),
        }
        for token in tokens {
            match token {
                Token::Hint(h) => self.module.hints.push(h),
                _ => return self.error(span, "only hints may follow the shader's name"),
            }
        }
    }

    fn symbol(&mut self, tokens: Vec<Token>, span: Span) {
        let mut tokens = tokens.into_iter().peekable();
        let word = |t: Option<Token>| match t {
            Some(Token::Word(w)) => Some(w),
            _ => None,
        };
        let first = word(tokens.next()).unwrap_or_default();
        let Some((kind, _)) = SymbolKind::ALL.into_iter().find(|(_, w)| *w == first) else {
            return self.error(span, format!("`{first}` is no kind of symbol"));
        };
        let mut spelling = word(tokens.next()).unwrap_or_default();
        let mut element = None;
        if spelling == "struct" {
            let written = word(tokens.next()).unwrap_or_default();
            let (name, rest) = written.split_at(written.find('[').unwrap_or(written.len()));
            element = Some(Element::Struct(name.to_owned()));
            spelling = rest.to_owned();
        } else if spelling == "closure" {
            spelling = word(tokens.next()).unwrap_or_default();
            let rest = spelling.find('[').map_or("", |i| &spelling[i..]).to_owned();
            element = Some(Element::Base(Base::Closure));
            spelling = rest;
        }
        let ty = match (element, sym_type(&spelling)) {
            (None, Ok(ty)) => ty,
            (Some(element), _) => match extent_of(&spelling) {
                Ok(extent) => SymType { element, extent },
                Err(message) => return self.error(span, message),
            },
            (None, Err(message)) => return self.error(span, message),
        };
        let Some(name) = word(tokens.next()).filter(|n| !n.is_empty()) else {
            return self.error(span, "this symbol has no name");
        };
        let mut values = Vec::new();
        let mut hints = Vec::new();
        for token in tokens {
            match token {
                Token::Value(v) if hints.is_empty() => values.push(v),
                Token::Hint(h) => hints.push(h),
                _ => return self.error(span, format!("symbol `{name}`: only values, then hints may follow its name")),
            }
        }
        if let Some(message) = misfit(&ty, &values) {
            return self.error(span, format!("symbol `{name}`: {message}"));
        }
        let uses = [uses(&mut hints, "read"), uses(&mut hints, "write")];
        let id = SymId(self.module.symbols.len() as u32);
        if self.names.insert(name.clone(), id).is_some() {
            return self.error(span, format!("two symbols are called `{name}`"));
        }
        if self.module.symbols.len() >= MAX_ITEMS {
            return self.error(span, "too many symbols");
        }
        self.module.symbols.push(Symbol { kind, ty, name, values, hints, uses, span });
    }

    fn section(&mut self, tokens: &[Token], span: Span) {
        self.state = State::Code;
        self.at = (None, 0);
        let [_, Token::Word(name)] = tokens else {
            return self.error(span, "expected `code` and the name of a parameter or `___main___`");
        };
        let known = self.names.get(name).is_some_and(|id| self.module.symbol(*id).kind.is_param());
        if name != MAIN && !known {
            self.error(span, format!("`{name}` is no parameter and can have no code"));
        }
        if self.module.sections.iter().any(|(n, _)| n == name) {
            self.error(span, format!("there are two code sections `{name}`"));
        }
        self.module.sections.push((name.clone(), self.module.ops.len() as u32));
    }

    fn operation(&mut self, tokens: Vec<Token>, span: Span) {
        let mut tokens = tokens.into_iter().peekable();
        // A label, `12:`, tells what is known.
        if let Some(Token::Word(w)) = tokens.peek()
            && w.strip_suffix(':').is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit()))
        {
            tokens.next();
        }
        let Some(Token::Word(name)) = tokens.next() else {
            return self.error(span, "expected the name of an operation");
        };
        let mut op = Op {
            name,
            args: Vec::new(),
            jumps: Vec::new(),
            access: Vec::new(),
            derivs: Vec::new(),
            section: (self.module.sections.len().max(1) - 1) as u32,
            at: None,
            span,
        };
        for token in tokens {
            match token {
                Token::Word(arg) if op.jumps.is_empty() => match self.names.get(&arg) {
                    Some(id) => op.args.push(*id),
                    None => return self.error(span, format!("`{}`: there is no symbol `{arg}`", op.name)),
                },
                Token::Value(Literal::Int(target)) if target >= 0 => op.jumps.push(target as u32),
                Token::Hint(h) => self.op_hint(&mut op, &h),
                _ => {
                    return self.error(span, format!("`{}`: symbols, jump targets and hints may follow it", op.name));
                }
            }
        }
        op.at = self.at.0.map(|file| (file, self.at.1));
        if op.access.len() != op.args.len() {
            op.access.clear();
        }
        if self.module.ops.len() >= MAX_OPS {
            return self.error(span, format!("more than {MAX_OPS} operations"));
        }
        self.module.ops.push(op);
    }

    fn op_hint(&mut self, op: &mut Op, hint: &Hint) {
        let first = hint.args.first().map_or("", HintArg::text);
        match hint.name.as_str() {
            "filename" => {
                let index = match self.module.files.iter().position(|f| f == first) {
                    Some(index) => index,
                    None => {
                        self.module.files.push(first.to_owned());
                        self.module.files.len() - 1
                    }
                };
                self.at.0 = Some(index as u32);
            }
            "line" => self.at.1 = first.parse().unwrap_or(0),
            "argrw" => {
                let access = |c| match c {
                    'w' => Access::Write,
                    'W' => Access::Both,
                    _ => Access::Read,
                };
                op.access = first.chars().map(access).collect();
            }
            "argderivs" => op.derivs = hint.args.iter().filter_map(|a| a.text().parse().ok()).collect(),
            _ => {}
        }
    }

    fn finish(mut self, end: u32) -> Result<Module, Vec<Diagnostic>> {
        if self.errors.is_empty() {
            let span = Span { file: self.file, start: end, end };
            match self.state {
                State::Version => self.error(span, "this is no .oso file: it is empty"),
                State::Shader => self.error(span, "the file ends before the shader's kind and name"),
                State::Symbols => self.error(span, "the file ends before its code: it was cut off"),
                State::Code | State::Ended => {}
            }
        }
        // Sections hold their jumps: a target is an operation of the same section, or its end.
        for index in 0..self.module.sections.len() {
            let range = self.module.section(index);
            for i in range.clone() {
                let op = &self.module.ops[i];
                let good = |j: &u32| (i + 1..=range.end).contains(&(*j as usize));
                if !op.jumps.iter().all(good) {
                    let (span, message) =
                        (op.span, format!("`{}`: a jump target lies outside of what it can reach", op.name));
                    self.error(span, message);
                }
            }
        }
        if self.errors.is_empty() { Ok(self.module) } else { Err(self.errors) }
    }
}

fn uses(hints: &mut Vec<Hint>, name: &str) -> Option<(u32, u32)> {
    let index = hints.iter().position(|h| h.name == name)?;
    let hint = hints.remove(index);
    let number = |i: usize| hint.args.get(i).and_then(|a| a.text().parse::<u32>().ok());
    Some((number(0)?, number(1)?))
}

/// The type that a word such as `float[4]` spells.
pub(super) fn sym_type(spelling: &str) -> Result<SymType, String> {
    let (name, rest) = spelling.split_at(spelling.find('[').unwrap_or(spelling.len()));
    let base = match name {
        "int" => Base::Int,
        "float" => Base::Float,
        "color" => Base::Color,
        "point" => Base::Point,
        "vector" => Base::Vector,
        "normal" => Base::Normal,
        "matrix" => Base::Matrix,
        "string" => Base::String,
        "void" => Base::Void,
        _ => return Err(format!("`{name}` is no type")),
    };
    Ok(SymType { element: Element::Base(base), extent: extent_of(rest)? })
}

fn extent_of(text: &str) -> Result<Extent, String> {
    match text {
        "" => Ok(Extent::Scalar),
        "[]" => Ok(Extent::Unsized),
        _ => match text.strip_prefix('[').and_then(|t| t.strip_suffix(']')).map(str::parse::<u32>) {
            Some(Ok(n)) if n >= 1 && n as usize <= MAX_ITEMS => Ok(Extent::Fixed(n)),
            _ => Err(format!("`{text}` is no array length")),
        },
    }
}

/// Why values do not fit a type.
fn misfit(ty: &SymType, values: &[Literal]) -> Option<String> {
    let elements = match ty.extent {
        Extent::Scalar => 1,
        Extent::Fixed(n) => n as usize,
        Extent::Unsized => values.len(),
    };
    if values.len() > elements * ty.components() {
        return Some(format!("{} has no room for {} values", ty.spelling(), values.len()));
    }
    let fits = |v: &Literal| match (ty.base(), v) {
        (Some(Base::String), Literal::Str(_)) | (Some(Base::Int), Literal::Int(_)) => true,
        (Some(Base::Closure), Literal::Int(_)) | (None, _) => true,
        (Some(Base::String | Base::Int | Base::Closure | Base::Void), _) | (_, Literal::Str(_)) => false,
        _ => true,
    };
    if values.iter().all(fits) { None } else { Some(format!("a value does not fit {}", ty.spelling())) }
}

/// Splits a line. Words are anything between blanks that is no number, string or hint.
fn tokens(line: &str, span: Span) -> Result<Vec<Token>, Box<Diagnostic>> {
    let mut out = Vec::new();
    let bytes = line.as_bytes();
    let mut i = 0;
    let wrong = |at: usize, message: &str| {
        let place = Span { start: span.start + at as u32, end: span.end.max(span.start + at as u32), ..span };
        Box::new(Diagnostic::error("E5001", place, message))
    };
    while i < bytes.len() {
        match bytes[i] {
            b if b.is_ascii_whitespace() || b == 0x0b => i += 1,
            b'#' => break,
            b'"' => {
                let (text, next) = string(line, i).ok_or_else(|| wrong(i, "a string that is never closed"))?;
                out.push(Token::Value(Literal::Str(text)));
                i = next;
            }
            b'%' => {
                let (hint, next) = hint(line, i).ok_or_else(|| wrong(i, "a hint that is never closed"))?;
                out.push(Token::Hint(hint));
                i = next;
            }
            _ => {
                let rest = &line[i..];
                let end = rest.find(|c: char| c.is_ascii_whitespace() || c == '\u{b}').unwrap_or(rest.len());
                let word = &rest[..end];
                out.push(match literal(word) {
                    Some(v) => Token::Value(v),
                    None => Token::Word(word.to_owned()),
                });
                i += end;
            }
        }
    }
    Ok(out)
}

/// A number.
pub(super) fn literal(word: &str) -> Option<Literal> {
    let digits = word.strip_prefix(['-', '+']).unwrap_or(word);
    if !digits.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return None;
    }
    if digits.bytes().all(|b| b.is_ascii_digit()) {
        let wide = word.parse::<i64>().ok();
        return Some(
            wide.and_then(|w| i32::try_from(w).ok())
                .map_or_else(|| Literal::Float(word.parse().unwrap_or(0.0)), Literal::Int),
        );
    }
    word.parse().ok().map(Literal::Float)
}

/// The string that starts at a quote, and where it ends.
fn string(line: &str, start: usize) -> Option<(String, usize)> {
    let bytes = line.as_bytes();
    let mut i = start + 1;
    while i < bytes.len() {
        match bytes[i] {
            b'\\' => i += 2,
            b'"' => return Some((unescape(&line[start + 1..i]), i + 1)),
            _ => i += 1,
        }
    }
    None
}

fn hint(line: &str, start: usize) -> Option<(Hint, usize)> {
    let rest = &line[start + 1..];
    let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
    let mut hint = Hint { name: rest[..length].to_owned(), args: Vec::new() };
    let mut i = start + 1 + length;
    if line.as_bytes().get(i) != Some(&b'{') {
        return Some((hint, i));
    }
    i += 1;
    loop {
        match line.as_bytes().get(i)? {
            b'}' => return Some((hint, i + 1)),
            b',' | b' ' | b'\t' => i += 1,
            b'"' => {
                let (text, next) = string(line, i)?;
                hint.args.push(HintArg::Str(text));
                i = next;
            }
            _ => {
                let rest = &line[i..];
                let end = rest.find([',', '}', '"'])?;
                hint.args.push(HintArg::Word(rest[..end].trim().to_owned()));
                i += end;
            }
        }
    }
}
