//! The tree of a document by aliases: what paths are looked up in while it is written, and how unique names are given.

use std::collections::{BTreeMap, BTreeSet};

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
        if let Some(o) = self.0.get_mut(object as u32 + 1) {
            o.alias = alias.to_owned();
        }
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

/// Gives unique names in order: objects that come together get the smallest number that is free for all of them, -1
/// meaning none.
#[derive(Default)]
pub struct Numbering<'a>(BTreeMap<&'a str, BTreeSet<i32>>);

impl<'a> Numbering<'a> {
    /// The number of objects with these aliases; it is taken from now on.
    pub fn next(&mut self, aliases: &[&'a str]) -> i32 {
        let free = |n: &i32| aliases.iter().all(|a| self.0.get(a).is_none_or(|taken| !taken.contains(n)));
        // Numbers are mostly given without gaps: there is none below the least of the counts that is full.
        let number = (-1..i32::MAX).find(free).unwrap_or(-1);
        for alias in aliases {
            self.0.entry(alias).or_default().insert(number);
        }
        number
    }

    /// Takes a number for an alias; `false`: it is taken.
    pub fn take(&mut self, alias: &'a str, number: i32) -> bool {
        self.0.entry(alias).or_default().insert(number)
    }
}

/// The suffix of a unique name of an alias: -1 for `b`, n for `b#n`. `None`: it is no name of that alias.
pub fn suffix_of(name: &str, alias: &str) -> Option<i32> {
    match name.strip_prefix(alias)? {
        "" => Some(-1),
        rest => rest.strip_prefix('#')?.parse().ok().filter(|n| *n >= 0),
    }
}
