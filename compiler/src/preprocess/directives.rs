//! Runs over files line by line: carries out directives, passes the rest through macro expansion to the output.

use super::expand::{Expander, Macro, Macros, expand_list, tokens_of};
use super::lexer::{FileText, Kind, Lexer, Token};
use super::{Includes, MAX_OUTPUT, Options, Preprocessed, condition};
use crate::diag::Diagnostic;
use crate::source::{FileId, SourceMap, Span};
use std::collections::HashSet;
use std::rc::Rc;

/// Files inside each other; beyond it a file includes itself.
const MAX_INCLUDE_DEPTH: usize = 64;

/// Files read in all; beyond it files include each other over and over.
const MAX_FILES: usize = 10_000;

/// Errors after which a file is given up.
const MAX_ERRORS: usize = 50;

/// One `#if` that is open.
struct Conditional {
    /// The directive that opened it.
    span: Span,
    /// The present group is read; then those around it are read, too.
    active: bool,
    /// Some group was already taken, or the whole conditional lies in a skipped group.
    done: bool,
    /// `#else` was seen.
    last: bool,
}

/// A run of the preprocessor.
pub(super) struct Run<'a> {
    includes: &'a dyn Includes,
    sources: &'a mut SourceMap,
    macros: Macros,
    once: HashSet<String>,
    /// The files being read, outermost first, with the place of the `#include` that opened each.
    open: Vec<(String, Option<Span>)>,
    out: Preprocessed,
    errors: Vec<Diagnostic>,
    /// End of the last token written, to tell neighbours from tokens that must be kept apart.
    last_end: Option<(FileId, u32)>,
    /// Nothing more is read: includes run in a circle.
    stopped: bool,
}

/// The version that `OSL_VERSION` claims: the language of OSL 1.16.
const VERSION: [(&str, &str); 4] =
    [("OSL_VERSION", "11600"), ("OSL_VERSION_MAJOR", "1"), ("OSL_VERSION_MINOR", "16"), ("OSL_VERSION_PATCH", "0")];

impl<'a> Run<'a> {
    pub fn new(options: &Options, includes: &'a dyn Includes, sources: &'a mut SourceMap) -> Self {
        let mut run = Run {
            includes,
            sources,
            macros: Macros::default(),
            once: HashSet::new(),
            open: Vec::new(),
            out: Preprocessed::default(),
            errors: Vec::new(),
            last_end: None,
            stopped: false,
        };
        let given = options.defines.iter().map(|(n, v)| (n.as_str(), v.as_str()));
        for (name, value) in VERSION.into_iter().chain(given) {
            run.define_given(name, value);
        }
        for name in &options.undefines {
            run.macros.0.remove(name);
        }
        run
    }

    /// A definition from outside the sources; `name` may be `F(x)`.
    fn define_given(&mut self, name: &str, value: &str) {
        let text = format!("{name} {value}");
        let id = self.sources.add("<command line>", text.as_str());
        let mut lexer = self.lexer(id);
        let tokens = tokens_of(&mut lexer);
        self.define(&tokens, Span { file: id, start: 0, end: text.len() as u32 });
    }

    pub fn include_implicitly(&mut self, name: &str) {
        if let Some((name, text)) = self.includes.read(name, None, true) {
            let id = self.sources.add(name, text);
            self.file(id);
        }
    }

    pub fn finish(mut self) -> Result<Preprocessed, Vec<Diagnostic>> {
        self.out.text.push('\n');
        if self.errors.is_empty() {
            return Ok(self.out);
        }
        self.errors.append(&mut self.out.warnings);
        Err(self.errors)
    }

    fn lexer(&self, id: FileId) -> Lexer {
        let file = self.sources.file(id);
        Lexer::new(Rc::new(FileText { id, text: file.text.clone() }))
    }

    fn error(&mut self, code: &'static str, span: Span, message: impl Into<String>) {
        self.errors.push(Diagnostic::error(code, span, message));
    }

