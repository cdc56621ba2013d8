//! Typed access to the values of a TOML file, so that every complaint has a line, a column and a key.
//!
//! In: a parsed document. Out: numbers, strings, tables, or an error. It must not know what the keys mean.

use super::error::{Error, Location, suggest};
use glam::DVec3;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// A file's name and text.
#[derive(Clone, Copy)]
pub(super) struct Text<'a> {
    pub path: &'a Path,
    pub source: &'a str,
}

impl Text<'_> {
    /// Line and column of a byte.
    pub fn at(&self, offset: usize) -> Location {
        let mut end = offset.min(self.source.len());
        while !self.source.is_char_boundary(end) {
            end -= 1;
        }
        let before = &self.source[..end];
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        Location {
            file: self.path.to_path_buf(),
            line: before.matches('\n').count() + 1,
            column: before[start..].chars().count() + 1,
        }
    }
}

/// A table, its full name and where it begins.
#[derive(Clone)]
pub(super) struct Table<'a> {
    pub text: Text<'a>,
    pub name: String,
    entries: &'a DeTable<'a>,
    offset: usize,
}

impl<'a> Table<'a> {
    /// The whole document.
    pub fn root(text: Text<'a>, document: &'a Spanned<DeTable<'a>>) -> Table<'a> {
        Table { text, name: "the scene".to_string(), entries: document.get_ref(), offset: 0 }
    }

    pub fn at(&self) -> Location {
        self.text.at(self.offset)
    }

    /// Refuses keys other than these.
    pub fn only(&self, known: &[&str]) -> Result<(), Error> {
        for key in self.entries.keys() {
            let name = key.get_ref().as_ref();
            if !known.contains(&name) {
                return Err(Error::UnknownKey {
                    at: self.text.at(key.span().start),
                    key: name.to_string(),
                    table: self.name.clone(),
                    help: suggest(name, known.iter().copied()),
                });
            }
        }
        Ok(())
    }

    /// All entries in the order of their names.
    pub fn entries(&self) -> impl Iterator<Item = (&'a str, Value<'a>)> + '_ {
        self.entries.iter().map(|(key, value)| (key.get_ref().as_ref(), self.value(key.get_ref(), value)))
    }

    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        self.entries.iter().find(|(k, _)| k.get_ref().as_ref() == key).map(|(_, value)| self.value(key, value))
    }

    pub fn need(&self, key: &str) -> Result<Value<'a>, Error> {
        self.get(key).ok_or_else(|| Error::MissingKey { at: self.at(), table: self.name.clone(), key: key.to_string() })
    }

    fn value(&self, key: &str, value: &'a Spanned<DeValue<'a>>) -> Value<'a> {
        let name = if self.name == "the scene" { key.to_string() } else { format!("{}.{key}", self.name) };
        Value { text: self.text, name, value }
    }
}

/// A value and its full name.
#[derive(Clone)]
pub(super) struct Value<'a> {
    pub text: Text<'a>,
    pub name: String,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Value<'a> {
    pub fn at(&self) -> Location {
        self.text.at(self.value.span().start)
    }

    pub fn raw(&self) -> &'a DeValue<'a> {
        self.value.get_ref()
    }

    /// As it stands in the file.
    pub fn written(&self) -> &'a str {
        self.text.source.get(self.value.span()).unwrap_or_default()
    }

    pub fn wrong_type(&self, expected: impl Into<String>) -> Error {
        let found = match self.raw() {
            DeValue::String(_) => "a string".to_string(),
            DeValue::Integer(_) => "an integer".to_string(),
            DeValue::Float(_) => "a float".to_string(),
            DeValue::Boolean(_) => "a boolean".to_string(),
            DeValue::Datetime(_) => "a date".to_string(),
            DeValue::Array(items) => format!("a list of {}", items.len()),
            DeValue::Table(_) => "a table".to_string(),
        };
        Error::WrongType { at: self.at(), key: self.name.clone(), expected: expected.into(), found }
    }

    pub fn out_of_range(&self, expected: impl Into<String>) -> Error {
        let found = if self.written().is_empty() { "this" } else { self.written() }.to_string();
        Error::OutOfRange { at: self.at(), key: self.name.clone(), expected: expected.into(), found }
    }

    pub fn string(&self) -> Result<&'a str, Error> {
        self.raw().as_str().ok_or_else(|| self.wrong_type("a string"))
    }

    pub fn boolean(&self) -> Result<bool, Error> {
        self.raw().as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64, Error> {
        let number = match self.raw() {
            DeValue::Integer(i) => integer(i).map(|i| i as f64),
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => return Err(self.wrong_type("a number")),
        };
        number.filter(|n: &f64| n.is_finite()).ok_or_else(|| self.out_of_range("a finite number"))
    }

    /// A whole number in a range.
    pub fn whole(&self, least: u64, most: u64) -> Result<u64, Error> {
        let DeValue::Integer(digits) = self.raw() else {
            return Err(self.wrong_type("an integer"));
        };
        let found = integer(digits).and_then(|i| u64::try_from(i).ok()).filter(|i| (least..=most).contains(i));
        found.ok_or_else(|| self.out_of_range(format!("an integer from {least} to {most}")))
    }

    /// An integer of 64 bits.
    pub fn integer(&self) -> Result<i64, Error> {
        let DeValue::Integer(digits) = self.raw() else {
            return Err(self.wrong_type("an integer"));
        };
        integer(digits).and_then(|i| i64::try_from(i).ok()).ok_or_else(|| self.out_of_range("an integer of 64 bits"))
    }

    pub fn items(&self) -> Option<Vec<Value<'a>>> {
        let DeValue::Array(items) = self.raw() else { return None };
        let item = |(i, value)| Value { text: self.text, name: format!("{}[{i}]", self.name), value };
        Some(items.iter().enumerate().map(item).collect())
    }

    /// A list of so many finite numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N], Error> {
        let items = self.items().filter(|items| items.len() == N);
        let items = items.ok_or_else(|| self.wrong_type(format!("a list of {N} numbers")))?;
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.number()?;
        }
        Ok(numbers)
    }

    pub fn vector(&self) -> Result<DVec3, Error> {
        self.numbers::<3>().map(DVec3::from_array)
    }

    pub fn table(&self) -> Result<Table<'a>, Error> {
        match self.raw() {
            DeValue::Table(entries) => {
                Ok(Table { text: self.text, name: self.name.clone(), entries, offset: self.value.span().start })
            }
            _ => Err(self.wrong_type("a table")),
        }
    }

    /// The tables of `[[name]]`.
    pub fn tables(&self) -> Result<Vec<Table<'a>>, Error> {
        let items = self.items().ok_or_else(|| self.wrong_type(format!("a list of tables ([[{}]])", self.name)))?;
        items.iter().map(Value::table).collect()
    }
}

fn integer(digits: &DeInteger<'_>) -> Option<i128> {
    i128::from_str_radix(digits.as_str(), digits.radix()).ok()
}
