//! Turns pest's findings into the user's words: what was expected, what was found, and where.

use super::Rule;
use crate::diag::Diagnostic;
use crate::preprocess::Preprocessed;
use pest::error::{Error, ErrorVariant, InputLocation};

pub(super) fn describe(error: &Error<Rule>, pre: &Preprocessed) -> Diagnostic {
    let at = match error.location {
        InputLocation::Pos(p) | InputLocation::Span((p, _)) => p,
    };
    let found = token_at(&pre.text, at);
    let here = pre.span(at, at + found.len().max(1));
    if is_reserved(found) {
        return Diagnostic::error("E1005", here, format!("`{found}` is a reserved word"))
            .help("choose another name; OSL has no such construct");
    }
    let positives = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => positives.as_slice(),
        ErrorVariant::CustomError { .. } => &[],
    };
    let found_words = if found.is_empty() { "the end of the file".to_string() } else { format!("`{found}`") };
    // A `;` that is missing belongs behind the token before, often on the line before.
    if positives.contains(&Rule::semi) && !positives.contains(&Rule::rparen) {
        let span = pre.behind(at);
        return Diagnostic::error("E1001", span, format!("expected `;` after this, found {found_words}"));
    }
    let expected = expectation(positives);
    let message = match expected {
        Some(words) => format!("expected {words}, found {found_words}"),
        None => format!("{found_words} is unexpected here"),
    };
    let mut diagnostic = Diagnostic::error("E1001", here, message);
    if found.is_empty() {
        diagnostic = Diagnostic { labels: Vec::new(), ..diagnostic };
        diagnostic.labels.push(crate::diag::Label { span: pre.behind(at), text: String::new() });
    }
    if let Some(help) = help_for(found) {
        diagnostic = diagnostic.help(help);
    }
    diagnostic
}

/// The words of what may come, the most telling first; at most three.
fn expectation(positives: &[Rule]) -> Option<String> {
    const WORDS: [(Rule, &str); 14] = [
        (Rule::rparen, "`)`"),
        (Rule::rbracket, "`]`"),
        (Rule::metadata_end, "`]]`"),
        (Rule::lparen, "`(`"),
        (Rule::lbrace, "`{`"),
        (Rule::colon, "`:`"),
        (Rule::block, "`{`"),
        (Rule::shader_kind, "a shader, function or struct"),
        (Rule::type_spec, "a type"),
        (Rule::simple_type, "a type"),
        (Rule::expr, "an expression"),
        (Rule::assign, "an expression"),
        (Rule::chain, "an expression"),
        (Rule::ident, "a name"),
    ];
    let expression_starts = positives.contains(&Rule::float_lit) || positives.contains(&Rule::neg);
    let mut words: Vec<&str> = Vec::new();
    if positives.contains(&Rule::if_kw) {
        words.push("a statement");
    } else if expression_starts {
        words.push("an expression");
    }
    for (rule, text) in WORDS {
        let hidden = expression_starts && matches!(rule, Rule::ident | Rule::simple_type | Rule::type_spec);
        if positives.contains(&rule) && !words.contains(&text) && !hidden {
            words.push(text);
        }
    }
    if positives.contains(&Rule::rbrace) && !words.contains(&"`}`") {
        words.push("`}`");
    }
    words.truncate(3);
    match words.as_slice() {
        [] => None,
        [one] => Some((*one).to_string()),
        [head @ .., last] => Some(format!("{} or {last}", head.join(", "))),
    }
}

/// The token at a byte of the text; empty at the end.
fn token_at(text: &str, at: usize) -> &str {
    let rest = text[at..].trim_start();
    let word = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
    if word > 0 {
        return &rest[..word];
    }
    if let Some(inner) = rest.strip_prefix('"') {
        let end = inner.find('"').map_or(rest.len(), |e| e + 2);
        return &rest[..end];
    }
    let long = ["[[", "]]", "&&", "||", "==", "!=", "<=", ">=", "<<", ">>", "++", "--"];
    match long.iter().find(|l| rest.starts_with(**l)) {
        Some(l) => &rest[..l.len()],
        None => &rest[..rest.chars().next().map_or(0, char::len_utf8)],
    }
}

fn is_reserved(word: &str) -> bool {
    const RESERVED: [&str; 31] = [
        "bool",
        "case",
        "char",
        "class",
        "const",
        "default",
        "double",
        "enum",
        "extern",
        "false",
        "friend",
        "inline",
        "long",
        "private",
        "protected",
        "short",
        "signed",
        "sizeof",
        "static",
        "switch",
        "template",
        "this",
        "true",
        "typedef",
        "uniform",
        "union",
        "unsigned",
        "varying",
        "virtual",
        "illuminance",
        "illuminate",
    ];
    RESERVED.contains(&word)
}

fn help_for(found: &str) -> Option<&'static str> {
    Some(match found {
        "]" => "metadata closes with `]]`",
        "light" => "OSL has no light shaders: lights are surfaces with emission()",
        "=" => "a comparison is written `==`",
        _ => return None,
    })
}
