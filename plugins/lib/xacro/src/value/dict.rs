//! Dictionaries: keys in order of insertion.

use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

use super::Value;
use crate::{
    error::{Result, fail},
    limits::{Budget, MAX_NESTING},
};

/// A key in a form in which equal keys are the same: 1, 1.0 and True are one key.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    None,
    Int(i64),
    Float(u64),
    Text(Rc<str>),
    Tuple(Vec<Key>),
}

impl Key {
    fn of(value: &Value, budget: &mut Budget) -> Result<Self> {
        budget.spend(1)?;
        Ok(match value {
            Value::None => Key::None,
            Value::Bool(b) => Key::Int(i64::from(*b)),
            Value::Int(i) => Key::Int(*i),
            Value::Float(f) => super::number::exact_int(*f).map_or_else(|| Key::Float(f.to_bits()), Key::Int),
            Value::Text(text) => Key::Text(text.clone()),
            Value::Tuple(items) => {
                Key::Tuple(items.items.iter().map(|item| Key::of(item, budget)).collect::<Result<_>>()?)
            }
            other => fail!("a {} cannot be the key of a dictionary", other.kind()),
        })
    }
}

/// The contents of a dictionary.
#[derive(Clone, Debug, Default)]
pub(crate) struct Entries {
    /// Removed entries are `None`.
    list: Vec<Option<(Key, Value, Value)>>,
    index: BTreeMap<Key, usize>,
    depth: usize,
}

impl Entries {
    pub fn len(&self) -> usize {
        self.index.len()
    }

    pub fn get(&self, key: &EntryKey) -> Option<&Value> {
        let slot = self.list.get(*self.index.get(&key.0)?)?;
        slot.as_ref().map(|(_, _, value)| value)
    }

    pub fn set(&mut self, key: Value, value: Value, budget: &mut Budget) -> Result<()> {
        budget.items(self.len())?;
        self.depth = self.depth.max(key.depth()).max(value.depth());
        if self.depth >= MAX_NESTING {
            fail!("dictionaries are nested deeper than {MAX_NESTING}");
        }
        let hashed = Key::of(&key, budget)?;
        match self.index.get(&hashed).and_then(|slot| self.list.get_mut(*slot)) {
            // As in Python, the first key stays.
            Some(Some((_, _, old))) => *old = value,
            _ => {
                self.index.insert(hashed.clone(), self.list.len());
                self.list.push(Some((hashed, key, value)));
            }
        }
        Ok(())
    }

    fn remove(&mut self, key: &EntryKey) -> Option<Value> {
        let slot = self.index.remove(&key.0)?;
        let (_, _, value) = self.list.get_mut(slot)?.take()?;
        if self.list.len() > 2 * self.index.len() + 8 {
            self.list.retain(Option::is_some);
            self.index = (0..).zip(self.list.iter().flatten()).map(|(i, (key, _, _))| (key.clone(), i)).collect();
        }
        Some(value)
    }

    /// Keys for lookups, and values, in order.
    pub fn iter(&self) -> impl Iterator<Item = (EntryKey, &Value)> {
        self.list.iter().flatten().map(|(key, _, value)| (EntryKey(key.clone()), value))
    }

    /// Keys as values, and values, in order.
    pub fn pairs(&self) -> impl Iterator<Item = (&Value, &Value)> {
        self.list.iter().flatten().map(|(_, key, value)| (key, value))
    }
}

/// A key for lookups.
pub(crate) struct EntryKey(Key);

impl EntryKey {
    pub fn new(value: &Value, budget: &mut Budget) -> Result<Self> {
        Ok(EntryKey(Key::of(value, budget)?))
    }
}

/// A dictionary, which its owners share. If it is from YAML, `d.name` is `d['name']`, and values are wrapped when they
/// are taken out.
#[derive(Clone, Debug)]
pub(crate) struct Dict {
    shared: Rc<RefCell<Rc<Entries>>>,
    pub from_yaml: bool,
}

impl Dict {
    pub fn new(entries: Entries) -> Self {
        Dict { shared: Rc::new(RefCell::new(Rc::new(entries))), from_yaml: false }
    }

    pub fn entries(&self) -> Rc<Entries> {
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
        Dict { shared: Rc::new(RefCell::new(self.entries())), from_yaml: true }
    }

    /// Replaces the entries for all who share the dictionary; they may not contain lists that were not in it.
    pub fn replace(&self, entries: Entries) {
        self.shared.replace(Rc::new(entries));
    }

    /// Removes an entry for all who share the dictionary.
    pub fn remove(&self, key: &EntryKey, budget: &mut Budget) -> Result<Option<Value>> {
        budget.spend(1)?;
        let mut cell = self.shared.borrow_mut();
        if Rc::strong_count(&cell) > 1 {
            budget.items(cell.len())?;
        }
        Ok(Rc::make_mut(&mut cell).remove(key))
    }
}
