//! Writes the expanded elements as XML, with the line of origin of each line.

use std::collections::BTreeSet;

use crate::{
    error::{Origin, Result, fail},
    source::{Element, Node, SourceFile, UNDECLARED_URI},
};

/// The text, and for each of its lines the index of a source file and the line in it.
pub(crate) struct Written {
    pub text: String,
    pub lines: Vec<(u32, u32)>,
    /// Prefixes that no element declares.
    pub undeclared: BTreeSet<String>,
}

/// Writes a tree with at most `max_bytes`.
pub(crate) fn write(root: &Element, sources: &[SourceFile], max_bytes: usize) -> Result<Written> {
    let mut undeclared = BTreeSet::new();
    find_undeclared(root, &mut vec!["xml"], &mut undeclared);
    let mut writer = Writer { text: String::new(), lines: Vec::new(), sources, max_bytes };
    writer.start_line(root.origin);
    writer.text.push_str("<?xml version=\"1.0\"?>\n");
    writer.element(root, 0, &undeclared)?;
    Ok(Written { text: writer.text, lines: writer.lines, undeclared })
}

fn prefix_of(name: &str) -> Option<&str> {
    name.split_once(':').map(|(prefix, _)| prefix)
}

fn find_undeclared<'e>(element: &'e Element, declared: &mut Vec<&'e str>, out: &mut BTreeSet<String>) {
    let outer = declared.len();
    declared.extend(element.attributes.iter().filter_map(|attribute| attribute.name.strip_prefix("xmlns:")));
    let names = element.attributes.iter().map(|attribute| &*attribute.name).chain([&*element.name]);
    for prefix in names.filter_map(prefix_of) {
        if prefix != "xmlns" && !declared.contains(&prefix) {
            out.insert(prefix.to_owned());
        }
    }
    for child in element.elements() {
        find_undeclared(child, declared, out);
    }
    declared.truncate(outer);
}

struct Writer<'a> {
    text: String,
    lines: Vec<(u32, u32)>,
    sources: &'a [SourceFile],
    max_bytes: usize,
}

impl Writer<'_> {
    /// Records where the line that begins here comes from.
    fn start_line(&mut self, origin: Origin) {
        let line = self.sources.get(origin.file as usize).map_or(0, |source| source.line(origin.offset));
        self.lines.push((origin.file, line));
    }

    fn element(&mut self, element: &Element, depth: usize, undeclared: &BTreeSet<String>) -> Result<()> {
        if self.text.len() > self.max_bytes {
            fail!("the expanded file has more than {} bytes", self.max_bytes);
        }
        self.start_line(element.origin);
        self.indent(depth);
        self.text.push('<');
        self.text.push_str(&element.name);
        for prefix in undeclared {
            self.attribute(&format!("xmlns:{prefix}"), &format!("{UNDECLARED_URI}{prefix}"));
        }
        for attribute in &element.attributes {
            self.attribute(&attribute.name, &attribute.value);
        }
        match element.children.as_slice() {
            [] => {
                self.text.push_str("/>\n");
                return Ok(());
            }
            [Node::Text(text, origin)] => {
                self.text.push('>');
                self.content(text, *origin);
            }
            children => {
                self.text.push_str(">\n");
                for child in children {
                    match child {
                        Node::Element(child) => self.element(child, depth + 1, &BTreeSet::new())?,
                        Node::Text(text, origin) => {
                            self.start_line(*origin);
                            self.indent(depth + 1);
                            self.content(text.trim(), *origin);
                            self.text.push('\n');
                        }
                    }
                }
                self.start_line(element.origin);
                self.indent(depth);
            }
        }
        self.text.push_str("</");
        self.text.push_str(&element.name);
        self.text.push_str(">\n");
        Ok(())
    }

    fn indent(&mut self, depth: usize) {
        // Deep elements are not indented further, so that the size stays linear.
        self.text.extend(std::iter::repeat_n(' ', 2 * depth.min(40)));
    }

    fn attribute(&mut self, name: &str, value: &str) {
        self.text.push(' ');
        self.text.push_str(name);
        self.text.push_str("=\"");
        for c in value.chars() {
            match c {
                '"' => self.text.push_str("&quot;"),
                '\n' => self.text.push_str("&#10;"),
                '\t' => self.text.push_str("&#9;"),
                _ => self.character(c),
            }
        }
        self.text.push('"');
    }

    fn content(&mut self, text: &str, origin: Origin) {
        for c in text.chars() {
            self.character(c);
            if c == '\n' {
                self.start_line(origin);
            }
        }
    }

    fn character(&mut self, c: char) {
        match c {
            '&' => self.text.push_str("&amp;"),
            '<' => self.text.push_str("&lt;"),
            '>' => self.text.push_str("&gt;"),
            '\r' => self.text.push_str("&#13;"),
            '\n' | '\t' => self.text.push(c),
            // Characters that XML does not have, which expressions can make.
            c if c.is_control() && c < ' ' || matches!(c, '\u{fffe}' | '\u{ffff}') => self.text.push('\u{fffd}'),
            c => self.text.push(c),
        }
    }
}
