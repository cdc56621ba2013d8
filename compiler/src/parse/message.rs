//! Turns pest's findings into the user's words: what was expected, what was found, and where.

use super::Rule;
use crate::diag::Diagnostic;
use crate::preprocess::Preprocessed;
use pest::error::{Error, ErrorVariant, InputLocation};

/// The byte at which the grammar gave up.
pub(super) fn place(error: &Error<Rule>) -> usize {
    match error.location {
        InputLocation::Pos(p) | InputLocation::Span((p, _)) => p,
    }
}

/// Describes an error in `text`, whose places are those of `pre`.
pub(super) fn describe(error: &Error<Rule>, pre: &Preprocessed, text: &str) -> Diagnostic {
    let at = place(error);
    let found = token_at(text, at);
    let here = pre.span(at, at + found.len().max(1));
    if let Some(help) = instead_of(found) {
        return Diagnostic::error("E1005", here, format!("`{found}` is a reserved word")).help(help);
    }
    if let Some((start, word)) = bad_number(text, at) {
        let span = pre.span(start, start + word.len());
        return Diagnostic::error("E1001", span, format!("`{word}` is not a number"))
            .help("numbers are written `2`, `0x1F`, `2.5` or `2e-3`, without a suffix");
    }
    if let Some(c) = found.chars().next().filter(|c| !c.is_ascii()) {
        return Diagnostic::error("E1001", here, format!("`{c}` cannot stand here")).help(
            "names hold the letters a to z and A to Z, digits and `_`; other characters stand in strings and comments",
        );
    }
    if matches!(found, "@" | "$" | "`" | "#" | "\\" | "'") {
        return Diagnostic::error("E1001", here, format!("`{found}` means nothing in OSL"));
    }
    let positives = match &error.variant {
        ErrorVariant::ParsingError { positives, .. } => positives.as_slice(),
        ErrorVariant::CustomError { .. } => &[],
    };
    let found_words = if found.is_empty() { "the end of the file".to_string() } else { format!("`{found}`") };
    // A `;` that is missing belongs behind the token before, often on the line before; the line is that of the next token, as in
    // the reference implementation.
    let body = positives.contains(&Rule::block) || positives.contains(&Rule::lbrace);
    if positives.contains(&Rule::semi) && !positives.contains(&Rule::rparen) && !body {
        let message = format!("expected `;`, found {found_words}");
        return match found {
            "" => Diagnostic::error("E1001", pre.behind(at), message),
            _ => Diagnostic::error("E1001", here, message).label(pre.behind(at), "after this"),
        };
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
    if let Some(help) = help_for(found, positives) {
        diagnostic = diagnostic.help(help);
    }
    if let Some((bracket, place)) = open_bracket(text, at) {
        let closing = match bracket {
            '(' => Rule::rparen,
            '[' => Rule::rbracket,
            _ => Rule::rbrace,
        };
        // It is worth showing only when something else stands where it should close.
        if positives.contains(&closing) && (bracket != '{' || found.is_empty()) {
            diagnostic = diagnostic.label(pre.span(place, place + 1), format!("this `{bracket}` is still open"));
        }
    }
    diagnostic
}

/// The words of what may come, the most telling first; at most three.
fn expectation(positives: &[Rule]) -> Option<String> {
    const WORDS: [(Rule, &str); 17] = [
        (Rule::comma, "`,`"),
        (Rule::equals, "`=`"),
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
        (Rule::semi, "`;`"),
    ];
    let expression_starts = positives.contains(&Rule::float_lit) || positives.contains(&Rule::neg);
    let statement = positives.contains(&Rule::if_kw);
    let mut words: Vec<&str> = Vec::new();
    if statement {
        words.push("a statement");
    } else if expression_starts {
        words.push("an expression");
    }
    for (rule, text) in WORDS {
        let type_or_name = matches!(rule, Rule::ident | Rule::simple_type | Rule::type_spec);
        let hidden = expression_starts && type_or_name
            || statement && (type_or_name || matches!(rule, Rule::lbrace | Rule::block | Rule::semi))
            || positives.contains(&Rule::shader_kind) && type_or_name;
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

/// What to write instead of a word that other languages have and OSL only reserves.
fn instead_of(reserved: &str) -> Option<&'static str> {
    Some(match reserved {
        "bool" | "char" | "long" | "short" | "signed" | "unsigned" => "the integer type of OSL is `int`",
        "double" => "the floating-point type of OSL is `float`",
        "true" => "write `1`",
        "false" => "write `0`",
        "const" | "static" | "inline" | "extern" | "uniform" | "varying" => "leave it out",
        "switch" | "case" | "default" => "use `if` and `else`",
        "enum" | "typedef" | "template" => "a macro may do: `#define`",
        "class" | "union" | "friend" | "private" | "protected" | "this" | "virtual" | "sizeof" => {
            "choose another name; OSL has no such construct"
        }
        "illuminance" | "illuminate" => "OSL has no light loops: the renderer gathers light for the closures in Ci",
        _ => return None,
    })
}

fn help_for(found: &str, positives: &[Rule]) -> Option<&'static str> {
    Some(match found {
        "]" if positives.contains(&Rule::metadata_end) => "metadata closes with `]]`",
        "=" if positives.contains(&Rule::lparen) => "variables stand inside of shaders and functions",
        "=" if positives.contains(&Rule::ident) => "the type comes first: `type name = value`",
        "else" => "there is no `if` in front of this `else`",
        _ => return None,
    })
}

/// The innermost bracket that is open at a byte of the text, and where it stands.
fn open_bracket(text: &str, at: usize) -> Option<(char, usize)> {
    let mut open = Vec::new();
    let mut in_string = false;
    let mut escaped = false;
    for (i, c) in text[..at].char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' if in_string => escaped = true,
            '"' => in_string = !in_string,
            _ if in_string => {}
            '(' | '[' | '{' => open.push((c, i)),
            ')' | ']' | '}' => {
                open.pop();
            }
            _ => {}
        }
    }
    open.pop()
}

/// The run of letters, digits and dots around a byte, when it starts like a number and goes on as none.
fn bad_number(text: &str, at: usize) -> Option<(usize, &str)> {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    let start = text[..at].rfind(|c: char| !part(c)).map_or(0, |i| i + 1);
    let len = text[start..].find(|c: char| !part(c)).unwrap_or(text.len() - start);
    let word = &text[start..start + len];
    let numeric = word.starts_with(|c: char| c.is_ascii_digit())
        || word.starts_with('.') && word[1..].starts_with(|c: char| c.is_ascii_digit());
    (numeric && (word.parse::<f64>().is_err() || word.contains('_'))).then_some((start, word))
}
