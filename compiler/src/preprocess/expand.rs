//! Macro definitions and their expansion (C11 6.10.3).

use super::lexer::{Kind, Lexer, Token};
use crate::diag::Diagnostic;
use crate::source::{SourceMap, Span};
use std::collections::HashMap;
use std::rc::Rc;

/// A `#define`.
#[derive(Debug)]
pub(super) struct Macro {
    /// `None`: object-like.
    pub params: Option<Vec<String>>,
    /// The last parameter takes all further arguments (`...` or `name...`).
    pub variadic: bool,
    pub body: Vec<Token>,
}

/// All macros in force.
#[derive(Default)]
pub(super) struct Macros(pub HashMap<String, Rc<Macro>>);

/// Where tokens come from: a replaced macro's body on a stack above the file.
struct Replacement {
    tokens: std::vec::IntoIter<Token>,
    /// The macro that is not expanded again while its replacement is read.
    name: String,
}

/// Reads tokens and replaces macros. `base` yields tokens once the replacements are used up.
pub(super) struct Expander<'a> {
    pub macros: &'a Macros,
    pub sources: &'a SourceMap,
    pub problems: Vec<Diagnostic>,
    stack: Vec<Replacement>,
    /// One token of lookahead from the base.
    peeked: Option<Token>,
    /// Tokens produced; bounds exponential growth.
    pub produced: usize,
    /// Arguments inside of arguments around this expansion.
    depth: usize,
    /// Whether `defined` has its meaning, as in `#if`.
    in_condition: bool,
}

/// Most tokens that the macros of one line may produce.
const MAX_PRODUCED: usize = 1_000_000;

/// Most arguments of macros inside each other: each level reads all that is inside of it.
const MAX_ARGUMENTS: usize = 256;

/// Most replacements inside each other.
const MAX_NESTING: usize = 1_000;

impl<'a> Expander<'a> {
    pub fn new(macros: &'a Macros, sources: &'a SourceMap) -> Self {
        Expander {
            macros,
            sources,
            problems: Vec::new(),
            stack: Vec::new(),
            peeked: None,
            produced: 0,
            depth: 0,
            in_condition: false,
        }
    }

    /// For the expression of an `#if`.
    pub fn of_condition(macros: &'a Macros, sources: &'a SourceMap) -> Self {
        Expander { in_condition: true, ..Expander::new(macros, sources) }
    }

    /// Whether nothing waits here, so that the base may be read directly.
    pub fn idle(&self) -> bool {
        self.stack.is_empty() && self.peeked.is_none()
    }

    fn read(&mut self, base: &mut dyn FnMut() -> Token) -> Token {
        while let Some(top) = self.stack.last_mut() {
            if let Some(token) = top.tokens.next() {
                return token;
            }
            self.stack.pop();
        }
        self.peeked.take().unwrap_or_else(base)
    }

    /// Whether the next token, new lines aside, opens an argument list. Consumes it if so.
    fn take_open(&mut self, base: &mut dyn FnMut() -> Token) -> bool {
        while let Some(top) = self.stack.last_mut() {
            match top.tokens.as_slice().first() {
                Some(t) if t.is("(") => {
                    top.tokens.next();
                    return true;
                }
                Some(_) => return false,
                None => {
                    self.stack.pop();
                }
            }
        }
        let token = self.peeked.take().unwrap_or_else(&mut *base);
        if token.is("(") {
            return true;
        }
        if token.kind != Kind::Newline {
            self.peeked = Some(token);
            return false;
        }
        // A call may start on a later line; if it does not, the new lines were only white space.
        let mut token = base();
        while token.kind == Kind::Newline {
            token = base();
        }
        token.spaced = true;
        let open = token.is("(");
        if !open {
            self.peeked = Some(token);
        }
        open
    }

    /// The next token after expansion.
    pub fn next(&mut self, base: &mut dyn FnMut() -> Token) -> Token {
        loop {
            let mut token = self.read(base);
            if token.kind != Kind::Ident || token.painted {
                return token;
            }
            if let Some(made) = self.position_macro(&token) {
                return made;
            }
            if self.in_condition && token.str() == "defined" {
                return self.defined(&token, base);
            }
            let Some(found) = self.macros.0.get(token.str()) else { return token };
            let definition = found.clone();
            if self.stack.iter().any(|r| r.name == token.str()) {
                token.painted = true;
                return token;
            }
            let args = match &definition.params {
                None => Vec::new(),
                Some(_) if !self.take_open(base) => return token,
                Some(params) => match self.arguments(&token, params, definition.variadic, base) {
                    Some(args) => args,
                    None => return token,
                },
            };
            if self.stack.len() >= MAX_NESTING || self.produced > MAX_PRODUCED {
                self.too_much(&token);
                self.stack.clear();
                return token;
            }
            let mut body = self.substitute(&definition, &args, &token);
            if let Some(first) = body.first_mut() {
                first.spaced = token.spaced;
            }
            self.produced += body.len();
            self.stack.push(Replacement { tokens: body.into_iter(), name: token.str().to_string() });
        }
    }