    fn give_up(&self) -> bool {
        self.stopped || self.errors.len() >= MAX_ERRORS || self.out.text.len() > MAX_OUTPUT
    }

    /// Reads a file that was added to the sources.
    pub fn file(&mut self, id: FileId) {
        let name = self.sources.file(id).name.clone();
        if self.open.is_empty() || self.open.last().is_none_or(|o| o.0 != name) {
            // The implicit and the main file have no `#include` of their own.
            self.open.push((name, None));
        }
        let mut lexer = self.lexer(id);
        let mut conditionals: Vec<Conditional> = Vec::new();
        while !self.give_up() {
            let active = conditionals.last().is_none_or(|c| c.active);
            lexer.lenient = !active;
            let first = lexer.next();
            self.errors.append(&mut lexer.problems);
            if first.kind == Kind::End {
                break;
            }
            if first.is("#") {
                let line = rest_of_line(&mut lexer);
                self.directive(&first, line, &mut conditionals, id);
            } else if active {
                self.line(first, &mut lexer);
            } else if first.kind != Kind::Newline {
                rest_of_line(&mut lexer);
            }
            self.errors.append(&mut lexer.problems);
        }
        if self.out.text.len() > MAX_OUTPUT {
            let span = lexer.span(0, 0);
            self.error(
                "E0007",
                span,
                format!("the text grows beyond {} MiB: a macro expands to too much", MAX_OUTPUT >> 20),
            );
        }
        if let Some(open) = conditionals.last().filter(|_| !self.stopped) {
            self.errors
                .push(Diagnostic::error("E0004", open.span, "this conditional is never closed").help("add `#endif`"));
        }
        self.open.pop();
    }

    /// Expands and writes from `first` to the end of the line (or of a macro call that runs on).
    fn line(&mut self, first: Token, lexer: &mut Lexer) {
        let mut problems = Vec::new();
        {
            let mut expander = Expander::new(&self.macros, self.sources);
            let mut first = Some(first);
            let mut base = || first.take().unwrap_or_else(|| lexer.next());
            loop {
                let token = expander.next(&mut base);
                match token.kind {
                    Kind::End => break,
                    Kind::Newline => {
                        self.out.text.push('\n');
                        self.last_end = None;
                        if expander.idle() {
                            break;
                        }
                    }
                    _ => {
                        let at = (token.span.file, token.span.start);
                        if token.spaced || self.last_end.is_some_and(|end| end != at) {
                            self.out.text.push(' ');
                        }
                        self.last_end = Some((token.span.file, token.span.end));
                        self.out.push(token.str(), token.span);
                    }
                }
                if self.out.text.len() > MAX_OUTPUT || !expander.problems.is_empty() {
                    problems.append(&mut expander.problems);
                    if problems.len() >= MAX_ERRORS || self.out.text.len() > MAX_OUTPUT {
                        break;
                    }
                }
            }
            problems.append(&mut expander.problems);
        }
        self.errors.append(&mut problems);
    }

    fn directive(&mut self, hash: &Token, line: Vec<Token>, conditionals: &mut Vec<Conditional>, id: FileId) {
        // A lone `#` is the null directive.
        let Some(name) = line.first() else { return };
        let span = hash.span.to(line.last().map_or(name.span, |t| t.span));
        let args = &line[1..];
        let active = conditionals.last().is_none_or(|c| c.active);
        match name.str() {
            "if" | "ifdef" | "ifndef" => {
                let taken = active && self.opening_condition(name, args);
                conditionals.push(Conditional { span, active: taken, done: taken || !active, last: false });
            }
            "elif" | "else" => {
                let Some(open) = conditionals.last() else {
                    return self.error("E0003", span, format!("`#{}` without `#if`", name.str()));
                };
                if open.last {
                    return self.error("E0003", span, format!("`#{}` after `#else`", name.str()));
                }
                let try_it = !open.done;
                let taken = try_it && (name.str() == "else" || self.condition(name, args));
                if let Some(open) = conditionals.last_mut() {
                    open.active = taken;
                    open.done |= taken;
                    open.last = name.str() == "else";
                }
            }
            "endif" => {
                if conditionals.pop().is_none() {
                    self.error("E0003", span, "`#endif` without `#if`");
                }
            }
            _ if !active => {}
            "define" => self.define(args, span),
            "undef" => match args.first() {
                Some(t) if t.kind == Kind::Ident => {
                    self.macros.0.remove(t.str());
                }
                _ => self.error("E0003", span, "`#undef` needs a name"),
            },
            "include" => self.include(args, span, id),
            "error" => {
                let message = text_of(args);
                self.error("E0008", span, if message.is_empty() { "#error".into() } else { message });
            }
            "warning" => self.out.warnings.push(Diagnostic::warning("W0001", span, text_of(args))),
            "pragma" => self.pragma(args, span, id),
            "line" => self.renumber(args, span),
            // As compilers write it: `# 12 "file" flags`.
            _ if name.kind == Kind::Number => self.renumber(&line, span),
            other => {
                let message = format!("`#{other}` is no preprocessor directive");
                self.error("E0003", span, message);
            }
        }
    }

