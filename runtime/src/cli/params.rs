//! Parameter values from the command line.
//!
//! In: `NAME=VALUE` texts and the shader's reflection. Out: the compiler's [`Binding`]s. What fits which type is for the
//! compiler to say; here is only decided whether a text means a string or numbers.

use super::Error;
use oslcl_compiler::{Binding, ShaderInfo};

/// All bindings, in order.
pub fn bindings(params: &[String], info: &ShaderInfo) -> Result<Vec<(String, Binding)>, Error> {
    params.iter().map(|text| binding(text, info)).collect()
}

fn binding(text: &str, info: &ShaderInfo) -> Result<(String, Binding), Error> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => {
            let name = name.trim();
            Ok((name.to_owned(), parse(value, declared(name, info))))
        }
        _ => Err(Error::Usage(format!("`--param {text}`: expected NAME=VALUE, such as --param Kd=0.5"))),
    }
}

/// The type of a parameter, or of a field `a.x` of one; empty when there is none.
fn declared<'a>(name: &str, info: &'a ShaderInfo) -> &'a str {
    let (head, field) = name.split_once('.').map_or((name, None), |(h, f)| (h, Some(f)));
    let Some(param) = info.params.iter().find(|p| p.name == head) else { return "" };
    match field {
        None => &param.ty,
        Some(f) => param.fields.iter().find(|x| x.name == f).map_or("", |x| &x.ty),
    }
}

fn parse(value: &str, ty: &str) -> Binding {
    if ty == "string" {
        return Binding::Str(unquote(value).to_owned());
    }
    if ty.starts_with("string[") {
        return Binding::Strs(value.split(',').map(|s| unquote(s.trim()).to_owned()).collect());
    }
    if let Ok(v) = value.trim().parse::<i64>() {
        return Binding::Int(v);
    }
    let numbers: Result<Vec<f64>, _> =
        value.trim_end_matches(',').split([',', ' ']).filter(|s| !s.is_empty()).map(str::parse).collect();
    match numbers {
        // A list of one number has a comma: `0.5,`.
        Ok(v) if v.len() == 1 && !value.contains(',') => Binding::Float(v[0]),
        Ok(v) if !v.is_empty() => Binding::Floats(v),
        _ => Binding::Str(unquote(value).to_owned()),
    }
}

/// Without the quotes around it, if any: shells differ in what they leave.
fn unquote(text: &str) -> &str {
    text.strip_prefix('"').and_then(|t| t.strip_suffix('"')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_become_values_by_the_declared_type() {
        assert_eq!(parse("3", "float"), Binding::Int(3));
        assert_eq!(parse("3", "string"), Binding::Str("3".into()));
        assert_eq!(parse("-1e-3", "float"), Binding::Float(-1e-3));
        assert_eq!(parse("1, 0.5 ,0", "color"), Binding::Floats(vec![1.0, 0.5, 0.0]));
        assert_eq!(parse("0.5,", "float[1]"), Binding::Floats(vec![0.5]));
        assert_eq!(parse("red", "color"), Binding::Str("red".into()));
        assert_eq!(parse("\"a\",b", "string[2]"), Binding::Strs(vec!["a".into(), "b".into()]));
        assert_eq!(parse("", "float"), Binding::Str(String::new()));
    }
}
