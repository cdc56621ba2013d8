//! The files of point clouds that are text: Houdini's classic geometry (.geo) and Maya's particles (.pda).
//!
//! In: a path. Out: a [`Cloud`], or why there is none. Numbers in headers are not trusted: only what is there is kept.

use super::{Attribute, Cloud, Data};
use std::path::Path;

/// Largest file that is read, in bytes.
const MOST_BYTES: u64 = 1 << 32;

/// Most numbers of an attribute of a point.
const MOST_NUMBERS: usize = 64;

/// Reads a file, by the ending of its name.
pub fn read(path: &Path) -> Result<Cloud, String> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let parse = match ending.as_str() {
        "geo" => geo,
        "pda" => pda,
        _ => return Err("only .geo (of Houdini's classic form) and .pda files are read".to_owned()),
    };
    let size = std::fs::metadata(path).map_err(|e| e.to_string())?.len();
    if size > MOST_BYTES {
        return Err(format!("it has {size} bytes, at most {MOST_BYTES} are read"));
    }
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let text = String::from_utf8(bytes).map_err(|_| "it is no text".to_owned())?;
    parse(&text)
}

/// Words of a text with their lines; parentheses are words of their own, quoted ones may hold blanks.
struct Words<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Words<'a> {
    fn skip_blanks(&mut self) {
        let trimmed = self.rest.trim_start();
        let blanks = &self.rest[..self.rest.len() - trimmed.len()];
        self.line += blanks.bytes().filter(|b| *b == b'\n').count();
        self.rest = trimmed;
    }

    fn next(&mut self) -> Option<&'a str> {
        self.skip_blanks();
        let rest = self.rest;
        let first = rest.chars().next()?;
        let (word, behind) = if let Some(quoted) = rest.strip_prefix('"') {
            quoted.split_once('"').unwrap_or((quoted, ""))
        } else if "()[]".contains(first) {
            rest.split_at(1)
        } else {
            let end = rest.find(|c: char| c.is_whitespace() || "()[]".contains(c)).unwrap_or(rest.len());
            rest.split_at(end)
        };
        self.line += word.bytes().filter(|b| *b == b'\n').count();
        self.rest = behind;
        Some(word)
    }

    fn wrong(&self, wanted: &str, found: Option<&str>) -> String {
        let found = found.map_or("the file ends".to_owned(), |w| format!("there is `{}`", w.escape_debug()));
        format!("line {}: {wanted} is expected, but {found}", self.line)
    }

    fn expect(&mut self, word: &str) -> Result<(), String> {
        match self.next() {
            Some(w) if w == word => Ok(()),
            other => Err(self.wrong(&format!("`{word}`"), other)),
        }
    }

    fn word(&mut self, wanted: &str) -> Result<&'a str, String> {
        self.next().ok_or_else(|| self.wrong(wanted, None))
    }

    fn number<T: std::str::FromStr>(&mut self, wanted: &str) -> Result<T, String> {
        let word = self.word(wanted)?;
        word.parse().map_err(|_| self.wrong(wanted, Some(word)))
    }

    fn finite(&mut self, wanted: &str) -> Result<f32, String> {
        let x: f32 = self.number(wanted)?;
        if x.is_finite() { Ok(x) } else { Err(self.wrong(&format!("{wanted} that is finite"), Some("another"))) }
    }

    /// `NAME COUNT`.
    fn count(&mut self, name: &str) -> Result<usize, String> {
        self.expect(name)?;
        self.number(&format!("the number of {name}"))
    }
}

/// An attribute whose values are being read.
struct Column {
    attribute: Attribute,
    /// Of strings: those that points name by number.
    texts: Option<Vec<String>>,
    /// `position` itself.
    is_position: bool,
}

impl Column {
    fn new(name: &str, data: Data) -> Column {
        Column { attribute: Attribute { name: name.to_owned(), data }, texts: None, is_position: false }
    }