    /// `#line number "file"`; the file may be left out.
    fn renumber(&mut self, args: &[Token], span: Span) {
        let mut expander = Expander::new(&self.macros, self.sources);
        let tokens = expand_list(&mut expander, args, Vec::new());
        let number = tokens.first().filter(|t| t.kind == Kind::Number).and_then(|t| t.str().parse::<u32>().ok());
        let name = match tokens.get(1) {
            None => Ok(None),
            Some(t) if t.kind == Kind::Str => Ok(Some(crate::escape::unescape(t.str().trim_matches('"')))),
            Some(_) => Err(()),
        };
        match (number.filter(|n| *n <= i32::MAX as u32), name) {
            (Some(number), Ok(name)) => self.sources.renumber(span, number, name.as_deref()),
            _ => self.error("E0003", span, "`#line` needs the number of the next line, and may name a file in quotes"),
        }
    }

    fn opening_condition(&mut self, name: &Token, args: &[Token]) -> bool {
        if name.str() == "if" {
            return self.condition(name, args);
        }
        match args.first() {
            Some(t) if t.kind == Kind::Ident => self.macros.0.contains_key(t.str()) == (name.str() == "ifdef"),
            _ => {
                self.error("E0003", name.span, format!("`#{}` needs a name", name.str()));
                false
            }
        }
    }

    fn condition(&mut self, name: &Token, args: &[Token]) -> bool {
        let mut expander = Expander::of_condition(&self.macros, self.sources);
        let expanded = expand_list(&mut expander, args, Vec::new());
        let mut problems = expander.problems;
        let is_bad = problems.iter().any(|d| d.code == "E0009");
        self.errors.append(&mut problems);
        if is_bad {
            return false;
        }
        match condition::evaluate(&expanded) {
            Ok(value) => value != 0,
            Err(message) => {
                let last = args.last().map_or(name.span, |t| t.span);
                self.error("E0009", name.span.to(last), format!("bad `#{}` expression: {message}", name.str()));
                false
            }
        }
    }

    fn define(&mut self, args: &[Token], span: Span) {
        let Some(name) = args.first().filter(|t| t.kind == Kind::Ident) else {
            return self.error("E0003", span, "`#define` needs a name");
        };
        let mut body = &args[1..];
        let mut params = None;
        let mut variadic = false;
        // Only a parenthesis right behind the name opens parameters.
        if body.first().is_some_and(|t| t.is("(") && !t.spaced) {
            let Some(close) = body.iter().position(|t| t.is(")")) else {
                return self.error("E0003", span, "the parameters of this macro are never closed");
            };
            let mut names: Vec<String> = Vec::new();
            for token in body[1..close].iter().filter(|t| !t.is(",")) {
                if token.is("...") {
                    variadic = true;
                    // `name...` names the rest itself; a lone `...` is `__VA_ARGS__`.
                    let places = body[1..close].split(|t| t.is(",")).count();
                    if names.len() < places {
                        names.push("__VA_ARGS__".into());
                    }
                } else if token.kind == Kind::Ident && !variadic {
                    names.push(token.str().to_string());
                } else {
                    return self.error("E0003", token.span, "this is no macro parameter");
                }
            }
            params = Some(names);
            body = &body[close + 1..];
        }
        let definition = Macro { params, variadic, body: body.to_vec() };
        self.macros.0.insert(name.str().to_string(), Rc::new(definition));
    }

