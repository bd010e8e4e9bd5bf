//! Errors of documents and plugins before a run, and faults during one.
//!
//! - [`Error`]: the reason why an operation on a scene, plugin, snapshot or world failed, with its [`SourceLocation`]
//!   in a file;
//! - [`Fault`]: an error during a run;
//! - [`Refusal`]: the reason why a property could not be read or set.

use std::{fmt, ops::Range, path::PathBuf};

use serde::{Deserialize, Serialize};

/// A position in a text file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SourceLocation {
    /// Path of the file.
    pub file: PathBuf,
    /// Line number, counted from 1; 0 stands for the whole file.
    pub line: usize,
    /// Column, counted from 1.
    pub column: usize,
    /// Byte range in the file that the error refers to.
    pub span: Range<usize>,
}

impl SourceLocation {
    /// Returns the position of line `line` of `file`, counted from 1; 0 stands for the whole file. `bytes` are the
    /// contents of the file; if they do not include that line, the span is empty.
    pub fn of_line(file: PathBuf, bytes: &[u8], line: usize) -> Self {
        SourceLocation { file, line, column: 1, span: line_span(bytes, line) }
    }
}

/// Returns the byte range of a line without surrounding white space. Lines are counted from 1; the range is empty if
/// there is no such line.
fn line_span(bytes: &[u8], line: usize) -> Range<usize> {
    let mut start = 0;
    for (n, text) in bytes.split_inclusive(|b| *b == b'\n').enumerate() {
        if n + 1 == line {
            let lead = text.iter().take_while(|b| b.is_ascii_whitespace()).count();
            return start + lead..start + text.trim_ascii_end().len().max(lead);
        }
        start += text.len();
    }
    0..0
}

/// The reason why an operation outside a run failed, such as loading a scene: what went wrong, where, what was
/// expected, and a hint.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Error {
    /// Stable code, such as "E103"; documented in `docs/reference/errors.md`.
    pub code: &'static str,
    /// What went wrong.
    pub text: String,
    /// Where it went wrong, if known.
    pub place: Option<Box<SourceLocation>>,
    /// What was expected, if stated.
    pub expected: Option<String>,
    /// A hint on how to correct it, if there is one.
    pub help: Option<String>,
}

/// The result of operations that may fail with an [`Error`].
pub type Result<T = (), E = Error> = std::result::Result<T, E>;

impl Error {
    /// Creates an error from its code and message.
    pub fn new(code: &'static str, text: impl Into<String>) -> Self {
        Error { code, text: truncate_long_text(text.into()), ..Default::default() }
    }
    /// Sets the position if the error does not have one yet; `None` leaves it unset.
    pub fn at(mut self, place: Option<SourceLocation>) -> Self {
        if self.place.is_none() {
            self.place = place.map(Box::new);
        }
        self
    }
    /// Sets the description of what was expected.
    pub fn expected(mut self, text: impl Into<String>) -> Self {
        self.expected = Some(truncate_long_text(text.into()));
        self
    }
    /// Sets the hint.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(truncate_long_text(text.into()));
        self
    }
    /// Sets the hint "did you mean ...?" if one of the names in `known` is similar to `name`.
    pub fn nearest<'a>(self, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        match nearest(name, known) {
            Some(near) => self.help(format!("did you mean `{near}`?")),
            None => self,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}] {}", self.code, self.text)?;
        if let Some(place) = &self.place {
            write!(f, "\n  --> {}", place.file.display())?;
            if place.line > 0 {
                write!(f, ":{}:{}", place.line, place.column)?;
            }
        }
        if let Some(expected) = &self.expected {
            write!(f, "\n  expected: {expected}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// Maximum length of a part of an error, bytes; it may contain a name from a file of any size.
const MAX_ERROR_TEXT_BYTES: usize = 16 << 10;

fn truncate_long_text(mut text: String) -> String {
    let length = text.len();
    if length > MAX_ERROR_TEXT_BYTES {
        text.truncate((0..=MAX_ERROR_TEXT_BYTES).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0));
        text += &format!("... ({length} bytes)");
    }
    text
}

/// Maximum length of names that are compared, bytes. The comparison takes time and memory in proportion to the product
/// of the lengths, and nobody misspells a longer name by few letters.
pub const MAX_COMPARED_NAME_BYTES: usize = 200;

/// Returns the name in `known` that is most similar to the misspelt `name`, ignoring case, or `None` if no name is
/// similar enough.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_COMPARED_NAME_BYTES {
        return None;
    }
    let lower = name.to_lowercase();
    known
        .into_iter()
        .filter(|k| k.len() <= MAX_COMPARED_NAME_BYTES)
        .map(|k| (strsim::damerau_levenshtein(&lower, &k.to_lowercase()), k))
        .filter(|(d, k)| *d <= 1 + k.len().max(name.len()) / 4)
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Puts the indefinite article before the name of a kind: "a sensor", "an actuator".
pub fn with_article(name: &str) -> String {
    let article = if name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {name}")
}

#[cfg(test)]
mod bounds {
    use super::*;

