//! Removal of tables and keys whose objects were removed from the scene.

use toml_edit::Item;

use super::tables::PatchWriter;
use crate::document::overrides;

/// Key that marks a table for removal; no key in a scene file has this name.
const REMOVAL_MARK: &str = "\u{0}";

impl PatchWriter<'_> {
    /// Removes tables whose objects were removed, and lists removed parts of models in `remove`. Objects that
    /// were moved out of a model are also listed there, and written as objects of the scene.
    pub fn remove_entries(&mut self) {
        let entries = self.entries;
        for entry in entries.list.iter().filter(|e| entries.remains(e) && e.is_placement) {
            let objects = &self.edited.document.objects;
            let gone = |o: usize| entries.entry_of(o) == Some(*entry) && !entries.described.contains(&o);
            let tops: Vec<usize> = (entry.first..objects.len())
                .take_while(|o| entries.entry_of(*o) == Some(*entry))
                .filter(|o| gone(*o) && objects[*o].parent.is_none_or(|p| entries.described.contains(&p)))
                .collect();
            for top in tops {
                let path = self.path_below(entry.first, top);
                if let Some(table) = self.table(entry) {
                    let list = table.entry("remove").or_insert_with(|| Item::Value(toml_edit::Array::new().into()));
                    if let Some(list) = list.as_array_mut() {
                        list.push(path);
                    }
                }
                self.out.changes += 1;
            }
        }
        for entry in entries.list.iter().rev().filter(|e| !entries.remains(e)) {
            if let Some(list) = self.doc.get_mut(entry.table).and_then(Item::as_array_of_tables_mut) {
                // The table is only marked here, which keeps indices valid until `tidy` is called.
                if let Some(table) = list.get_mut(entry.index) {
                    table.clear();
                    table.insert(REMOVAL_MARK, toml_edit::value(true));
                }
            }
            self.out.changes += 1;
        }
    }

    /// Returns the path of an object of the document relative to the base of its model.
    fn path_below(&self, base: usize, object: usize) -> String {
        let document = self.edited.document;
        let objects = &document.objects;
        let alias = |i: usize| document.reading.replaced_aliases.get(&i).unwrap_or(&objects[i].alias);
        let (mut parts, mut at) = (Vec::new(), Some(object));
        while let Some(o) = at.filter(|o| *o != base) {
            let alike = |i: &usize| objects[*i].parent == objects[o].parent && alias(*i) == alias(o);
            let same: Vec<usize> = (0..objects.len()).filter(alike).collect();
            let index = same.iter().position(|i| *i == o).unwrap_or(0);
            parts.push(match same.len() {
                1 => alias(o).clone(),
                _ => format!("{}[{index}]", alias(o)),
            });
            at = objects[o].parent;
        }
        parts.reverse();
        parts.join("/")
    }

    /// Removes keys of `[set]` whose objects were removed, and renames those whose paths have changed.
    pub fn clean_set(&mut self) {
        let document = self.edited.document;
        // Paths in `[set]` contain the aliases that objects have before `[set]` is applied.
        let (mut base, slots) = document.instantiate();
        for (object, alias) in &document.reading.replaced_aliases {
            base.set_name(slots[*object], alias, -1);
        }
        let Some(set) = self.doc.get_mut("set").and_then(Item::as_table_like_mut) else { return };
        let keys: Vec<String> = set.iter().map(|(k, _)| k.to_owned()).collect();
        for written in keys {
            let Some((path, key)) = written.rsplit_once('.').filter(|(p, _)| *p != "scene") else { continue };
            let found = base.find(0, path).and_then(|slot| slots.iter().position(|s| *s == slot));
            let Some(object) = found.or_else(|| overrides::find_object(document, None, path).ok()) else { continue };
            let now =
                self.entries.described.contains(&object).then(|| self.scene_before_set.path(self.edited.slots[object]));
            let moved =
                |now: &str| now != path && self.scene_before_set.find(0, path) != Some(self.edited.slots[object]);
            match now {
                Some(now) if moved(&now) => {
                    let item = set.remove(&written).unwrap_or_default();
                    set.insert(&format!("{now}.{key}"), item);
                }
                Some(_) => continue,
                None => drop(set.remove(&written)),
            }
            self.out.changes += 1;
        }
    }

    /// Removes the tables marked by `remove_entries`, and an empty `[set]`.
    pub fn tidy(&mut self) {
        for what in ["model", "import", "object"] {
            let Some(list) = self.doc.get_mut(what).and_then(Item::as_array_of_tables_mut) else { continue };
            list.retain(|t| !t.contains_key(REMOVAL_MARK));
            if list.is_empty() {
                self.doc.remove(what);
            }
        }
        let last = self.last_position();
        match self.doc.get_mut("set").and_then(Item::as_table_mut) {
            Some(set) if set.is_empty() => drop(self.doc.remove("set")),
            // A new `[set]` is written at the end of the file.
            Some(set) if set.position().is_none() => set.set_position(Some(last + 1)),
            _ => {}
        }
    }
}
