//! The tables of a scene file that describe objects.

/// A table of the file: `[[object]]`, `[[model]]` or `[[import]]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// `object`, `model` or `import`.
    pub what: &'static str,
    /// Its index among the tables of that name.
    pub index: usize,
    /// Its first object. It is the base of a model.
    pub first: usize,
    /// Whether it places a model or an imported file.
    pub places: bool,
}
