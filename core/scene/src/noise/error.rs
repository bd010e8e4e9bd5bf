//! Errors in noise tables.

use std::ops::Range;

use tatu_errors::Error;

/// An error in a noise table, and its position in the text.
#[derive(Debug)]
pub struct NoiseError {
    /// The error.
    pub error: Error,
    /// Byte range of the error in the text.
    pub span: Option<Range<usize>>,
}

impl NoiseError {
    /// Returns the error with its line number, for TOML that is not from a file.
    pub fn with_line(self, text: &str) -> Error {
        let Some(span) = self.span else { return self.error };
        let line = text.as_bytes()[..span.start.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1;
        Error { text: format!("line {line} of `noise`: {}", self.error.text), ..self.error }
    }
}

pub fn noise_error(text: impl Into<String>) -> NoiseError {
    NoiseError { error: Error::new("E102", text), span: None }
}

impl NoiseError {
    /// Sets the position of the error unless it already has one.
    pub fn at_span(self, span: &Option<Range<usize>>) -> Self {
        NoiseError { span: self.span.or_else(|| span.clone()), ..self }
    }
}