    /// 1 or 0 for `defined X` or `defined(X)`, whose name is not replaced; also where a macro made it (clang's way with what C leaves
    /// open).
    fn defined(&mut self, word: &Token, base: &mut dyn FnMut() -> Token) -> Token {
        let bracketed = self.take_open(base);
        let subject = self.read(base);
        if subject.kind != Kind::Ident {
            self.problems.push(Diagnostic::error("E0009", word.span, "`defined` needs a name"));
        } else if bracketed && !self.read(base).is(")") {
            self.problems.push(Diagnostic::error("E0009", word.span, "`defined(` needs a `)`"));
        }
        let value = if self.macros.0.contains_key(subject.str()) { "1" } else { "0" };
        Token::made(Kind::Number, value, word.span)
    }

    /// Reports once that a use of a macro is given up.
    fn too_much(&mut self, token: &Token) {
        if !self.problems.iter().any(|d| d.code == "E0007") {
            let message = format!("macro `{}` expands to too much", token.str());
            let help = "a macro that repeats its argument, or others, doubles the text at each level";
            self.problems.push(Diagnostic::error("E0007", token.span, message).help(help));
        }
    }

    fn position_macro(&self, token: &Token) -> Option<Token> {
        let mut made = match token.str() {
            "__LINE__" => Token::made(Kind::Number, &self.sources.shown(token.span).1.to_string(), token.span),
            "__FILE__" => Token::made(Kind::Str, &quote(self.sources.shown(token.span).0), token.span),
            _ => return None,
        };
        made.spaced = token.spaced;
        Some(made)
    }

    /// Arguments up to the closing parenthesis, unexpanded.
    fn arguments(
        &mut self,
        name: &Token,
        params: &[String],
        variadic: bool,
        base: &mut dyn FnMut() -> Token,
    ) -> Option<Vec<Vec<Token>>> {
        let mut args = vec![Vec::new()];
        let mut depth = 0u32;
        loop {
            let mut token = self.read(base);
            match token.kind {
                Kind::End => {
                    let message = format!("the arguments of macro `{}` are never closed", name.str());
                    self.problems.push(Diagnostic::error("E0006", name.span, message).help("add `)`"));
                    self.peeked = Some(token);
                    return None;
                }
                Kind::Newline => continue,
                _ => {}
            }
            if token.is("(") {
                depth += 1;
            } else if token.is(")") {
                if depth == 0 {
                    break;
                }
                depth -= 1;
            } else if depth == 0 && token.is(",") && !(variadic && args.len() == params.len()) {
                args.push(Vec::new());
                continue;
            }
            if token.kind == Kind::Ident && self.stack.iter().any(|r| r.name == token.str()) {
                token.painted = true;
            }
            if let Some(last) = args.last_mut() {
                last.push(token);
            }
        }
        if params.is_empty() && args.len() == 1 && args[0].is_empty() {
            args.clear();
        }
        if variadic && args.len() + 1 == params.len() {
            args.push(Vec::new());
        }
        if args.len() != params.len() {
            let message =
                format!("macro `{}` takes {} arguments, but {} are given", name.str(), params.len(), args.len());
            self.problems.push(Diagnostic::error("E0006", name.span, message));
            return None;
        }
        Some(args)
    }

    /// The body with arguments in place of parameters, `#` and `##` carried out; all at the place of the use.
    fn substitute(&mut self, definition: &Macro, args: &[Vec<Token>], name: &Token) -> Vec<Token> {
        let params = definition.params.as_deref().unwrap_or(&[]);
        let body = &definition.body;
        let index_of = |t: &Token| params.iter().position(|p| t.kind == Kind::Ident && p == t.str());
        let mut expanded: Vec<Option<Vec<Token>>> = vec![None; args.len()];
        let mut out: Vec<Token> = Vec::with_capacity(body.len());
        let mut i = 0;
        while i < body.len() {
            let token = &body[i];
            if definition.params.is_some()
                && token.is("#")
                && let Some(k) = body.get(i + 1).and_then(index_of)
            {
                let mut made = Token::made(Kind::Str, &stringify(&args[k]), name.span);
                made.spaced = token.spaced;
                out.push(made);
                i += 2;
                continue;
            }
            if token.is("##") && !out.is_empty() && i + 1 < body.len() {
                let next = &body[i + 1];
                let right = match index_of(next) {
                    Some(k) => args[k].clone(),
                    None => vec![next.clone()],
                };
                paste(&mut out, right, name.span);
                i += 2;
                continue;
            }
            match index_of(token) {
                Some(k) if body.get(i + 1).is_some_and(|t| t.is("##")) => {
                    let mut arg = args[k].clone();
                    if arg.is_empty() {
                        // A placemarker: keeps `##` from eating what stands before the parameter.
                        arg.push(Token::made(Kind::Punct, "", name.span));
                    }
                    push_argument(&mut out, arg, token.spaced);
                }
                Some(k) => {
                    let arg = match &expanded[k] {
                        Some(done) => done.clone(),
                        None => {
                            let done = self.expand_argument(&args[k]);
                            expanded[k] = Some(done.clone());
                            done
                        }
                    };
                    push_argument(&mut out, arg, token.spaced);
                }
                None => out.push(token.clone()),
            }
            i += 1;
        }
        out.retain(|t| !(t.kind == Kind::Punct && t.str().is_empty()));
        for token in &mut out {
            token.span = name.span;
        }
        out
    }

