//! Records elements that are unknown to the reader, so that no data is lost silently.

use std::collections::BTreeMap;

use super::cursor::ByteSpan;

/// Unknown elements with the same path.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UnknownElement {
    /// Number of occurrences.
    pub count: usize,
    /// Total size of all occurrences, in bytes.
    pub bytes: usize,
    /// Positions of the first occurrences.
    pub spans: Vec<ByteSpan>,
}

/// Unknown elements by their path of tags: `SHP/Ge2/Xyz`.
#[derive(Debug, Clone, Default)]
pub struct UnknownElements {
    /// The unknown elements, by path.
    pub all: BTreeMap<String, UnknownElement>,
    path: Vec<String>,
}

/// Maximum number of paths, and of positions stored per path; further elements are only counted, because malformed
/// files can contain any number of them.
const MAX_RECORDED: usize = 1000;

impl UnknownElements {
    /// Enters a section: its tag becomes part of the path of further elements.
    pub fn enter(&mut self, tag: &str) {
        self.path.push(tag.to_owned());
    }
    /// Leaves the section that was entered last.
    pub fn leave(&mut self) {
        self.path.pop();
    }
    /// Records an unknown element.
    pub fn add(&mut self, tag: &str, span: ByteSpan) {
        let mut path = self.path.join("/");
        if !path.is_empty() {
            path.push('/');
        }
        path.push_str(tag);
        if self.all.len() >= MAX_RECORDED && !self.all.contains_key(&path) {
            path = "others".into();
        }
        let entry = self.all.entry(path).or_default();
        if entry.spans.len() < MAX_RECORDED {
            entry.spans.push(span);
        }
        entry.count += 1;
        entry.bytes += span.len;
    }
}
