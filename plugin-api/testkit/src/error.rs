//! The error type of this crate.

use std::fmt;

use tatu_plugin_api::safe::Fail;

/// The result of functions that can fail. Tests can return it as well.
pub type Result<T = (), E = Error> = std::result::Result<T, E>;

/// An error: a message that states what is wrong, where, and what was expected.
#[derive(Clone, PartialEq)]
pub struct Error(String);

impl Error {
    /// Creates an error with a message.
    pub fn new(text: impl Into<String>) -> Self {
        Error(text.into())
    }
    /// Returns the message.
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

// `cargo test` prints the error that a test returns with `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

impl From<Fail> for Error {
    fn from(fail: Fail) -> Self {
        Error(fail.to_string())
    }
}
