//! Windows with buttons, sliders and labels of scenes before version 3.3.

use serde::{Deserialize, Serialize};

/// Bits of the API: the kind of a button, and what it can do.
pub(crate) mod bits {
    /// The kinds of buttons are the numbers in these bits.
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
    /// Of windows.
    pub(crate) const VISIBLE: i64 = 1;
    pub(crate) const ROLLED_UP: i64 = 256;
    pub(crate) const WHEN_SELECTED: i64 = 1024;
}

/// Greatest position of a slider.
pub(crate) const SLIDER_END: f64 = 1000.0;

/// A button, label, slider or edit field.
#[derive(Serialize, Deserialize, Clone, Default)]
pub(crate) struct Button {
    pub(crate) handle: i64,
    pub(crate) attributes: i64,
    /// Columns and rows that it spans, then its first column and row.
    pub(crate) cells: [i64; 4],
    /// Labels: normal, and while pressed.
    pub(crate) labels: [String; 2],
    /// Slider position, 0 to 1000; in files -1 to 1.
    pub(crate) slider: f64,
    /// Red, green and blue from 0 to 1, as far as scripts have set them: up, down, label.
    #[serde(default)]
    pub(crate) colors: [Option<[f64; 3]>; 3],
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
    /// The button that was used last and its two values, until a script or a client reads them.
    #[serde(default)]
    pub(crate) event: Option<(i64, [i64; 2])>,
}

/// All windows of a world.
pub(crate) type Windows = Vec<Window>;

impl Button {
    pub(crate) fn kind(&self) -> i64 {
        self.attributes & bits::KIND
    }
    pub(crate) fn has(&self, bit: i64) -> bool {
        self.attributes & bit != 0
    }
    /// Whether a user can operate it.
    pub(crate) fn is_active(&self) -> bool {
        self.has(bits::ENABLED) && !self.has(bits::IGNORES_MOUSE)
    }
    /// The label that is shown now.
    pub(crate) fn label(&self) -> &str {
        let pressed = self.has(bits::IS_DOWN) && !self.labels[1].is_empty();
        &self.labels[usize::from(pressed)]
    }
}

impl Window {
    /// Converts what a file holds: its sliders go from -1 to 1.
    pub(crate) fn of_file(mut self) -> Self {
        for button in &mut self.buttons {
            button.slider = ((button.slider.clamp(-1.0, 1.0) + 1.0) * SLIDER_END / 2.0).round();
        }
        self
    }
}
