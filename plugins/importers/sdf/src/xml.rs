//! Parses XML files into elements.

use roxmltree::{Document, Error, ParsingOptions};
use tatu_importers_robots::Element;
use tatu_importers_xml::too_large;
use tatu_plugin_api::safe::{Fail, Result};

use crate::text::repair;

/// Maximum number of nodes of the XML tree of one file.
const MAX_NODES: u32 = 2_000_000;

/// Parses a text, whose lines have numbers above `before`. Fails if the text is not well-formed XML, even after repairs,
/// or is nested too deeply.
pub fn parse(text: &str, before: u64) -> Result<Element> {
    let text = repair(text);
    let fail = |line: u64, text: String| Fail::argument(text).at("", before + line);
    let line_of = |at: usize| text.get(..at).unwrap_or_default().matches('\n').count() as u64 + 1;
    if let Some((at, why)) = too_large(&text) {
        return Err(fail(line_of(at), why));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..Default::default() };
    let document = Document::parse_with_options(&text, options).map_err(|e| match e {
        Error::DtdDetected => {
            let line = line_of(text.find("<!DOCTYPE").unwrap_or(0));
            fail(line, "a document type declaration is not supported in an SDF file; remove it".into())
        }
        Error::NodesLimitReached => fail(1, format!("the file has more than {MAX_NODES} XML nodes")),
        // The parser does not report a position for these errors.
        Error::UnclosedRootNode | Error::NoRootNode | Error::UnexpectedEndOfStream => {
            fail(line_of(text.trim_end().len()), format!("the file is not well-formed XML, or it is incomplete: {e}"))
        }
        e => {
            let (line, said) = (e.pos().row, e.to_string());
            let said = said.strip_suffix(&format!(" at {}", e.pos())).unwrap_or(&said).to_owned();
            fail(line.into(), format!("the file is not well-formed XML: {said}"))
        }
    })?;
    let starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
    let line_of = |at: usize| before + starts.partition_point(|start| *start <= at).max(1) as u64;
    Element::copy(document.root_element(), &line_of)
}
