//! What the page tells of the edits of the scene, and copies of those that are in no file.

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
/// Least interval of copies of unsaved edits.
const COPIES: Duration = Duration::from_secs(3);
/// How long what is known of the edits is used: another program may write or remove the files.
const FRESH: Duration = Duration::from_secs(1);

/// The edits as they were read last, and when copies are due.
#[derive(Default)]
pub(crate) struct Known {
    edits: Edits,
    read: Option<Instant>,
    /// Whether there were edits since the last copy.
    copy_due: bool,
    copied: Option<Instant>,
    /// Whether it was reported that no copy can be written.
    told: bool,
}

impl Known {
    /// Notes that the scene was edited, or that it is another one.
    pub(crate) fn changed(&mut self) {
        (self.read, self.copy_due) = (None, true);
    }

    /// Notes that files of the scene may have changed.
    pub(crate) fn look_again(&mut self) {
        self.read = None;
    }

    /// Returns the edits.
    pub(crate) fn read(&mut self, turn: &Turn<'_>) -> Edits {
        if self.read.is_none_or(|at| at.elapsed() >= FRESH) {
            self.edits = turn.edits().map(edits).unwrap_or_default();
            self.read = Some(Instant::now());
        }
        self.edits.clone()
    }

    /// Copies unsaved edits if that is due. Without an edit, nothing is done.
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
    // A scene that comes with the program is saved under a name of one's own.
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
