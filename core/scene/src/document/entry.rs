//! The tables of a scene file that describe objects.

/// A table of the file: `[[object]]`, `[[model]]` or `[[import]]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneEntry {
    /// Name of the table: `object`, `model` or `import`.
    pub table: &'static str,
    /// Index of the table among those with the same name.
    pub index: usize,
    /// Index of the first object that the table describes, which is the base of a model or import.
    pub first: usize,
    /// Whether the table places a model or an imported file.
    pub is_placement: bool,
}
