//! Parser of the XML description of a window.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Result};
use xml::{EmitterConfig, EventWriter, ParserConfig, common::Position, reader::XmlEvent};

use crate::node::WidgetNode;

/// Maximum length of a description, in bytes.
const MAX_BYTES: usize = 1 << 20;
/// Maximum nesting depth of the elements of a window.
const MAX_DEPTH: usize = 64;
/// Maximum number of elements.
const MAX_NODES: usize = 5000;

/// Attributes with numeric values. Those in `BOOLEAN_ATTRIBUTES` are booleans. All others are strings, except `checked`
/// and, unless the element is an `<edit>`, `value`, which are numbers.
const NUMBER_ATTRIBUTES: &[&str] =
    &["minimum", "maximum", "step", "tick-interval", "max-buffer-size", "auto-repeat-interval", "width", "height"];
const BOOLEAN_ATTRIBUTES: &[&str] = &[
    "enabled",
    "visible",
    "flat",
    "closeable",
    "closable",
    "resizable",
    "modal",
    "activate",
    "checkable",
    "auto-exclusive",
    "wordwrap",
    "float",
    "editable",
    "auto-repeat",
    "scaled-contents",
    "keep-aspect-ratio",
];

/// Parses a description into its elements; the first one is the window.
pub(crate) fn read(text: &str) -> Result<Vec<WidgetNode>> {
    if text.len() > MAX_BYTES {
        return Err(Fail::argument(format!(
            "the description of the window has {} bytes; at most {MAX_BYTES} are accepted",
            text.len()
        )));
    }
    if text.contains("<!DOCTYPE") {
        return Err(Fail::argument(
            "a document type declaration is not supported in the description of a window; remove it",
        ));
    }
    let config = ParserConfig::new().trim_whitespace(true).cdata_to_characters(true).ignore_comments(true);
    let text = escaped(text.trim_start());
    let mut reader = config.add_entity("nbsp", "\u{a0}").create_reader(text.as_bytes());
    let (mut nodes, mut open): (Vec<WidgetNode>, Vec<usize>) = (Vec::new(), Vec::new());
    // The content of an `<svg>` widget is stored as text instead of nodes.
    let mut drawing: Option<DrawingBuffer> = None;
    loop {
        let event = reader.next();
        let line = reader.position().row + 1;
        let event =
            event.map_err(|e| Fail::argument(format!("line {line} of the window: invalid XML: {}", e.msg())))?;
        let within = open.last().is_some_and(|n| nodes[*n].element == "svg");
        if within && (drawing.is_some() || matches!(event, XmlEvent::StartElement { .. })) {
            let now = drawing.get_or_insert_with(DrawingBuffer::new);
            if now.append(&event, open.len(), line)? {
                let text = drawing.take().map(DrawingBuffer::text).unwrap_or_default();
                nodes.last_mut().into_iter().for_each(|n| drop(n.values.insert("data".into(), json!(text))));
            }
            continue;
        }
        match event {
            XmlEvent::StartElement { name, attributes, .. } => {
                if open.len() >= MAX_DEPTH || nodes.len() >= MAX_NODES {
                    return Err(Fail::argument(format!(
                        "line {line} of the window: expected at most {MAX_NODES} elements, nested at most \
                         {MAX_DEPTH} deep"
                    )));
                }
                let element = name.local_name.to_ascii_lowercase();
                if nodes.is_empty() && element != "ui" {
                    return Err(Fail::argument(format!("the outermost element of a window is <ui>, not <{element}>")));
                }
                let n = nodes.len();
                let mut node = WidgetNode { element, above: open.last().copied(), ..Default::default() };
                for a in attributes {
                    attribute(&mut node, &a.name.local_name, a.value);
                }
                if let Some(above) = node.above {
                    nodes[above].below.push(n);
                }
                set_defaults(&mut node);
                nodes.push(node);
                open.push(n);
            }
            XmlEvent::Characters(text) => {
                if let Some(&n) = open.last() {
                    nodes[n].values.entry("text").or_insert_with(|| json!(text));
                }
            }
            XmlEvent::EndElement { .. } => {
                open.pop();
            }
            XmlEvent::EndDocument => break,
            _ => {}
        }
    }
    move_children_into_values(&mut nodes);
    Ok(nodes)
}

