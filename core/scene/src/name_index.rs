//! An index of objects by alias, with the suffixes of their unique names. It is updated incrementally, because a world
//! can contain a hundred thousand objects with the same alias.

use std::collections::{BTreeMap, BTreeSet};

/// Aliases, with the objects that have them.
#[derive(Debug, Clone, Default)]
pub(super) struct NameIndex(BTreeMap<String, AliasUsers>);

/// The objects with one alias.
#[derive(Debug, Clone)]
struct AliasUsers {
    /// Suffix of the unique name, and slot, of each object.
    all: BTreeSet<(i32, u32)>,
    /// All suffixes below this value are taken; the search for a free suffix starts here.
    free: i32,
}

impl AliasUsers {
    fn is_taken(&self, number: i32) -> bool {
        self.all.range((number, 0)..=(number, u32::MAX)).next().is_some()
    }
}

impl NameIndex {
    pub fn add(&mut self, alias: &str, suffix: i32, slot: u32) {
        if !self.0.contains_key(alias) {
            self.0.insert(alias.to_owned(), AliasUsers { all: BTreeSet::new(), free: -1 });
        }
        let Some(users) = self.0.get_mut(alias) else { return };
        users.all.insert((suffix, slot));
    }

    pub fn remove(&mut self, alias: &str, suffix: i32, slot: u32) {
        let Some(users) = self.0.get_mut(alias) else { return };
        users.all.remove(&(suffix, slot));
        if users.all.is_empty() {
            self.0.remove(alias);
        } else if suffix >= -1 && suffix < users.free && !users.is_taken(suffix) {
            users.free = suffix;
        }
    }

    /// Returns the slots of the objects with this unique name, in ascending order.
    pub fn objects_named(&self, alias: &str, suffix: i32) -> impl Iterator<Item = u32> {
        let users = self.0.get(alias);
        users.into_iter().flat_map(move |u| u.all.range((suffix, 0)..=(suffix, u32::MAX))).map(|(_, slot)| *slot)
    }

    /// Returns the only object with this alias, or `None` if no object or several objects have it.
    pub fn only(&self, alias: &str) -> Option<u32> {
        let users = self.0.get(alias).filter(|u| u.all.len() == 1)?;
        users.all.first().map(|(_, slot)| *slot)
    }

    /// Returns the smallest suffix that is free for all these aliases; -1 stands for names without a suffix.
    pub fn free_suffix<'a>(&mut self, aliases: impl Iterator<Item = &'a str> + Clone) -> i32 {
        for alias in aliases.clone() {
            let Some(users) = self.0.get_mut(alias) else { continue };
            while users.is_taken(users.free) {
                users.free += 1;
            }
        }
        let users = aliases.filter_map(|a| self.0.get(a));
        let least = users.clone().map(|u| u.free).max().unwrap_or(-1);
        (least..i32::MAX).find(|n| users.clone().all(|u| !u.is_taken(*n))).unwrap_or(-1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smallest_suffix_free_for_all_aliases_is_found() {
        let mut index = NameIndex::default();
        for (alias, suffix, slot) in [("a", -1, 1), ("a", 0, 2), ("b", 1, 3), ("a", 5, 4)] {
            index.add(alias, suffix, slot);
        }
        let free = |index: &mut NameIndex, aliases: &[&str]| index.free_suffix(aliases.iter().copied());
        assert_eq!((free(&mut index, &["a"]), free(&mut index, &["b"]), free(&mut index, &["c"])), (1, -1, -1));
        assert_eq!(free(&mut index, &["a", "b"]), 2);
        index.remove("a", 0, 2);
        assert_eq!((free(&mut index, &["a"]), free(&mut index, &["a", "b"])), (0, 0));
        assert_eq!((index.only("b"), index.only("a"), index.only("c")), (Some(3), None, None));
        assert_eq!(index.objects_named("a", 5).collect::<Vec<_>>(), [4]);
    }
}
