//! The part of XPath 1.0 that dictionaries are asked in: location paths in their short form, with predicates.
//!
//! In: a tree, a start, a query. Out: nodes in the order of the document, each once. Steps: names, `*`, `.`, `..`, `text()`,
//! `node()`, with `/` and `//` between; predicates: a position, `last()`, an attribute or a child (also compared with a text
//! by `=` or `!=`), `text()`, several of them, and `and`, `or`, `not()` of such. Paths may be joined by `|`. What is none of
//! this finds nothing.

use super::xml::Tree;

/// Longest query.
const MAX_BYTES: usize = 4096;

/// The nodes that a query finds.
pub(super) fn select(tree: &Tree, start: usize, query: &str) -> Vec<usize> {
    if query.len() > MAX_BYTES {
        return Vec::new();
    }
    let mut out = Vec::new();
    for path in split(query, "|") {
        let mut p = Parser { rest: path.trim(), tree };
        match p.path(start) {
            Some(nodes) if p.rest.trim().is_empty() => out.extend(nodes),
            _ => return Vec::new(),
        }
    }
    // Handles grow in the order of the document.
    out.sort_unstable();
    out.dedup();
    out
}

/// Parts of a text between separators that stand in neither quotes nor brackets.
fn split<'a>(text: &'a str, separator: &str) -> Vec<&'a str> {
    let (mut depth, mut quote, mut begin, mut out) = (0i32, None, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '(') => depth += 1,
            (None, ']' | ')') => depth -= 1,
            _ if depth == 0 && i >= begin && text[i..].starts_with(separator) => {
                out.push(&text[begin..i]);
                begin = i + separator.len();
            }
            _ => {}
        }
    }
    out.push(&text[begin..]);
    out
}

struct Parser<'a> {
    rest: &'a str,
    tree: &'a Tree,
}

impl<'a> Parser<'a> {
    fn eat(&mut self, token: &str) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(token) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn name(&mut self) -> Option<&'a str> {
        self.rest = self.rest.trim_start();
        let part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ':');
        let end = self.rest.find(|c| !part(c)).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        let first = name.chars().next()?;
        if first.is_ascii_digit() || matches!(first, '-' | '.') {
            return None;
        }
        self.rest = rest;
        Some(name)
    }

    fn path(&mut self, start: usize) -> Option<Vec<usize>> {
        let mut nodes = vec![start];
        let mut deep = false;
        if self.eat("//") {
            (nodes, deep) = (vec![0], true);
        } else if self.eat("/") {
            nodes = vec![0];
            if self.rest.trim().is_empty() {
                return Some(nodes);
            }
        }
        loop {
            nodes = self.step(nodes, deep)?;
            if self.eat("//") {
                deep = true;
            } else if self.eat("/") {
                deep = false;
            } else {
                return Some(nodes);
            }
        }
    }

    fn step(&mut self, from: Vec<usize>, deep: bool) -> Option<Vec<usize>> {
        let tree = self.tree;
        let mut origins = from;
        if deep {
            let inner: Vec<usize> = origins.iter().flat_map(|n| tree.below(*n)).collect();
            origins.extend(inner);
            origins.sort_unstable();
            origins.dedup();
        }
        if self.eat("..") {
            let mut out: Vec<usize> = origins.iter().filter(|n| **n != 0).map(|n| tree.nodes[*n].parent).collect();
            out.dedup();
            return Some(out);
        }
        if self.eat(".") {
            return Some(origins);
        }
        self.eat("child::");
        let is_element = |n: usize| tree.nodes[n].name.is_some();
        let test: Box<dyn Fn(usize) -> bool> = if self.eat("*") {
            Box::new(is_element)
        } else if self.eat("text()") {
            Box::new(move |n| !is_element(n))
        } else if self.eat("node()") {
            Box::new(|_| true)
        } else {
            let name = self.name()?.to_owned();
            Box::new(move |n| tree.nodes[n].name.as_deref() == Some(name.as_str()))
        };
        let mut predicates = Vec::new();
        while self.eat("[") {
            let end = closing(self.rest)?;
            predicates.push(&self.rest[..end]);
            self.rest = &self.rest[end + 1..];
        }
        let mut out = Vec::new();
        for origin in origins {
            // Positions count among the children of one node.
            let mut list: Vec<usize> = tree.nodes[origin].children.iter().copied().filter(|n| test(*n)).collect();
            for predicate in &predicates {
                let count = list.len();
                let mut kept = Vec::new();
                for (i, node) in list.into_iter().enumerate() {
                    if holds(tree, node, i + 1, count, predicate.trim())? {
                        kept.push(node);
                    }
                }
                list = kept;
            }
            out.extend(list);
        }
        Some(out)
    }
}

