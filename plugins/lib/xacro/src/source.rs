//! Source files: their elements, and lines and columns of offsets.

use std::rc::Rc;

use roxmltree::{Document, NodeId, NodeType, ParsingOptions};
use tatu_importers_xml::too_large;

use crate::error::{Fault, Origin, Place, Result, fail};

/// Maximum depth of elements in a file.
const MAX_DEPTH: usize = 256;
/// Maximum number of prefixes that a file uses without a declaration.
const MAX_UNDECLARED: usize = 32;
/// What an undeclared prefix is bound to, followed by the prefix.
pub(crate) const UNDECLARED_URI: &str = "urn:undeclared:";

/// An element of a source file, or one that was made from it.
#[derive(Debug)]
pub(crate) struct Element {
    /// The name with its prefix.
    pub name: Rc<str>,
    /// Attributes in order, declarations of namespaces among them.
    pub attributes: Vec<Attribute>,
    pub children: Vec<Node>,
    pub origin: Origin,
}

#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub name: Rc<str>,
    pub value: Rc<str>,
    pub origin: Origin,
}

#[derive(Clone, Debug)]
pub(crate) enum Node {
    Element(Rc<Element>),
    /// Text that is not blank. Comments are not needed by readers of the result.
    Text(Rc<str>, Origin),
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| &*attribute.name == name)
    }

    /// The child elements, without text.
    pub fn elements(&self) -> impl Iterator<Item = &Rc<Element>> {
        self.children.iter().filter_map(|child| match child {
            Node::Element(element) => Some(element),
            Node::Text(..) => None,
        })
    }
}

/// Lines of a file.
#[derive(Debug)]
pub(crate) struct SourceFile {
    pub name: Rc<str>,
    text: String,
    line_starts: Vec<usize>,
    /// Offset and length of declarations that were added to the text.
    added: (usize, usize),
    /// Prefixes that the file uses without a declaration.
    pub undeclared: Vec<String>,
}

impl SourceFile {
    fn new(name: &str, text: String) -> Self {
        let starts = text.match_indices('\n').map(|(at, _)| at + 1);
        let line_starts = std::iter::once(0).chain(starts).collect();
        SourceFile { name: name.into(), text, line_starts, added: (usize::MAX, 0), undeclared: Vec::new() }
    }

    /// The line of an offset, from 1.
    pub fn line(&self, offset: u32) -> u32 {
        self.line_starts.partition_point(|start| *start <= offset as usize) as u32
    }

    pub fn place(&self, offset: u32) -> Place {
        let line = self.line(offset);
        let start = self.line_starts.get(line.saturating_sub(1) as usize).copied().unwrap_or(0);
        let before = self.text.get(start..offset as usize).unwrap_or("");
        let (added_at, added_len) = self.added;
        let is_after = added_at >= start && added_at < offset as usize;
        // What was added is ASCII.
        let added = if is_after { added_len.min(offset as usize - added_at) } else { 0 };
        Place { file: self.name.to_string(), line, column: (1 + before.chars().count() - added) as u32 }
    }

    /// The offset of a line and a column, both from 1.
    fn offset(&self, line: u32, column: u32) -> u32 {
        let start = self.line_starts.get(line.saturating_sub(1) as usize).copied().unwrap_or(0);
        let rest = self.text.get(start..).unwrap_or("");
        let within = rest.char_indices().nth(column.saturating_sub(1) as usize).map_or(rest.len(), |(at, _)| at);
        (start + within) as u32
    }

    /// Declares a prefix at the root element.
    fn declare(&mut self, prefix: &str) -> bool {
        let Some(at) = end_of_root_name(&self.text) else { return false };
        let declaration = format!(" xmlns:{prefix}=\"{UNDECLARED_URI}{prefix}\"");
        self.text.insert_str(at, &declaration);
        for start in self.line_starts.iter_mut().filter(|start| **start > at) {
            *start += declaration.len();
        }
        self.undeclared.push(prefix.to_owned());
        self.added = (at, if self.added.0 == at { self.added.1 } else { 0 } + declaration.len());
        true
    }
}

/// Offset after the name of the root element: after the declaration, comments and instructions.
fn end_of_root_name(text: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        let skipped = [("<?", "?>"), ("<!--", "-->"), ("<!", ">")].iter().find(|(open, _)| rest.starts_with(open));
        match skipped {
            Some((_, close)) => at += rest.find(close)? + close.len(),
            None => {
                let len = rest[1..].find(|c: char| c.is_whitespace() || c == '>' || c == '/')?;
                return Some(at + 1 + len);
            }
        }
    }
}

