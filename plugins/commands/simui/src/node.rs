//! The elements of a window.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

/// Values of a widget, by name.
pub(crate) type WidgetValues = Map<String, Json>;

/// An element of a window. The first node of a window represents the window itself.
#[derive(Serialize, Deserialize, Clone, Default, Debug)]
pub(crate) struct WidgetNode {
    pub(crate) element: String,
    /// The id assigned by the script, usually a number; empty if the script did not assign one.
    pub(crate) id: String,
    pub(crate) values: WidgetValues,
    pub(crate) above: Option<usize>,
    pub(crate) below: Vec<usize>,
}
