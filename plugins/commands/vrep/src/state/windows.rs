//! Windows with buttons, sliders and labels of scenes before version 3.3.

use serde::{Deserialize, Serialize};

/// A button, label, slider or edit field.
#[derive(Serialize, Deserialize, Clone, Default)]
pub(crate) struct Button {
    pub(crate) handle: i64,
    pub(crate) attributes: i64,
    /// Columns and rows that it spans, then its first column and row.
    pub(crate) cells: [i64; 4],
    /// Labels: normal, and while pressed.
    pub(crate) labels: [String; 2],
    /// Slider position, 0 to 1000.
    pub(crate) slider: f64,
}

/// A window.
#[derive(Serialize, Deserialize, Clone, Default)]
pub(crate) struct Window {
    pub(crate) name: String,
    pub(crate) handle: i64,
    /// Handle of the object in the file, or -1 if there is none.
    pub(crate) object: i64,
    pub(crate) attributes: i64,
    /// Columns and rows.
    pub(crate) cells: [i64; 2],
    pub(crate) buttons: Vec<Button>,
    #[serde(default)]
    pub(crate) position: [i64; 2],
}

/// All windows of a world.
pub(crate) type Windows = Vec<Window>;