    /// An argument is expanded on its own before it is put in.
    fn expand_argument(&mut self, arg: &[Token]) -> Vec<Token> {
        let has_macro = arg.iter().any(|t| t.kind == Kind::Ident && !t.painted);
        if !has_macro || self.produced > MAX_PRODUCED {
            // Past the limit it was reported already.
            return arg.to_vec();
        }
        let mut inner = Expander::new(self.macros, self.sources);
        (inner.produced, inner.depth, inner.in_condition) = (self.produced, self.depth + 1, self.in_condition);
        if self.depth >= MAX_ARGUMENTS {
            self.too_much(&arg[0]);
            return arg.to_vec();
        }
        let names: Vec<String> = self.stack.iter().map(|r| r.name.clone()).collect();
        let out = expand_list(&mut inner, arg, names);
        self.produced = inner.produced;
        let known = self.problems.iter().any(|d| d.code == "E0007");
        inner.problems.retain(|d| !(known && d.code == "E0007"));
        self.problems.append(&mut inner.problems);
        out
    }
}

/// Expands a list of tokens that stands alone; `active` macros are left alone.
pub(super) fn expand_list(expander: &mut Expander, tokens: &[Token], active: Vec<String>) -> Vec<Token> {
    let end = Token::made(
        Kind::End,
        "",
        tokens.first().map_or(Span { file: crate::source::FileId(0), start: 0, end: 0 }, |t| t.span),
    );
    let mut input = tokens.iter().cloned().map(|mut t| {
        t.painted |= t.kind == Kind::Ident && active.iter().any(|n| n == t.str());
        t
    });
    let mut base = || input.next().unwrap_or_else(|| end.clone());
    let mut out = Vec::new();
    loop {
        let token = expander.next(&mut base);
        if token.kind == Kind::End {
            return out;
        }
        out.push(token);
        if expander.produced > MAX_PRODUCED {
            if let Some(first) = tokens.first() {
                expander.too_much(first);
            }
            return out;
        }
    }
}

fn push_argument(out: &mut Vec<Token>, mut arg: Vec<Token>, spaced: bool) {
    if let Some(first) = arg.first_mut() {
        first.spaced = spaced;
    }
    out.append(&mut arg);
}

/// `##`: glues the last token of `out` to the first of `right`.
fn paste(out: &mut Vec<Token>, right: Vec<Token>, span: Span) {
    let mut right = right.into_iter();
    // An empty argument leaves the left one as it is.
    let Some(first) = right.next() else { return };
    if let Some(left) = out.pop() {
        let text = format!("{}{}", left.str(), first.str());
        let kind = match text.as_bytes().first() {
            Some(b'0'..=b'9') => Kind::Number,
            Some(b'"') => Kind::Str,
            Some(b'.') if text.len() > 1 => Kind::Number,
            Some(b) if b.is_ascii_alphabetic() || *b == b'_' => Kind::Ident,
            _ => Kind::Punct,
        };
        let mut made = Token::made(kind, &text, span);
        made.spaced = left.spaced;
        out.push(made);
    }
    out.extend(right);
}

fn stringify(arg: &[Token]) -> String {
    let mut text = String::new();
    for (i, token) in arg.iter().enumerate() {
        if i > 0 && token.spaced {
            text.push(' ');
        }
        text.push_str(token.str());
    }
    quote(&text)
}

fn quote(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The tokens of a text that stands in no file of the user, such as a `-D` value.
pub(super) fn tokens_of(lexer: &mut Lexer) -> Vec<Token> {
    let mut out = Vec::new();
    loop {
        let token = lexer.next();
        match token.kind {
            Kind::End => return out,
            Kind::Newline => {}
            _ => out.push(token),
        }
    }
}
