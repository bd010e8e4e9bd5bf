//! What is wrong in a table of noise.

use std::ops::Range;

use tatu_errors::Error;

/// What is wrong in a table, and where in its text.
#[derive(Debug)]
pub struct Wrong {
    /// What.
    pub error: Error,
    /// Where.
    pub span: Option<Range<usize>>,
}

impl Wrong {
    /// The error with the line, for a text that is no file.
    pub fn in_text(self, text: &str) -> Error {
        let Some(span) = self.span else { return self.error };
        let line = text.as_bytes()[..span.start.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1;
        Error { text: format!("line {line} of the noise: {}", self.error.text), ..self.error }
    }
}

pub fn wrong(text: impl Into<String>) -> Wrong {
    Wrong { error: Error::new("E102", text), span: None }
}

impl Wrong {
    /// With a place, if it has none.
    pub fn or(self, span: &Option<Range<usize>>) -> Self {
        Wrong { span: self.span.or_else(|| span.clone()), ..self }
    }
}
