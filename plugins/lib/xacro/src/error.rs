//! Errors, first as faults with offsets in files, then as text with line and column.

use std::fmt;

/// Maximum number of calls and includes that an error lists.
const MAX_TRACE: usize = 8;

/// A place in a source file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Name of the file, as the reader of files knows it.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Why a file could not be expanded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct XacroError {
    /// What is wrong, what was expected, and what to do.
    pub message: String,
    /// Where; `None` if the error has no place, such as in the arguments.
    pub place: Option<Place>,
    /// What led there, from the inside out: calls of macros, includes and properties, each with its place.
    pub trace: Vec<(String, Place)>,
}

impl fmt::Display for XacroError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        f.write_str(&self.message)?;
        for (what, place) in &self.trace {
            write!(f, "\n  {place}: {what}")?;
        }
        Ok(())
    }
}

impl std::error::Error for XacroError {}

/// A place as the index of a file and an offset in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Origin {
    pub file: u32,
    pub offset: u32,
}

/// An error whose place is not yet text.
#[derive(Debug)]
pub(crate) struct Fault {
    pub message: String,
    pub origin: Option<Origin>,
    pub trace: Vec<(String, Origin)>,
    /// Whether a file could not be read, which an optional include ignores.
    pub is_missing_file: bool,
}

pub(crate) type Result<T> = std::result::Result<T, Box<Fault>>;

impl Fault {
    pub fn new(message: impl Into<String>) -> Box<Self> {
        Box::new(Fault { message: message.into(), origin: None, trace: Vec::new(), is_missing_file: false })
    }

    /// Sets the place, unless an inner one is known.
    pub fn at(mut self: Box<Self>, origin: Origin) -> Box<Self> {
        self.origin.get_or_insert(origin);
        self
    }

    /// Adds what led to the place.
    pub fn within(mut self: Box<Self>, what: impl FnOnce() -> String, origin: Origin) -> Box<Self> {
        if self.trace.len() < MAX_TRACE {
            self.trace.push((what(), origin));
        }
        self
    }
}

/// Returns an error with a formatted message.
macro_rules! fail {
    ($($format:tt)*) => {
        return Err($crate::error::Fault::new(format!($($format)*)))
    };
}
pub(crate) use fail;

/// Shortens a text for a message.
pub(crate) fn excerpt(text: &str) -> String {
    const MAX_CHARS: usize = 60;
    match text.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
