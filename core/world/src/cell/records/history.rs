//! The edits that a user made, and the state of the scene before each of them.
//!
//! An edit consists of a label and the state of the whole scene before the edit. Scenes share their meshes, so a state
//! takes only about 1 kB per object.

use std::collections::{BTreeMap, VecDeque};

use tatu_plugin_api::safe::Value;
use tatu_scene::{
    Scene,
    document::{DeviceSpec, ScriptSpec, WorldSettings},
    property_table::Property,
};

/// Maximum number of edits that can be undone.
const MAX_EDITS: usize = 200;
/// Maximum total size of all states, bytes, as estimated by `Memento::bytes`. At least one edit is stored, regardless
/// of its size.
const MAX_STATE_BYTES: usize = 256 << 20;
/// Estimated size of an object in a state, bytes: its slot, its transforms and its boxed data.
const BYTES_PER_OBJECT: usize = 1000;

/// The uid that represents the world itself; uids of objects start at 1.
pub(crate) const WORLD_UID: u64 = 0;

/// A state of the scene to which a stop or an undo returns.
#[derive(Clone)]
pub(crate) struct Memento {
    pub scene: Scene,
    /// Slots, kinds and parameters of the devices.
    pub devices: Vec<(u32, DeviceSpec)>,
    /// The scripts of the scene with their slots, in the order in which they were added.
    pub scripts: Vec<(u32, ScriptSpec)>,
    pub settings: WorldSettings,
    /// See [`EditHistory::models`].
    pub models: BTreeMap<u64, String>,
}

impl Memento {
    fn bytes(&self) -> usize {
        let texts: usize = self.scripts.iter().map(|(_, s)| s.text.len()).sum();
        self.scene.slots().count() * BYTES_PER_OBJECT + texts
    }
}

/// An edit that can be undone or redone, with the state that undoing or redoing it restores.
struct Edit {
    label: String,
    /// Consecutive edits with the same label and the same `merge` key are combined into one, unless the key is empty.
    merge: String,
    /// The revision of `state`.
    revision: u64,
    state: Memento,
}

/// The state to which the scene is rolled back if an edit is discarded.
enum RollbackState {
    /// No state, because the simulation is running, and its stop will revert the edit.
    InRun,
    /// No state, because the edit becomes part of the previous one.
    MergesWithLast,
    /// The state before the edit.
    State(Box<Memento>),
}

/// An edit in progress.
struct OpenEdit {
    label: String,
    merge: String,
    before: RollbackState,
    /// Nesting depth; nested edits are part of the outermost one.
    depth: u32,
}

/// The edits of a world.
#[derive(Default)]
pub(crate) struct EditHistory {
    undo: VecDeque<Edit>,
    redo: Vec<Edit>,
    open: Option<OpenEdit>,
    /// Identifies the present state among the states of this history.
    revision: u64,
    /// The last revision that was assigned.
    last_revision: u64,
    /// The revision that was saved last.
    saved_revision: u64,
    /// The revision that was last saved or written to a recovery copy.
    copied_revision: u64,
    /// Whether a recovery copy made by this world exists.
    has_copy: bool,
    /// Whether scripts were changed in the current run; a stop does not revert their sources.
    scripts_changed: bool,
    /// Ids of the models that were added to the scene, by the uid of their base objects.
    pub models: BTreeMap<u64, String>,
    /// Values of properties that runs changed and that a stop does not restore, by the uid of the object. Such changes
    /// are not edits.
    pub run_changes: BTreeMap<(u64, Property), Value>,
}

/// The outcome of ending an edit.
pub(crate) enum EditOutcome {
    /// The edit is nested in another one, which is still in progress.
    Nested,
    /// The edit is in effect, and is part of the history.
    Committed,
    /// The edit must be rolled back to this state.
    RollBack(Box<Memento>),
    /// The edit remains in effect, since no separate state was captured for it. If it was made during a run, the stop
    /// reverts it.
    NotRecorded,
}

impl EditHistory {
    /// Returns whether an edit is in progress.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Returns whether an edit that begins now requires the present state.
    pub fn needs_state(&self, label: &str, merge: &str) -> bool {
        self.open.is_none() && !self.merges_with_last(label, merge)
    }

