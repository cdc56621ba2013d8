//! Closures that a vendor's header declares: `closure color NAME(...) BUILTIN;`.
//!
//! In: a syntax tree, and mappings: OSL texts whose functions say by our closures what a vendor's closure looks like
//! (docs/adr/0018). Out: the tree with those declarations replaced by the functions; declarations of what the compiler has
//! anyway are dropped. What no mapping knows stays declared: the checker takes calls of it for closures that contribute nothing.
//! It must not know types or the IR.
//!
//! A mapping's function may name in its metadata `[[ int tokens = N ]]`: its last N parameters are then given by token/value pairs
//! with the parameters' names, and are 0 where a call says nothing.

use crate::ast::{self, ArraySize, Function, Item, TypeName};
use crate::builtins;
use crate::diag::{Diagnostic, Severity};
use crate::preprocess::{self, Includes};
use crate::source::SourceMap;
use crate::{facade, parse};
use std::collections::HashSet;
use std::sync::Arc;

/// A text with mapping functions, and its name for messages.
pub type Mapping = (String, String);

/// Replaces declarations of vendors' closures. The first mapping that has a name counts; ours come last. Closures that the text
/// calls and nothing declares are taken from the vendor's own `stdosl.h` where the user has one (`vendor_header`), then from the
/// mappings. The warnings.
pub(crate) fn complete(
    file: &mut ast::File,
    text: &str,
    mappings: &[Mapping],
    vendor_header: &dyn Fn() -> Option<(String, Arc<str>)>,
    includes: &dyn Includes,
    sources: &mut SourceMap,
) -> Result<Vec<Diagnostic>, Vec<Diagnostic>> {
    let mut warnings = Vec::new();
    file.items.retain(|item| !matches!(item, Item::Function(f) if is_ours(f)));
    let mut wanted: HashSet<String> = HashSet::new();
    let mut unknown = unknown_calls(file, text);
    if !unknown.is_empty()
        && let Some((name, header)) = vendor_header()
    {
        match take(&name, &header, file, &mut unknown, includes, sources) {
            Ok(()) => {}
            Err(said) => {
                let why = said.first().map_or_else(String::new, |d| format!(": {}", d.message));
                let message = format!("`{name}` cannot be read and is left out{why}");
                warnings.push(Diagnostic { severity: Severity::Warning, ..Diagnostic::global("W2011", message) });
            }
        }
    }
    for name in unknown {
        let head = format!("closure color {name}(");
        if mappings.iter().any(|(_, text)| text.contains(&head)) || header_of(&name).is_some() {
            wanted.insert(name);
        }
    }
    for item in &file.items {
        if let Item::Function(f) = item
            && is_declaration(f)
        {
            wanted.insert(f.name.name.clone());
        }
    }
    let ours = facade::CLOSURE_MAPPINGS.iter().map(|(name, text)| (format!("<{name}>"), (*text).to_owned()));
    for (name, text) in mappings.iter().cloned().chain(ours) {
        // Most files declare nothing: then no mapping is read.
        if wanted.is_empty() {
            break;
        }
        // Names first: parsing a mapping costs more than most shaders.
        if !wanted.iter().any(|w| text.contains(w.as_str())) {
            continue;
        }
        let options = preprocess::Options::default();
        let pre = preprocess::preprocess(&name, text.as_str(), &options, includes, sources)?;
        let library = parse::parse(&pre)?;
        let functions: Vec<Function> = library
            .items
            .into_iter()
            .filter_map(|item| match item {
                Item::Function(f) if f.body.is_some() && span_is_in(&f, sources, &name) => Some(f),
                _ => None,
            })
            .collect();
        let found: HashSet<String> =
            functions.iter().map(|f| f.name.name.clone()).filter(|n| wanted.contains(n)).collect();
        if found.is_empty() {
            continue;
        }
        wanted.retain(|w| !found.contains(w));
        // A declaration of other parameters is another closure of that name.
        let mapped = |f: &Function| functions.iter().any(|m| m.name.name == f.name.name && shape(m) == shape(f));
        file.items.retain(|item| match item {
            Item::Function(f) => f.body.is_some() || !mapped(f),
            _ => true,
        });
        // Helpers, which return no closure or say nothing of tokens, come along.
        let helps = |f: &Function| f.ret.name != TypeName::Closure || metadata(f, "tokens").is_none();
        let taken = functions.into_iter().filter(|f| helps(f) || found.contains(&f.name.name));
        file.items.splice(0..0, taken.map(Item::Function));
    }
    Ok(warnings)
}

/// The names that a text calls and neither it nor the compiler has.
fn unknown_calls(file: &ast::File, text: &str) -> HashSet<String> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut known: HashSet<&str> = HashSet::new();
    for item in &file.items {
        match item {
            Item::Function(f) => known.insert(&f.name.name),
            Item::Struct(s) => known.insert(&s.name.name),
            Item::Shader(s) => known.insert(&s.name.name),
        };
    }
    let mut unknown = HashSet::new();
    for (at, _) in text.match_indices('(') {
        let before = text[..at].trim_end();
        let name = &before[before.rfind(|c| !is_word(c)).map_or(0, |i| i + 1)..];
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && !KEYWORDS.contains(&name);
        if is_name && known.insert(name) && builtins::find(name).is_none() && builtins::find_closure(name).is_none() {
            unknown.insert(name.to_owned());
        }
    }
    unknown
}

