//! XML as text.

use std::fmt::Write as _;

/// Number of levels that are indented. A chain of thousands of bodies would be mostly spaces otherwise.
const MAX_INDENT: usize = 32;

/// Writes elements with indentation.
#[derive(Default)]
pub struct XmlWriter {
    text: String,
    open: Vec<&'static str>,
}

impl XmlWriter {
    /// Creates a writer whose text begins with the declaration and, if it is not empty, a comment.
    pub fn new(comment: &str) -> Self {
        let mut text = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n".to_owned();
        if !comment.is_empty() {
            // Two hyphens would end the comment.
            let comment = comment.replace("--", "- -");
            let _ = writeln!(text, "<!-- {comment} -->");
        }
        XmlWriter { text, open: Vec::new() }
    }

    /// Creates a writer for elements that [`append`](Self::append) adds `depth` elements deep.
    pub fn nested(depth: usize) -> Self {
        XmlWriter { text: String::new(), open: vec![""; depth] }
    }

    /// Adds the elements of a nested writer.
    pub fn append(&mut self, nested: XmlWriter) {
        self.text.push_str(&nested.text);
    }

    fn indent(&mut self) {
        for _ in 0..self.open.len().min(MAX_INDENT) {
            self.text.push_str("  ");
        }
    }

    fn tag(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.indent();
        let _ = write!(self.text, "<{name}");
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"");
            escape(&mut self.text, value);
            self.text.push('"');
        }
    }

    /// Writes an element without content.
    pub fn empty(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.tag(name, attributes);
        self.text.push_str("/>\n");
    }

    /// Begins an element, which [`end`](Self::end) ends.
    pub fn begin(&mut self, name: &'static str, attributes: &[(&str, String)]) {
        self.tag(name, attributes);
        self.text.push_str(">\n");
        self.open.push(name);
    }

    /// Ends the innermost element. One that turned out to have no content is written in the short form.
    pub fn end(&mut self) {
        let Some(name) = self.open.pop() else { return };
        let begin = self.text[..self.text.len().saturating_sub(1)].rfind('\n').map_or(0, |at| at + 1);
        let last = self.text[begin..].trim_start();
        let is_own = last.starts_with(&format!("<{name} ")) || last == format!("<{name}>\n");
        if is_own && last.ends_with(">\n") && !last.ends_with("/>\n") {
            self.text.truncate(self.text.len() - 2);
            self.text.push_str("/>\n");
            return;
        }
        self.indent();
        let _ = writeln!(self.text, "</{name}>");
    }

    /// Writes an element with text.
    pub fn text(&mut self, name: &str, content: &str) {
        self.tag(name, &[]);
        self.text.push('>');
        escape(&mut self.text, content);
        let _ = writeln!(self.text, "</{name}>");
    }

    /// Returns the text; all elements must have ended.
    pub fn finish(self) -> String {
        self.text
    }
}

/// Appends text with the characters escaped that XML reserves, and without those that it forbids.
fn escape(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' | '\r' => {
                let _ = write!(out, "&#{};", u32::from(c));
            }
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => out.push('_'),
            c => out.push(c),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_indented_and_reserved_characters_escaped() {
        let mut xml = XmlWriter::new("a--b");
        xml.begin("robot", &[("name", "a \"<&>\" \u{1}ü".to_owned())]);
        xml.begin("link", &[("name", "x".to_owned())]);
        xml.end();
        xml.begin("link", &[]);
        xml.text("material", "a&b");
        xml.empty("mass", &[("value", "1".to_owned())]);
        xml.end();
        xml.end();
        let expected = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- a- -b -->\n\
            <robot name=\"a &quot;&lt;&amp;&gt;&quot; _ü\">\n  <link name=\"x\"/>\n  <link>\n    \
            <material>a&amp;b</material>\n    <mass value=\"1\"/>\n  </link>\n</robot>\n";
        assert_eq!(xml.finish(), expected);
    }
}