    /// Begins an edit. `state` is the present state if the edit [requires](Self::needs_state) it, or `None` while the
    /// simulation is running.
    pub fn begin(&mut self, label: &str, merge: &str, state: Option<Memento>) {
        if let Some(open) = &mut self.open {
            open.depth += 1;
            return;
        }
        let before = match self.merges_with_last(label, merge) {
            true => RollbackState::MergesWithLast,
            false => state.map_or(RollbackState::InRun, |m| RollbackState::State(Box::new(m))),
        };
        self.open = Some(OpenEdit { label: label.to_owned(), merge: merge.to_owned(), before, depth: 1 });
    }

    /// Returns whether an edit becomes part of the previous one. The edit after a save is always separate, so that
    /// undoing it restores the saved state.
    fn merges_with_last(&self, label: &str, merge: &str) -> bool {
        let joins = |last: &Edit| !merge.is_empty() && last.label == label && last.merge == merge;
        self.revision != self.saved_revision && self.redo.is_empty() && self.undo.back().is_some_and(joins)
    }

    /// Ends an edit, which is kept or discarded. Returns `None` if no edit is in progress.
    pub fn end(&mut self, keep: bool) -> Option<EditOutcome> {
        let open = self.open.as_mut()?;
        open.depth -= 1;
        if open.depth > 0 {
            return Some(EditOutcome::Nested);
        }
        let open = self.open.take()?;
        Some(match (open.before, keep) {
            (RollbackState::InRun, _) => EditOutcome::NotRecorded,
            (RollbackState::MergesWithLast, true) => {
                self.advance_revision();
                EditOutcome::Committed
            }
            (RollbackState::MergesWithLast, false) => EditOutcome::NotRecorded,
            (RollbackState::State(before), true) => {
                self.push(open.label, open.merge, *before);
                EditOutcome::Committed
            }
            (RollbackState::State(before), false) => EditOutcome::RollBack(before),
        })
    }

    /// Adds a completed edit and the state before it.
    pub fn push(&mut self, label: String, merge: String, before: Memento) {
        self.redo.clear();
        self.undo.push_back(Edit { label, merge, revision: self.revision, state: before });
        self.advance_revision();
        let mut bytes: usize = self.undo.iter().map(|e| e.state.bytes()).sum();
        while self.undo.len() > MAX_EDITS || (bytes > MAX_STATE_BYTES && self.undo.len() > 1) {
            let Some(oldest) = self.undo.pop_front() else { break };
            bytes -= oldest.state.bytes();
        }
    }

    fn advance_revision(&mut self) {
        self.last_revision += 1;
        self.revision = self.last_revision;
    }

    /// Moves the last edit from the undo list to the redo list, or back if `redo` is set, and returns its label and the
    /// state to restore. `present` captures the state that the opposite operation restores.
    pub fn step_back(&mut self, redo: bool, present: impl FnOnce() -> Memento) -> Option<(String, Memento)> {
        let Edit { label, revision, state, .. } = if redo { self.redo.pop()? } else { self.undo.pop_back()? };
        let other = Edit { label: label.clone(), merge: String::new(), revision: self.revision, state: present() };
        match redo {
            true => self.undo.push_back(other),
            false => self.redo.push(other),
        }
        self.revision = revision;
        Some((label, state))
    }

    /// Returns the labels of the edits that can be undone or, if `redo` is set, redone. The next edit is last.
    pub fn labels(&self, redo: bool) -> Vec<&str> {
        match redo {
            true => self.redo.iter().map(|e| e.label.as_str()).collect(),
            false => self.undo.iter().map(|e| e.label.as_str()).collect(),
        }
    }

    /// Records that a script was changed during a run.
    pub fn note_script(&mut self) {
        if !std::mem::replace(&mut self.scripts_changed, true) {
            self.advance_revision();
        }
    }

    /// Returns whether scripts were changed in the run that ends, and clears the flag.
    pub fn take_scripts_changed(&mut self) -> bool {
        std::mem::take(&mut self.scripts_changed)
    }

