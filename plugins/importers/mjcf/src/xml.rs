//! Elements of XML files, detached from the text, so that included files can be merged into one tree.

use std::rc::Rc;

use roxmltree::{Document, Error, Node, ParsingOptions};
use tatu_importers_xml::too_large;
use tatu_plugin_api::safe::{Fail, Result};

/// Maximum nesting depth of elements. Ropes and chains nest one body in another; known ones have up to 100 links.
pub const MAX_DEPTH: usize = 200;
/// Maximum number of nodes of the XML tree of one file.
const MAX_NODES: u32 = 2_000_000;

/// A line of a file. The name of the imported file itself is empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    pub file: Rc<str>,
    pub line: u64,
}

impl Place {
    /// Builds an error at this place.
    pub fn fail(&self, text: impl Into<String>) -> Fail {
        Fail::argument(text).at(&*self.file, self.line)
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &*self.file {
            "" => write!(f, "line {}", self.line),
            file => write!(f, "line {} of {file}", self.line),
        }
    }
}

/// An element with its attributes in the order of the file. Namespaces are ignored.
#[derive(Debug, Clone)]
pub struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub place: Place,
}

impl Element {
    /// Returns the text of an attribute, or `None` if it is missing.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }
    /// Returns the children with this name.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.name == name)
    }
    /// Returns the children of all children with this name, such as those of all sections `asset` of a file.
    pub fn section<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.named(name).flat_map(|section| &section.children)
    }
    /// Builds an error at this element.
    pub fn fail(&self, text: impl Into<String>) -> Fail {
        self.place.fail(text)
    }
}

/// Parses a text; `file` is the name for errors. Fails if the text is not well-formed XML or is nested too deeply.
pub fn parse(text: &str, file: &Rc<str>) -> Result<Element> {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    let fail = |line: u64, text: String| Fail::argument(text).at(&**file, line);
    let last = || text.trim_end().matches('\n').count() as u64 + 1;
    if let Some((at, why)) = too_large(text) {
        let line = text.get(..at).unwrap_or_default().matches('\n').count() as u64 + 1;
        return Err(fail(line, why));
    }
    let document = Document::parse_with_options(text, options).map_err(|e| match e {
        Error::DtdDetected => {
            let before = text.find("<!DOCTYPE").and_then(|at| text.get(..at)).unwrap_or_default();
            let line = before.matches('\n').count() as u64 + 1;
            fail(line, "a document type declaration is not supported in an MJCF file; remove it".into())
        }
        Error::NodesLimitReached => fail(1, format!("the file has more than {MAX_NODES} XML nodes")),
        // The parser does not report a position for these errors.
        Error::UnclosedRootNode | Error::NoRootNode | Error::UnexpectedEndOfStream => {
            fail(last(), format!("the file is not well-formed XML, or it is incomplete: {e}"))
        }
        e => {
            let (line, column, said) = (e.pos().row, e.pos().col, e.to_string());
            let said = said.strip_suffix(&format!(" at {}", e.pos())).unwrap_or(&said).to_owned();
            fail(line.into(), format!("the file is not well-formed XML: {said} (column {column})"))
        }
    })?;
    let starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
    element(document.root_element(), file, &starts, 1)
}

fn element(node: Node<'_, '_>, file: &Rc<str>, starts: &[usize], depth: usize) -> Result<Element> {
    let line = starts.partition_point(|start| *start <= node.range().start).max(1) as u64;
    let place = Place { file: file.clone(), line };
    if depth > MAX_DEPTH {
        return Err(place.fail(format!("the file nests elements more than {MAX_DEPTH} levels deep")));
    }
    let attributes = node.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())).collect();
    let children = node.children().filter(Node::is_element).map(|c| element(c, file, starts, depth + 1));
    Ok(Element {
        name: node.tag_name().name().to_owned(),
        attributes,
        children: children.collect::<Result<_>>()?,
        place,
    })
}
