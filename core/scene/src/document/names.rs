//! The tree of the aliases in a document. It is used to look up paths while the document is being built, and to assign
//! unique names.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;

use crate::{ObjectVariant, Scene};

/// Aliases and parents of the objects added so far.
#[derive(Debug, Clone, Default)]
pub struct AliasTree {
    scene: Scene,
    /// The slot in `scene` of each object of the document.
    slots: Vec<u32>,
    /// Index, in the document, of the object in each slot.
    objects: Vec<usize>,
    /// Objects whose unique name is specified in the file, by alias and suffix. No other object gets such a name.
    specified: BTreeMap<(String, i32), usize>,
}

impl AliasTree {
    /// Adds an object, with the next index.
    pub fn add(&mut self, parent: Option<usize>, alias: &str) {
        let slot =
            self.scene.add(self.slot(parent), alias, Isometry3::identity(), ObjectVariant::Dummy(None)).unwrap_or(0);
        self.slots.push(slot);
        self.set_object(slot, self.slots.len() - 1);
    }

    /// Removes objects; the indices of later objects decrease accordingly.
    pub fn remove(&mut self, gone: &BTreeSet<usize>) {
        let Some(first) = gone.first().copied().filter(|f| *f < self.slots.len()) else { return };
        // Children follow their parents, so removal in reverse order never attaches a child to a different parent.
        for object in gone.iter().rev() {
            self.scene.remove(self.slot(Some(*object)));
        }
        let rest = self.slots.split_off(first);
        self.slots.extend((first..).zip(rest).filter(|(i, _)| !gone.contains(i)).map(|(_, slot)| slot));
        (first..self.slots.len()).for_each(|i| self.set_object(self.slots[i], i));
        let told = std::mem::take(&mut self.specified);
        let moved = |i: usize| if i < first { i } else { i - gone.range(..i).count() };
        self.specified =
            told.into_iter().filter(|(_, i)| !gone.contains(i)).map(|(name, i)| (name, moved(i))).collect();
    }

    fn slot(&self, object: Option<usize>) -> u32 {
        object.and_then(|o| self.slots.get(o)).copied().unwrap_or(0)
    }

    fn set_object(&mut self, slot: u32, object: usize) {
        let at = slot as usize;
        self.objects.resize(self.objects.len().max(at + 1), 0);
        self.objects[at] = object;
    }

    /// Changes the alias of an object.
    pub fn rename(&mut self, object: usize, alias: &str) {
        self.scene.set_name(self.slot(Some(object)), alias, -1);
    }

    /// Records the unique name that the file specifies for an object. If it is specified for several objects, the first
    /// one keeps it.
    pub fn specify_name(&mut self, object: usize, alias: &str, suffix: i32) {
        self.specified.entry((alias.to_owned(), suffix)).or_insert(object);
    }

    /// Returns the object for which the file specifies this unique name.
    pub fn find_specified(&self, name: &str) -> Option<usize> {
        let (alias, suffix) = match name.split_once('#') {
            Some((alias, "")) => (alias, -1),
            Some((alias, n)) => (alias, n.parse().ok()?),
            None => (name, -1),
        };
        self.specified.get(&(alias.to_owned(), suffix)).copied()
    }

    /// Returns the only object with this alias, or `None` if no object or several objects have it.
    pub fn only(&self, alias: &str) -> Option<usize> {
        self.scene.only(alias).map(|slot| self.objects[slot as usize])
    }

    /// Finds an object by a path that consists only of aliases. Returns `None` if the object does not exist, or if the
    /// path contains `:` or `#`.
    pub fn find(&self, from: Option<usize>, path: &str) -> Option<usize> {
        if path.contains([':', '#']) {
            return None;
        }
        let base = self.slot(from);
        let found = match path.starts_with(['/', '.']) {
            true => self.scene.find(base, path),
            // Below a model, a plain name refers to one of its parts.
            false if base != 0 => self.scene.find(base, &format!("./{path}")),
            false => None,
        };
        found.map(|slot| self.objects[slot as usize])
    }

    /// Returns all objects below another one, at any depth, whose alias matches a pattern with `*` and `?`.
    pub fn all_below(&self, from: usize, pattern: &str) -> Vec<usize> {
        let found = self.scene.all_below(self.slot(Some(from)), pattern);
        found.into_iter().map(|slot| self.objects[slot as usize]).collect()
    }
}

/// Returns the suffix of a unique name, -1 for `b` and n for `b#n`, or `None` if the name does not consist of this
/// alias and a suffix.
pub fn suffix_of(name: &str, alias: &str) -> Option<i32> {
    match name.strip_prefix(alias)? {
        "" => Some(-1),
        rest => rest.strip_prefix('#')?.parse().ok().filter(|n| *n >= 0),
    }
}
