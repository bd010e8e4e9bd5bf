//! The tree of a document by aliases, used to look up paths while it is being built, and to assign unique names.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use crate::{Data, Scene};

/// Aliases and parents of the objects so far; the object with index i is in slot i + 1.
#[derive(Debug, Clone, Default)]
pub struct Names {
    scene: Scene,
    /// Objects whose unique name is specified in the file, by alias and number. No other object gets such a name.
    told: BTreeMap<(String, i32), usize>,
}

impl Names {
    /// Adds the next object.
    pub fn add(&mut self, parent: Option<usize>, alias: &str) {
        let parent = parent.map_or(0, |p| p as u32 + 1);
        self.scene.add(parent, alias, Isometry3::identity(), Data::Dummy(None));
    }

    /// Changes the alias of an object.
    pub fn rename(&mut self, object: usize, alias: &str) {
        self.scene.set_name(object as u32 + 1, alias, -1);
    }

    /// Records an object's unique name as specified in the file; the first of equal ones keeps it.
    pub fn tell(&mut self, object: usize, alias: &str, suffix: i32) {
        self.told.entry((alias.to_owned(), suffix)).or_insert(object);
    }

    /// Returns the object whose unique name is specified in the file.
    pub fn told(&self, name: &str) -> Option<usize> {
        let (alias, suffix) = match name.split_once('#') {
            Some((alias, "")) => (alias, -1),
            Some((alias, n)) => (alias, n.parse().ok()?),
            None => (name, -1),
        };
        self.told.get(&(alias.to_owned(), suffix)).copied()
    }

    /// Returns the only object with this alias, or `None` if there are none or several.
    pub fn only(&self, alias: &str) -> Option<usize> {
        self.scene.only(alias).map(|slot| slot as usize - 1)
    }

    /// Finds an object by a path that consists only of aliases. Returns `None` if it does not exist, or if the path has
    /// other parts.
    pub fn find(&self, from: Option<usize>, path: &str) -> Option<usize> {
        if path.contains([':', '#']) {
            return None;
        }
        let base = from.map_or(0, |f| f as u32 + 1);
        let found = match path.starts_with(['/', '.']) {
            true => self.scene.find(base, path),
            // Below a model, a plain name refers to one of its parts.
            false if base != 0 => self.scene.find(base, &format!("./{path}")),
            false => None,
        };
        found.map(|slot| slot as usize - 1)
    }
}

/// Returns the suffix of a unique name, -1 for `b` and n for `b#n`, or `None` if it is not a name with this alias.
pub fn suffix_of(name: &str, alias: &str) -> Option<i32> {
    match name.strip_prefix(alias)? {
        "" => Some(-1),
        rest => rest.strip_prefix('#')?.parse().ok().filter(|n| *n >= 0),
    }
}
