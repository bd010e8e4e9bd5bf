//! The state of edits to the scene, as shown by the page, and backup copies of unsaved edits.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{Turn, ValueRef},
};

use crate::{gallery::comes_with_program, protocol::Edits};

/// The event that reports an edit.
pub(crate) const EVENT: &str = "edited";
/// Minimum interval between copies of unsaved edits.
const COPIES: Duration = Duration::from_secs(3);
/// Time after which the state of the edits is read again, because another program may have written or removed the
/// files.
const FRESH: Duration = Duration::from_secs(1);

/// The last known state of the edits, and the time of the last copy.
#[derive(Default)]
pub(crate) struct Known {
    edits: Edits,
    read: Option<Instant>,
    /// Whether there were edits since the last copy.
    copy_due: bool,
    copied: Option<Instant>,
    /// Whether a failure to write a copy was reported.
    told: bool,
}

impl Known {
    /// Records that the scene was edited or replaced.
    pub(crate) fn changed(&mut self) {
        (self.read, self.copy_due) = (None, true);
    }

    /// Records that files of the scene may have changed.
    pub(crate) fn look_again(&mut self) {
        self.read = None;
    }

    /// Returns the state of the edits.
    pub(crate) fn read(&mut self, turn: &Turn<'_>) -> Edits {
        if self.read.is_none_or(|at| at.elapsed() >= FRESH) {
            self.edits = turn.edits().map(edits).unwrap_or_default();
            self.read = Some(Instant::now());
        }
        self.edits.clone()
    }

    /// Writes a copy of unsaved edits if one is due. Does nothing if there were no edits since the last copy.
    pub(crate) fn keep(&mut self, turn: &Turn<'_>) {
        if !self.copy_due || self.copied.is_some_and(|at| at.elapsed() < COPIES) {
            return;
        }
        (self.copy_due, self.copied) = (false, Some(Instant::now()));
        if let Err(fail) = turn.copy_edits()
            && !std::mem::replace(&mut self.told, true)
        {
            let text = format!("unsaved edits would be lost if the program ended unexpectedly: {}", fail.text());
            turn.log(TATU_LOG_WARNING, text.as_bytes());
        }
    }
}

fn edits(told: ValueRef<'_>) -> Edits {
    let last = |key: &str| Some(told.get(key)?.list()?.last()?.as_str()?.into_owned());
    let is = |key: &str| told.get(key).is_some_and(|v| v.truthy());
    let file = told.get("file").and_then(|v| v.as_str()).map(|s| s.into_owned()).unwrap_or_default();
    // A scene that comes with the program must be saved under another name.
    let is_ours = comes_with_program(Path::new(&file));
    Edits {
        undo: last("undo"),
        redo: last("redo"),
        unsaved: is("unsaved"),
        on_disk: is("on_disk") && !is_ours,
        file,
        recovery: told.get("recovery").and_then(|v| v.as_i64()),
    }
}
