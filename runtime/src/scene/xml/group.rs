//! A `<ShaderGroup>` as a group's text, each statement where it stands in the scene file, so that errors name that file's lines.
//!
//! In: an element. Out: the text (specification ch. 9) and warnings. It must not know shaders.

use super::super::error::{Error, Location};
use super::node::{Attribute, Element, Piece};

/// The attribute `commands`, or without one the texts within; then what the elements within say.
pub(super) fn text(element: &Element<'_, '_>) -> Result<(String, Vec<String>), Error> {
    let mut pieces: Vec<(Location, String)> = Vec::new();
    let mut warnings = Vec::new();
    match element.get("commands").filter(|c| !c.text.trim().is_empty()) {
        Some(commands) => pieces.push((commands.at(), commands.text.to_owned())),
        None => pieces.extend(element.texts().map(|Piece { at, text }| (at, text.to_owned()))),
    }
    for child in element.children() {
        match child.name() {
            "Parameter" => pieces.extend(child.attributes().map(|a| (a.at(), parameter(&a)))),
            "Shader" => {
                warnings.extend(child.unknown_attributes(&["type", "name", "layer"]));
                let [name, layer] = ["name", "layer"].map(|key| child.need(key));
                pieces.push((child.at(), format!("shader {} {};", quoted(name?.text), quoted(layer?.text))));
            }
            "ConnectShaders" => {
                const ENDS: [&str; 4] = ["srclayer", "srcparam", "dstlayer", "dstparam"];
                warnings.extend(child.unknown_attributes(&ENDS));
                let [a, b, c, d] = ENDS.map(|key| child.need(key));
                let (from, to) = (format!("{}.{}", a?.text, b?.text), format!("{}.{}", c?.text, d?.text));
                pieces.push((child.at(), format!("connect {from} {to};")));
            }
            name => warnings.push(child.unknown_element(name, &["Parameter", "Shader", "ConnectShaders"])),
        }
    }
    if pieces.is_empty() {
        let cause = "<ShaderGroup> is empty: it needs a group's text, `commands`, or <Shader> elements".to_owned();
        return Err(Error::Conflict { at: element.at(), cause });
    }
    // Text between elements comes in the order of the file.
    pieces.sort_by_key(|(at, _)| (at.line, at.column));
    Ok((in_place(&pieces), warnings))
}

/// A value with the word for its type in front; what has none is a string.
fn parameter(value: &Attribute<'_>) -> String {
    let name = value.key;
    let (word, rest) = value.text.trim().split_once(char::is_whitespace).unwrap_or(("", ""));
    let whole = rest.split_whitespace().map(|n| n.parse::<i32>().is_ok());
    let real = rest.split_whitespace().map(|n| n.parse::<f64>().is_ok_and(f64::is_finite));
    let numbers: Vec<bool> = if word == "int" { whole.collect() } else { real.collect() };
    let width = match word {
        "int" | "float" => 1,
        "vector" | "point" | "color" => 3,
        _ => 0,
    };
    if width > 0 && numbers.len() == width && numbers.iter().all(|good| *good) {
        return format!("param {word} {name} {rest};");
    }
    format!("param string {name} {};", quoted(value.text))
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// All texts in one, behind as many line breaks and blanks as bring each to its place, where there is room for it.
fn in_place(pieces: &[(Location, String)]) -> String {
    let (mut out, mut line, mut column) = (String::new(), 1, 1);
    for (at, text) in pieces {
        if !out.is_empty() {
            out.push(' ');
            column += 1;
        }
        while line < at.line {
            out.push('\n');
            (line, column) = (line + 1, 1);
        }
        while line == at.line && column < at.column {
            out.push(' ');
            column += 1;
        }
        out.push_str(text);
        line += text.matches('\n').count();
        column = match text.rfind('\n') {
            Some(last) => text[last + 1..].chars().count() + 1,
            None => column + text.chars().count(),
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::value::Text;
    use std::path::Path;

    fn of(source: &str) -> String {
        let document = roxmltree::Document::parse(source).expect("good XML");
        let text = Text { path: Path::new("a.xml"), source };
        super::text(&Element::new(document.root_element(), text)).map_or_else(|e| e.to_string(), |(t, _)| t)
    }

    #[test]
    fn statements_keep_their_places() {
        assert_eq!(of("<ShaderGroup>\n  shader a b;</ShaderGroup>"), "             \n  shader a b;");
        assert_eq!(of("<G commands=\"shader a b;\">float x 1;</G>"), "             shader a b;");
        let children =
            "<G>\n<Parameter Kd=\"float 0.5\" s=\"wood\" p=\"point 1 2\"/>\n<Shader name=\"a\" layer=\"b\"/></G>";
        let lines: Vec<String> = of(children).lines().map(|l| l.trim().to_owned()).collect();
        assert_eq!(
            lines,
            ["", "param float Kd 0.5; param string s \"wood\"; param string p \"point 1 2\";", "shader \"a\" \"b\";"]
        );
        let connect = "<G>shader a b;<ConnectShaders srclayer='a' srcparam='o' dstlayer='b' dstparam='i'/></G>";
        assert!(of(connect).ends_with("shader a b; connect a.o b.i;"), "{}", of(connect));
        assert!(of("<G/>").starts_with("a.xml:1:1: <ShaderGroup> is empty"));
    }
}