/// A drawing that is being parsed.
struct DrawingBuffer {
    writer: EventWriter<Vec<u8>>,
    depth: usize,
}

impl DrawingBuffer {
    fn new() -> Self {
        let config = EmitterConfig::new().write_document_declaration(false);
        DrawingBuffer { writer: config.create_writer(Vec::new()), depth: 0 }
    }
    /// Appends an XML event to the drawing, and returns whether the drawing is complete.
    fn append(&mut self, event: &XmlEvent, above: usize, line: u64) -> Result<bool> {
        match event {
            XmlEvent::StartElement { .. } => self.depth += 1,
            XmlEvent::EndElement { .. } => self.depth -= 1,
            _ => {}
        }
        if self.depth + above > MAX_DEPTH {
            return Err(Fail::argument(format!(
                "line {line} of the window: elements can be nested at most {MAX_DEPTH} levels deep"
            )));
        }
        if let Some(event) = event.as_writer_event() {
            let written = self.writer.write(event);
            written.map_err(|e| Fail::argument(format!("line {line} of the window: invalid drawing: {e}")))?;
        }
        Ok(self.depth == 0)
    }
    fn text(self) -> String {
        String::from_utf8_lossy(&self.writer.into_inner()).into_owned()
    }
}

fn attribute(node: &mut WidgetNode, name: &str, value: String) {
    let name = name.to_ascii_lowercase();
    // Older scripts spell these attribute names differently.
    let name = match name.as_str() {
        "onclick" => "on-click",
        "onchange" => "on-change",
        "onclose" => "on-close",
        "resizeable" => "resizable",
        "closable" => "closeable",
        other => other,
    };
    if name == "id" {
        node.id = value;
        return;
    }
    let number = || value.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let value = if NUMBER_ATTRIBUTES.contains(&name) {
        number().map_or(Json::Null, |x| json!(x))
    } else if BOOLEAN_ATTRIBUTES.contains(&name) {
        json!(matches!(value.trim(), "true" | "1" | "yes"))
    } else if name == "checked" {
        let on = matches!(value.trim(), "true" | "1" | "yes");
        json!(if !on { 0 } else { if node.element == "checkbox" { 2 } else { 1 } })
    } else if name == "value" && node.element != "edit" {
        number().map_or(Json::Null, |x| json!(x))
    } else {
        json!(value)
    };
    node.values.insert(name.to_owned(), value);
}

/// Sets the values that the description of a widget omits to their defaults.
fn set_defaults(node: &mut WidgetNode) {
    let mut put = |key: &str, value: Json| {
        node.values.entry(key).or_insert(value);
    };
    match node.element.as_str() {
        "hslider" | "vslider" | "progressbar" => {
            put("minimum", json!(0));
            put("maximum", json!(100));
        }
        "spinbox" => {
            put("minimum", json!(0));
            put("maximum", json!(100));
            put("step", json!(1));
        }
        "edit" => put("value", json!("")),
        "checkbox" | "radiobutton" => put("checked", json!(0)),
        "combobox" => {
            put("index", json!(0));
            put("items", json!([]));
        }
        "tabs" => put("current", json!(0)),
        "table" => {
            put("headers", json!([]));
            put("rows", json!([]));
        }
        "tree" => put("rows", json!([])),
        "plot" => put("curves", json!([])),
        _ => {}
    }
    if matches!(node.element.as_str(), "hslider" | "vslider" | "progressbar" | "spinbox") {
        let least = node.values.get("minimum").cloned().unwrap_or(json!(0));
        node.values.entry("value").or_insert(least);
    }
}