    /// Returns the revision of the present state, which identifies it among the states of this history.
    pub fn revision(&self) -> u64 {
        self.revision
    }
    /// Returns whether the present state differs from the state that was saved last.
    pub fn is_unsaved(&self) -> bool {
        self.revision != self.saved_revision
    }
    /// Records that the present state was saved.
    pub fn note_saved(&mut self) {
        (self.saved_revision, self.copied_revision) = (self.revision, self.revision);
    }
    /// Records that the initial state was recovered, and therefore differs from that of the file.
    pub fn note_recovered(&mut self) {
        self.advance_revision();
        self.copied_revision = self.revision;
    }
    /// Returns whether the present state has neither been saved nor copied.
    pub fn needs_copy(&self) -> bool {
        self.revision != self.copied_revision
    }
    /// Records that a recovery copy of the present state was written or, if `there` is false, that it no longer exists.
    pub fn note_copied(&mut self, there: bool) {
        (self.copied_revision, self.has_copy) = (self.revision, there);
    }
    /// Returns whether a recovery copy made by this world exists.
    pub fn has_copy(&self) -> bool {
        self.has_copy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(n: usize) -> Memento {
        let mut scene = Scene::default();
        for _ in 0..n {
            scene.add(0, "x", nalgebra::Isometry3::identity(), tatu_scene::ObjectVariant::Dummy(None));
        }
        Memento {
            scene,
            devices: Vec::new(),
            scripts: Vec::new(),
            settings: WorldSettings::default(),
            models: BTreeMap::new(),
        }
    }

    fn edit(history: &mut EditHistory, label: &str, merge: &str, n: usize) {
        history.begin(label, merge, Some(state(n)));
        assert!(matches!(history.end(true), Some(EditOutcome::Committed)));
    }

    #[test]
    fn undo_and_redo_restore_the_neighbouring_states() {
        let mut history = EditHistory::default();
        assert!(!history.is_unsaved());
        edit(&mut history, "a", "", 0);
        edit(&mut history, "b", "", 1);
        assert_eq!((history.labels(false), history.is_unsaved()), (vec!["a", "b"], true));
        let (label, back) = history.step_back(false, || state(2)).unwrap();
        assert_eq!((label.as_str(), back.scene.slots().count()), ("b", 1));
        let (_, back) = history.step_back(false, || state(1)).unwrap();
        assert_eq!((back.scene.slots().count(), history.is_unsaved()), (0, false));
        assert!(history.step_back(false, || state(0)).is_none());
        let (label, ahead) = history.step_back(true, || state(0)).unwrap();
        assert_eq!((label.as_str(), ahead.scene.slots().count()), ("a", 1));
        edit(&mut history, "c", "", 1);
        assert_eq!((history.labels(false), history.labels(true)), (vec!["a", "c"], vec![]));
    }

    #[test]
    fn drag_merges_into_one_edit_but_not_across_a_save() {
        let mut history = EditHistory::default();
        for n in 0..5 {
            edit(&mut history, "Move a", "drag 1", n);
        }
        edit(&mut history, "Move a", "drag 2", 5);
        assert_eq!(history.labels(false), ["Move a", "Move a"]);
        history.note_saved();
        edit(&mut history, "Move a", "drag 2", 6);
        assert_eq!((history.labels(false).len(), history.is_unsaved()), (3, true));
        history.step_back(false, || state(7));
        assert!(!history.is_unsaved());
    }

    #[test]
    fn nested_edits_join_the_outer_one_and_discarded_edits_leave_no_entry() {
        let mut history = EditHistory::default();
        history.begin("outer", "", Some(state(3)));
        assert!(!history.needs_state("inner", ""));
        history.begin("inner", "", None);
        assert!(matches!(history.end(false), Some(EditOutcome::Nested)));
        let Some(EditOutcome::RollBack(before)) = history.end(false) else { panic!() };
        assert_eq!((before.scene.slots().count(), history.labels(false).len()), (3, 0));
        assert!(history.end(true).is_none() && !history.is_unsaved());
    }

    #[test]
    fn edits_beyond_the_limit_drop_the_oldest() {
        let mut history = EditHistory::default();
        for n in 0..MAX_EDITS + 5 {
            edit(&mut history, &n.to_string(), "", 0);
        }
        assert_eq!((history.labels(false).len(), history.labels(false)[0]), (MAX_EDITS, "5"));
    }
}
