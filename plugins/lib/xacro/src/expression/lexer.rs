//! The tokens of an expression.

use std::rc::Rc;

use crate::error::{Result, excerpt, fail};

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token {
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    Name(Rc<str>),
    Symbol(&'static str),
    End,
}

/// Longer symbols first.
const SYMBOLS: [&str; 35] = [
    "**", "//", "<<", ">>", "<=", ">=", "==", "!=", ":=", "->", "+", "-", "*", "/", "%", "(", ")", "[", "]", "{", "}",
    ",", ":", ".", "<", ">", "=", "|", "^", "&", "~", "@", ";", "!", "?",
];

/// Python's keywords, which are no names.
const KEYWORDS: [&str; 35] = [
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue", "def", "del",
    "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "nonlocal",
    "not", "or", "pass", "raise", "return", "try", "while", "with", "yield",
];

/// Whether a text can be the name of a property.
pub(crate) fn is_identifier(text: &str) -> bool {
    let mut chars = text.chars();
    chars.next().is_some_and(starts_name) && chars.all(continues_name) && !KEYWORDS.contains(&text)
}

fn starts_name(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

fn continues_name(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}

/// Returns the tokens of a text, each with its offset; the last one is `End`.
pub(crate) fn tokens(text: &str) -> Result<Vec<(Token, usize)>> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        if c.is_whitespace() {
            at += c.len_utf8();
        } else if c == '#' {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if c.is_ascii_digit() || (c == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit())) {
            let (token, len) = number(rest)?;
            out.push((token, at));
            at += len;
        } else if c == '\'' || c == '"' {
            let (text, len) = quoted(rest, false)?;
            out.push((Token::Text(text.into()), at));
            at += len;
        } else if starts_name(c) {
            let len = rest.find(|c| !continues_name(c)).unwrap_or(rest.len());
            let word = &rest[..len];
            if rest[len..].starts_with(['\'', '"']) {
                match word {
                    "r" | "R" | "u" | "U" => {
                        let (text, quoted_len) = quoted(&rest[len..], word.eq_ignore_ascii_case("r"))?;
                        out.push((Token::Text(text.into()), at));
                        at += len + quoted_len;
                        continue;
                    }
                    _ => fail!("texts that begin with {word}' are not supported; for f'...', use '{{}}'.format(...)"),
                }
            }
            out.push((Token::Name(word.into()), at));
            at += len;
        } else if let Some(symbol) = SYMBOLS.iter().find(|s| rest.starts_with(**s)) {
            out.push((Token::Symbol(symbol), at));
            at += symbol.len();
        } else {
            fail!("`{c}` is no part of an expression");
        }
    }
    out.push((Token::End, at));
    Ok(out)
}

/// Reads a number; returns its length, too.
fn number(text: &str) -> Result<(Token, usize)> {
    let wrong = |len: usize| fail!("`{}` is no number", excerpt(&text[..len]));
    let radix = match text.as_bytes() {
        [b'0', b'x' | b'X', ..] => 16,
        [b'0', b'o' | b'O', ..] => 8,
        [b'0', b'b' | b'B', ..] => 2,
        _ => 10,
    };
    if radix != 10 {
        let len = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(text.len());
        let digits = text[2..len].replace('_', "");
        return match i64::from_str_radix(&digits, radix) {
            Ok(value) => Ok((Token::Int(value), len)),
            Err(_) => wrong(len),
        };
    }
    let digits =
        |from: usize| from + text[from..].find(|c: char| !c.is_ascii_digit() && c != '_').unwrap_or(text.len() - from);
    let mut len = digits(0);
    let mut is_float = false;
    if text[len..].starts_with('.') {
        is_float = true;
        len = digits(len + 1);
    }
    if text[len..].starts_with(['e', 'E']) {
        let sign = usize::from(text[len + 1..].starts_with(['+', '-']));
        if text[len + 1 + sign..].starts_with(|c: char| c.is_ascii_digit()) {
            is_float = true;
            len = digits(len + 1 + sign);
        }
    }
    if text[len..].starts_with(starts_name) {
        return wrong(len + text[len..].find(|c| !continues_name(c)).unwrap_or(text.len() - len));
    }
    let word = &text[..len];
    if word.contains("__") || word.ends_with('_') || word.contains("_.") || word.contains("._") {
        return wrong(len);
    }
    let plain = word.replace('_', "");
    if is_float {
        return plain.parse().map_or_else(|_| wrong(len), |value| Ok((Token::Float(value), len)));
    }
    if plain.starts_with('0') && plain.bytes().any(|b| b != b'0') {
        fail!("`{word}` begins with 0: write {}", plain.trim_start_matches('0'));
    }
    match plain.parse() {
        Ok(value) => Ok((Token::Int(value), len)),
        Err(_) => fail!("the integer {} has more than 64 bits: write it with a decimal point", excerpt(word)),
    }
}

/// Reads a text in quotes; returns its length with them, too.
fn quoted(text: &str, is_raw: bool) -> Result<(String, usize)> {
    let mark = &text[..1];
    let triple = mark.repeat(3);
    let quote = if text.starts_with(&triple) { triple.as_str() } else { mark };
    let mut out = String::new();
    let mut at = quote.len();
    loop {
        let rest = &text[at..];
        if rest.starts_with(quote) {
            return Ok((out, at + quote.len()));
        }
        let mut chars = rest.chars();
        match chars.next() {
            None => fail!("the text {} has no end: {quote} is missing", excerpt(text)),
            Some('\\') => {
                let (replaced, len) = escape(&rest[1..])?;
                if is_raw || replaced.is_none() {
                    // As it is; in a raw text, a quote after it does not end the text either.
                    let next = chars.next().map_or(0, char::len_utf8);
                    out.push_str(&rest[..1 + next]);
                    at += 1 + next;
                } else {
                    out.extend(replaced.flatten());
                    at += 1 + len;
                }
            }
            Some(c) => {
                out.push(c);
                at += c.len_utf8();
            }
        }
    }
}

/// Reads what follows a backslash: the character that it stands for (`Some(None)`: nothing), and its length. `None`: the
/// backslash has no special meaning there.
fn escape(rest: &str) -> Result<(Option<Option<char>>, usize)> {
    let hex = |digits: usize| {
        let code = rest.get(1..1 + digits).and_then(|d| u32::from_str_radix(d, 16).ok()).and_then(char::from_u32);
        match code {
            Some(c) => Ok((Some(Some(c)), 1 + digits)),
            None => fail!("`\\{}` is no character: expected {digits} hexadecimal digits", excerpt(rest)),
        }
    };
    let simple = |c| Ok((Some(Some(c)), 1));
    match rest.chars().next() {
        Some('n') => simple('\n'),
        Some('t') => simple('\t'),
        Some('r') => simple('\r'),
        Some('a') => simple('\u{7}'),
        Some('b') => simple('\u{8}'),
        Some('f') => simple('\u{c}'),
        Some('v') => simple('\u{b}'),
        Some(c @ ('\\' | '\'' | '"')) => simple(c),
        Some('\n') => Ok((Some(None), 1)),
        Some('x') => hex(2),
        Some('u') => hex(4),
        Some('U') => hex(8),
        Some('0'..='7') => {
            let len = rest.bytes().take(3).take_while(|b| (b'0'..=b'7').contains(b)).count();
            let code = u32::from_str_radix(&rest[..len], 8).ok().and_then(char::from_u32);
            Ok((Some(code), len))
        }
        Some('N') => fail!("characters by name (\\N) are not supported"),
        _ => Ok((None, 0)),
    }
}
