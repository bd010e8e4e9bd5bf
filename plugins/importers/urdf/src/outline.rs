//! Determines the lines of links and joints in the file, because urdf-rs neither reports lines nor checks nesting.

use std::{collections::BTreeMap, ops::Range};

use tatu_plugin_api::safe::{Fail, Result};
use xml::{
    common::Position,
    reader::{EventReader, XmlEvent},
};

/// Maximum nesting depth of elements; real files have a depth of 6.
const MOST_DEPTH: usize = 64;
/// Maximum number of links and joints in total.
const MOST_PARTS: usize = 20_000;

/// The location of a child element of `<robot>`.
pub struct Part {
    /// Line of the element's start tag, counted from 1.
    pub line: u64,
    bytes: Range<usize>,
}

/// Positions of the elements below `<robot>`.
#[derive(Default)]
pub struct Outline {
    /// Links, in the order of the file.
    pub links: Vec<Part>,
    /// Joints, in the order of the file.
    pub joints: Vec<Part>,
    /// Other elements, which are ignored, and their numbers of occurrences.
    pub others: BTreeMap<String, usize>,
}

/// Reads the outline. Invalid XML, or a root element other than `<robot>`, is an error that contains the line.
pub fn read(text: &str) -> Result<Outline> {
    let starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
    // Rows and columns are zero-based; columns count characters. Positions are requested in ascending order, so each
    // search starts at the last position. This matters if a file consists of a single long line.
    let mut last = (0, 0, 0);
    let mut byte = |row: u64, column: u64| {
        let (start, skip) = match last {
            (r, c, at) if r == row && c <= column => (at, column - c),
            _ => (starts.get(row as usize).copied().unwrap_or(text.len()), column),
        };
        let rest = &text[start..];
        let at = start + rest.char_indices().nth(skip as usize).map_or(rest.len(), |(i, _)| i);
        last = (row, column, at);
        at
    };
    if let Some(at) = text.find("<!DOCTYPE") {
        let line = text[..at].matches('\n').count() as u64 + 1;
        return Err(
            Fail::argument("a document type declaration is not supported in a URDF file; remove it").at("", line)
        );
    }
    let mut outline = Outline::default();
    let mut depth = 0;
    let mut open: Option<(String, usize, u64)> = None;
    let mut reader = EventReader::new(text.as_bytes());
    loop {
        let event = reader.next();
        let at = reader.position();
        let line = at.row + 1;
        match event
            .map_err(|e| Fail::argument(format!("not well-formed XML: {}", e.msg())).at("", e.position().row + 1))?
        {
            XmlEvent::StartElement { name, .. } => {
                depth += 1;
                if depth > MOST_DEPTH {
                    return Err(
                        Fail::argument(format!("elements are nested more than {MOST_DEPTH} levels deep")).at("", line)
                    );
                }
                if name.namespace.as_deref().is_some_and(|n| n.contains("xacro")) || name.local_name == "macro" {
                    return Err(Fail::unsupported("this is a xacro file, not a URDF file")
                        .help("run `xacro robot.urdf.xacro > robot.urdf` first")
                        .at("", line));
                }
                match depth {
                    1 if name.local_name != "robot" => {
                        return Err(Fail::argument(format!(
                            "the root element is <{}>, but <robot> is expected",
                            name.local_name
                        ))
                        .help("a URDF file contains exactly one <robot>")
                        .at("", line));
                    }
                    2 => open = Some((name.local_name, byte(at.row, at.column), line)),
                    _ => {}
                }
            }
            XmlEvent::EndElement { .. } => {
                if depth == 2
                    && let Some((name, start, line)) = open.take()
                {
                    let from = byte(at.row, at.column).max(start);
                    let end = text[from..].find('>').map_or(text.len(), |i| from + i + 1);
                    let part = Part { line, bytes: start..end };
                    match name.as_str() {
                        "link" => outline.links.push(part),
                        "joint" => outline.joints.push(part),
                        "material" => {}
                        _ => *outline.others.entry(name).or_default() += 1,
                    }
                    if outline.links.len() + outline.joints.len() > MOST_PARTS {
                        return Err(Fail::argument(format!("the file has more than {MOST_PARTS} links and joints"))
                            .at("", line));
                    }
                }
                depth = depth.saturating_sub(1);
            }
            XmlEvent::EndDocument => return Ok(outline),
            _ => {}
        }
    }
}

impl Outline {
    /// Parses the robot. If urdf-rs fails, links and joints are parsed separately to find the line of the error.
    pub fn parse(&self, text: &str) -> Result<urdf_rs::Robot> {
        let robot = urdf_rs::read_from_string(text).map_err(|e| {
            let alone = |p: &Part| {
                let part = text.get(p.bytes.clone()).unwrap_or_default();
                urdf_rs::read_from_string(&format!("<robot name=\"r\">{part}</robot>")).err()
            };
            let mut parts = self.links.iter().map(|p| (p, "link")).chain(self.joints.iter().map(|p| (p, "joint")));
            match parts.find_map(|(p, what)| alone(p).map(|e| (p, what, e))) {
                Some((p, what, e)) => Fail::argument(format!("a {what} cannot be read: {e}")).at("", p.line),
                None => Fail::argument(format!("the robot cannot be read: {e}")).at("", 1),
            }
        })?;
        // Lines are assigned to links and joints by their order, so their counts must agree.
        if (robot.links.len(), robot.joints.len()) != (self.links.len(), self.joints.len()) {
            return Err(Fail::argument("links and joints must be direct children of <robot>").at("", 1));
        }
        Ok(robot)
    }
}
