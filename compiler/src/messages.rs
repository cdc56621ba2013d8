//! What a shader says to the host: `printf`, `fprintf`, `error`, `warning`.
//!
//! The device writes a record per call: the number of the [`Site`] that printed, then the values that only the device knows.
//! In: the artifact's sites and strings, and the records' words. Out: [`Message`]s. It must not know devices.

use crate::ir::{Const, Ty};
use crate::strings::string_id;
use crate::text::{self, Rules};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Stands in the formats of reports for `FILE:LINE` of the call: only who has the sources can tell it (the facade does).
pub const PLACE: &str = "\u{1}place";

/// Stands in the formats of reports for the group's name: `link` knows it.
pub const GROUP: &str = "\u{1}group";

/// Stands in the formats of reports for the layer's number and name: `link` knows them.
pub const LAYER: &str = "\u{1}layer";

/// Where a message goes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// `printf`
    Print,
    /// `error`
    Error,
    /// `warning`
    Warning,
    /// `fprintf`: the name of the file.
    File(String),
    /// `pointcloud_write`: the name of the file. The text is what the point has: fields behind [`FIELD`], each a name, a type
    /// (`i f v s`, as in the names of kernel functions) and a value between [`PART`]s; the first is `position`.
    Cloud(String),
}

/// Ends a field of what a point of a cloud has.
pub const FIELD: char = '\u{1e}';

/// Stands between the parts of such a field.
pub const PART: char = '\u{1f}';

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// What said it.
    pub kind: Kind,
    /// The number of the point that was shaded, in the order of the grid: row by row.
    pub point: u32,
    /// The text; of errors and warnings with the reference's words in front (`Shader error [NAME]: `).
    pub text: String,
}

/// The number of a kind in the IR's `print` calls, which have as arguments: this number, the file's or the shader's name,
/// the format, then the values.
pub mod code {
    /// `printf`; its name is empty.
    pub const PRINT: i32 = 0;
    /// `error`, with the shader's name; without one it is the renderer that speaks.
    pub const ERROR: i32 = 1;
    /// `warning`, with the shader's name.
    pub const WARNING: i32 = 2;
    /// `fprintf`, with the file's name.
    pub const FILE: i32 = 3;
    /// `pointcloud_write`, with the file's name.
    pub const CLOUD: i32 = 5;
    /// What the runtime itself finds wrong: an error without words in front.
    pub const RUNTIME: i32 = 4;
}

/// An argument of a [`Site`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SiteArg {
    /// Known at compile time: not part of the record.
    Constant(Const),
    /// In the record, as so many values of this type, one behind the other: an int or a string's id one word, floats (as
    /// 32-bit ones) one word, triples three, matrices sixteen.
    Value {
        /// `i f v m s`, as in the names of kernel functions.
        ty: char,
        /// Elements; `None`: no array.
        len: Option<u32>,
    },
}

/// A call of the code that prints; its arguments are those of the IR's `print`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Site {
    /// Kind, name, format, values.
    pub args: Vec<SiteArg>,
}

/// Words of one value in a record.
pub fn words_of(ty: Ty) -> u32 {
    match ty {
        Ty::Triple => 3,
        Ty::Matrix => 16,
        _ => 1,
    }
}

/// The records that lie one behind the other in these words; each has at least three.
pub fn records(words: &[u32]) -> Result<Vec<&[u32]>, Damaged> {
    let mut out = Vec::new();
    let mut rest = words;
    while let Some(size) = rest.first() {
        let (record, behind) = rest.split_at_checked(*size as usize).filter(|_| *size >= 3).ok_or(Damaged)?;
        out.push(record);
        rest = behind;
    }
    Ok(out)
}

/// Decodes records.
#[derive(Clone, Debug)]
pub struct Decoder<'a> {
    sites: &'a [Site],
    strings: HashMap<u32, &'a str>,
}

/// Records are not what the code of this artifact writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the messages that came back from the device are damaged")]
pub struct Damaged;

