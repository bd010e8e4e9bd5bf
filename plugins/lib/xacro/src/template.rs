//! Texts with `${...}` and `$(...)` in them.

use crate::error::{Result, excerpt, fail};

/// A part of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece<'a> {
    /// Text as it is.
    Text(&'a str),
    /// What is between `${` and `}`.
    Expression(&'a str),
    /// What is between `$(` and `)`.
    Substitution(&'a str),
}

/// Divides a text. `$${` and `$$(` are texts with one `$` less; neither braces nor brackets nest, as in xacro.
pub(crate) fn pieces(text: &str) -> Result<Vec<Piece<'_>>> {
    let mut out = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let dollars = rest.len() - rest.trim_start_matches('$').len();
        let after = rest[dollars..].chars().next();
        let (piece, len) = match (dollars, after) {
            (0, _) => {
                let len = rest.find('$').unwrap_or(rest.len());
                (Piece::Text(&rest[..len]), len)
            }
            (2.., Some('{' | '(')) => (Piece::Text(&rest[1..=dollars]), dollars + 1),
            (1, Some('{')) => match rest.find('}') {
                Some(end) => (Piece::Expression(&rest[2..end]), end + 1),
                None => fail!("`{}`: the closing `}}` is missing", excerpt(rest)),
            },
            (1, Some('(')) => match rest.find(')') {
                Some(end) => (Piece::Substitution(&rest[2..end]), end + 1),
                None => fail!("`{}`: the closing `)` is missing", excerpt(rest)),
            },
            (1, _) => {
                let len = 1 + rest[1..].find(['{', '(', '$']).unwrap_or(rest.len() - 1);
                (Piece::Text(&rest[..len]), len)
            }
            _ => fail!("`{}`: expected `{{` or `(` after `$$`", excerpt(rest)),
        };
        out.push(piece);
        rest = &rest[len..];
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_divided_at_dollars() {
        assert_eq!(
            pieces("a${b}$(c d)e").ok(),
            Some(vec![Piece::Text("a"), Piece::Expression("b"), Piece::Substitution("c d"), Piece::Text("e")])
        );
        assert_eq!(pieces("$${x}").ok(), Some(vec![Piece::Text("${"), Piece::Text("x}")]));
        assert_eq!(pieces("5$ é$").ok(), Some(vec![Piece::Text("5"), Piece::Text("$ é"), Piece::Text("$")]));
        assert_eq!(pieces("").ok(), Some(vec![]));
        for wrong in ["${a", "$(a", "$$", "$$a"] {
            assert!(pieces(wrong).is_err(), "{wrong}");
        }
    }
}
