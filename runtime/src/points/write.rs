//! Point clouds that shaders write, as text: Houdini's classic geometry (.geo) and Maya's particles (.pda).
//!
//! In: what shaders said of points, in order. Out: files, all of them or none. It must not know shaders.

use crate::files;
use oslcl_compiler::messages::{FIELD, Kind, Message, PART};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// A file that can't be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Its name says nothing that is known.
    #[error("point cloud `{name}`: only .geo and .pda files are written")]
    Ending {
        /// The file.
        name: String,
    },
    /// The disk refuses.
    #[error(transparent)]
    Write(#[from] files::Error),
}

/// An attribute: name, type, and the texts of its values, by point.
struct Column<'a> {
    name: &'a str,
    ty: &'a str,
    values: Vec<(usize, &'a str)>,
}

/// The points of one file.
#[derive(Default)]
struct Points<'a> {
    count: usize,
    columns: Vec<Column<'a>>,
}

impl<'a> Points<'a> {
    /// What a point has; where a name comes with another type than before, that value is left out.
    fn add(&mut self, text: &'a str) {
        for field in text.split_terminator(FIELD) {
            let mut parts = field.splitn(3, PART);
            let (Some(name), Some(ty), Some(value)) = (parts.next(), parts.next(), parts.next()) else { continue };
            let at = self.columns.iter().position(|c| c.name == name).unwrap_or_else(|| {
                self.columns.push(Column { name, ty, values: Vec::new() });
                self.columns.len() - 1
            });
            let column = &mut self.columns[at];
            if column.ty == ty && column.values.last().is_none_or(|(i, _)| *i != self.count) {
                column.values.push((self.count, value));
            }
        }
        self.count += 1;
    }
}

impl<'a> Column<'a> {
    /// By point; where a point has nothing, zeros.
    fn all(&self, count: usize) -> Vec<&'a str> {
        let zero = match self.ty {
            "v" => "0 0 0",
            "s" => "",
            _ => "0",
        };
        let mut out = vec![zero; count];
        self.values.iter().for_each(|(i, value)| out[*i] = value);
        out
    }
}

/// Writes all point clouds among these messages; points in their order.
pub fn write(messages: &[Message]) -> Result<(), Error> {
    let mut clouds: BTreeMap<&str, Points<'_>> = BTreeMap::new();
    for message in messages {
        if let Kind::Cloud(file) = &message.kind {
            clouds.entry(file).or_default().add(&message.text);
        }
    }
    let mut outputs = Vec::with_capacity(clouds.len());
    for (name, points) in clouds {
        let path = Path::new(name);
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let text = match ending.as_str() {
            "geo" => geo(&points),
            "pda" => pda(&points),
            _ => return Err(Error::Ending { name: name.to_owned() }),
        };
        outputs.push(files::Output { path: path.to_owned(), bytes: text.into_bytes() });
    }
    if outputs.is_empty() { Ok(()) } else { Ok(files::replace(&outputs)?) }
}

/// A string as a word of the file.
fn quoted(text: &str) -> String {
    let clean: String = text.chars().map(|c| if c == '"' || c.is_control() { ' ' } else { c }).collect();
    if clean.is_empty() || clean.contains([' ', '(', ')', '[', ']']) { format!("\"{clean}\"") } else { clean }
}

fn geo(points: &Points<'_>) -> String {
    let count = points.count;
    let (positions, rest): (Vec<_>, Vec<_>) = points.columns.iter().partition(|c| c.name == "position");
    let mut out = format!(
        "PGEOMETRY V5\nNPoints {count} NPrims 1\nNPointGroups 0 NPrimGroups 0\nNPointAttrib {} NVertexAttrib 0 NPrimAttrib 1 \
         NAttrib 0\n",
        rest.len()
    );
    if !rest.is_empty() {
        out.push_str("PointAttrib\n");
    }
    // Strings are listed, and named by number.
    let mut numbers: Vec<Vec<String>> = Vec::new();
    for column in &rest {
        let mut values: Vec<String> = column.all(count).into_iter().map(str::to_owned).collect();
        let name = quoted(column.name);
        match column.ty {
            "s" => {
                let mut texts: Vec<String> = Vec::new();
                for value in &mut values {
                    let at = texts.iter().position(|t| t == value).unwrap_or_else(|| {
                        texts.push(value.clone());
                        texts.len() - 1
                    });
                    *value = at.to_string();
                }
                let texts: Vec<String> = texts.iter().map(|t| quoted(t)).collect();
                let _ = writeln!(out, "{name} 1 index {} {}", texts.len(), texts.join(" "));
            }
            "v" => out.push_str(&format!("{name} 3 vector 0 0 0\n")),
            "i" => out.push_str(&format!("{name} 1 int 0\n")),
            _ => out.push_str(&format!("{name} 1 float 0\n")),
        }
        numbers.push(values);
    }
    let places = positions.first().map_or_else(|| vec!["0 0 0"; count], |c| c.all(count));
    for (i, place) in places.iter().enumerate() {
        let _ = write!(out, "{place} 1");
        let values: Vec<&str> = numbers.iter().map(|column| column[i].as_str()).collect();
        let _ = if values.is_empty() { writeln!(out) } else { writeln!(out, " ({})", values.join("\t")) };
    }
    out.push_str("PrimitiveAttrib\ngenerator 1 index 1 papi\nPart ");
    let _ = write!(out, "{count}");
    for i in 0..count {
        let _ = write!(out, " {i}");
    }
    out.push_str(" [0]\nbeginExtra\nendExtra\n");
    out
}

/// Strings have no place in such files.
fn pda(points: &Points<'_>) -> String {
    let columns: Vec<&Column<'_>> = points.columns.iter().filter(|c| c.ty != "s").collect();
    let names: Vec<&str> = columns.iter().map(|c| c.name).collect();
    let letter = |c: &&Column<'_>| match c.ty {
        "v" => "V",
        "i" => "I",
        _ => "R",
    };
    let types: Vec<&str> = columns.iter().map(letter).collect();
    let mut out = format!(
        "ATTRIBUTES\n {}\nTYPES\n {}\nNUMBER_OF_PARTICLES: {}\nBEGIN DATA\n",
        names.join(" "),
        types.join(" "),
        points.count
    );
    let values: Vec<Vec<&str>> = columns.iter().map(|c| c.all(points.count)).collect();
    for i in 0..points.count {
        let row: Vec<&str> = values.iter().map(|column| column[i]).collect();
        let _ = writeln!(out, "{}", row.join(" "));
    }
    out
}
