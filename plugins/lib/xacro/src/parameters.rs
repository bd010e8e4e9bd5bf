//! The parameters of macros: `a b:=5 c:='x y' d:=^ e:=^|7 *block **content`.

use crate::error::{Result, excerpt, fail};

/// A parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Parameter {
    /// The name; that of a block begins with `*` or `**`.
    pub name: String,
    /// Whether the value of the caller's property of this name is taken (`^`).
    pub is_forwarded: bool,
    pub default: Option<String>,
}

impl Parameter {
    pub fn is_block(&self) -> bool {
        self.name.starts_with('*')
    }
}

/// Parses the attribute `params`.
pub(crate) fn parse(text: &str) -> Result<Vec<Parameter>> {
    let mut out = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let name_end = rest.find(|c: char| c.is_whitespace() || c == ':' || c == '=').unwrap_or(rest.len());
        let after_name = rest[name_end..].trim_start();
        let assigned = after_name.strip_prefix(":=").or_else(|| after_name.strip_prefix('='));
        match assigned {
            Some(value) if name_end > 0 => {
                let value = value.trim_start();
                let (is_forwarded, value) = match value.strip_prefix('^') {
                    Some(value) => (true, value.strip_prefix('|').unwrap_or(value)),
                    None => (false, value),
                };
                let len = default_len(value)?;
                out.push(Parameter {
                    name: rest[..name_end].to_owned(),
                    is_forwarded,
                    default: (len > 0).then(|| value[..len].to_owned()),
                });
                rest = value[len..].trim_start();
            }
            _ => {
                let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
                out.push(Parameter { name: rest[..end].to_owned(), is_forwarded: false, default: None });
                rest = rest[end..].trim_start();
            }
        }
    }
    Ok(out)
}

/// Length of the default value at the start of a text: `${...}` and `$(...)` may contain blanks, and so may quotes.
fn default_len(text: &str) -> Result<usize> {
    let ends_at = |at: usize| text[at..].chars().next().is_none_or(char::is_whitespace);
    for (open, close) in [("${", '}'), ("$(", ')')] {
        if text.starts_with(open) {
            let end = text.match_indices(close).map(|(at, _)| at + 1).find(|at| ends_at(*at));
            if let Some(end) = end {
                return Ok(end);
            }
        }
    }
    let mut at = 0;
    while let Some(c) = text[at..].chars().next().filter(|c| !c.is_whitespace()) {
        at += c.len_utf8();
        if c == '\'' || c == '"' {
            match text[at..].find(c) {
                Some(len) => at += len + 1,
                None => fail!("the parameter's default value {} has no closing {c}", excerpt(text)),
            }
        }
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_forms_of_parameters_are_read() {
        let parameters =
            parse(" a  b:=5 c = 'x y' d:=^ e:=^|7 f:=${1 + g} *h **i j:=a'b c'd k:=$(arg x) l:=\"\" m:= n").unwrap();
        let found: Vec<(&str, bool, Option<&str>)> =
            parameters.iter().map(|p| (p.name.as_str(), p.is_forwarded, p.default.as_deref())).collect();
        let expected = [
            ("a", false, None),
            ("b", false, Some("5")),
            ("c", false, Some("'x y'")),
            ("d", true, None),
            ("e", true, Some("7")),
            ("f", false, Some("${1 + g}")),
            ("*h", false, None),
            ("**i", false, None),
            ("j", false, Some("a'b c'd")),
            ("k", false, Some("$(arg x)")),
            ("l", false, Some("\"\"")),
            ("m", false, Some("n")),
        ];
        assert_eq!(found, expected);
        assert!(parse("a:='x").is_err());
        assert_eq!(parse("").unwrap(), []);
    }
}
