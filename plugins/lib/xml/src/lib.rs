//! A look at the tags of an XML file before roxmltree parses it: the name of the root element, and whether tags are too
//! large, since the parser's time grows with the square of the number of attributes in a tag, and with the number of
//! namespaces at each element. All readers of XML files share it.

use std::ops::Range;

/// Maximum number of attributes of an element.
const MAX_ATTRIBUTES: usize = 256;
/// Maximum number of declarations of namespaces in a file.
const MAX_NAMESPACES: usize = 500;

/// Returns where the name of the root element is in a text, or `None` if the text does not begin as an XML file without
/// a document type declaration does.
pub fn root_name(text: &str) -> Option<Range<usize>> {
    let mut at = 0;
    loop {
        let rest = text[at..].trim_start_matches('\u{feff}').trim_start();
        at = text.len() - rest.len();
        let skipped = [("<!--", "-->"), ("<?", "?>")].iter().find(|(open, _)| rest.starts_with(open));
        match skipped {
            Some((_, close)) => at += rest.find(close)? + close.len(),
            None => {
                let name = rest.strip_prefix('<').filter(|name| !name.starts_with('!'))?;
                let length = name.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>'))?;
                return Some(at + 1..at + 1 + length).filter(|_| length > 0);
            }
        }
    }
}

/// Returns the first tag with too much in it: its offset, and what is wrong. Flaws of XML are left to the parser.
pub fn too_large(text: &str) -> Option<(usize, String)> {
    let mut at = 0;
    let mut namespaces = 0;
    while let Some(found) = text[at..].find('<') {
        let start = at + found;
        let rest = &text[start..];
        let skipped =
            [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")].iter().find(|(open, _)| rest.starts_with(open));
        if let Some((open, close)) = skipped {
            match rest[open.len()..].find(close) {
                Some(end) => at = start + open.len() + end + close.len(),
                None => return None,
            }
            continue;
        }
        let mut quote = None;
        let mut attributes = 0;
        let mut end = rest.len();
        for (offset, byte) in rest.bytes().enumerate() {
            match (quote, byte) {
                (Some(open), _) => quote = (byte != open).then_some(open),
                (None, b'"' | b'\'') => quote = Some(byte),
                (None, b'=') => attributes += 1,
                (None, b'>') => {
                    end = offset + 1;
                    break;
                }
                _ => {}
            }
        }
        if attributes > MAX_ATTRIBUTES {
            return Some((start, format!("the element has more than {MAX_ATTRIBUTES} attributes")));
        }
        // Values that contain the word count, too, which is harmless.
        namespaces += rest[..end].matches("xmlns").count();
        if namespaces > MAX_NAMESPACES {
            return Some((start, format!("the file declares more than {MAX_NAMESPACES} namespaces")));
        }
        at = start + end;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_element_has_a_name() {
        let name = |text: &'static str| root_name(text).map(|range| &text[range]);
        assert_eq!(name("\u{feff}<?xml version='1.0'?>\n<!-- <a> -->\n<robot name='r'>"), Some("robot"));
        assert_eq!([name("<sdf/>"), name("<x:y>")], [Some("sdf"), Some("x:y")]);
        assert_eq!(["", "robot", "<", "<>", "<a", "<!DOCTYPE a>", "<!-- a"].map(root_name), [const { None }; 7]);
    }

    #[test]
    fn only_large_tags_are_found() {
        let attributes = |count: usize| (0..count).map(|i| format!(" a{i}='='")).collect::<String>();
        let before = "<?a ='?><!-- < -- ' --><b c='>'/><![CDATA[<']]>";
        assert_eq!(too_large(&format!("{before}<d{}/>", attributes(256))), None);
        let found = too_large(&format!("{before}<d{}/>", attributes(257))).map(|(at, _)| at);
        assert_eq!(found, Some(before.len()));
        assert!(too_large(&"<a xmlns:b='c'/>".repeat(501)).is_some_and(|(_, text)| text.contains("namespaces")));
        assert_eq!(["", "<", "<!--", "<a b='", "<a ="].map(too_large), [None, None, None, None, None]);
    }
}