/// Words that stand before parentheses and are no functions.
const KEYWORDS: [&str; 14] = [
    "if", "for", "while", "return", "int", "float", "color", "point", "vector", "normal", "matrix", "string", "void",
    "and",
];

/// Takes functions and structs of a vendor's header that a file calls, with what those need, unless the compiler has them.
fn take(
    name: &str,
    text: &Arc<str>,
    file: &mut ast::File,
    unknown: &mut HashSet<String>,
    includes: &dyn Includes,
    sources: &mut SourceMap,
) -> Result<(), Vec<Diagnostic>> {
    if !unknown.iter().any(|w| text.contains(w.as_str())) {
        return Ok(());
    }
    let options = preprocess::Options::default();
    let pre = preprocess::preprocess(name, text.clone(), &options, includes, sources)?;
    let library = parse::parse(&pre)?;
    let given = |item: &Item| match item {
        Item::Function(f) => unknown.contains(&f.name.name),
        _ => false,
    };
    if !library.items.iter().any(given) {
        return Ok(());
    }
    let has = |file: &ast::File, name: &str| {
        file.items.iter().any(|item| match item {
            Item::Function(f) => f.name.name == name,
            Item::Struct(s) => s.name.name == name,
            Item::Shader(_) => false,
        })
    };
    let mut taken = Vec::new();
    for item in library.items {
        let new = match &item {
            Item::Function(f) => {
                let ours = builtins::find(&f.name.name).is_some() || builtins::find_closure(&f.name.name).is_some();
                !ours && !has(file, &f.name.name)
            }
            Item::Struct(s) => !has(file, &s.name.name),
            Item::Shader(_) => false,
        };
        if new {
            if let Item::Function(f) = &item {
                unknown.remove(&f.name.name);
            }
            taken.push(item);
        }
    }
    file.items.splice(0..0, taken);
    Ok(())
}

/// The header of ours that has a closure of this name.
pub(crate) fn header_of(name: &str) -> Option<&'static str> {
    let head = format!("closure color {name}(");
    facade::CLOSURE_MAPPINGS.iter().find(|(_, text)| text.contains(&head)).map(|(header, _)| *header)
}

/// Whether a function stands in the mapping itself, not in what it includes.
fn span_is_in(f: &Function, sources: &SourceMap, name: &str) -> bool {
    sources.file(f.name.span.file).name == name
}

/// `[[ int KEY = value ]]` of a function.
pub(crate) fn metadata(f: &Function, key: &str) -> Option<i32> {
    f.metadata.iter().find(|m| m.name.name == key).and_then(|m| match &m.value {
        ast::Init::Expr(e) => match &e.kind {
            ast::ExprKind::Int(v) => Some(*v),
            _ => None,
        },
        ast::Init::List(..) => None,
    })
}

/// Whether this declares a closure that a renderer is to have.
pub(crate) fn is_declaration(f: &Function) -> bool {
    f.body.is_none() && f.ret.name == TypeName::Closure && metadata(f, "builtin") == Some(1)
}

/// Whether a declaration repeats a row of our tables.
fn is_ours(f: &Function) -> bool {
    if f.body.is_some() || metadata(f, "builtin") != Some(1) {
        return false;
    }
    let args: Vec<String> = f.params.iter().map(spelling).collect();
    let is_row = |row: &builtins::ClosureRow| row.name == f.name.name && row.args == args.join(",");
    builtins::CLOSURES.iter().any(is_row) || (f.ret.name != TypeName::Closure && builtins::find(&f.name.name).is_some())
}

/// What a closure's parameters are, those given by tokens left out; triples of any kind convert to each other.
fn shape(f: &Function) -> Vec<String> {
    let tokens = metadata(f, "tokens").and_then(|n| usize::try_from(n).ok()).unwrap_or(0);
    let of = |p: &ast::Param| {
        let spelt = spelling(p);
        ["color", "point", "vector", "normal"].iter().fold(spelt, |s, triple| match s.strip_prefix(triple) {
            Some(rest) => format!("triple{rest}"),
            None => s,
        })
    };
    f.params.iter().take(f.params.len().saturating_sub(tokens)).map(of).collect()
}

/// A parameter's type as the tables spell it.
fn spelling(p: &ast::Param) -> String {
    let base = match &p.ty.name {
        TypeName::Int => "int",
        TypeName::Float => "float",
        TypeName::Color => "color",
        TypeName::Point => "point",
        TypeName::Vector => "vector",
        TypeName::Normal => "normal",
        TypeName::Matrix => "matrix",
        TypeName::String => "string",
        TypeName::Void => "void",
        TypeName::Closure => "closure color",
        TypeName::Struct(name) => name,
    };
    let brackets = match &p.array {
        None => "",
        Some(ArraySize::Unsized | ArraySize::Fixed(_)) => "[]",
    };
    format!("{base}{brackets}")
}
