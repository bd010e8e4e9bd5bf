//! Parses `--addon NAME:KEY=VALUE,KEY=VALUE`.

use tatu_core::errors::{Error, Result};

/// An add-on named on the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AddonRequest {
    /// The add-on's name or file.
    pub name: String,
    /// The add-on's options, in order. If a key occurs several times, its last value is used.
    pub options: Vec<(String, String)>,
}

impl AddonRequest {
    /// Parses an argument. A part without `=` continues the preceding value, so values can contain commas.
    pub fn parse(text: &str) -> Result<Self> {
        let at = text.match_indices(':').map(|(i, _)| i).find(|i| begins_options(&text[i + 1..]));
        let (name, rest) = at.map_or((text, ""), |i| (&text[..i], &text[i + 1..]));
        let mut options: Vec<(String, String)> = Vec::new();
        for piece in rest.split(',') {
            match (key_of(piece), options.last_mut()) {
                (Some((key, value)), _) => options.push((key.to_owned(), value.to_owned())),
                (None, Some((_, value))) => {
                    value.push(',');
                    value.push_str(piece);
                }
                (None, None) if piece.is_empty() => {}
                (None, None) => {
                    return Err(Error::new(
                        "E102",
                        format!("--addon `{text}`: `{piece}` is not of the form KEY=VALUE"),
                    )
                    .expected("NAME:KEY=VALUE,KEY=VALUE")
                    .help("an example is `pose_logger:file=poses.csv,period=0.1`"));
                }
            }
        }
        if name.trim().is_empty() {
            return Err(
                Error::new("E102", format!("--addon: `{text}` does not name an add-on")).expected("a name, or a file")
            );
        }
        Ok(AddonRequest { name: name.trim().to_owned(), options })
    }
}

/// Splits `KEY=VALUE`; returns `None` if there is no `=`, or if the key is not a valid name.
fn key_of(piece: &str) -> Option<(&str, &str)> {
    let (key, value) = piece.split_once('=')?;
    let key = key.trim();
    let good = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    good.then_some((key, value))
}

/// Returns whether `rest`, the text after a colon, starts with an option. The colon can also be part of a path.
fn begins_options(rest: &str) -> bool {
    key_of(rest).is_some() || rest.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (String, Vec<(String, String)>) {
        let w = AddonRequest::parse(text).unwrap();
        (w.name, w.options)
    }
    fn pairs(all: &[(&str, &str)]) -> Vec<(String, String)> {
        all.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
    }

    #[test]
    fn names_files_and_options_are_parsed() {
        assert_eq!(parsed("pose_logger"), ("pose_logger".into(), vec![]));
        assert_eq!(parsed("a b:file=x.csv,period=0.1"), ("a b".into(), pairs(&[("file", "x.csv"), ("period", "0.1")])));
        assert_eq!(parsed("d:odd/a.lua:n=1"), ("d:odd/a.lua".into(), pairs(&[("n", "1")])));
        assert_eq!(
            parsed("log:objects=/A/b,/C,period=1"),
            ("log".into(), pairs(&[("objects", "/A/b,/C"), ("period", "1")]))
        );
        assert_eq!(parsed("log:"), ("log".into(), vec![]));
        assert!(AddonRequest::parse(":a=1").is_err());
        assert!(AddonRequest::parse("").is_err());
    }
}