    fn include(&mut self, args: &[Token], span: Span, id: FileId) {
        let mut expander = Expander::new(&self.macros, self.sources);
        let tokens = match args.first() {
            Some(t) if t.kind == Kind::Ident => expand_list(&mut expander, args, Vec::new()),
            _ => args.to_vec(),
        };
        let (path, system) = match tokens.as_slice() {
            [t, ..] if t.kind == Kind::Str => (t.str().trim_matches('"').to_string(), false),
            [open, inner @ .., close] if open.is("<") && close.is(">") => {
                (inner.iter().map(|t| t.str()).collect::<String>(), true)
            }
            _ => return self.error("E0003", span, "`#include` needs \"file\" or <file>"),
        };
        let from = self.sources.file(id).name.clone();
        let Some((name, text)) = self.includes.read(&path, Some(&from), system) else {
            let help = "includes are searched beside the including file, then in the folders given with -I";
            self.errors.push(Diagnostic::error("E0001", span, format!("cannot find `{path}`")).help(help));
            return;
        };
        if self.once.contains(&name) {
            return;
        }
        if self.open.len() >= MAX_INCLUDE_DEPTH || self.sources.len() >= MAX_FILES {
            return self.include_cycle(&name, span);
        }
        let included = self.sources.add_included(name.clone(), text, span);
        self.open.push((name, Some(span)));
        self.out.text.push('\n');
        self.last_end = None;
        self.file(included);
    }

    fn include_cycle(&mut self, name: &str, span: Span) {
        let cycle = match self.open.iter().rposition(|o| o.0 == name) {
            Some(i) => {
                let names: Vec<&str> = self.open[i..].iter().map(|o| o.0.as_str()).chain([name]).collect();
                format!("`{name}` includes itself: {}", names.join(" -> "))
            }
            None => format!("includes are nested more than {MAX_INCLUDE_DEPTH} deep, or read over {MAX_FILES} files"),
        };
        let help = "put `#pragma once` at the top of the file, or a guard around it";
        self.errors.push(Diagnostic::error("E0002", span, cycle).help(help));
        self.stopped = true;
    }

    fn pragma(&mut self, args: &[Token], span: Span, id: FileId) {
        let word = |i: usize| args.get(i).map_or("", |t: &Token| t.str());
        match (word(0), word(1)) {
            ("once", _) => {
                self.once.insert(self.sources.file(id).name.clone());
            }
            ("error", _) => {
                let message = text_of(&args[1..]);
                self.error("E0008", span, message);
            }
            ("warning", _) => self.out.warnings.push(Diagnostic::warning("W0001", span, text_of(&args[1..]))),
            ("osl", "nowarn") => {
                let line = self.sources.line(span);
                self.out.nowarn.push((id, line + 1));
            }
            // Pragmas of other tools are none of our business.
            _ => {}
        }
    }
}

fn rest_of_line(lexer: &mut Lexer) -> Vec<Token> {
    let mut out = Vec::new();
    loop {
        let token = lexer.next();
        match token.kind {
            Kind::Newline | Kind::End => return out,
            _ => out.push(token),
        }
    }
}

/// The message of `#error` and the like: the line's words, or the text of one string.
fn text_of(tokens: &[Token]) -> String {
    if let [only] = tokens
        && only.kind == Kind::Str
    {
        return only.str().trim_matches('"').to_string();
    }
    let mut text = String::new();
    for token in tokens {
        if token.spaced && !text.is_empty() {
            text.push(' ');
        }
        text.push_str(token.str());
    }
    text
}
