//! Maps objects to the tables of a scene file that describe them, and finds the objects that the file still describes.

use std::collections::BTreeSet;

use super::edited::Edited;
use crate::{Scene, document::entry::Entry};

/// The tables of a file, and the table that describes each object.
pub struct Entries {
    /// The tables, in file order.
    pub list: Vec<Entry>,
    /// Index of the entry of each object of the document.
    of: Vec<Option<usize>>,
    /// Objects of the document that their entries still describe: not removed, and not moved out of a model.
    pub kept: BTreeSet<usize>,
    /// The slots of these objects in the scene.
    kept_slots: BTreeSet<u32>,
    /// The objects in `kept`, by slot.
    by_slot: std::collections::BTreeMap<u32, usize>,
}

impl Entries {
    pub fn new(edited: &Edited<'_>) -> Self {
        let list = edited.document.entries.clone();
        let count = edited.document.objects.len();
        let mut of = vec![None; count];
        for (n, entry) in list.iter().enumerate() {
            let end = list.get(n + 1).map_or(count, |next| next.first);
            of[entry.first.min(count)..end.min(count)].fill(Some(n));
        }
        let mut entries = Entries { list, of, ..Entries::empty() };
        for (object, slot) in edited.slots.iter().enumerate().filter(|(_, s)| **s != 0) {
            if entries.stays(edited, object, *slot) {
                entries.kept.insert(object);
                entries.kept_slots.insert(*slot);
                entries.by_slot.insert(*slot, object);
            }
        }
        entries
    }

    fn empty() -> Self {
        Entries {
            list: Vec::new(),
            of: Vec::new(),
            kept: BTreeSet::new(),
            kept_slots: BTreeSet::new(),
            by_slot: Default::default(),
        }
    }

    /// Returns whether the entry of an existing object still describes it. The parent must already have been examined,
    /// which is the case because parents precede their children.
    fn stays(&self, edited: &Edited<'_>, object: usize, slot: u32) -> bool {
        let Some(entry) = self.of(object) else { return false };
        if entry.first == object || !entry.places {
            return true;
        }
        let Some(parent) = edited.document.objects[object].parent else { return true };
        let above = edited.scene.get(slot).map_or(0, |o| o.parent);
        self.kept.contains(&parent) && edited.slots[parent] == above
    }

    /// Returns the entry of an object of the document.
    pub fn of(&self, object: usize) -> Option<Entry> {
        self.of.get(object).copied().flatten().map(|n| self.list[n])
    }
    /// Returns the object in `kept` that is in a slot of the scene.
    pub fn object_at(&self, slot: u32) -> Option<usize> {
        self.by_slot.get(&slot).copied()
    }
    /// Returns whether the file describes the object in a slot of the scene.
    pub fn has(&self, slot: u32) -> bool {
        self.kept_slots.contains(&slot)
    }
    /// Returns a copy of the scene with the aliases that its objects have before `[set]` is applied. Parts of models
    /// have the aliases that the models define.
    pub fn named(&self, edited: &Edited<'_>) -> Scene {
        let mut named = edited.scene.clone();
        for &object in &self.kept {
            let replaced = edited.document.replaced_aliases.get(&object);
            let own = self.of(object).is_some_and(|e| e.first == object);
            let (slot, spec) = (edited.slots[object], &edited.document.objects[object]);
            let Some(alias) = replaced.or(Some(&spec.alias).filter(|_| !own)) else { continue };
            if named.get(slot).is_some_and(|o| o.alias() != alias) {
                named.set_name(slot, alias, -1);
            }
        }
        named
    }
    /// Returns whether an entry remains in the file.
    pub fn stays_listed(&self, entry: &Entry) -> bool {
        self.kept.contains(&entry.first)
    }
}
