//! Preparation of plugins' texts for display: control characters are escaped, and long texts are truncated.

use std::{borrow::Cow, fmt::Write};

/// Maximum size of one part of an error text, bytes.
pub const MAX_ERROR_BYTES: usize = 16 << 10;

/// Number of bytes that the host can add to a truncated text without causing it to be truncated again.
const TRUNCATION_SLACK: usize = 1 << 10;

/// Returns whether a character controls a terminal, or reorders the text after it.
fn is_terminal_control(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Returns a text in which control characters other than tab and newline, and those that reorder text, are escaped as
/// in `\u{1b}`. A carriage return before a newline is removed.
pub fn clean(text: &str) -> Cow<'_, str> {
    let wrong = |c: char| is_terminal_control(c) && c != '\n' && c != '\t';
    if !text.contains(wrong) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    let mut all = text.chars().peekable();
    while let Some(c) = all.next() {
        match wrong(c) {
            // A CR LF line end becomes LF.
            true if c == '\r' && all.peek() == Some(&'\n') => {}
            true => out.extend(c.escape_default()),
            false => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// Like `clean`, for bytes; invalid UTF-8 is left unchanged.
fn clean_bytes(bytes: &[u8]) -> Cow<'_, [u8]> {
    // Fast path: nearly every text is ASCII without control characters.
    if bytes.iter().all(|b| matches!(b, b' '..=b'~' | b'\n' | b'\t')) {
        return Cow::Borrowed(bytes);
    }
    let mut out = Vec::with_capacity(bytes.len() + 16);
    for chunk in bytes.utf8_chunks() {
        out.extend_from_slice(clean(chunk.valid()).as_bytes());
        out.extend_from_slice(chunk.invalid());
    }
    Cow::Owned(out)
}

/// Returns an error text, cleaned and truncated to a readable length; the number of omitted bytes is appended.
pub(crate) fn clean_error(bytes: &[u8]) -> Vec<u8> {
    if bytes.len() <= MAX_ERROR_BYTES + TRUNCATION_SLACK {
        return clean_bytes(bytes).into_owned();
    }
    // Go back to the start of a character, which has at most four bytes.
    let begins = |at: &usize| bytes[*at] & 0xC0 != 0x80;
    let at = (MAX_ERROR_BYTES - 3..=MAX_ERROR_BYTES).rev().find(begins).unwrap_or(MAX_ERROR_BYTES);
    let mut out = clean_bytes(&bytes[..at]).into_owned();
    out.extend_from_slice(format!("... ({} more bytes are left out)", bytes.len() - at).as_bytes());
    out
}

/// Returns a name for display, with control characters and invalid UTF-8 escaped.
pub fn label(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            match is_terminal_control(c) {
                true => out.extend(c.escape_default()),
                false => out.push(c),
            }
        }
        for b in chunk.invalid() {
            // Writing to a `String` cannot fail.
            let _ = write!(out, "\\x{b:02x}");
        }
    }
    out
}

/// The hint for an invalid name.
pub(super) const HELP: &str = "use letters, digits, `_` and dots: `mine.name`";

/// Returns why a name is invalid, or `None` if it is valid. The name must be a result of [`label`], in which a
/// backslash marks characters that cannot be displayed.
pub(super) fn flaw(name: &str) -> Option<&'static str> {
    match name {
        "" => Some("is empty"),
        _ if name.contains('\\') => Some("contains control characters, backslashes or bytes that are not UTF-8"),
        _ if name.contains(char::is_whitespace) => Some("contains a space"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_control_characters_are_escaped() {
        for (text, shown) in [
            ("plain\ttext\n", "plain\ttext\n"),
            ("größe", "größe"),
            ("\u{1b}[31mred\u{7}", "\\u{1b}[31mred\\u{7}"),
            ("a\r\nb\rc", "a\nb\\rc"),
            ("\u{9b}2J \u{202e}", "\\u{9b}2J \\u{202e}"),
            ("\0", "\\u{0}"),
        ] {
            assert_eq!(clean(text), shown);
            assert_eq!(*clean_bytes(text.as_bytes()), *shown.as_bytes());
        }
        assert_eq!(*clean_bytes(b"\xff\x1b"), *b"\xff\\u{1b}", "texts of scripts need not be UTF-8");
        assert_eq!(label(b"a\n\xffb c"), "a\\n\\xffb c");
    }

    #[test]
    fn long_texts_are_truncated_at_character_boundaries() {
        let text = format!("{}{}", "x".repeat(MAX_ERROR_BYTES - 1), "ö".repeat(2000));
        let cut = String::from_utf8(clean_error(text.as_bytes())).unwrap();
        assert_eq!(cut, format!("{}... (4000 more bytes are left out)", "x".repeat(MAX_ERROR_BYTES - 1)));
        // A truncated text is not truncated again when the host adds a prefix.
        let longer = format!("plugin `x` failed: {cut}");
        assert_eq!(clean_error(longer.as_bytes()), longer.as_bytes());
        assert!(clean_error(&[0x80; 40000]).len() < MAX_ERROR_BYTES + 100);
    }
}
