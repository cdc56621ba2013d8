//! `oslcl info`: a shader's parameters and metadata, or what is in a package, for people or as JSON.

use super::args::InfoArgs;
use super::sources::{self, Folders};
use super::{Error, package, report, terminal};
use oslcl_compiler::ShaderInfo;
use oslcl_compiler::reflect::{Metadata, Param, Value};
use std::fmt::Write;

/// Prints the reflection.
pub fn run(args: &InfoArgs) -> Result<(), Error> {
    if let Some((file, name)) = package::named(&args.shader) {
        return package::show(args, &file, name.as_deref());
    }
    let source = sources::read_or_shipped(&args.shader)?;
    let options = sources::options(&source, &args.source)?;
    let master = report::master(&source.text, &options, &Folders::new(&args.source))?;
    if args.json {
        // Serialising to memory fails only for maps with keys that are no strings, and there are no maps here.
        let json = serde_json::to_string_pretty(master.info()).unwrap_or_default();
        terminal::print(&format!("{json}\n"))
    } else {
        terminal::print(&text(master.info(), &|_| String::new()))
    }
}

/// The reflection for people; `note` says what stands behind a parameter's default.
pub(super) fn text(info: &ShaderInfo, note: &dyn Fn(&str) -> String) -> String {
    let mut out = format!("{} {}\n", info.kind, info.name);
    metadata(&mut out, &info.metadata, "    ");
    for param in &info.params {
        one(&mut out, param, &note(&param.name));
    }
    out
}

fn one(out: &mut String, param: &Param, note: &str) {
    let output = if param.output { "output " } else { "" };
    let _ = write!(out, "\n  {output}{} {}", param.ty, param.name);
    match &param.default {
        Some(value) => {
            let _ = writeln!(out, " = {}{note}", show(value));
        }
        None => {
            let _ = writeln!(out, "{note}");
        }
    }
    for field in &param.fields {
        let _ = writeln!(out, "      .{} ({})", field.name, field.ty);
    }
    metadata(out, &param.metadata, "      ");
}

fn metadata(out: &mut String, list: &[Metadata], indent: &str) {
    for datum in list {
        let value = datum.value.as_ref().map_or("(computed)".to_owned(), show);
        let _ = writeln!(out, "{indent}{}: {value}", datum.name);
    }
}

/// As OSL writes it: numbers with spaces between, strings in quotes, arrays in braces.
fn show(value: &Value) -> String {
    match value {
        Value::Int(v) => v.to_string(),
        Value::Float(v) => number(*v),
        Value::Str(s) => format!("{s:?}"),
        Value::List(items) if items.iter().any(|i| matches!(i, Value::List(_) | Value::Str(_))) => {
            format!("{{ {} }}", items.iter().map(show).collect::<Vec<_>>().join(", "))
        }
        Value::List(items) => items.iter().map(show).collect::<Vec<_>>().join(" "),
    }
}

/// Values of `float` are kept in more digits than they have.
fn number(v: f64) -> String {
    let short = v as f32;
    let text = if f64::from(short) == v { short.to_string() } else { v.to_string() };
    text.trim_end_matches(".0").to_owned()
}