    /// Reads what one point has.
    fn read(&mut self, words: &mut Words<'_>, positions: &mut Vec<[f32; 3]>) -> Result<(), String> {
        let wanted = format!("a number of the attribute `{}`", self.attribute.name);
        match &mut self.attribute.data {
            Data::Ints(n, all) => {
                for _ in 0..*n {
                    all.push(words.number(&wanted)?);
                }
            }
            Data::Floats(n, all) => {
                for _ in 0..*n {
                    all.push(words.number(&wanted)?);
                }
            }
            Data::Triples(_) if self.is_position => {
                positions.push([words.finite(&wanted)?, words.finite(&wanted)?, words.finite(&wanted)?]);
            }
            Data::Triples(all) => all.push([words.number(&wanted)?, words.number(&wanted)?, words.number(&wanted)?]),
            Data::Texts(all) => {
                let number: i64 = words.number(&wanted)?;
                let texts = self.texts.as_deref().unwrap_or_default();
                all.push(usize::try_from(number).ok().and_then(|i| texts.get(i)).cloned().unwrap_or_default());
            }
        }
        Ok(())
    }
}

fn cloud(positions: Vec<[f32; 3]>, columns: Vec<Column>) -> Cloud {
    Cloud::new(positions, columns.into_iter().filter(|c| !c.is_position).map(|c| c.attribute).collect())
}

/// Houdini's classic text: counts, the attributes of points, a line per point: x y z w (values).
fn geo(text: &str) -> Result<Cloud, String> {
    let mut words = Words { rest: text, line: 1 };
    words.expect("PGEOMETRY")?;
    words.word("a version")?;
    let points = words.count("NPoints")?;
    for name in ["NPrims", "NPointGroups", "NPrimGroups"] {
        words.count(name)?;
    }
    let attributes = words.count("NPointAttrib")?;
    for name in ["NVertexAttrib", "NPrimAttrib", "NAttrib"] {
        words.count(name)?;
    }
    let mut columns = Vec::new();
    if attributes > 0 {
        words.expect("PointAttrib")?;
    }
    for _ in 0..attributes {
        let name = words.word("the name of an attribute")?;
        let size: usize = words.number("the size of an attribute")?;
        if !(1..=MOST_NUMBERS).contains(&size) {
            return Err(format!(
                "line {}: an attribute of {size} numbers, at most {MOST_NUMBERS} are read",
                words.line
            ));
        }
        let mut column = match words.word("the type of an attribute")? {
            "float" => Column::new(name, Data::Floats(size, Vec::new())),
            "vector" if size == 3 => Column::new(name, Data::Triples(Vec::new())),
            "vector" => Column::new(name, Data::Floats(size, Vec::new())),
            "int" => Column::new(name, Data::Ints(size, Vec::new())),
            "index" if size == 1 => {
                let count: usize = words.number("the number of strings")?;
                let mut texts = Vec::new();
                for _ in 0..count {
                    texts.push(words.word("a string")?.to_owned());
                }
                Column { texts: Some(texts), ..Column::new(name, Data::Texts(Vec::new())) }
            }
            other => return Err(words.wrong("`float`, `int`, `vector` or `index`", Some(other))),
        };
        if column.texts.is_none() {
            for _ in 0..size {
                words.word("the default of an attribute")?;
            }
        }
        column.attribute.name = name.to_owned();
        columns.push(column);
    }
    let mut positions = Vec::new();
    for _ in 0..points {
        positions.push([words.finite("a coordinate")?, words.finite("a coordinate")?, words.finite("a coordinate")?]);
        words.number::<f32>("a coordinate")?;
        if !columns.is_empty() {
            words.expect("(")?;
        }
        for column in &mut columns {
            column.read(&mut words, &mut Vec::new())?;
        }
        if !columns.is_empty() {
            words.expect(")")?;
        }
    }
    Ok(cloud(positions, columns))
}

