//! Dictionaries: keys in order of insertion.

use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

use crate::{
    error::{Result, fail},
    limits::{Budget, MAX_NESTING},
};

/// A key in a form in which equal keys are the same: 1, 1.0 and True are one key.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum EntryKey {
    None,
    Int(i64),
    Float(u64),
    Text(Rc<str>),
    Tuple(Vec<EntryKey>),
}

/// The contents of a dictionary, whose keys and values are of type `V`.
#[derive(Clone, Debug)]
pub(crate) struct DictEntries<V> {
    /// Keys for lookups, keys, and values; removed entries are `None`.
    list: Vec<Option<(EntryKey, V, V)>>,
    index: BTreeMap<EntryKey, usize>,
    /// The greatest depth of lists in it.
    depth: usize,
}

impl<V> Default for DictEntries<V> {
    fn default() -> Self {
        DictEntries { list: Vec::new(), index: BTreeMap::new(), depth: 0 }
    }
}

impl<V> DictEntries<V> {
    pub fn len(&self) -> usize {
        self.index.len()
    }

    pub fn get(&self, key: &EntryKey) -> Option<&V> {
        let slot = self.list.get(*self.index.get(key)?)?;
        slot.as_ref().map(|(_, _, value)| value)
    }

    /// Sets an entry; `depth` is that of lists in the key and the value.
    pub fn insert(&mut self, lookup: EntryKey, (key, value): (V, V), depth: usize, budget: &mut Budget) -> Result<()> {
        budget.another_item(self.len())?;
        self.depth = self.depth.max(depth);
        if self.depth >= MAX_NESTING {
            fail!("dictionaries are nested deeper than {MAX_NESTING}");
        }
        match self.index.get(&lookup).and_then(|slot| self.list.get_mut(*slot)) {
            // As in Python, the first key stays.
            Some(Some((_, _, old))) => *old = value,
            _ => {
                self.index.insert(lookup.clone(), self.list.len());
                self.list.push(Some((lookup, key, value)));
            }
        }
        Ok(())
    }

    fn remove(&mut self, key: &EntryKey) -> Option<V> {
        let slot = self.index.remove(key)?;
        let (_, _, value) = self.list.get_mut(slot)?.take()?;
        if self.list.len() > 2 * self.index.len() + 8 {
            self.list.retain(Option::is_some);
            self.index = (0..).zip(self.list.iter().flatten()).map(|(i, (key, _, _))| (key.clone(), i)).collect();
        }
        Some(value)
    }

    /// Keys for lookups, and values, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&EntryKey, &V)> {
        self.list.iter().flatten().map(|(lookup, _, value)| (lookup, value))
    }

    /// Keys and values, in order.
    pub fn pairs(&self) -> impl Iterator<Item = (&V, &V)> {
        self.list.iter().flatten().map(|(_, key, value)| (key, value))
    }
}

/// A dictionary, which its owners share. If it is from YAML, `d.name` is `d['name']`, and values are wrapped when they
/// are taken out.
#[derive(Clone, Debug)]
pub(crate) struct SharedDict<V> {
    shared: Rc<RefCell<Rc<DictEntries<V>>>>,
    pub from_yaml: bool,
}

impl<V: Clone> SharedDict<V> {
    pub fn new(entries: DictEntries<V>) -> Self {
        SharedDict { shared: Rc::new(RefCell::new(Rc::new(entries))), from_yaml: false }
    }

    pub fn entries(&self) -> Rc<DictEntries<V>> {
        self.shared.borrow().clone()
    }

    pub fn len(&self) -> usize {
        self.shared.borrow().len()
    }

    pub fn depth(&self) -> usize {
        self.shared.borrow().depth + 1
    }

    /// A copy that is not shared, with the same entries.
    pub fn wrapped(&self) -> Self {
        SharedDict { shared: Rc::new(RefCell::new(self.entries())), from_yaml: true }
    }

    /// Replaces the entries for all who share the dictionary; they may not contain lists that were not in it.
    pub fn replace(&self, entries: DictEntries<V>) {
        self.shared.replace(Rc::new(entries));
    }

    /// Removes an entry for all who share the dictionary.
    pub fn remove(&self, key: &EntryKey, budget: &mut Budget) -> Result<Option<V>> {
        budget.spend(1)?;
        let mut cell = self.shared.borrow_mut();
        if Rc::strong_count(&cell) > 1 {
            budget.items(cell.len())?;
        }
        Ok(Rc::make_mut(&mut cell).remove(key))
    }
}