/// Parses a file; returns the file also if that fails, so that the error has a place in it.
pub(crate) fn parse(name: &str, bytes: &[u8], index: u32) -> (SourceFile, Result<Rc<Element>>) {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(error) => {
            let start = std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or("").to_owned();
            let origin = Origin { file: index, offset: start.len() as u32 };
            let fault = Fault::new("the file is no text in UTF-8: save it in this encoding").at(origin);
            return (SourceFile::new(name, start), Err(fault));
        }
    };
    let mut file = SourceFile::new(name, text);
    if let Some((offset, message)) = too_large(&file.text) {
        let origin = Origin { file: index, offset: offset as u32 };
        return (file, Err(Fault::new(message).at(origin)));
    }
    for _ in 0..=MAX_UNDECLARED {
        let error = match Document::parse_with_options(&file.text, ParsingOptions::default()) {
            Ok(document) => {
                let root = read(&document, document.root_element().id(), index, 0);
                return (file, root);
            }
            Err(error) => error,
        };
        let is_declared = match &error {
            roxmltree::Error::UnknownNamespace(prefix, _) => file.declare(prefix),
            _ => false,
        };
        if !is_declared {
            let position = error.pos();
            let offset = match (&error, file.text.find("<!DOCTYPE")) {
                (roxmltree::Error::DtdDetected, Some(at)) => at as u32,
                _ => file.offset(position.row, position.col),
            };
            let origin = Origin { file: index, offset };
            let message = match error {
                roxmltree::Error::DtdDetected => {
                    "<!DOCTYPE ...> is not supported: remove it, and write out what its entities stand for".to_owned()
                }
                other => format!("the file is no well-formed XML: {}", without_position(&other.to_string())),
            };
            return (file, Err(Fault::new(message).at(origin)));
        }
    }
    (file, Err(Fault::new(format!("more than {MAX_UNDECLARED} prefixes have no xmlns:... that declares them"))))
}

/// An error's text without the position at its end, which is given as a place.
fn without_position(text: &str) -> &str {
    match text.rsplit_once(" at ") {
        Some((message, position)) if position.starts_with(|c: char| c.is_ascii_digit()) => message,
        _ => text,
    }
}

fn read(document: &Document<'_>, id: NodeId, index: u32, depth: usize) -> Result<Rc<Element>> {
    let source = document.input_text();
    let Some(node) = document.get_node(id) else { fail!("the document has no root element") };
    let at = |offset: usize| Origin { file: index, offset: offset as u32 };
    let range = node.range();
    if depth >= MAX_DEPTH {
        return Err(Fault::new(format!("elements are nested deeper than {MAX_DEPTH}")).at(at(range.start)));
    }
    let tag = &source[range.clone()];
    let name_len = tag[1..].find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap_or(tag.len() - 1);
    let mut attributes = declarations(&node, &tag[1 + name_len..], at(range.start));
    attributes.extend(node.attributes().map(|attribute| Attribute {
        name: source[attribute.range_qname()].into(),
        value: attribute.value().into(),
        origin: at(attribute.range_qname().start),
    }));
    let mut children = Vec::new();
    for child in node.children() {
        match child.node_type() {
            NodeType::Element => children.push(Node::Element(read(document, child.id(), index, depth + 1)?)),
            NodeType::Text => {
                let text = child.text().unwrap_or("");
                if !text.trim().is_empty() {
                    children.push(Node::Text(text.into(), at(child.range().start)));
                }
            }
            _ => {}
        }
    }
    Ok(Rc::new(Element { name: tag[1..=name_len].into(), attributes, children, origin: at(range.start) }))
}

/// The declarations of namespaces in a tag, which follows its name. The XML is known to be well-formed.
fn declarations(node: &roxmltree::Node<'_, '_>, tag: &str, origin: Origin) -> Vec<Attribute> {
    let mut out = Vec::new();
    let mut rest = tag.trim_start();
    while let Some((name, after)) = rest.split_once('=') {
        if name.starts_with(['>', '/']) {
            break;
        }
        let name = name.trim();
        let after = after.trim_start();
        let Some(quote) = after.chars().next() else { break };
        let Some((_, next)) = after.get(1..).and_then(|value| value.split_once(quote)) else { break };
        if name == "xmlns" || name.starts_with("xmlns:") {
            let prefix = name.strip_prefix("xmlns:");
            let uri = node.lookup_namespace_uri(prefix).unwrap_or("");
            out.push(Attribute { name: name.into(), value: uri.into(), origin });
        }
        rest = next.trim_start();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_without_declaration_do_not_move_places() {
        let text = "<?xml version=\"1.0\"?>\n<!-- <x> -->\n<robot a='1' sensor:b='2'>\n <xacro:if/>é<q z='3'/></robot>";
        let (file, root) = parse("f", text.as_bytes(), 0);
        let root = root.unwrap();
        let names: Vec<&str> = root.attributes.iter().map(|a| &*a.name).collect();
        assert_eq!(names, ["xmlns:xacro", "xmlns:sensor", "a", "sensor:b"]);
        let place = |origin: Origin| (file.place(origin.offset).line, file.place(origin.offset).column);
        assert_eq!(place(root.attributes[3].origin), (3, 14));
        let inner: Vec<_> = root.elements().collect();
        assert_eq!(place(inner[1].origin), (4, 14));
        assert_eq!(place(inner[1].attributes[0].origin), (4, 17));
    }

    #[test]
    fn flaws_of_xml_have_a_place() {
        for (text, line, column) in
            [("<a>\n<b></a>", 2, 4), ("<a>\n\u{e4}<!-- -- --></a>", 2, 2), ("<!DOCTYPE a []><a/>", 1, 1), ("", 1, 1)]
        {
            let (file, root) = parse("f", text.as_bytes(), 0);
            let place = file.place(root.unwrap_err().origin.unwrap().offset);
            assert_eq!((place.line, place.column), (line, column), "{text}");
        }
        let deep = "<a>".repeat(1000) + &"</a>".repeat(1000);
        assert!(parse("f", deep.as_bytes(), 0).1.unwrap_err().message.contains("deeper"));
        assert!(parse("f", b"<a>\xff</a>", 0).1.unwrap_err().message.contains("UTF-8"));
    }
}
