//! Materials of a scene file.
//!
//! In: a table with a shader and its parameters. Out: a [`Material`]. Packages of compiled shaders are named, not opened. It must not know meshes, or what OSL means.

use super::error::{Error, suggest};
use super::value::{Table, Value};
use super::{Attributes, Material, ParamValue, shipped};
use crate::shader_file;
use std::path::{Path, PathBuf};
use toml::de::DeValue;

/// Reads `shader = "NAME, FILE.osl, FILE.oso or FILE.oslpak:NAME"`, `osl = "text"` or `group = "text"`, and `params`, which override the group's. The
/// caller, who knows all materials, reads `displacement`.
pub(super) fn read(table: &Table<'_>, name: &str) -> Result<Material, Error> {
    const WAYS: [&str; 3] = ["shader", "osl", "group"];
    table.only(&["shader", "osl", "group", "params", "displacement", "interactive", "attributes"])?;
    let given: Vec<(&str, Value<'_>)> = WAYS.iter().filter_map(|key| Some((*key, table.get(key)?))).collect();
    let mut material = match given.as_slice() {
        [("shader", shader)] => by_name(shader, shader.string()?, name)?,
        [("group", text)] => of_group(text, name)?,
        [(_, osl)] => Material::new(name, table.text.path.to_path_buf(), in_place(osl)?),
        [] => {
            let cause = format!(
                "`{}` needs a `shader` (a shipped one or a file), `osl` (its text) or `group` (a shader group's text)",
                table.name
            );
            return Err(Error::Conflict { at: table.at(), cause });
        }
        [(first, _), (second, value), ..] => {
            let cause = format!("`{}` has both `{first}` and `{second}`", table.name);
            return Err(Error::Conflict { at: value.at(), cause });
        }
    };
    if let Some(params) = table.get("params") {
        for (name, value) in params.table()?.entries() {
            material.params.retain(|(other, _)| other != name);
            material.params.push((name.to_string(), param(&value)?));
            if let Some(from) = &mut material.package {
                from.params_at.push((name.to_string(), value.at()));
            }
        }
    }
    if let Some(names) = table.get("interactive") {
        for name in names.items().ok_or_else(|| names.wrong_type("a list of names of parameters"))? {
            material.interactive.push(name.string()?.to_string());
        }
    }
    material.attributes = attributes(table)?;
    Ok(material)
}

/// The table `attributes` of a table; empty without one.
pub(super) fn attributes(table: &Table<'_>) -> Result<Attributes, Error> {
    let Some(value) = table.get("attributes") else { return Ok(Attributes::new()) };
    value.table()?.entries().map(|(name, value)| Ok((name.to_string(), param(&value)?))).collect()
}

/// OSL or a group's text from the scene file, behind as many empty lines and blanks as make its lines and columns those of the file.
/// (Escapes within the text are shorter than they look there.)
fn in_place(osl: &Value<'_>) -> Result<String, Error> {
    let (text, at) = (osl.string()?, osl.at());
    let written = osl.written();
    let quotes = if written.starts_with("\"\"\"") || written.starts_with("'''") { 3 } else { 1 };
    let rest = &written[quotes.min(written.len())..];
    // A line break right behind three quotes belongs to neither.
    let broken = quotes == 3 && (rest.starts_with('\n') || rest.starts_with("\r\n"));
    let (lines, blanks) = if broken { (at.line, 0) } else { (at.line - 1, at.column - 1 + quotes) };
    Ok("\n".repeat(lines) + &" ".repeat(blanks) + text)
}

/// A group: the compiler reads its text, which stands where it does in the scene file, so that errors name that file's lines.
fn of_group(text: &Value<'_>, name: &str) -> Result<Material, Error> {
    let (source, path) = (in_place(text)?, text.text.path.to_path_buf());
    Ok(Material { group: true, ..Material::new(name, path, source) })
}

/// The shader `wanted`, which `shader` names.
fn by_name(shader: &Value<'_>, wanted: &str, name: &str) -> Result<Material, Error> {
    let folder = shader.text.path.parent().unwrap_or(Path::new("")).to_owned();
    if let Some((package, shader_name)) = shader_file::in_package(wanted) {
        let mut material = Material::from_package(name, &folder.join(package), shader_name);
        if let Some(from) = &mut material.package {
            from.at = shader.at();
        }
        return Ok(material);
    }
    if shader_file::is_shader(Path::new(wanted)) {
        return of_file(folder.join(wanted), name, shader);
    }
    if shipped::shipped(wanted).is_some() {
        return Ok(Material::of_shipped(name, wanted));
    }
    match shader_file::find(wanted, &[folder]) {
        Some(path) => of_file(path, name, shader),
        None => {
            let help = suggest(wanted, shipped::names());
            Err(Error::UnknownName { at: shader.at(), what: "shipped shader", name: wanted.to_string(), help })
        }
    }
}

/// The shader in a file, OSL or `.oso`, which `shader` names.
fn of_file(path: PathBuf, name: &str, shader: &Value<'_>) -> Result<Material, Error> {
    let source = std::fs::read_to_string(&path).map_err(|cause| Error::UnreadablePart {
        at: shader.at(),
        what: "shader",
        path: path.clone(),
        cause: cause.to_string(),
    })?;
    Ok(Material::new(name, path, source))
}

fn param(value: &Value<'_>) -> Result<ParamValue, Error> {
    Ok(match value.raw() {
        DeValue::String(text) => ParamValue::Str(text.to_string()),
        DeValue::Boolean(yes) => ParamValue::Int(i64::from(*yes)),
        DeValue::Integer(_) => ParamValue::Int(value.integer()?),
        DeValue::Float(_) => ParamValue::Float(value.number()?),
        DeValue::Array(_) => return list(value),
        DeValue::Datetime(_) | DeValue::Table(_) => {
            return Err(value.wrong_type("a number, a string, a boolean, or a list of numbers or of strings"));
        }
    })
}

/// A list of strings, or of numbers and lists of numbers, whose nesting is dropped: `[[0, 0, 1], [1, 1, 1]]` is six.
fn list(value: &Value<'_>) -> Result<ParamValue, Error> {
    let items = value.items().unwrap_or_default();
    match items.first().map(Value::raw) {
        None => Err(value.wrong_type("a list of at least one number or string")),
        Some(DeValue::String(_)) => {
            let texts = items.iter().map(|item| item.string().map(str::to_string));
            texts.collect::<Result<_, _>>().map(ParamValue::Strs)
        }
        Some(_) => {
            let mut numbers = Vec::new();
            for item in &items {
                match item.items() {
                    None => numbers.push(item.number()?),
                    Some(row) => {
                        for number in row {
                            numbers.push(number.number()?);
                        }
                    }
                }
            }
            Ok(ParamValue::Floats(numbers))
        }
    }
}
