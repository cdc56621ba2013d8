//! Shader groups as text (specification ch. 9), such as
//! `param float Kd 0.8; shader matte layer1; connect noise1.out layer1.Cs;`.
//!
//! In: text, and who finds shaders by name. Out: a [`Group`], or a [`TextError`] with its place; and a group's text.

use super::{Binding, Bound, Group, Layer, Master};
use crate::passes::link::{Connection, Hints};
use std::fmt;
use std::fmt::Write as _;
use std::sync::Arc;

/// What is wrong with a group's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextError {
    /// From 1.
    pub line: usize,
    /// In characters, from 1.
    pub column: usize,
    /// A sentence without a final full stop.
    pub message: String,
    /// What the user can do, if we know.
    pub help: Option<String>,
}

impl fmt::Display for TextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for TextError {}

/// Why a text gives no group.
#[derive(Debug)]
pub enum ParseError<E> {
    /// The text is malformed.
    Text(TextError),
    /// A shader can't be had.
    Shader {
        /// Its name in the text.
        name: String,
        /// Line of the text, from 1.
        line: usize,
        /// The finder's own error.
        cause: E,
    },
}

/// A value for a parameter in a group's text.
type Pending = Vec<Bound>;

/// Largest array in a group's text: bounds what a short text can ask for.
const MAX_LENGTH: u32 = 1 << 20;

impl Group {
    /// Reads a group's text. Statements end with `;` or `,`; `#` starts a comment; values that are missing are 0 or `""`.
    /// Shaders without a layer name are named by their own and their number. `find` gives the shader of a name.
    pub fn parse<E>(
        name: &str,
        text: &str,
        find: &mut dyn FnMut(&str) -> Result<Arc<Master>, E>,
    ) -> Result<Group, ParseError<E>> {
        let mut group = Group { name: name.to_owned(), ..Group::default() };
        let mut reader = Reader { text, tokens: tokens(text).map_err(ParseError::Text)?, at: 0 };
        let mut pending = Pending::new();
        let mut last = 0;
        while let Some(token) = reader.peek() {
            let (start, word) = (token.start, token.text.clone());
            last = start;
            match (token.kind, word.as_str()) {
                (Kind::End, _) => reader.at += 1,
                (Kind::Word, "shader") => {
                    reader.at += 1;
                    let shader = reader.need("the shader's name").map_err(ParseError::Text)?;
                    let layer = match reader.peek() {
                        Some(t) if t.kind != Kind::End => reader.need("the layer's name").map_err(ParseError::Text)?,
                        _ => String::new(),
                    };
                    reader.end("shader").map_err(ParseError::Text)?;
                    let line = reader.place(start).0;
                    let master =
                        find(&shader).map_err(|cause| ParseError::Shader { name: shader.clone(), line, cause })?;
                    let name =
                        if layer.is_empty() { format!("{}_{}", master.info().name, group.layers.len()) } else { layer };
                    group.layers.push(Layer { name, master, bindings: std::mem::take(&mut pending) });
                }
                (Kind::Word, "connect") => {
                    reader.at += 1;
                    let connection = reader.connection(&group).map_err(ParseError::Text)?;
                    group.connections.push(connection);
                }
                (Kind::Word, word) => {
                    let is_param = word == "param";
                    reader.at += usize::from(is_param);
                    if !is_param && width_of(word.split('[').next().unwrap_or(word)).is_none() {
                        let message = format!("`{word}` is none of `param`, `shader` and `connect`");
                        let near = crate::suggest::closest(word, ["param", "shader", "connect"].into_iter());
                        let help = near.map(|n| format!("did you mean `{n}`?"));
                        return Err(ParseError::Text(reader.error_at(start, message, help)));
                    }
                    pending.push(reader.param().map_err(ParseError::Text)?);
                }
                _ => {
                    let message = format!("expected `param`, `shader` or `connect`, found {}", token.show());
                    return Err(ParseError::Text(reader.error_at(start, message, None)));
                }
            }
        }
        if let Some(first) = pending.first() {
            let message = format!("parameter `{}` belongs to no shader", first.name);
            let help = Some("put `param` statements before the `shader` that they are for".to_owned());
            return Err(ParseError::Text(reader.error_at(last, message, help)));
        }
        if group.layers.is_empty() {
            return Err(ParseError::Text(reader.error_at(0, "there is no `shader` statement".to_owned(), None)));
        }
        Ok(group)
    }

