//! Repairs what Gazebo's reader accepts, but a strict reader of XML does not: two hyphens in a comment, blanks before the
//! declaration, prefixes that are not declared, values without quotes, ampersands that are not escaped. A twentieth of
//! public files has such flaws. Lines stay the same.

/// Returns the text as strict XML, without its declaration and comments. Prefixes become parts of names: `a:b` is `a_b`.
pub fn repair(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 64);
    let mut rest = text.strip_prefix('\u{feff}').unwrap_or(text);
    while let Some(at) = rest.find(['<', '&']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        rest = match rest.as_bytes() {
            [b'&', ..] => ampersand(rest, &mut out),
            [b'<', b'!', b'-', b'-', ..] => blank(rest, "-->", &mut out),
            [b'<', b'?', ..] => blank(rest, "?>", &mut out),
            _ if rest.starts_with("<![CDATA[") => copy(rest, "]]>", &mut out),
            // The reader refuses document types.
            [b'<', b'!', ..] => copy(rest, ">", &mut out),
            _ => tag(rest, &mut out),
        };
    }
    out.push_str(rest);
    out
}

/// Replaces a text up to and including its end by blanks and line breaks. Returns what follows.
fn blank<'t>(text: &'t str, end: &str, out: &mut String) -> &'t str {
    // Without an end, the reader reports where the text begins.
    let Some(length) = text.find(end).map(|at| at + end.len()) else { return copy(text, end, out) };
    out.extend(text[..length].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
    &text[length..]
}

/// Copies a text up to and including its end. Returns what follows.
fn copy<'t>(text: &'t str, end: &str, out: &mut String) -> &'t str {
    let length = text.find(end).map_or(text.len(), |at| at + end.len());
    out.push_str(&text[..length]);
    &text[length..]
}

/// Largest number of bytes of a reference, such as `&#x10FFFF;`.
const MAX_REFERENCE: usize = 12;

/// Copies a reference, or escapes an ampersand that begins none.
fn ampersand<'t>(text: &'t str, out: &mut String) -> &'t str {
    // The longest references have nine characters, and a search to the end of the text would take a quadratic time.
    let end = text.bytes().take(MAX_REFERENCE).position(|c| c == b';');
    let name = end.and_then(|end| text.get(1..end)).unwrap_or_default();
    let is_reference = matches!(name, "lt" | "gt" | "amp" | "quot" | "apos")
        || name.strip_prefix('#').is_some_and(|n| {
            let is_digit = |c: char| c.is_ascii_hexdigit() || c == 'x';
            n.len() <= 8 && !n.is_empty() && n.chars().all(is_digit)
        });
    out.push_str(if is_reference { "&" } else { "&amp;" });
    &text[1..]
}

/// Copies a tag with repaired names and values.
fn tag<'t>(text: &'t str, out: &mut String) -> &'t str {
    let mut chars = text.char_indices().peekable();
    let mut is_value = false;
    while let Some((at, c)) = chars.next() {
        match c {
            '>' => {
                out.push('>');
                return &text[at + 1..];
            }
            '"' | '\'' => {
                out.push(c);
                let inside = &text[at + 1..];
                let Some(end) = inside.find(c) else {
                    out.push_str(inside);
                    return "";
                };
                let mut value = &inside[..end];
                while let Some(next) = value.find('&') {
                    out.push_str(&value[..next]);
                    value = ampersand(&value[next..], out);
                }
                out.push_str(&value.replace('<', "&lt;"));
                out.push(c);
                while chars.next_if(|(next, _)| *next <= at + 1 + end).is_some() {}
                is_value = false;
            }
            ':' => out.push('_'),
            '=' => {
                out.push('=');
                is_value = true;
            }
            c if is_value && !c.is_whitespace() => {
                // A value without quotes ends at a blank or at the end of the tag.
                let inside = &text[at..];
                let end = inside.find(|c: char| c.is_whitespace() || c == '>' || c == '"' || c == '<');
                let mut value = &inside[..end.unwrap_or(inside.len())];
                if inside[value.len()..].starts_with('>') {
                    value = value.strip_suffix('/').unwrap_or(value);
                }
                out.push('"');
                out.push_str(&value.replace('&', "&amp;"));
                out.push('"');
                while chars.next_if(|(next, _)| *next < at + value.len()).is_some() {}
                is_value = false;
            }
            c => out.push(c),
        }
    }
    ""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flaws_that_gazebo_accepts_are_repaired() {
        for (flawed, strict) in [
            ("\n<?xml version='1.0'?>\n<a/>", "\n                     \n<a/>"),
            ("<!-- a --levels\n b --><a/>", "               \n      <a/>"),
            ("<ignition:a gz:b='c:d'/>", "<ignition_a gz_b='c:d'/>"),
            ("<a b=1.5 c = x/>", "<a b=\"1.5\" c = \"x\"/>"),
            ("<a b=1>2</a>", "<a b=\"1\">2</a>"),
            ("<a b='x & y &amp; <z'>1 & 2 &lt; &#65;</a>", "<a b='x &amp; y &amp; &lt;z'>1 &amp; 2 &lt; &#65;</a>"),
            ("<a><![CDATA[<!-- & -->]]></a>", "<a><![CDATA[<!-- & -->]]></a>"),
            ("\u{feff}<a/>", "<a/>"),
        ] {
            assert_eq!(repair(flawed), strict);
        }
        for incomplete in ["<", "<!--", "<a b='", "<a b=", "<?", "&", "<![CDATA[", "<a b=ä"] {
            repair(incomplete);
        }
    }
}
