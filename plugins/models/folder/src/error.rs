//! Errors in the text of a model.

use std::ops::Range;

use tatu_plugin_api::safe::Fail;

/// An error in the text of a model, and its range.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelError {
    /// The message, which states what is wrong and what was expected.
    pub text: String,
    /// A hint at how to fix the error.
    pub help: Option<String>,
    /// The byte range of the error; `None` for the whole text.
    pub span: Option<Range<usize>>,
}

/// The result of reading a text.
pub type Result<T = ()> = std::result::Result<T, ModelError>;

impl ModelError {
    /// Creates an error without a range.
    pub fn new(text: impl Into<String>) -> Self {
        ModelError { text: text.into(), help: None, span: None }
    }
    /// Adds a hint on how to correct the error.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
    /// Sets the range, unless the error already has one.
    pub fn at(mut self, span: Option<Range<usize>>) -> Self {
        self.span = self.span.or(span);
        self
    }
    /// Adds the hint "did you mean ...?" or, if no known name is similar, the list of known names. Adds no hint if
    /// `known` is empty.
    pub fn suggest<'a>(self, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        let distance = |k: &str| strsim::damerau_levenshtein(&name.to_lowercase(), &k.to_lowercase());
        // The comparison takes time in proportion to the product of the lengths.
        const MAX_COMPARED_BYTES: usize = 200;
        let comparable = known.iter().filter(|k| name.len() <= MAX_COMPARED_BYTES && k.len() <= MAX_COMPARED_BYTES);
        let near = comparable.map(|k| (distance(k), *k)).min();
        match near.filter(|(d, k)| *d <= 1 + k.len().max(name.len()) / 4) {
            Some((_, near)) => self.help(format!("did you mean `{near}`?")),
            None if known.is_empty() => self,
            None => self.help(format!("the known names are {}", known.join(", "))),
        }
    }
    /// Converts the error for the host. The line is that of the range in `text`, or 0 if the error has no range; `name`
    /// is the name of the file.
    pub fn into_fail(self, name: &str, text: &str) -> Fail {
        let line = self.span.map_or(0, |s| 1 + text.bytes().take(s.start).filter(|b| *b == b'\n').count());
        let fail = Fail::new(self.text).at(name, line as u64);
        match self.help {
            Some(help) => fail.help(help),
            None => fail,
        }
    }
}
