//! Elements that nobody here understands: where they are, so that nothing is lost silently.

use std::collections::BTreeMap;

use super::cursor::Span;

/// Elements of one sort.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unknown {
    /// How many there are.
    pub count: usize,
    /// Their bytes together.
    pub bytes: usize,
    /// Where they are: the first ones.
    pub spans: Vec<Span>,
}

/// All of them, by the tags that lead to them: `SHP/Ge2/Xyz`.
#[derive(Debug, Clone, Default)]
pub struct Unknowns {
    /// Sorts.
    pub all: BTreeMap<String, Unknown>,
    path: Vec<String>,
}

/// More sorts than this are counted together, and more of a sort are only counted: hostile files have as many as they like.
const MOST: usize = 1000;

impl Unknowns {
    /// A section begins.
    pub fn enter(&mut self, tag: &str) {
        self.path.push(tag.to_owned());
    }
    /// It ends.
    pub fn leave(&mut self) {
        self.path.pop();
    }
    /// An element that is not known.
    pub fn add(&mut self, tag: &str, span: Span) {
        let mut path = self.path.join("/");
        if !path.is_empty() {
            path.push('/');
        }
        path.push_str(tag);
        if self.all.len() >= MOST && !self.all.contains_key(&path) {
            path = "others".into();
        }
        let entry = self.all.entry(path).or_default();
        if entry.spans.len() < MOST {
            entry.spans.push(span);
        }
        entry.count += 1;
        entry.bytes += span.len;
    }
}