impl<'a> Decoder<'a> {
    /// For the artifact with these sites and strings.
    pub fn new(sites: &'a [Site], strings: impl IntoIterator<Item = &'a String>) -> Decoder<'a> {
        let strings = strings.into_iter().map(|s| (string_id(s), s.as_str())).collect();
        Decoder { sites, strings }
    }

    /// The messages of records that lie one behind the other: words of the record, point, site, values. By points, then in
    /// the order of the records.
    pub fn messages(&self, words: &[u32]) -> Result<Vec<Message>, Damaged> {
        let records = records(words)?;
        let mut out = records.iter().map(|r| self.message(r[1], r[2], &r[3..])).collect::<Result<Vec<_>, _>>()?;
        // Stable: a point's records stay as they are.
        out.sort_by_key(|m| m.point);
        Ok(out)
    }

    fn message(&self, point: u32, site: u32, record: &[u32]) -> Result<Message, Damaged> {
        let site = self.sites.get(site as usize).ok_or(Damaged)?;
        let mut record = record.iter().copied();
        let mut args = Vec::with_capacity(site.args.len());
        for arg in &site.args {
            args.push(match arg {
                SiteArg::Constant(c) => c.clone(),
                SiteArg::Value { ty, len: None } => self.value(*ty, &mut record)?,
                SiteArg::Value { ty, len: Some(n) } => {
                    let items = (0..*n).map(|_| self.value(*ty, &mut record));
                    Const::Array(items.collect::<Result<_, _>>()?)
                }
            });
        }
        said(&args).map(|(kind, text)| Message { kind, point, text }).ok_or(Damaged)
    }

    fn value(&self, ty: char, words: &mut impl Iterator<Item = u32>) -> Result<Const, Damaged> {
        let mut word = || words.next().ok_or(Damaged);
        let float = |w: u32| f64::from(f32::from_bits(w));
        Ok(match ty {
            'f' => Const::Float(float(word()?)),
            'v' => Const::Triple([float(word()?), float(word()?), float(word()?)]),
            'm' => {
                let mut m = [0.0; 16];
                for x in &mut m {
                    *x = float(word()?);
                }
                Const::Matrix(m)
            }
            's' => {
                let id = word()?;
                let known = self.strings.get(&id).map(|s| (*s).to_owned());
                Const::Str(known.unwrap_or_else(|| if id == 0 { String::new() } else { format!("<string {id:08x}>") }))
            }
            _ => Const::Int(word()? as i32),
        })
    }
}

/// What a `print` call with these arguments says; `None` when they are not those of one.
pub fn said(args: &[Const]) -> Option<(Kind, String)> {
    let [Const::Int(code), Const::Str(name), Const::Str(pattern), values @ ..] = args else { return None };
    let kind = match *code {
        code::PRINT => Kind::Print,
        code::ERROR | code::RUNTIME => Kind::Error,
        code::WARNING => Kind::Warning,
        code::FILE => Kind::File(name.clone()),
        code::CLOUD => Kind::Cloud(name.clone()),
        _ => return None,
    };
    let Some(text) = text::format(pattern, values, Rules::Fmt) else {
        return Some((Kind::Error, "Mismatch between format string and arguments".to_owned()));
    };
    let text = match kind {
        // The renderer's own words.
        Kind::Error if name.is_empty() || *code == code::RUNTIME => text,
        Kind::Error => format!("Shader error [{name}]: {text}"),
        Kind::Warning => format!("Shader warning [{name}]: {text}"),
        _ => text,
    };
    Some((kind, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_become_messages_in_order_of_points() {
        let constant = |s: &str| SiteArg::Constant(Const::Str(s.into()));
        let site = |code, name, pattern| {
            let mut args = vec![SiteArg::Constant(Const::Int(code)), constant(name), constant(pattern)];
            args.push(SiteArg::Value { ty: 's', len: Some(2) });
            args.push(SiteArg::Value { ty: 'f', len: None });
            Site { args }
        };
        let sites = [site(code::PRINT, "", "%s: %g"), site(code::ERROR, "glass", "%s %g")];
        let strings = ["a".to_owned()];
        let decoder = Decoder::new(&sites, &strings);
        let a = string_id("a");
        let words = [6, 1, 1, a, 0, 1.5f32.to_bits(), 6, 0, 0, a, a, 2.0f32.to_bits()];
        let messages = decoder.messages(&words).expect("records");
        assert_eq!(messages[0], Message { kind: Kind::Print, point: 0, text: "a a: 2".into() });
        let text = "Shader error [glass]: a  1.5".to_owned();
        assert_eq!(messages[1], Message { kind: Kind::Error, point: 1, text });
        assert_eq!(decoder.messages(&words[..5]), Err(Damaged));
        assert_eq!(decoder.messages(&[3, 0, 9]), Err(Damaged));
    }
}
