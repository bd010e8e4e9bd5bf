//! The tree of a document by aliases: what paths are looked up in while it is written, and how unique names are given.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use crate::{Data, Scene};

/// Aliases and parents of the objects written so far; the object of index i is in slot i + 1.
#[derive(Debug, Clone, Default)]
pub struct Names {
    scene: Scene,
    /// Objects whose unique name the file gives, by alias and number: no other object gets it.
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

    /// The file gives an object's unique name; the first of equal ones keeps it.
    pub fn tell(&mut self, object: usize, alias: &str, suffix: i32) {
        self.told.entry((alias.to_owned(), suffix)).or_insert(object);
    }

    /// The object of a unique name that the file gives.
    pub fn told(&self, name: &str) -> Option<usize> {
        let (alias, suffix) = match name.split_once('#') {
            Some((alias, "")) => (alias, -1),
            Some((alias, n)) => (alias, n.parse().ok()?),
            None => (name, -1),
        };
        self.told.get(&(alias.to_owned(), suffix)).copied()
    }

    /// The only object with this alias; `None`: there is none, or several.
    pub fn only(&self, alias: &str) -> Option<usize> {
        self.scene.only(alias).map(|slot| slot as usize - 1)
    }

    /// Finds by a path that consists of aliases only; `None`: there is none, or it needs more.
    pub fn find(&self, from: Option<usize>, path: &str) -> Option<usize> {
        if path.contains([':', '#']) {
            return None;
        }
        let base = from.map_or(0, |f| f as u32 + 1);
        let found = match path.starts_with(['/', '.']) {
            true => self.scene.find(base, path),
            // Below a model, a plain name means one of its parts.
            false if base != 0 => self.scene.find(base, &format!("./{path}")),
            false => None,
        };
        found.map(|slot| slot as usize - 1)
    }
}

/// The suffix of a unique name of an alias: -1 for `b`, n for `b#n`. `None`: it is no name of that alias.
pub fn suffix_of(name: &str, alias: &str) -> Option<i32> {
    match name.strip_prefix(alias)? {
        "" => Some(-1),
        rest => rest.strip_prefix('#')?.parse().ok().filter(|n| *n >= 0),
    }
}
