//! A document as a tree: elements with attributes, and texts.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Deepest nesting that is read.
const MAX_DEPTH: usize = 1024;

/// Most nodes of a document.
const MAX_NODES: usize = 1 << 20;

/// A node; the document itself is the first.
pub(super) struct Node {
    /// Name of an element; `None`: a text.
    pub name: Option<String>,
    /// In the order of the document.
    pub attributes: Vec<(String, String)>,
    /// Of a text.
    pub text: String,
    pub parent: usize,
    pub children: Vec<usize>,
}

/// A document. Node 0 holds all others.
pub(super) struct Tree {
    pub nodes: Vec<Node>,
}

impl Tree {
    /// Reads a document; the error in the words of the reference's reader where it has some.
    pub fn read(text: &str) -> Result<Tree, String> {
        let mut tree = Tree { nodes: Vec::new() };
        tree.add(0, Some(String::new()), Vec::new(), String::new());
        let mut reader = Reader::from_str(text);
        let mut open = vec![0];
        loop {
            let parent = open.last().copied().unwrap_or(0);
            let at = reader.buffer_position();
            let fail = |what: &str| format!("{what}, at offset {at}");
            if open.len() > MAX_DEPTH || tree.nodes.len() > MAX_NODES {
                return Err(fail("The document is too large"));
            }
            match reader.read_event() {
                Ok(Event::Start(tag)) => {
                    let node = tree.element(parent, &tag).ok_or_else(|| fail("Error parsing element attribute"))?;
                    open.push(node);
                }
                Ok(Event::Empty(tag)) => {
                    tree.element(parent, &tag).ok_or_else(|| fail("Error parsing element attribute"))?;
                }
                Ok(Event::End(_)) => {
                    open.pop();
                }
                Ok(Event::Text(text)) => tree.text(parent, &text),
                Ok(Event::CData(text)) => tree.text(parent, &text),
                Ok(Event::GeneralRef(name)) => tree.text(parent, &format!("&{};", &*name)),
                Ok(Event::Eof) => break,
                Ok(_) => {}
                Err(_) => return Err(fail("Start-end tags mismatch")),
            }
        }
        if open.len() > 1 {
            return Err(format!("Start-end tags mismatch, at offset {}", text.len()));
        }
        if tree.nodes[0].children.iter().all(|c| tree.nodes[*c].name.is_none()) {
            return Err("No document element found, at offset 0".to_owned());
        }
        Ok(tree)
    }

    fn add(&mut self, parent: usize, name: Option<String>, attributes: Vec<(String, String)>, text: String) -> usize {
        let id = self.nodes.len();
        self.nodes.push(Node { name, attributes, text, parent, children: Vec::new() });
        if id > 0 {
            self.nodes[parent].children.push(id);
        }
        id
    }

    fn element(&mut self, parent: usize, tag: &BytesStart<'_>) -> Option<usize> {
        let text = str::to_owned;
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.ok()?;
            let value = text(&attribute.value);
            let value = quick_xml::escape::unescape(&value).map_or_else(|_| value.clone(), |v| v.into_owned());
            attributes.push((text(attribute.key.as_ref()), value));
        }
        Some(self.add(parent, Some(text(tag.name().as_ref())), attributes, String::new()))
    }

    /// Texts of blanks only are none.
    fn text(&mut self, parent: usize, text: &str) {
        if !text.trim().is_empty() {
            let text = quick_xml::escape::unescape(text).map_or_else(|_| text.to_owned(), |t| t.into_owned());
            self.add(parent, None, Vec::new(), text);
        }
    }

    /// The text of an attribute; with an empty name that of the node itself, which elements have none of.
    pub fn value(&self, node: usize, attribute: &str) -> Option<&str> {
        let node = self.nodes.get(node)?;
        if attribute.is_empty() {
            return Some(&node.text);
        }
        node.attributes.iter().find(|(name, _)| name == attribute).map(|(_, value)| value.as_str())
    }

    /// All below a node, in the order of the document.
    pub fn below(&self, node: usize) -> Vec<usize> {
        let mut out = Vec::new();
        let mut todo: Vec<usize> = self.nodes[node].children.iter().rev().copied().collect();
        while let Some(id) = todo.pop() {
            out.push(id);
            todo.extend(self.nodes[id].children.iter().rev());
        }
        out
    }
}