/// Where the bracket that is open ends.
fn closing(text: &str) -> Option<usize> {
    let (mut depth, mut quote) = (0, None);
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[') => depth += 1,
            (None, ']') if depth == 0 => return Some(i),
            (None, ']') => depth -= 1,
            _ => {}
        }
    }
    None
}

/// Whether a predicate holds of a node; `None` when it is none of the known ones.
fn holds(tree: &Tree, node: usize, position: usize, count: usize, text: &str) -> Option<bool> {
    for (word, any) in [(" or ", true), (" and ", false)] {
        let parts = split(text, word);
        if parts.len() > 1 {
            for part in parts {
                if holds(tree, node, position, count, part.trim())? == any {
                    return Some(any);
                }
            }
            return Some(!any);
        }
    }
    if let Some(inner) = text.strip_prefix("not(").and_then(|t| t.strip_suffix(')')) {
        return Some(!holds(tree, node, position, count, inner.trim())?);
    }
    if let Ok(n) = text.parse::<usize>() {
        return Some(n == position);
    }
    if text == "last()" {
        return Some(position == count);
    }
    for (operator, equal) in [("!=", false), ("=", true)] {
        if let [left, right] = split(text, operator).as_slice() {
            let right = right.trim();
            if left.trim() == "position()" {
                let wanted = if right == "last()" { count } else { right.parse().ok()? };
                return Some((position == wanted) == equal);
            }
            let quoted = ['"', '\''].iter().find_map(|q| right.strip_prefix(*q)?.strip_suffix(*q));
            let (texts, number) = (texts(tree, node, left.trim())?, right.parse::<f64>().ok());
            let same = |t: &String| match (quoted, number) {
                (Some(q), _) => Some(t == q),
                (None, Some(n)) => Some(t.trim().parse::<f64>().is_ok_and(|v| v == n)),
                (None, None) => None,
            };
            let mut any = false;
            for t in &texts {
                any |= same(t)? == equal;
            }
            return Some(any);
        }
    }
    Some(!texts(tree, node, text)?.is_empty())
}

/// The texts of what stands in a predicate: an attribute, or the nodes of a path.
fn texts(tree: &Tree, node: usize, what: &str) -> Option<Vec<String>> {
    if let Some(name) = what.strip_prefix('@') {
        let all = &tree.nodes[node].attributes;
        let named = all.iter().filter(|(n, _)| name == "*" || n == name);
        return Some(named.map(|(_, v)| v.clone()).collect());
    }
    let mut p = Parser { rest: what, tree };
    let nodes = p.path(node)?;
    if !p.rest.trim().is_empty() {
        return None;
    }
    let text = |n: usize| {
        let inner = tree.below(n);
        std::iter::once(n).chain(inner).map(|n| tree.nodes[n].text.as_str()).collect::<String>()
    };
    Some(nodes.into_iter().map(text).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_predicates() {
        let text = "<r><a k='1'><b>x</b></a><a k='2'/><c><a k='3'><b>y</b><b>z</b></a></c></r>";
        let tree = Tree::read(text).expect("a document");
        let keys = |query: &str| -> Vec<String> {
            let found = select(&tree, 0, query);
            found.iter().map(|n| tree.value(*n, "k").unwrap_or("-").to_owned()).collect()
        };
        assert_eq!(keys("//a"), ["1", "2", "3"]);
        assert_eq!(keys("/r/a"), ["1", "2"]);
        assert_eq!(keys("/r/a[2]"), ["2"]);
        assert_eq!(keys("/r/a[last()]"), ["2"]);
        assert_eq!(keys("//a[@k='3']"), ["3"]);
        assert_eq!(keys("//a[@k!='3' and b]"), ["1"]);
        assert_eq!(keys("//a[b='z']"), ["3"]);
        assert_eq!(keys("//b/.."), ["1", "3"]);
        assert_eq!(keys("//c/* | /r/a[@k=1]"), ["1", "3"]);
        assert_eq!(keys("//a[not(b)]"), ["2"]);
        assert_eq!(keys("//a["), [""; 0]);
        assert_eq!(keys("count(//a)"), [""; 0]);
        assert_eq!(select(&tree, 0, "//b/text()").len(), 3);
    }
}
