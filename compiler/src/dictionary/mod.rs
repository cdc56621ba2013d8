//! OSL's dictionaries (specification ch. 7.12): XML documents, asked by XPath.
//!
//! In: names of files or XML texts, queries, attributes. Out: numbers of nodes and values, as the reference gives them: 0 is no
//! node, -1 a document that cannot be read. Nodes are numbered in the order in which they are found. It must not know IR.

mod xml;
mod xpath;

use std::collections::HashMap;
use std::sync::Arc;
use xml::Tree;

/// Most nodes that queries may find.
const MAX_NODES: usize = 1 << 16;

/// Reads the file with this name; `None`: there is none.
pub type ReadFile<'a> = &'a dyn Fn(&str) -> Option<String>;

/// The text of a file by its name; `None` where there is none.
pub type Read = dyn Fn(&str) -> Option<String> + Send + Sync;

/// Reads files that dictionaries are in, for whoever has files.
#[derive(Clone)]
pub struct Documents(pub Arc<Read>);

impl std::fmt::Debug for Documents {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Documents")
    }
}

impl PartialEq for Documents {
    fn eq(&self, other: &Documents) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// A node that some query found.
struct Found {
    document: usize,
    node: usize,
    /// The next one of the same query; 0: none.
    next: i32,
}

/// All documents and the nodes found in them.
pub struct Dictionary<'a> {
    read: ReadFile<'a>,
    documents: Vec<Tree>,
    names: HashMap<String, Result<usize, String>>,
    found: Vec<Found>,
    queries: HashMap<(usize, i32, String), i32>,
}

impl<'a> Dictionary<'a> {
    /// An empty one; files come through `read`.
    pub fn new(read: ReadFile<'a>) -> Dictionary<'a> {
        Dictionary { read, documents: Vec::new(), names: HashMap::new(), found: Vec::new(), queries: HashMap::new() }
    }

    /// How many nodes were found: their numbers are `1..=count`.
    pub fn count(&self) -> i32 {
        self.found.len() as i32
    }

    /// The document of this name, which is a file's when it ends in `.xml` and a text otherwise; or what is wrong with it.
    fn document(&mut self, name: &str) -> Result<usize, String> {
        if let Some(known) = self.names.get(name) {
            return known.clone();
        }
        let text = if name.ends_with(".xml") {
            (self.read)(name).ok_or_else(|| "File was not found, at offset 0".to_owned())
        } else {
            Ok(name.to_owned())
        };
        let result = text.and_then(|text| Tree::read(&text)).map(|tree| {
            self.documents.push(tree);
            self.documents.len() - 1
        });
        self.names.insert(name.to_owned(), result.clone());
        result
    }

    /// What is wrong with a document, in the reference's words; `None` when it can be read.
    pub fn error(&mut self, name: &str) -> Option<String> {
        self.document(name).err().map(|why| format!("XML parsed with errors: {why}"))
    }

    /// The first node that a query finds in a document.
    pub fn find(&mut self, name: &str, query: &str) -> i32 {
        match self.document(name) {
            Ok(document) => self.query(document, 0, 0, query),
            Err(_) => -1,
        }
    }

    /// The first node that a query finds from a node.
    pub fn find_from(&mut self, node: i32, query: &str) -> i32 {
        let Some(from) = self.get(node) else { return 0 };
        let (document, start) = (from.document, from.node);
        self.query(document, node, start, query)
    }

    /// The next node of the query that found this one.
    pub fn next(&self, node: i32) -> i32 {
        self.get(node).map_or(0, |f| f.next)
    }

    /// The text of an attribute of a node; with an empty name that of the node itself.
    pub fn value(&self, node: i32, attribute: &str) -> Option<&str> {
        let found = self.get(node)?;
        self.documents[found.document].value(found.node, attribute)
    }

    fn get(&self, node: i32) -> Option<&Found> {
        self.found.get(usize::try_from(node).ok()?.checked_sub(1)?)
    }

    fn query(&mut self, document: usize, from: i32, start: usize, query: &str) -> i32 {
        let key = (document, from, query.to_owned());
        if let Some(known) = self.queries.get(&key) {
            return *known;
        }
        let matches = xpath::select(&self.documents[document], start, query);
        let first = self.found.len() as i32 + 1;
        let room = MAX_NODES.saturating_sub(self.found.len());
        let count = matches.len().min(room);
        for (i, node) in matches.into_iter().take(count).enumerate() {
            let next = if i + 1 < count { first + i as i32 + 1 } else { 0 };
            self.found.push(Found { document, node, next });
        }
        let result = if count == 0 { 0 } else { first };
        self.queries.insert(key, result);
        result
    }
}

/// The numbers at the front of a text, with blanks or single commas between; those that are missing repeat what was read
/// last, as in the reference, whose reader leaves them as they are.
pub fn numbers(text: &str, count: usize) -> Vec<f64> {
    let mut rest = text;
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        rest = rest.trim_start();
        let end = rest
            .char_indices()
            .find(|(i, c)| {
                let sign = matches!(c, '+' | '-') && (*i == 0 || rest[..*i].ends_with(['e', 'E']));
                !(c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E') || sign)
            })
            .map_or(rest.len(), |(i, _)| i);
        match rest[..end].parse::<f64>() {
            Ok(v) => {
                out.push(v);
                rest = rest[end..].trim_start();
                rest = rest.strip_prefix(',').unwrap_or(rest);
            }
            Err(_) => out.push(0.0),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETUP: &str = r#"<?xml version="1.0"?><setup><pack name="a" on="1"><cam m="1.0 2, 3"/><image c="x"/><image c="y"/></pack>
        <pack name="b"><!-- none --></pack>text</setup>"#;

    #[test]
    fn nodes_are_found_and_numbered() {
        let read = |name: &str| (name == "s.xml").then(|| SETUP.to_owned());
        let mut d = Dictionary::new(&read);
        let first = d.find("s.xml", "//pack");
        assert_eq!((first, d.next(1), d.next(2)), (1, 2, 0));
        assert_eq!(d.value(1, "name"), Some("a"));
        assert_eq!(d.value(2, "on"), None);
        let image = d.find_from(1, "image");
        assert_eq!(d.value(image, "c"), Some("x"));
        assert_eq!(d.value(d.next(image), "c"), Some("y"));
        assert_eq!(d.find_from(2, "image"), 0);
        assert_eq!(d.find("s.xml", "//pack"), 1);
        assert_eq!(d.find("none.xml", "a"), -1);
        assert_eq!(d.error("none.xml").as_deref(), Some("XML parsed with errors: File was not found, at offset 0"));
        assert!(d.error("<a><b></a>").is_some());
        assert_eq!(d.find("<a><b k='2'/></a>", "/a/b"), d.count());
    }

    #[test]
    fn numbers_stand_with_blanks_or_commas() {
        assert_eq!(numbers("1.0 2, 3 -4e1", 4), [1.0, 2.0, 3.0, -40.0]);
        assert_eq!(numbers("7", 2), [7.0, 0.0]);
        assert_eq!(numbers("x", 1), [0.0]);
    }
}
