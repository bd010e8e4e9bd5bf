//! The tables of a scene file that describe objects.

/// A table of the file: `[[object]]`, `[[model]]` or `[[import]]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Name of the table: `object`, `model` or `import`.
    pub what: &'static str,
    /// Its index among the tables of that name.
    pub index: usize,
    /// Index of its first object; for a model or import, its base.
    pub first: usize,
    /// Whether the table places a model or an imported file.
    pub places: bool,
}
