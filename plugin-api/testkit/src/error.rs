//! What can go wrong in a test, in words.

use std::fmt;

use tatu_plugin_api::safe::Fail;

/// The result of everything that can fail; it makes a test fail that returns it.
pub type Result<T = (), E = Error> = std::result::Result<T, E>;

/// What went wrong, where, and what was expected.
#[derive(Clone, PartialEq)]
pub struct Error(String);

impl Error {
    /// An error with this text.
    pub fn new(text: impl Into<String>) -> Self {
        Error(text.into())
    }
    /// The text.
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

// `cargo test` prints what a test returns in this form.
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
