//! Maps objects to the tables of a scene file that describe them, and finds the objects that the file still describes.

use std::collections::BTreeSet;

use super::edited::EditedScene;
use crate::{Scene, document::entry::SceneEntry};

/// The tables of a file, and the table that describes each object.
pub struct EntryIndex {
    /// The tables, in file order.
    pub list: Vec<SceneEntry>,
    /// Index of the entry of each object of the document.
    entry_of_object: Vec<Option<usize>>,
    /// Objects of the document that their entries still describe: not removed, and not moved out of a model.
    pub described: BTreeSet<usize>,
    /// The slots of these objects in the scene.
    described_slots: BTreeSet<u32>,
    /// The objects in `described`, by slot.
    by_slot: std::collections::BTreeMap<u32, usize>,
}

impl EntryIndex {
    pub fn new(edited: &EditedScene<'_>) -> Self {
        let list = edited.document.entries.clone();
        let count = edited.document.objects.len();
        let mut of = vec![None; count];
        for (n, entry) in list.iter().enumerate() {
            let end = list.get(n + 1).map_or(count, |next| next.first);
            of[entry.first.min(count)..end.min(count)].fill(Some(n));
        }
        let mut entries = EntryIndex { list, entry_of_object: of, ..EntryIndex::empty() };
        for (object, slot) in edited.slots.iter().enumerate().filter(|(_, s)| **s != 0) {
            if entries.is_still_described(edited, object, *slot) {
                entries.described.insert(object);
                entries.described_slots.insert(*slot);
                entries.by_slot.insert(*slot, object);
            }
        }
        entries
    }

    fn empty() -> Self {
        EntryIndex {
            list: Vec::new(),
            entry_of_object: Vec::new(),
            described: BTreeSet::new(),
            described_slots: BTreeSet::new(),
            by_slot: Default::default(),
        }
    }

    /// Returns whether the entry of an existing object still describes it. The parent must already have been examined,
    /// which is the case because parents precede their children.
    fn is_still_described(&self, edited: &EditedScene<'_>, object: usize, slot: u32) -> bool {
        let Some(entry) = self.entry_of(object) else { return false };
        if entry.first == object || !entry.is_placement {
            return true;
        }
        let Some(parent) = edited.document.objects[object].parent else { return true };
        let above = edited.scene.get(slot).map_or(0, |o| o.parent);
        self.described.contains(&parent) && edited.slots[parent] == above
    }

    /// Returns the entry of an object of the document.
    pub fn entry_of(&self, object: usize) -> Option<SceneEntry> {
        self.entry_of_object.get(object).copied().flatten().map(|n| self.list[n])
    }
    /// Returns the object in `described` that is in a slot of the scene.
    pub fn object_at(&self, slot: u32) -> Option<usize> {
        self.by_slot.get(&slot).copied()
    }
    /// Returns whether the file describes the object in a slot of the scene.
    pub fn describes_slot(&self, slot: u32) -> bool {
        self.described_slots.contains(&slot)
    }
    /// Returns a copy of the scene with the aliases that its objects have before `[set]` is applied. Parts of models
    /// have the aliases that the models define.
    pub fn scene_before_set(&self, edited: &EditedScene<'_>) -> Scene {
        let mut named = edited.scene.clone();
        for &object in &self.described {
            let replaced = edited.document.reading.replaced_aliases.get(&object);
            let own = self.entry_of(object).is_some_and(|e| e.first == object);
            let (slot, spec) = (edited.slots[object], &edited.document.objects[object]);
            let Some(alias) = replaced.or(Some(&spec.alias).filter(|_| !own)) else { continue };
            if named.get(slot).is_some_and(|o| o.alias() != alias) {
                named.set_name(slot, alias, -1);
            }
        }
        named
    }
    /// Returns whether an entry remains in the file.
    pub fn remains(&self, entry: &SceneEntry) -> bool {
        self.described.contains(&entry.first)
    }
}
