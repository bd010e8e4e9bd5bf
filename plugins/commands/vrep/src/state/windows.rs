//! Windows with buttons, sliders and labels, from scenes before V-REP 3.3.

use serde::{Deserialize, Serialize};

/// Bits of the attributes of buttons and windows in the API.
pub(crate) mod bits {
    /// Mask of the bits that contain the kind of a button.
    pub(crate) const KIND: i64 = 7;
    pub(crate) const BUTTON: i64 = 0;
    pub(crate) const LABEL: i64 = 1;
    pub(crate) const SLIDER: i64 = 2;
    pub(crate) const EDIT: i64 = 3;
    pub(crate) const STAYS_DOWN: i64 = 8;
    pub(crate) const ENABLED: i64 = 16;
    pub(crate) const CENTERED: i64 = 64;
    pub(crate) const IGNORES_MOUSE: i64 = 128;
    pub(crate) const IS_DOWN: i64 = 256;
    pub(crate) const TRANSPARENT: i64 = 512;
    pub(crate) const NO_BACKGROUND: i64 = 1024;
    pub(crate) const ROLLS_UP: i64 = 2048;
    pub(crate) const CLOSES: i64 = 4096;
    pub(crate) const DOWN_AND_UP: i64 = 16384;
    /// Attribute of windows: visible.
    pub(crate) const VISIBLE: i64 = 1;
    /// Attribute of windows: only the first row is shown.
    pub(crate) const ROLLED_UP: i64 = 256;
    /// Attribute of windows: shown only while the object to which the window belongs is selected.
    pub(crate) const WHEN_SELECTED: i64 = 1024;
}

/// Maximum position of a slider.
pub(crate) const MAX_SLIDER_POSITION: f64 = 1000.0;

/// A button, label, slider or edit field.
#[derive(Serialize, Deserialize, Clone, Default)]
pub(crate) struct WindowButton {
    pub(crate) handle: i64,
    pub(crate) attributes: i64,
    /// Numbers of columns and rows that the button spans, then its first column and row.
    pub(crate) cells: [i64; 4],
    /// Labels: normal, and while pressed.
    pub(crate) labels: [String; 2],
    /// Slider position, 0 to 1000 (in files, -1 to 1).
    pub(crate) slider: f64,
    /// Colours set by scripts for the states up and down and for the label: red, green and blue, 0 to 1.
    #[serde(default)]
    pub(crate) colors: [Option<[f64; 3]>; 3],
}

/// A window and its buttons.
#[derive(Serialize, Deserialize, Clone, Default)]
pub(crate) struct Window {
    pub(crate) name: String,
    pub(crate) handle: i64,
    /// Handle in the file of the object to which the window belongs, or -1 if there is none.
    pub(crate) object: i64,
    pub(crate) attributes: i64,
    /// Numbers of columns and rows.
    pub(crate) cells: [i64; 2],
    pub(crate) buttons: Vec<WindowButton>,
    #[serde(default)]
    pub(crate) position: [i64; 2],
    /// The button that was last operated and its two values, until a script or a client reads them.
    #[serde(default)]
    pub(crate) event: Option<(i64, [i64; 2])>,
}

/// All windows of a world.
pub(crate) type Windows = Vec<Window>;

impl WindowButton {
    pub(crate) fn kind(&self) -> i64 {
        self.attributes & bits::KIND
    }
    pub(crate) fn has(&self, bit: i64) -> bool {
        self.attributes & bit != 0
    }
    /// Returns whether a user can operate the button.
    pub(crate) fn is_active(&self) -> bool {
        self.has(bits::ENABLED) && !self.has(bits::IGNORES_MOUSE)
    }
    /// Returns the label that is currently shown.
    pub(crate) fn label(&self) -> &str {
        let pressed = self.has(bits::IS_DOWN) && !self.labels[1].is_empty();
        &self.labels[usize::from(pressed)]
    }
}

impl Window {
    /// Converts a window that was read from a file, in which slider positions range from -1 to 1.
    pub(crate) fn of_file(mut self) -> Self {
        for button in &mut self.buttons {
            button.slider = ((button.slider.clamp(-1.0, 1.0) + 1.0) * MAX_SLIDER_POSITION / 2.0).round();
        }
        self
    }
}
