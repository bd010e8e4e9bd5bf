//! Key presses from a file with lines `TIME KEY`.

use std::{
    fs::File,
    io::{Error as IoError, ErrorKind, Read, Result as IoResult},
    path::Path,
};

use tatu_core::errors::{Error, SourceLocation};
use tatu_plugin_api::safe::MAX_FILE_BYTES;

/// Reads a file as text; a pipe is read until it is closed.
fn read_text(path: &Path) -> IoResult<String> {
    let mut text = String::new();
    File::open(path)?.take(MAX_FILE_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(IoError::new(ErrorKind::FileTooLarge, format!("it is larger than {} MB", MAX_FILE_BYTES >> 20)));
    }
    Ok(text)
}

/// The remaining key presses, each with its simulation time in s, in reverse order: the next key press is the last
/// element.
#[derive(Debug, Default, PartialEq)]
pub struct KeyPresses(Vec<(f64, String)>);

impl KeyPresses {
    /// Reads a file. Empty lines and lines beginning with `#` are skipped. Fails with E105 if the file cannot be read,
    /// and with E102 if a line is not a time and a key.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = read_text(path)
            .map_err(|e| Error::new("E105", format!("cannot read the key presses {}: {e}", path.display())))?;
        Self::parse(&text).map_err(|(line, wrong)| {
            let start = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
            let place = SourceLocation { file: path.to_owned(), line, column: 1, span: start..start + wrong.len() };
            Error::new("E102", format!("the line `{wrong}` is not of the form `TIME KEY`"))
                .expected("a time in seconds and a key: a character, a name such as `up`, or a code")
                .at(Some(place))
        })
    }

    fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut all = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let wrong = || (i + 1, line.to_owned());
            let (time, key) = line.split_once(char::is_whitespace).ok_or_else(wrong)?;
            let time: f64 = time.parse().ok().filter(|t: &f64| t.is_finite()).ok_or_else(wrong)?;
            all.push((time, key.trim().to_owned()));
        }
        // The sort is stable: keys with equal times remain in the order of the file.
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.reverse();
        Ok(KeyPresses(all))
    }

    /// Removes and returns the next key that is due at `time` or earlier, if any.
    pub fn due(&mut self, time: f64) -> Option<String> {
        // Step times are products and carry rounding errors: 0.15 may be computed as 0.15000000000000002.
        self.0.pop_if(|(at, _)| *at <= time + 1e-9).map(|(_, key)| key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn key_presses_are_due_at_their_times_in_order() {
        let mut keys = KeyPresses::parse("# keys\n0.5 up\n0.15 s\n\n0.15 #\n").unwrap();
        assert_eq!(keys.due(0.1), None);
        assert_eq!(keys.due(0.05 * 3.0).as_deref(), Some("s"));
        assert_eq!(keys.due(0.15).as_deref(), Some("#"));
        assert_eq!(keys.due(0.15), None);
        assert_eq!(keys.due(7.0).as_deref(), Some("up"));
        assert_eq!(keys.due(7.0), None);
    }

    #[test]
    fn invalid_line_of_key_file_is_reported_with_its_number() {
        assert_eq!(KeyPresses::parse("1 a\n\nb 2"), Err((3, "b 2".into())));
        assert_eq!(KeyPresses::parse("1"), Err((1, "1".into())));
        assert_eq!(KeyPresses::parse("nan a"), Err((1, "nan a".into())));
    }
}
