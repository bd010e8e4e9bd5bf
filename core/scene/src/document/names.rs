//! The tree of a document by aliases: what paths are looked up in while it is written, and how unique names are given.

use nalgebra::Isometry3;

use crate::{Data, Scene};

/// Aliases and parents of the objects written so far; the object of index i is in slot i + 1.
#[derive(Debug, Clone, Default)]
pub struct Names(Scene);

impl Names {
    /// Adds the next object.
    pub fn add(&mut self, parent: Option<usize>, alias: &str) {
        let parent = parent.map_or(0, |p| p as u32 + 1);
        self.0.add(parent, alias, Isometry3::identity(), Data::Dummy(None));
    }

    /// Gives an object another alias.
    pub fn rename(&mut self, object: usize, alias: &str) {
        self.0.set_name(object as u32 + 1, alias, -1);
    }

    /// The only object with this alias; `None`: there is none, or several.
    pub fn only(&self, alias: &str) -> Option<usize> {
        self.0.only(alias).map(|slot| slot as usize - 1)
    }

    /// Finds by a path that needs nothing but aliases; `None`: there is none, or it needs more.
    pub fn find(&self, from: Option<usize>, path: &str) -> Option<usize> {
        if path.contains([':', '#']) {
            return None;
        }
        let base = from.map_or(0, |f| f as u32 + 1);
        let found = match path.starts_with(['/', '.']) {
            true => self.0.find(base, path),
            // Below a model, a plain name means one of its parts.
            false if base != 0 => self.0.find(base, &format!("./{path}")),
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
