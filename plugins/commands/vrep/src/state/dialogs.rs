//! Open dialogs.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A dialog that a script has opened.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct Dialog {
    pub(crate) style: i64,
    pub(crate) text: Vec<u8>,
    pub(crate) opened: i64,
    /// Whether a view shows the dialog, which then waits for the user's answer.
    pub(crate) attended: bool,
    /// The answer, or 0 if there is none yet.
    pub(crate) result: i64,
}

/// All dialogs of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Dialogs {
    pub(crate) open: BTreeMap<i64, Dialog>,
    pub(crate) made: i64,
}