    /// The group as text that [`Group::parse`] reads back.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for layer in &self.layers {
            for bound in &layer.bindings {
                let ty = layer.type_of(&bound.name, &bound.value);
                let _ = write!(out, "param {ty} {} {}", bound.name, values(&bound.value));
                let hints = [
                    (bound.hints.lockgeom == Some(false), "int lockgeom=0"),
                    (bound.hints.lockgeom == Some(true), "int lockgeom=1"),
                    (bound.hints.interpolated, "int interpolated=1"),
                    (bound.hints.interactive, "int interactive=1"),
                ];
                let hints: Vec<&str> = hints.iter().filter(|(on, _)| *on).map(|(_, text)| *text).collect();
                if !hints.is_empty() {
                    let _ = write!(out, " [[{}]]", hints.join(", "));
                }
                out.push_str(" ;\n");
            }
            let _ = writeln!(out, "shader {} {} ;", layer.master.info().name, layer.name);
        }
        for c in &self.connections {
            let _ = writeln!(out, "connect {}.{} {}.{} ;", c.from_layer, c.from, c.to_layer, c.to);
        }
        out
    }
}

impl Layer {
    /// The type of a flattened parameter in OSL's words; of one that the shader does not have, that of its value.
    fn type_of(&self, name: &str, value: &Binding) -> String {
        let params = &self.master.info().params;
        let plain = params.iter().find(|p| p.name == name && p.fields.is_empty()).map(|p| p.ty.clone());
        let field = || {
            let (root, rest) = name.split_once('.')?;
            let param = params.iter().find(|p| p.name == root)?;
            param.fields.iter().find(|f| f.name == rest).map(|f| f.ty.clone())
        };
        plain.or_else(field).unwrap_or_else(|| match value {
            Binding::Int(_) => "int".to_owned(),
            Binding::Float(_) => "float".to_owned(),
            Binding::Str(_) => "string".to_owned(),
            Binding::Floats(v) => format!("float[{}]", v.len()),
            Binding::Strs(v) => format!("string[{}]", v.len()),
        })
    }
}

fn values(value: &Binding) -> String {
    let string = |s: &str| format!("\"{}\"", s.escape_default());
    match value {
        Binding::Int(v) => v.to_string(),
        Binding::Float(v) => v.to_string(),
        Binding::Str(s) => string(s),
        Binding::Floats(list) => list.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
        Binding::Strs(list) => list.iter().map(|s| string(s)).collect::<Vec<_>>().join(" "),
    }
}

/// Numbers (or strings) of an element of a type; `None` for what is no type of a parameter.
fn width_of(base: &str) -> Option<usize> {
    match base {
        "int" | "float" | "string" => Some(1),
        "color" | "point" | "vector" | "normal" => Some(3),
        "matrix" => Some(16),
        _ => None,
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Word,
    Quoted,
    /// `;` or `,`.
    End,
    /// `[[ ... ]]`, without the brackets.
    Hints,
}

/// A piece of the text.
#[derive(Clone, Debug)]
struct Token {
    kind: Kind,
    text: String,
    start: usize,
}

impl Token {
    fn show(&self) -> String {
        match self.kind {
            Kind::Word | Kind::End => format!("`{}`", self.text),
            Kind::Quoted => format!("the string \"{}\"", self.text),
            Kind::Hints => "hints in `[[ ]]`".to_owned(),
        }
    }
}

fn error(text: &str, at: usize, message: String, help: Option<String>) -> TextError {
    let before = &text[..at.min(text.len())];
    let line = before.matches('\n').count() + 1;
    let column = before[before.rfind('\n').map_or(0, |i| i + 1)..].chars().count() + 1;
    TextError { line, column, message, help }
}

fn tokens(text: &str) -> Result<Vec<Token>, TextError> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let (kind, token, length) = match first {
            c if c.is_whitespace() => {
                at += c.len_utf8();
                continue;
            }
            '#' => {
                at += rest.find('\n').unwrap_or(rest.len());
                continue;
            }
            ';' | ',' => (Kind::End, first.to_string(), 1),
            '"' => {
                let (string, length) = quoted(rest)
                    .ok_or_else(|| error(text, at, "a string without its closing quote".to_owned(), None))?;
                (Kind::Quoted, string, length)
            }
            _ if rest.starts_with("[[") => {
                let end = rest.find("]]").ok_or_else(|| error(text, at, "`[[` without `]]`".to_owned(), None))?;
                (Kind::Hints, rest[2..end].to_owned(), end + 2)
            }
            _ => {
                let ends = |(i, c): (usize, char)| {
                    let hints = i > 0 && rest[i..].starts_with("[[");
                    (c.is_whitespace() || matches!(c, ';' | ',' | '"' | '#') || hints).then_some(i)
                };
                let length = rest.char_indices().find_map(ends).unwrap_or(rest.len());
                (Kind::Word, rest[..length].to_owned(), length)
            }
        };
        out.push(Token { kind, text: token, start: at });
        at += length;
    }
    Ok(out)
}