/// Maya's particles as text: names, types (V: a triple, R: a float, I: an int), a line per point.
fn pda(text: &str) -> Result<Cloud, String> {
    let mut words = Words { rest: text, line: 1 };
    words.expect("ATTRIBUTES")?;
    let mut columns: Vec<Column> = Vec::new();
    loop {
        match words.word("`TYPES`")? {
            "TYPES" => break,
            name => columns.push(Column::new(name, Data::Triples(Vec::new()))),
        }
    }
    for column in &mut columns {
        let name = column.attribute.name.as_str();
        column.attribute.data = match words.word("the type of an attribute")? {
            "V" => Data::Triples(Vec::new()),
            "R" => Data::Floats(1, Vec::new()),
            "I" => Data::Ints(1, Vec::new()),
            other => return Err(words.wrong("`V`, `R` or `I`", Some(other))),
        };
        column.is_position = name == "position" && matches!(column.attribute.data, Data::Triples(_));
    }
    if !columns.iter().any(|c| c.is_position) {
        return Err("no attribute `position` of type V".to_owned());
    }
    let points = words.count("NUMBER_OF_PARTICLES:")?;
    words.expect("BEGIN")?;
    words.expect("DATA")?;
    let mut positions = Vec::new();
    for _ in 0..points {
        for column in &mut columns {
            column.read(&mut words, &mut positions)?;
        }
    }
    Ok(cloud(positions, columns))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEO: &str = "PGEOMETRY V5\nNPoints 2 NPrims 1\nNPointGroups 0 NPrimGroups 0\n\
        NPointAttrib 4 NVertexAttrib 0 NPrimAttrib 1 NAttrib 0\nPointAttrib\nuv 3 vector 0 0 0\nk 1 int 0\nq 2 float 0 0\n\
        s 1 index 2 \"a b\" c\n0 1 2 1 (5 6 7\t8\t9 10 0)\n3 4 5 1 (1 2 3 4 5 6 1)\nPrimitiveAttrib\n";

    #[test]
    fn houdinis_text_is_read() {
        let cloud = geo(GEO).expect("a cloud");
        assert_eq!(cloud.positions, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        let data: Vec<&Data> = cloud.attributes.iter().map(|a| &a.data).collect();
        assert_eq!(data[0], &Data::Triples(vec![[5.0, 6.0, 7.0], [1.0, 2.0, 3.0]]));
        assert_eq!(data[1], &Data::Ints(1, vec![8, 4]));
        assert_eq!(data[2], &Data::Floats(2, vec![9.0, 10.0, 5.0, 6.0]));
        assert_eq!(data[3], &Data::Texts(vec!["a b".into(), "c".into()]));
    }

    #[test]
    fn mayas_text_is_read() {
        let text = "ATTRIBUTES\n id position mass\nTYPES\n I V R\nNUMBER_OF_PARTICLES: 1\nBEGIN DATA\n7 1 2 3 0.5\n";
        let cloud = pda(text).expect("a cloud");
        assert_eq!(cloud.positions, [[1.0, 2.0, 3.0]]);
        let names: Vec<&str> = cloud.attributes.iter().map(|a| a.name.as_str()).collect();
        assert_eq!(names, ["id", "mass"]);
    }

    #[test]
    fn damage_is_told_with_its_line() {
        for (text, wanted) in [
            ("", "line 1: `PGEOMETRY` is expected, but the file ends"),
            ("PGEOMETRY V5\nNPoints x", "line 2: the number of NPoints is expected, but there is `x`"),
        ] {
            assert_eq!(geo(text).expect_err("damaged"), wanted);
        }
        // Numbers in the header promise nothing.
        let huge = GEO.replace("NPoints 2", "NPoints 99999999999");
        assert!(geo(&huge).expect_err("damaged").contains("a coordinate"));
        assert!(geo(&GEO.replace("0 1 2 1", "0 nan 2 1")).expect_err("no place").contains("finite"));
        for end in 0..GEO.len() - 20 {
            assert!(geo(&GEO[..end]).is_err() || end > GEO.len() - 24, "{end}");
        }
        assert!(pda("ATTRIBUTES mass TYPES R NUMBER_OF_PARTICLES: 0 BEGIN DATA").is_err());
    }
}