/// Moves the child elements of combo boxes (their entries), tables (header and rows) and trees (header) into the values
/// of these widgets.
fn move_children_into_values(nodes: &mut [WidgetNode]) {
    let texts = |nodes: &[WidgetNode], n: usize| -> Vec<Json> {
        let items = nodes[n].below.iter().filter(|b| nodes[**b].element == "item");
        items.map(|b| nodes[*b].values.get("text").cloned().unwrap_or(json!(""))).collect()
    };
    for n in 0..nodes.len() {
        match nodes[n].element.as_str() {
            "combobox" => {
                let items = texts(nodes, n);
                nodes[n].values.insert("items".into(), json!(items));
            }
            "table" | "tree" => {
                let mut rows = Vec::new();
                let mut headers = Json::Null;
                for &b in &nodes[n].below {
                    match nodes[b].element.as_str() {
                        "header" => headers = json!(texts(nodes, b)),
                        "row" => rows.push(texts(nodes, b)),
                        _ => {}
                    }
                }
                if !headers.is_null() {
                    nodes[n].values.insert("headers".into(), headers);
                }
                if nodes[n].element == "table" {
                    nodes[n].values.insert("rows".into(), json!(rows));
                }
            }
            _ => continue,
        }
        nodes[n].below.clear();
    }
}

/// Replaces `<` in attribute values with `&lt;`. XML does not permit an unescaped `<` in them, but V-REP accepts it.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut in_tag, mut quote) = (text, false, None);
    while let Some(c) = rest.chars().next() {
        let whole =
            [("<!--", "-->"), ("<![CDATA[", "]]>")].into_iter().find(|(from, _)| !in_tag && rest.starts_with(from));
        if let Some((_, to)) = whole {
            let end = rest.find(to).map_or(rest.len(), |i| i + to.len());
            out.push_str(&rest[..end]);
            rest = &rest[end..];
            continue;
        }
        match (in_tag, quote, c) {
            (true, Some(_), '<') => out.push_str("&lt;"),
            _ => out.push(c),
        }
        match (in_tag, quote, c) {
            (false, _, '<') => in_tag = true,
            (true, None, '>') => in_tag = false,
            (true, None, '"' | '\'') => quote = Some(c),
            (true, Some(q), _) if q == c => quote = None,
            _ => {}
        }
        rest = &rest[c.len_utf8()..];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_read_in_both_spellings() {
        let all = read(
            "<ui title='T' closeable=\"true\" onclose=\"bye\"><label text='a &lt;b&gt;'/><hslider id='2' minimum='-5' \
             maximum='5' on-change='f'/><combobox id='3'><item>x</item><item>y</item></combobox><label>inside</label></ui>",
        )
        .unwrap();
        assert_eq!(all[0].values["on-close"], "bye");
        assert_eq!(all[0].values["closeable"], true);
        assert_eq!(all[1].values["text"], "a <b>");
        assert_eq!((&all[2].values["value"], all[2].id.as_str()), (&json!(-5.0), "2"));
        assert_eq!(all[3].values["items"], json!(["x", "y"]));
        assert!(all.iter().any(|n| n.values.get("text") == Some(&json!("inside"))));
    }

    #[test]
    fn drawing_inside_a_widget_is_preserved_verbatim() {
        let drawing = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\"><g><text>a &lt; b</text></g></svg>";
        let all =
            read(&format!("<ui><svg id='1'>{drawing}</svg><svg id='2' file='a.svg'/><label text='c'/></ui>")).unwrap();
        assert_eq!(all.len(), 4);
        assert_eq!((all[1].values["data"].as_str(), all[1].id.as_str()), (Some(drawing), "1"));
        assert_eq!((&all[2].values["file"], all[2].values.get("data")), (&json!("a.svg"), None));
        assert_eq!((all[3].values["text"].as_str(), all[3].above), (Some("c"), Some(0)));
        let deep = format!("<ui><svg>{}", "<g>".repeat(70));
        assert!(read(&deep).unwrap_err().text().contains("deep"));
    }

    #[test]
    fn invalid_window_is_reported_with_its_line() {
        let told = |text: &str| read(text).unwrap_err().text().to_owned();
        assert!(told("<window/>").contains("<ui>"));
        assert!(told("<ui>\n<label text=5/></ui>").contains("line 2"), "{}", told("<ui>\n<label text=5/></ui>"));
        assert!(told("<!DOCTYPE a><ui/>").contains("document type"));
        assert!(told(&format!("{}{}", "<ui>", "<group>".repeat(70))).contains("nested"));
        assert!(told("").contains("invalid XML"));
        let text = "<ui title='a<b'><!-- it's <fine> --><label text=\"x < y\"/></ui>";
        let all = read(text).unwrap();
        assert_eq!((&all[0].values["title"], &all[1].values["text"]), (&json!("a<b"), &json!("x < y")));
    }
}
