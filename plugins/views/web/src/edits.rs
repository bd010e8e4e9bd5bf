//! Tracks the edits of the scene for the page: undo, redo and unsaved changes. Also writes backup copies of unsaved
//! edits.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{Turn, ValueRef},
};

use crate::{gallery::comes_with_program, protocol::EditState};

/// The name of the event that reports an edit of the scene.
pub(crate) const EDITED_EVENT: &str = "edited";
/// Minimum interval between two backup copies of unsaved edits.
const BACKUP_INTERVAL: Duration = Duration::from_secs(3);
/// Time after which the state of the edits is read again, because another program may have written or removed the file
/// of the scene.
const EDITS_MAX_AGE: Duration = Duration::from_secs(1);

/// The last known state of the edits, and the time of the last copy.
#[derive(Default)]
pub(crate) struct EditTracker {
    edits: EditState,
    /// Time at which `edits` was read; `None` if it must be read again.
    read_at: Option<Instant>,
    /// Whether the scene was edited since the last copy.
    copy_due: bool,
    /// Time of the last attempt to write a copy.
    last_copy: Option<Instant>,
    /// Whether a failure to write a copy has been reported; later failures are not.
    failure_reported: bool,
}

impl EditTracker {
    /// Records that the scene was edited or replaced.
    pub(crate) fn mark_edited(&mut self) {
        (self.read_at, self.copy_due) = (None, true);
    }

    /// Records that the file of the scene may have been written or removed.
    pub(crate) fn invalidate(&mut self) {
        self.read_at = None;
    }

    /// Returns the state of the edits, which is up to a second old.
    pub(crate) fn read(&mut self, turn: &Turn<'_>) -> EditState {
        if self.read_at.is_none_or(|at| at.elapsed() >= EDITS_MAX_AGE) {
            self.edits = turn.edits().map(edits).unwrap_or_default();
            self.read_at = Some(Instant::now());
        }
        self.edits.clone()
    }

    /// Writes a copy of unsaved edits if the scene was edited since the last copy and the interval has passed.
    pub(crate) fn write_backup(&mut self, turn: &Turn<'_>) {
        if !self.copy_due || self.last_copy.is_some_and(|at| at.elapsed() < BACKUP_INTERVAL) {
            return;
        }
        (self.copy_due, self.last_copy) = (false, Some(Instant::now()));
        if let Err(fail) = turn.copy_edits()
            && !std::mem::replace(&mut self.failure_reported, true)
        {
            let text = format!(
                "unsaved edits will be lost if the program crashes, because no copy of them can be written: {}",
                fail.text()
            );
            turn.log(TATU_LOG_WARNING, text.as_bytes());
        }
    }
}

fn edits(told: ValueRef<'_>) -> EditState {
    let last = |key: &str| Some(told.get(key)?.list()?.last()?.as_str()?.into_owned());
    let is = |key: &str| told.get(key).is_some_and(|v| v.truthy());
    let file = told.get("file").and_then(|v| v.as_str()).map(|s| s.into_owned()).unwrap_or_default();
    // Files that come with the program must not be overwritten, so the scene must be saved under another name.
    let is_ours = comes_with_program(Path::new(&file));
    EditState {
        undo: last("undo"),
        redo: last("redo"),
        unsaved: is("unsaved"),
        on_disk: is("on_disk") && !is_ours,
        file,
        recovery: told.get("recovery").and_then(|v| v.as_i64()),
    }
}