    #[test]
    fn long_names_are_neither_compared_nor_repeated() {
        let long = "k".repeat(10_000_000);
        let known = ["keys", "k"];
        assert_eq!(nearest(&long, known), None);
        assert_eq!(nearest("key", [long.as_str(), "keys"]), Some("keys"));
        let error = Error::new("E101", format!("unknown key `{long}`")).nearest(&long, known).help(long.clone());
        assert!(error.text.len() < 20_000 && error.text.ends_with("(10000014 bytes)"), "{}", error.text.len());
        assert!(error.help.is_some_and(|h| h.len() < 20_000));
        // A character is not divided.
        let text = Error::new("E101", "\u{e4}".repeat(20_000)).text;
        assert!(text.starts_with('\u{e4}') && text.len() < 20_000);
    }
}

/// The kind of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// An unknown command was called.
    UnknownFunction,
    /// The command or setting is recognized, but is not supported or cannot be used here.
    Unsupported,
    /// An argument is invalid.
    BadArgument,
    /// An object does not exist.
    MissingObject,
    /// A script raised an error.
    Runtime,
    /// A script has exhausted its budget of instructions or memory.
    Budget,
    /// A plugin failed or panicked.
    Plugin,
    /// The motion of a body became infinite, and the body was frozen.
    Physics,
    /// A plugin call did not return.
    Stuck,
    /// The program crashed, in a plugin or elsewhere.
    Crash,
    /// A plugin exited the process.
    Exit,
}

impl FaultKind {
    /// Returns the kind that corresponds to a status of the ABI.
    pub fn of(status: i32) -> Self {
        use tatu_plugin_api::abi::*;
        match status {
            TATU_ERR_UNKNOWN => FaultKind::UnknownFunction,
            TATU_ERR_UNSUPPORTED | TATU_ERR_BUSY => FaultKind::Unsupported,
            TATU_ERR_ARGUMENT | TATU_ERR_SPACE => FaultKind::BadArgument,
            TATU_ERR_MISSING | TATU_ERR_GONE => FaultKind::MissingObject,
            TATU_ERR_BUDGET | TATU_ERR_MEMORY => FaultKind::Budget,
            TATU_ERR_PANIC => FaultKind::Plugin,
            TATU_ERR_PHYSICS => FaultKind::Physics,
            _ => FaultKind::Runtime,
        }
    }
    /// Returns the status of the ABI by which a failure of this kind is reported.
    pub fn status(self) -> i32 {
        use tatu_plugin_api::abi::*;
        match self {
            FaultKind::UnknownFunction => TATU_ERR_UNKNOWN,
            FaultKind::BadArgument => TATU_ERR_ARGUMENT,
            FaultKind::MissingObject => TATU_ERR_MISSING,
            FaultKind::Unsupported => TATU_ERR_UNSUPPORTED,
            FaultKind::Plugin => TATU_ERR_PANIC,
            _ => TATU_ERR,
        }
    }
    /// Returns the stable code of faults of this kind.
    pub fn code(self) -> &'static str {
        match self {
            FaultKind::UnknownFunction => "F201",
            FaultKind::Unsupported => "F202",
            FaultKind::BadArgument => "F203",
            FaultKind::MissingObject => "F204",
            FaultKind::Runtime => "F205",
            FaultKind::Budget => "F206",
            FaultKind::Plugin => "F207",
            FaultKind::Physics => "F208",
            FaultKind::Stuck => "F210",
            FaultKind::Crash => "F211",
            FaultKind::Exit => "F212",
        }
    }
}

/// An error during a run. Repeated occurrences are counted instead of being stored separately.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fault {
    /// Stable code, such as "F203".
    pub code: &'static str,
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Id of the plugin in which the fault occurred, if it occurred in one.
    pub plugin: Option<String>,
    /// Name of the script that raised the fault, if one did.
    pub script: Option<String>,
    /// Path of the affected object, if any.
    pub object: Option<String>,
    /// File of the script, if it has one.
    pub file: Option<String>,
    /// Line in `file`, from 1.
    pub line: Option<u64>,
    /// What went wrong.
    pub message: String,
    /// A hint on how to correct it, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
    /// Traceback of the script, innermost call first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traceback: Option<String>,
    /// Number of times that the fault has occurred.
    pub count: u64,
}

impl Fault {
    /// Creates a fault that has occurred once, without a plugin, script, object or position.
    pub fn new(kind: FaultKind, message: impl Into<String>) -> Self {
        Fault {
            code: kind.code(),
            kind,
            plugin: None,
            script: None,
            object: None,
            file: None,
            line: None,
            message: message.into(),
            help: None,
            traceback: None,
            count: 1,
        }
    }
    /// Returns whether two faults have the same kind, message, plugin, object, file and line, and are therefore counted
    /// as one.
    pub fn same_as(&self, other: &Fault) -> bool {
        self.kind == other.kind
            && self.message == other.message
            && self.plugin == other.plugin
            && self.object == other.object
            && (&self.file, self.line) == (&other.file, other.line)
    }
}

/// The reason why a property could not be read or set: a status of the ABI and a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal(pub tatu_plugin_api::abi::tatu_status, pub String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_get_their_article() {
        assert_eq!(["sensor", "actuator", "octree"].map(with_article), ["a sensor", "an actuator", "an octree"]);
    }

    #[test]
    fn line_span_is_found_by_line_number() {
        let text = b"one\n  two \r\n\nfour";
        for (line, wanted) in [(1, "one"), (2, "two"), (3, ""), (4, "four"), (5, ""), (0, "")] {
            assert_eq!(&text[line_span(text, line)], wanted.as_bytes(), "{line}");
        }
    }
}
