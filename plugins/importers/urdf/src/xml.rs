//! Access to the elements of an XML file and their attributes. Errors contain the line and column.

use std::borrow::Cow;

use roxmltree::{Document, Error, Node, ParsingOptions};
use tatu_importers_robots::Element;
use tatu_importers_xml::root_name;
use tatu_plugin_api::safe::{Fail, Result};

/// Maximum nesting depth of elements; real files have a depth of 6.
const MAX_DEPTH: usize = 64;
/// Maximum number of nodes of the XML tree. It limits the memory that a file can occupy to a few hundred megabytes.
const MAX_NODES: u32 = 2_000_000;

/// A text and the offsets at which its lines begin.
pub struct LineIndex<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> LineIndex<'t> {
    /// Creates the index of a text.
    pub fn new(text: &'t str) -> Self {
        LineIndex { text, starts: std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect() }
    }
    /// Returns the line and column of a byte, counted from 1; columns count characters.
    fn position_of(&self, byte: usize) -> (u64, usize) {
        let line = self.starts.partition_point(|start| *start <= byte).max(1);
        let before = self.text.get(self.starts[line - 1]..byte).unwrap_or_default();
        (line as u64, before.chars().count() + 1)
    }
    /// Returns the line of the last character.
    fn last_line(&self) -> u64 {
        self.position_of(self.text.trim_end().len()).0
    }
}

/// Maximum number of prefixes that [`bind_prefixes`] binds.
const MAX_PREFIXES: usize = 64;

/// Returns the text with all namespace prefixes bound that it uses without binding them, as readers without namespaces
/// accept it, and the first of these prefixes. Lines stay the same.
pub fn bind_prefixes(text: &str) -> (Cow<'_, str>, Option<String>) {
    let mut bound = Cow::Borrowed(text);
    let mut first = None;
    for _ in 0..MAX_PREFIXES {
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
        let Err(Error::UnknownNamespace(prefix, _)) = Document::parse_with_options(&bound, options) else { break };
        // A xacro file has a better error.
        let Some(at) = root_name(&bound).map(|name| name.end).filter(|_| prefix != "xacro") else { break };
        bound = Cow::Owned(format!("{} xmlns:{prefix}=\"unbound\"{}", &bound[..at], &bound[at..]));
        first.get_or_insert(prefix);
    }
    (bound, first)
}

/// Parses a file. Fails if the text is not well-formed XML or is nested too deeply.
pub fn parse<'t>(lines: &LineIndex<'t>) -> Result<Document<'t>> {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    let document = Document::parse_with_options(lines.text, options).map_err(|e| {
        let (line, column) = (u64::from(e.pos().row), e.pos().col);
        match e {
            Error::DtdDetected => {
                let line = lines.position_of(lines.text.find("<!DOCTYPE").unwrap_or(0)).0;
                Fail::argument("a document type declaration is not supported in a URDF file; remove it").at("", line)
            }
            Error::UnknownNamespace(prefix, _) if prefix == "xacro" => xacro(line),
            Error::NodesLimitReached => Fail::argument(format!("the file has more than {MAX_NODES} XML nodes")),
            // The parser does not report a position for these errors.
            Error::UnclosedRootNode | Error::NoRootNode | Error::UnexpectedEndOfStream => {
                Fail::argument(format!("the file is not well-formed XML, or it is incomplete: {}", error_text(&e)))
                    .at("", lines.last_line())
            }
            e => Fail::argument(format!("the file is not well-formed XML: {} (column {column})", error_text(&e)))
                .at("", line),
        }
    })?;
    // The ancestors of the current element, and the element itself.
    let mut above = Vec::new();
    for node in document.descendants().filter(Node::is_element) {
        let parent = node.parent_element().map(|p| p.id());
        while above.last().copied() != parent {
            above.pop();
        }
        above.push(node.id());
        let tag = XmlElement { node, lines };
        if above.len() > MAX_DEPTH {
            return Err(tag.fail(format!("the file nests elements more than {MAX_DEPTH} levels deep")));
        }
        if node.tag_name().namespace().is_some_and(|n| n.contains("xacro")) || tag.name() == "macro" {
            return Err(xacro(tag.line()));
        }
    }
    Ok(document)
}

/// Returns the message of a parser error without the position, which is reported separately.
fn error_text(e: &Error) -> String {
    let text = e.to_string();
    text.strip_suffix(&format!(" at {}", e.pos())).unwrap_or(&text).to_owned()
}