/// A string's text and its length with quotes.
fn quoted(rest: &str) -> Option<(String, usize)> {
    let mut text = String::new();
    let mut chars = rest.char_indices().skip(1);
    while let Some((at, c)) = chars.next() {
        match c {
            '"' => return Some((text, at + 1)),
            '\\' => text.push(match chars.next()?.1 {
                'n' => '\n',
                't' => '\t',
                'r' => '\r',
                other => other,
            }),
            other => text.push(other),
        }
    }
    None
}

/// Reads statements.
struct Reader<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    at: usize,
}

impl Reader<'_> {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    fn place(&self, start: usize) -> (usize, usize) {
        let e = error(self.text, start, String::new(), None);
        (e.line, e.column)
    }

    fn error_at(&self, start: usize, message: String, help: Option<String>) -> TextError {
        error(self.text, start, message, help)
    }

    /// An error at the next token.
    fn error(&self, message: String) -> TextError {
        self.error_at(self.peek().map_or(self.text.len(), |t| t.start), message, None)
    }

    /// The next word or string.
    fn need(&mut self, what: &str) -> Result<String, TextError> {
        match self.peek() {
            Some(token) if matches!(token.kind, Kind::Word | Kind::Quoted) => {
                let text = token.text.clone();
                self.at += 1;
                Ok(text)
            }
            Some(token) => Err(self.error(format!("expected {what}, found {}", token.show()))),
            None => Err(self.error(format!("expected {what}, but the text ends"))),
        }
    }

    /// The end of a statement; the last one may be missing.
    fn end(&mut self, statement: &str) -> Result<(), TextError> {
        match self.peek() {
            Some(token) if token.kind == Kind::End => self.at += 1,
            Some(token) => return Err(self.error(format!("expected `;` after `{statement}`, found {}", token.show()))),
            None => {}
        }
        Ok(())
    }

    fn connection(&mut self, group: &Group) -> Result<Connection, TextError> {
        let mut ends = Vec::new();
        for _ in 0..2 {
            let start = self.peek().map_or(self.text.len(), |t| t.start);
            let end = self.need("`LAYER.PARAMETER`")?;
            let Some((layer, param)) = end.split_once('.').filter(|(l, p)| !l.is_empty() && !p.is_empty()) else {
                let message = format!("`{end}` is no `LAYER.PARAMETER`");
                return Err(self.error_at(start, message, None));
            };
            if !group.layers.iter().any(|l| l.name == layer) {
                let names = group.layers.iter().map(|l| l.name.as_str());
                let help = match crate::suggest::closest(layer, names) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "a `connect` stands behind the `shader` statements of both layers".to_owned(),
                };
                let message = format!("there is no layer `{layer}` before this `connect`");
                return Err(self.error_at(start, message, Some(help)));
            }
            ends.push((layer.to_owned(), param.to_owned()));
        }
        self.end("connect")?;
        // Two were read.
        let [(from_layer, from), (to_layer, to)] = <[_; 2]>::try_from(ends).unwrap_or_default();
        Ok(Connection { from_layer, from, to_layer, to })
    }

    /// `TYPE NAME VALUES... [[hints]];`
    fn param(&mut self) -> Result<Bound, TextError> {
        let start = self.peek().map_or(self.text.len(), |t| t.start);
        let mut ty = self.need("the parameter's type")?;
        // `float [3] x`
        if let Some(token) = self.peek()
            && token.kind == Kind::Word
            && token.text.starts_with('[')
        {
            ty.push_str(&token.text);
            self.at += 1;
        }
        let (base, length) = self.type_of(&ty, start)?;
        let width = width_of(base).unwrap_or(1);
        let name = self.need("the parameter's name")?;
        let mut values: Vec<Token> = Vec::new();
        while let Some(token) = self.peek()
            && matches!(token.kind, Kind::Word | Kind::Quoted)
        {
            values.push(token.clone());
            self.at += 1;
        }
        let hints = match self.peek() {
            Some(Token { kind: Kind::Hints, text, start }) => {
                let hints = self.hints(text, *start)?;
                self.at += 1;
                hints
            }
            _ => Hints::default(),
        };
        self.end("param")?;
        let wanted = match length {
            None => width,
            Some(0) => values.len().max(1).next_multiple_of(width),
            Some(n) => n as usize * width,
        };
        if values.len() > wanted {
            let message = format!("parameter `{name}` of type `{ty}` takes {wanted} values, not {}", values.len());
            return Err(self.error_at(start, message, None));
        }
        let value = self.value(base, length.is_some(), wanted, &name, &values)?;
        Ok(Bound { name, value, hints })
    }

    /// The base and the length: `Some(0)` for as many as there are values.
    fn type_of<'t>(&self, ty: &'t str, start: usize) -> Result<(&'t str, Option<u32>), TextError> {
        let (base, length) = match ty.split_once('[') {
            None => (ty, None),
            Some((base, rest)) => {
                let digits = rest.strip_suffix(']').unwrap_or("?");
                let length = if digits.is_empty() { Some(0) } else { digits.parse().ok().filter(|n| *n > 0) };
                let message = || format!("`{ty}` is no array type of 1 to {MAX_LENGTH} elements");
                let length = length.filter(|n| *n <= MAX_LENGTH);
                (base, Some(length.ok_or_else(|| self.error_at(start, message(), None))?))
            }
        };
        if width_of(base).is_none() {
            let known = ["int", "float", "color", "point", "vector", "normal", "matrix", "string"];
            let help = match crate::suggest::closest(base, known.into_iter()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the types are {}", known.join(", ")),
            };
            return Err(self.error_at(start, format!("`{base}` is no type of a parameter"), Some(help)));
        }
        Ok((base, length))
    }

    fn value(
        &self,
        base: &str,
        array: bool,
        wanted: usize,
        name: &str,
        values: &[Token],
    ) -> Result<Binding, TextError> {
        if base == "string" {
            let mut texts: Vec<String> = values.iter().map(|t| t.text.clone()).collect();
            texts.resize(wanted, String::new());
            return Ok(if array { Binding::Strs(texts) } else { Binding::Str(texts.swap_remove(0)) });
        }
        let mut numbers = Vec::with_capacity(wanted);
        for token in values {
            let number = if base == "int" {
                let int: Option<i32> = token.text.parse().ok();
                int.map(f64::from)
            } else {
                token.text.parse::<f64>().ok()
            };
            let what = if base == "int" { "int" } else { "number" };
            let wrong = || format!("parameter `{name}`: {} is no {what}", token.show());
            numbers.push(
                number.filter(|_| token.kind == Kind::Word).ok_or_else(|| self.error_at(token.start, wrong(), None))?,
            );
        }
        numbers.resize(wanted, 0.0);
        Ok(match base {
            "int" if !array => Binding::Int(numbers[0] as i64),
            "float" if !array => Binding::Float(numbers[0]),
            _ => Binding::Floats(numbers),
        })
    }

    /// `int lockgeom=0, int interactive=1`
    fn hints(&self, text: &str, start: usize) -> Result<Hints, TextError> {
        let mut hints = Hints::default();
        for hint in text.split([',', ';']).map(str::trim).filter(|h| !h.is_empty()) {
            let malformed = || {
                let help = Some("hints are `int lockgeom=0`, `int interpolated=1` and `int interactive=1`".to_owned());
                self.error_at(start, format!("`{hint}` is no hint"), help)
            };
            let (left, value) = hint.split_once('=').ok_or_else(malformed)?;
            let words: Vec<&str> = left.split_whitespace().collect();
            let ["int", name] = words[..] else { return Err(malformed()) };
            let on = value.trim().parse::<i32>().map_err(|_| malformed())? != 0;
            match name {
                "lockgeom" => hints.lockgeom = Some(on),
                "interpolated" => hints.interpolated = on,
                "interactive" => hints.interactive = on,
                _ => return Err(malformed()),
            }
        }
        Ok(hints)
    }
}
