//! The tree of a document by aliases: what paths are looked up in while it is written, and how unique names are given.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;

use crate::{Data, Scene};

/// Aliases and parents of the objects written so far; the object of index i is in slot i + 1.
#[derive(Debug, Clone, Default)]
pub struct Names {
    scene: Scene,
    /// Indices of the objects of each alias.
    by_alias: BTreeMap<String, Vec<usize>>,
    count: usize,
}

impl Names {
    /// Adds the next object.
    pub fn add(&mut self, parent: Option<usize>, alias: &str) {
        let parent = parent.map_or(0, |p| p as u32 + 1);
        self.scene.add(parent, alias, Isometry3::identity(), Data::Dummy(None));
        self.by_alias.entry(alias.to_owned()).or_default().push(self.count);
        self.count += 1;
    }

    /// Gives an object another alias.
    pub fn rename(&mut self, object: usize, alias: &str) {
        if let Some(o) = self.scene.get_mut(object as u32 + 1) {
            if let Some(same) = self.by_alias.get_mut(&o.alias) {
                same.retain(|i| *i != object);
            }
            o.alias = alias.to_owned();
            self.by_alias.entry(alias.to_owned()).or_default().push(object);
        }
    }

    /// The only object with this alias; `None`: there is none, or several.
    pub fn only(&self, alias: &str) -> Option<usize> {
        match self.by_alias.get(alias)?.as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }

    /// Finds by a path that needs nothing but aliases; `None`: there is none, or it needs more.
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

/// Gives unique names in order: objects that come together get the smallest number that is free for all of them, -1
/// meaning none.
#[derive(Default)]
pub struct Numbering<'a>(BTreeMap<&'a str, Taken>);

/// The numbers of an alias that are taken.
struct Taken {
    all: BTreeSet<i32>,
    /// The least that is free.
    free: i32,
}

impl Default for Taken {
    fn default() -> Self {
        Taken { all: BTreeSet::new(), free: -1 }
    }
}

impl Taken {
    /// `false`: it was taken.
    fn insert(&mut self, number: i32) -> bool {
        let new = self.all.insert(number);
        while self.all.contains(&self.free) {
            self.free += 1;
        }
        new
    }
}

impl<'a> Numbering<'a> {
    /// The number of objects with these aliases; it is taken from now on.
    pub fn next(&mut self, aliases: &[&'a str]) -> i32 {
        let free = |n: &i32| aliases.iter().all(|a| self.0.get(a).is_none_or(|taken| !taken.all.contains(n)));
        let least = aliases.iter().filter_map(|a| self.0.get(a)).map(|taken| taken.free).max().unwrap_or(-1);
        let number = (least..i32::MAX).find(free).unwrap_or(-1);
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
