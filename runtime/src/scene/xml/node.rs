//! Typed access to the elements of an XML document, so that every complaint has a line, a column and a name.
//!
//! In: a parsed document. Out: numbers, vectors, texts, or an error. It must not know what elements mean.

use super::super::error::{Error, Location, suggest};
use super::super::value::Text;
use glam::DVec3;
use roxmltree::Node;

/// An element.
#[derive(Clone, Copy)]
pub(super) struct Element<'a, 'i> {
    node: Node<'a, 'i>,
    text: Text<'a>,
}

/// Text between elements, and where it begins.
pub(super) struct Piece<'a> {
    pub at: Location,
    pub text: &'a str,
}

/// An attribute.
#[derive(Clone, Copy)]
pub(super) struct Attribute<'a> {
    pub key: &'a str,
    pub text: &'a str,
    element: &'a str,
    start: usize,
    place: Text<'a>,
}

impl<'a, 'i: 'a> Element<'a, 'i> {
    pub fn new(node: Node<'a, 'i>, text: Text<'a>) -> Element<'a, 'i> {
        Element { node, text }
    }

    pub fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    pub fn at(&self) -> Location {
        self.text.at(self.node.range().start)
    }

    /// The elements within.
    pub fn children(&self) -> impl Iterator<Item = Element<'a, 'i>> {
        let text = self.text;
        self.node.children().filter(Node::is_element).map(move |node| Element { node, text })
    }

    /// The texts within that are not blank.
    pub fn texts(&self) -> impl Iterator<Item = Piece<'a>> {
        let place = self.text;
        let pieces = self.node.children().filter(|n| n.is_text());
        pieces.filter_map(move |n| Some((n.range().start, n.text()?))).filter(|(_, t)| !t.trim().is_empty()).map(
            move |(start, text)| {
                // CDATA's own brackets stand before its text.
                let opening = if place.source[start..].starts_with("<![CDATA[") { "<![CDATA[".len() } else { 0 };
                Piece { at: place.at(start + opening), text }
            },
        )
    }

    pub fn attributes(&self) -> impl Iterator<Item = Attribute<'a>> {
        let (element, place) = (self.name(), self.text);
        self.node.attributes().map(move |a| Attribute {
            key: a.name(),
            text: a.value(),
            element,
            start: a.range_value().start,
            place,
        })
    }

    pub fn get(&self, key: &str) -> Option<Attribute<'a>> {
        self.attributes().find(|a| a.key == key)
    }

    pub fn need(&self, key: &str) -> Result<Attribute<'a>, Error> {
        let missing = || Error::MissingKey { at: self.at(), table: format!("<{}>", self.name()), key: key.to_owned() };
        self.get(key).ok_or_else(missing)
    }

    /// A whole number in a range, or what counts without it.
    pub fn whole(&self, key: &str, default: u32, least: u32, most: u32) -> Result<u32, Error> {
        let Some(value) = self.get(key) else { return Ok(default) };
        let Ok(number) = value.text.trim().parse::<i64>() else { return Err(value.wrong_type("a whole number")) };
        let fits = u32::try_from(number).ok().filter(|n| (least..=most).contains(n));
        fits.ok_or_else(|| value.out_of_range(&format!("a whole number from {least} to {most}")))
    }

    /// A warning for an element that means nothing here.
    pub fn unknown_element(&self, name: &str, known: &[&str]) -> String {
        let help = suggest(name, known.iter().copied());
        format!("{}: warning: unknown element <{name}> is left out{help}", self.at())
    }

    /// Warnings for attributes that mean nothing here.
    pub fn unknown_attributes(&self, known: &[&str]) -> Vec<String> {
        let unknown = self.attributes().filter(|a| !known.contains(&a.key));
        unknown.map(|a| self.unknown_attribute(&a, known)).collect()
    }

    /// A warning for one such attribute.
    pub fn unknown_attribute(&self, attribute: &Attribute<'_>, known: &[&str]) -> String {
        let (at, key, name) = (attribute.at(), attribute.key, self.name());
        let help = suggest(key, known.iter().copied());
        format!("{at}: warning: unknown attribute `{key}` of <{name}> is left out{help}")
    }
}

impl Attribute<'_> {
    pub fn at(&self) -> Location {
        self.place.at(self.start)
    }

    fn name(&self) -> String {
        format!("{} of <{}>", self.key, self.element)
    }

    pub fn wrong_type(&self, expected: &str) -> Error {
        let found = format!("\"{}\"", self.text);
        Error::WrongType { at: self.at(), key: self.name(), expected: expected.to_owned(), found }
    }

    pub fn out_of_range(&self, expected: &str) -> Error {
        let found = format!("\"{}\"", self.text);
        Error::OutOfRange { at: self.at(), key: self.name(), expected: expected.to_owned(), found }
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64, Error> {
        let number: f64 = self.text.trim().parse().map_err(|_| self.wrong_type("a number"))?;
        if number.is_finite() { Ok(number) } else { Err(self.out_of_range("a finite number")) }
    }

    /// Three finite numbers with commas or blanks between them.
    pub fn vector(&self) -> Result<DVec3, Error> {
        let expected = "three numbers with commas between them";
        let mut numbers = Vec::new();
        for part in self.text.split(',') {
            let words: Vec<&str> = part.split_whitespace().collect();
            if words.is_empty() {
                return Err(self.wrong_type(expected));
            }
            for word in words {
                numbers.push(word.parse::<f64>().map_err(|_| self.wrong_type(expected))?);
            }
        }
        match numbers[..] {
            [x, y, z] if numbers.iter().all(|n| n.is_finite()) => Ok(DVec3::new(x, y, z)),
            [_, _, _] => Err(self.out_of_range("finite numbers")),
            _ => Err(self.wrong_type(expected)),
        }
    }
}
