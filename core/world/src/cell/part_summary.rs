//! The calls of a part, for the summary of a run.

/// The activity of one part since its creation.
#[derive(Debug, Clone, PartialEq)]
pub struct PartSummary {
    /// Path of the part's object.
    pub object: String,
    /// Id of the part's kind.
    pub kind: String,
    /// Number of calls of its functions.
    pub calls: u64,
    /// Real time of these calls, with the commands that they called, s. It differs from run to run.
    pub seconds: f64,
    /// Whether the part has been switched off because it failed.
    pub off: bool,
}
