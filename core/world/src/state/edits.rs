//! Begins, ends, undoes and redoes edits of the scene.
//!
//! While the simulation is running, edits cannot be undone one by one. The stop reverts the changes by the run and the
//! user, except those of a few properties (see `memento`), and the edits from before the run can then be undone again.

use std::path::Path;

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;

use super::{
    memento::{capture, restore_state},
    recovery,
};
use crate::cell::{WorldCell, records::history::EditOutcome};

/// The event that reports that the list of edits has changed.
const EDITED_EVENT: &str = "edited";

/// Begins an edit. Consecutive edits with the same label and the same `merge` key are combined, unless the key is
/// empty.
pub(crate) fn begin(cell: &WorldCell, label: &str, merge: &str) {
    let state = || (!cell.running()).then(|| capture(cell));
    // Capturing a state reads the history, so the history must not be borrowed meanwhile.
    let needed = cell.model.history.borrow().needs_state(label, merge);
    let state = if needed { state() } else { None };
    cell.model.history.borrow_mut().begin(label, merge, state);
}

/// Ends an edit. If `keep` is false, the edit is rolled back.
pub(crate) fn end(cell: &WorldCell, keep: bool) -> Result {
    let ended = cell.model.history.borrow_mut().end(keep);
    match ended {
        None => Err(Error::new("E305", "there is no edit to end")),
        Some(EditOutcome::RollBack(state)) => {
            restore_state(cell, *state);
            Ok(())
        }
        Some(EditOutcome::Committed) => {
            publish_edits(cell);
            Ok(())
        }
        Some(EditOutcome::Nested | EditOutcome::NotRecorded) => Ok(()),
    }
}

/// Undoes the last edit, or redoes the last one undone if `redo` is set. Returns its label, or `None` if there is no
/// such edit.
pub(crate) fn step_back(cell: &WorldCell, redo: bool) -> Result<Option<String>> {
    let what = if redo { "redone" } else { "undone" };
    if cell.running() {
        let text = format!("nothing can be {what} while the simulation runs");
        return Err(Error::new("E305", text).help("stop it: a stop reverts all changes since the start"));
    }
    if cell.model.history.borrow().is_open() {
        return Err(Error::new("E305", format!("nothing can be {what} within an edit")));
    }
    if cell.run.scripts.borrow().list.iter().any(|s| s.depth.get() > 0) {
        return Err(Error::new("E305", format!("nothing can be {what} while a script is running"))
            .help("scripts cannot undo edits; only remote clients and the page can"));
    }
    let present = capture(cell);
    let taken = cell.model.history.borrow_mut().step_back(redo, || present);
    let Some((label, state)) = taken else { return Ok(None) };
    restore_state(cell, state);
    publish_edits(cell);
    Ok(Some(label))
}

/// Records that a script was changed, if the simulation is running. The stop does not revert this change.
pub(crate) fn note_script(cell: &WorldCell) {
    if cell.running() {
        cell.model.history.borrow_mut().note_script();
        publish_edits(cell);
    }
}

/// Returns the state of the edits as a map: the labels of those that can be undone or redone, whether there are unsaved
/// ones, the revision, the file of the scene, and the time of a recovery copy that has been neither opened nor
/// discarded.
pub(crate) fn edits_value(cell: &WorldCell) -> Value {
    let history = cell.model.history.borrow();
    let file = cell.model.document.file.as_deref();
    let is_answered = history.has_copy() || cell.model.document.sources.are_recovered();
    let copied = file.filter(|_| !is_answered).and_then(recovery::written_at);
    let labels = |redo| Value::List(history.labels(redo).into_iter().map(Value::text).collect());
    Value::Map(vec![
        (Value::text("undo"), labels(false)),
        (Value::text("redo"), labels(true)),
        (Value::text("unsaved"), Value::Bool(history.is_unsaved())),
        (Value::text("revision"), Value::Int(history.revision() as i64)),
        (Value::text("file"), Value::text(file.map_or(String::new(), |f| f.display().to_string()))),
        (Value::text("on_disk"), Value::Bool(file.is_some_and(Path::is_file))),
        (Value::text("recovery"), copied.map_or(Value::Nil, Value::Int)),
    ])
}

/// Publishes an event with the labels of the edits that would be undone and redone next.
pub(crate) fn publish_edits(cell: &WorldCell) {
    let payload = {
        let history = cell.model.history.borrow();
        let last = |redo| history.labels(redo).last().map_or(Value::Nil, Value::text);
        Value::Map(vec![
            (Value::text("undo"), last(false)),
            (Value::text("redo"), last(true)),
            (Value::text("unsaved"), Value::Bool(history.is_unsaved())),
        ])
    };
    cell.run.connections.publish_value(EDITED_EVENT, payload);
}