fn xacro(line: u64) -> Fail {
    Fail::unsupported("this element of xacro has not been expanded")
        .help("name the namespace `xacro`: `<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">`, `<xacro:macro>`")
        .at("", line)
}

/// An element. Namespaces are ignored.
#[derive(Clone, Copy)]
pub struct XmlElement<'a, 't> {
    node: Node<'a, 't>,
    lines: &'a LineIndex<'t>,
}

impl<'a, 't> XmlElement<'a, 't> {
    /// Returns the root element.
    pub fn root(document: &'a Document<'t>, lines: &'a LineIndex<'t>) -> Self {
        XmlElement { node: document.root_element(), lines }
    }
    /// Returns the name of the element without its namespace prefix.
    pub fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }
    /// Returns the element as it is written in the file.
    pub fn source(&self) -> &'t str {
        self.lines.text.get(self.node.range()).unwrap_or_default()
    }
    /// Copies the element. Fails if it is nested too deeply.
    pub fn copy(&self) -> Result<Element> {
        Element::copy(self.node, &|at| self.lines.position_of(at).0)
    }
    /// Returns the line of the start tag, counted from 1.
    pub fn line(&self) -> u64 {
        self.lines.position_of(self.node.range().start).0
    }
    /// Returns the child elements.
    pub fn children(self) -> impl Iterator<Item = XmlElement<'a, 't>> {
        self.node.children().filter(Node::is_element).map(move |node| XmlElement { node, lines: self.lines })
    }
    /// Returns the child element with this name, or `None` if there is none. Fails if there are several.
    pub fn child(self, name: &str) -> Result<Option<XmlElement<'a, 't>>> {
        let mut found = self.children().filter(|c| c.name() == name);
        match (found.next(), found.next()) {
            (_, Some(second)) => Err(second.fail(format!("{self} has more than one <{name}>"))),
            (first, None) => Ok(first),
        }
    }
    /// Returns the first child element with this name, or `None` if there is none.
    pub fn first_child(self, name: &str) -> Option<XmlElement<'a, 't>> {
        self.children().find(|c| c.name() == name)
    }
    /// Returns the child element with this name. Fails unless there is exactly one.
    pub fn required_child(self, name: &str) -> Result<XmlElement<'a, 't>> {
        self.child(name)?.ok_or_else(|| self.fail(format!("{self} has no <{name}>")))
    }

    /// Builds an error whose position is that of the start tag.
    pub fn fail(&self, text: String) -> Fail {
        self.fail_at(self.node.range().start, text)
    }
    fn fail_at(&self, byte: usize, text: String) -> Fail {
        let (line, column) = self.lines.position_of(byte);
        Fail::argument(format!("{text} (column {column})")).at("", line)
    }
    /// Builds the error for an attribute that is missing or has an invalid value.
    pub fn invalid(&self, attribute: &str, expected: &str) -> Fail {
        match self.node.attribute_node(attribute) {
            Some(a) => {
                let text = format!("`{attribute}` of {self} is \"{}\"; expected {expected}", a.value());
                self.fail_at(a.range().start, text)
            }
            None => self.fail(format!("{self} has no `{attribute}`; expected {expected}")),
        }
    }

    /// Returns the text of an attribute, or `None` if it is missing.
    pub fn text(&self, attribute: &str) -> Option<&'a str> {
        self.node.attributes().find(|a| a.name() == attribute).map(|a| a.value())
    }
    /// Returns the text in the element, or `None` if it has none.
    pub fn content(&self) -> Option<&'a str> {
        self.node.text()
    }
    /// Returns the text of an attribute. Fails if it is missing.
    pub fn required(&self, attribute: &str) -> Result<String> {
        self.text(attribute).map(str::to_owned).ok_or_else(|| self.fail(format!("{self} has no `{attribute}`")))
    }
    /// Returns the number in an attribute, or `None` if the attribute is missing.
    pub fn number(&self, attribute: &str) -> Result<Option<f64>> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        text.trim().parse().map(Some).map_err(|_| self.invalid(attribute, "a number"))
    }
    /// Returns the number in an attribute. Fails if the attribute is missing.
    pub fn required_number(&self, attribute: &str) -> Result<f64> {
        self.number(attribute)?.ok_or_else(|| self.invalid(attribute, "a number"))
    }
    /// Returns the `N` numbers in an attribute, or `None` if the attribute is missing. Words that are not numbers are
    /// ignored. Fails if there are not exactly `N` numbers.
    pub fn numbers<const N: usize>(&self, attribute: &str) -> Result<Option<[f64; N]>> {
        let Some(text) = self.text(attribute) else { return Ok(None) };
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        numbers.try_into().map(Some).map_err(|_| self.invalid(attribute, &format!("{N} numbers")))
    }
    /// Returns the `N` numbers in an attribute. Fails if the attribute is missing or does not contain `N` numbers.
    pub fn required_numbers<const N: usize>(&self, attribute: &str) -> Result<[f64; N]> {
        self.numbers(attribute)?.ok_or_else(|| self.invalid(attribute, &format!("{N} numbers")))
    }
}

impl std::fmt::Display for XmlElement<'_, '_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "<{}>", self.name())
    }
}
