//! Shader groups in OSL's serialised form (specification ch. 9), of one shader so far.
//!
//! In: text such as `param float Kd 0.8; shader matte layer1;`. Out: the shader's name and its parameters, or what is wrong in
//! words. It must not know scene files.

use super::ParamValue;

/// A group of one shader.
#[derive(Debug, PartialEq)]
pub(super) struct Group {
    /// The shader's name.
    pub shader: String,
    /// Values in order.
    pub params: Vec<(String, ParamValue)>,
}

/// A word, number or string; `text` is without quotes.
struct Token {
    text: String,
    quoted: bool,
}

/// Reads a group's text.
pub(super) fn parse(text: &str) -> Result<Group, String> {
    let mut params = Vec::new();
    let mut shader = None;
    for statement in statements(text)? {
        let words: Vec<&str> = statement.iter().map(|t| t.text.as_str()).collect();
        match words[0] {
            "param" => params.push(param(&statement)?),
            "shader" if shader.is_some() => {
                return Err("a group of more than one shader is not supported yet".into());
            }
            "shader" => match words[..] {
                [_, name, _layer] => shader = Some(name.to_string()),
                _ => return Err("`shader` takes the shader's name and the layer's".into()),
            },
            "connect" => return Err("`connect` is not supported yet: a group has one shader so far".into()),
            other => return Err(format!("`{other}` is none of `param`, `shader` and `connect`")),
        }
        if shader.is_some() && words[0] == "param" {
            return Err("a `param` after the last `shader` belongs to none".into());
        }
    }
    let shader = shader.ok_or("no `shader` statement")?;
    Ok(Group { shader, params })
}

/// Statements up to their semicolons, without `[[ hints ]]` and `#` comments.
fn statements(text: &str) -> Result<Vec<Vec<Token>>, String> {
    let mut out = Vec::new();
    let mut current: Vec<Token> = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let used = match first {
            ';' => {
                if !current.is_empty() {
                    out.push(std::mem::take(&mut current));
                }
                1
            }
            '#' => rest.find('\n').unwrap_or(rest.len()),
            '"' => {
                let (string, length) = quoted(rest)?;
                current.push(Token { text: string, quoted: true });
                length
            }
            _ if rest.starts_with("[[") => rest.find("]]").ok_or("`[[` without `]]`")? + 2,
            _ => {
                let ends = |c: char| c.is_whitespace() || matches!(c, ';' | '"' | '#');
                let length = rest.find(ends).unwrap_or(rest.len());
                current.push(Token { text: rest[..length].to_string(), quoted: false });
                length
            }
        };
        rest = rest[used..].trim_start();
    }
    // The last semicolon may be missing, as in the reference implementation.
    if !current.is_empty() {
        out.push(current);
    }
    Ok(out)
}

/// A string's text and its length with quotes.
fn quoted(rest: &str) -> Result<(String, usize), String> {
    let mut text = String::new();
    let mut chars = rest.char_indices().skip(1);
    while let Some((at, c)) = chars.next() {
        match c {
            '"' => return Ok((text, at + 1)),
            '\\' => text.push(match chars.next() {
                Some((_, 'n')) => '\n',
                Some((_, 't')) => '\t',
                Some((_, other)) => other,
                None => break,
            }),
            other => text.push(other),
        }
    }
    Err("a string without its closing quote".into())
}

/// `param TYPE NAME VALUES...`; values that are missing are 0.
fn param(statement: &[Token]) -> Result<(String, ParamValue), String> {
    let [_, ty, name, values @ ..] = statement else {
        return Err("`param` takes a type, a name and values".into());
    };
    let (base, is_array) = match ty.text.split_once('[') {
        Some((base, _)) => (base, true),
        None => (ty.text.as_str(), false),
    };
    let width = match base {
        "int" | "float" | "string" => 1,
        "color" | "point" | "vector" | "normal" => 3,
        "matrix" => 16,
        other => return Err(format!("`{other}` is no type of a parameter")),
    };
    if values.is_empty() || (!is_array && values.len() > width) {
        return Err(format!("parameter `{}` of type `{}` has {} values", name.text, ty.text, values.len()));
    }
    let number = |t: &Token| {
        let wrong = || format!("parameter `{}`: `{}` is no number", name.text, t.text);
        if t.quoted { Err(wrong()) } else { t.text.parse::<f64>().map_err(|_| wrong()) }
    };
    let value = match (base, is_array) {
        ("string", false) => ParamValue::Str(values[0].text.clone()),
        ("string", true) => ParamValue::Strs(values.iter().map(|t| t.text.clone()).collect()),
        ("int", false) => {
            let wrong = |_| format!("parameter `{}`: `{}` is no int", name.text, values[0].text);
            ParamValue::Int(values[0].text.parse().map_err(wrong)?)
        }
        ("float", false) => ParamValue::Float(number(&values[0])?),
        _ => {
            let mut numbers = values.iter().map(number).collect::<Result<Vec<f64>, String>>()?;
            numbers.resize(numbers.len().next_multiple_of(width), 0.0);
            ParamValue::Floats(numbers)
        }
    };
    Ok((name.text.clone(), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_of_one_shader() {
        let text = "param float Kd 0.8 [[ int lockgeom = 0 ]];\n# note; ignored\nparam color Cs 1 0.5;\n\
                    param string s \"a;\\\"b\"; param int[2] i 1 2; shader matte layer1;";
        let params = [
            ("Kd", ParamValue::Float(0.8)),
            ("Cs", ParamValue::Floats(vec![1.0, 0.5, 0.0])),
            ("s", ParamValue::Str("a;\"b".into())),
            ("i", ParamValue::Floats(vec![1.0, 2.0])),
        ];
        let params = params.map(|(n, v)| (n.to_string(), v)).to_vec();
        assert_eq!(parse(text), Ok(Group { shader: "matte".into(), params }));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, part) in [
            ("", "no `shader`"),
            ("shader a b; shader c d;", "more than one"),
            ("shader a b; connect a.x b.y;", "not supported yet"),
            ("shader a;", "layer"),
            ("param float x;", "values"),
            ("param float x 1 2; shader a b;", "has 2 values"),
            ("param float x y; shader a b;", "`y` is no number"),
            ("param blob x 1; shader a b;", "`blob` is no type"),
            ("param string x \"y; shader a b;", "closing quote"),
            ("shade a b;", "`shade` is none of"),
            ("shader a b; param int x 1;", "belongs to none"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
