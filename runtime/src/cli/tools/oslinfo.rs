//! `oslinfo`: a shader's parameters, defaults and metadata, as the reference implementation's tool prints them.
//!
//! In: the command line. Out: text or JSON on standard output; a shader that cannot be had is a line there, as in the
//! reference. Takes `.oso` files and OSL.

use super::super::args::SourceArgs;
use super::super::sources::{self, Folders};
use super::super::{Error, terminal};
use super::options::{self, Spec, Takes, spec};
use oslcl_compiler::escape::escape;
use oslcl_compiler::oso::number::general;
use oslcl_compiler::reflect::{Metadata, Value};
use oslcl_compiler::{Options, Query, QueryParam, query_shader};
use oslcl_runtime::shader_file;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

const TABLE: &[Spec] = &[
    spec(&["v"], Takes::Nothing, "Verbose output"),
    spec(&["runstats"], Takes::Nothing, "Benchmark the time to load each shader"),
    spec(&["p"], Takes::Values(1), "SEARCHPATH: folders to look for shaders in, with `:` between"),
    spec(&["param"], Takes::Values(1), "NAME: tell about this parameter only"),
    spec(&["json"], Takes::Nothing, "Print JSON for other tools"),
    spec(&["help", "h"], Takes::Nothing, "Print this help"),
    spec(&["version"], Takes::Nothing, "Print the version"),
];

/// Runs the tool.
pub fn run(args: &[String]) -> Result<ExitCode, Error> {
    let items = options::read(args, TABLE).map_err(|e| Error::Usage(format!("oslinfo: {e}")))?;
    let has = |name: &str| items.iter().any(|i| i.name == name);
    let value = |name: &str| items.iter().rev().find(|i| i.name == name).map(|i| i.value().to_owned());
    if has("version") {
        terminal::print(concat!("oslinfo (oslcl ", env!("CARGO_PKG_VERSION"), ")\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    if has("help") || !has("") {
        let head = "oslinfo -- list the parameters of OSL shaders\nUsage:  oslinfo [options] file0 [file1 ...]\n";
        terminal::print(&format!("{head}{}", options::help(TABLE)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let path = value("p").unwrap_or_default();
    let only = value("param");
    let mut queries = Vec::new();
    let mut code = ExitCode::SUCCESS;
    for item in items.iter().filter(|i| i.name.is_empty()) {
        let start = Instant::now();
        match load(item.value(), &path) {
            Err(cause) => {
                terminal::print(&format!("ERROR opening shader \"{}\" ({cause})\n", item.value()))?;
                // Text is read by people, JSON by tools that look at the exit code.
                if has("json") {
                    code = ExitCode::FAILURE;
                }
            }
            Ok(_) if has("runstats") => {
                terminal::print(&format!("{:.6} sec for {}\n", start.elapsed().as_secs_f64(), item.value()))?;
            }
            Ok(query) if has("json") => queries.push(query),
            Ok(query) => terminal::print(&text(&query, has("v"), only.as_deref()))?,
        }
    }
    if has("json") {
        if let Some(name) = only {
            queries.iter_mut().for_each(|q| q.params.retain(|p| p.name == name));
        }
        // Serialising to memory fails only for maps with keys that are no strings, and there are no maps here.
        let json = match queries.as_slice() {
            [one] => serde_json::to_string_pretty(one),
            list => serde_json::to_string_pretty(list),
        };
        terminal::print(&format!("{}\n", json.unwrap_or_default()))?;
    }
    Ok(code)
}

/// Finds and asks a shader; the error is one line.
fn load(name: &str, search: &str) -> Result<Query, String> {
    let folders: Vec<PathBuf> =
        if search.is_empty() { vec![PathBuf::new()] } else { std::env::split_paths(search).collect() };
    let file = shader_file::find(name, &folders).ok_or_else(|| format!("File \"{name}\" could not be found."))?;
    let source = sources::read(&file).map_err(|e| e.to_string())?;
    let options = Options { file_name: source.name.clone(), ..Options::default() };
    let folders = Folders::new(&SourceArgs { include: Vec::new(), define: Vec::new(), closures: Vec::new() });
    query_shader(&source.text, &options, &folders).map_err(|failure| {
        let first = failure.to_string();
        first.lines().next().unwrap_or_default().to_owned()
    })
}

/// What the reference's tool prints.
fn text(query: &Query, verbose: bool, only: Option<&str>) -> String {
    let mut out = String::new();
    if only.is_none() {
        let _ = writeln!(out, "{} \"{}\"", query.kind, query.name);
        if verbose {
            query.metadata.iter().for_each(|m| metadata(&mut out, m));
        }
    }
    for param in query.params.iter().filter(|p| only.is_none_or(|name| p.name == name)) {
        let output = if param.output { "output " } else { "" };
        if verbose {
            let _ = writeln!(out, "    \"{}\" \"{output}{}\"", param.name, param.ty);
        } else {
            let _ = write!(out, "{output}{} {} ", param.ty, param.name);
        }
        match (&param.fields, &param.default) {
            (Some(fields), _) => {
                let field = |f: &String| {
                    let name = format!("{}.{f}", param.name);
                    let found = query.params.iter().find(|p| p.name == name);
                    found.map_or("UNKNOWN".to_owned(), |p| format!("{} {f}", p.ty))
                };
                let list: Vec<String> = fields.iter().map(field).collect();
                let _ = writeln!(out, "{}fields: {{{}}}", if verbose { "\t\t" } else { "" }, list.join(", "));
            }
            (None, None) if verbose => out.push_str("\t\tUnknown default value\n"),
            (None, None) => out.push_str("nodefault\n"),
            (None, Some(values)) => default(&mut out, param, values, verbose),
        }
        if verbose {
            param.metadata.iter().for_each(|m| metadata(&mut out, m));
        }
    }
    out
}

fn default(out: &mut String, param: &QueryParam, values: &[Value], verbose: bool) {
    if values.iter().all(|v| matches!(v, Value::Str(_))) {
        for value in values {
            if verbose {
                let _ = writeln!(out, "\t\tDefault value: {}", show(value));
            } else {
                let _ = write!(out, "{} ", show(value));
            }
        }
        if !verbose {
            out.push('\n');
        }
        return;
    }
    if verbose {
        out.push_str("\t\tDefault value:");
    }
    if param.brackets {
        out.push_str(" [");
    }
    for value in values {
        let _ = write!(out, " {}", show(value));
    }
    out.push_str(if param.brackets { " ]\n" } else { "\n" });
}

fn metadata(out: &mut String, datum: &Metadata) {
    let _ = write!(out, "\t\tmetadata: {} {} =", datum.ty, datum.name);
    let mut todo: Vec<&Value> = datum.value.iter().collect();
    while let Some(value) = todo.pop() {
        match value {
            Value::List(items) => todo.extend(items.iter().rev()),
            one => {
                let _ = write!(out, " {}", show(one));
            }
        }
    }
    out.push('\n');
}

/// Numbers have six digits, as C++ prints them.
fn show(value: &Value) -> String {
    match value {
        Value::Int(v) => v.to_string(),
        Value::Float(v) => general(f64::from(*v as f32), 6),
        Value::Str(s) => format!("\"{}\"", escape(s)),
        Value::List(items) => items.iter().map(show).collect::<Vec<_>>().join(" "),
    }
}
