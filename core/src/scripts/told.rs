//! What scripts did, for the summary of a run.

use std::{cell::RefCell, collections::BTreeMap};

use super::{Script, Scripts};
use crate::world::WorldCell;

/// What one script did since its world began.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptTold {
    /// Path of the object that it belongs to.
    pub object: String,
    /// "child", "customization", "main", ...
    pub kind: String,
    /// The dialect chosen for it; empty: it could not be loaded.
    pub dialect: String,
    /// How often each of its callbacks was called.
    pub calls: BTreeMap<String, u64>,
    /// Instructions that it used, as its language counts them.
    pub instructions: u64,
}

/// Calls by callback.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// The language's numbers, and the callbacks' names.
    names: RefCell<BTreeMap<u32, String>>,
    calls: RefCell<BTreeMap<String, u64>>,
    pub dialect: RefCell<String>,
}

impl Told {
    /// Notes the language's number for a callback.
    pub fn name(&self, id: u32, name: &[u8]) {
        let mut names = self.names.borrow_mut();
        if id != 0 && !names.contains_key(&id) {
            names.insert(id, String::from_utf8_lossy(name).into_owned());
        }
    }
    /// Counts a call of it.
    pub fn count(&self, id: u32) {
        let names = self.names.borrow();
        let Some(name) = names.get(&id) else { return };
        let mut calls = self.calls.borrow_mut();
        match calls.get_mut(name) {
            Some(n) => *n += 1,
            None => drop(calls.insert(name.clone(), 1)),
        }
    }
    /// How often each callback was called.
    pub fn calls(&self) -> BTreeMap<String, u64> {
        self.calls.borrow().clone()
    }
    /// Takes that back.
    pub fn recall(&self, calls: BTreeMap<String, u64>) {
        *self.calls.borrow_mut() = calls;
    }
    /// Forgets the numbers: another instance gives its own.
    pub fn renumber(&self) {
        self.names.borrow_mut().clear();
    }
}

impl Scripts {
    /// What all scripts did that are there, in the order in which they were added.
    pub fn told(world: &WorldCell) -> Vec<ScriptTold> {
        let Ok(scripts) = world.scripts.try_borrow() else { return Vec::new() };
        scripts.list.iter().map(|s| s.tell(world)).collect()
    }
}

impl Script {
    fn tell(&self, world: &WorldCell) -> ScriptTold {
        ScriptTold {
            object: self.owner_path(world),
            kind: self.kind_name.clone(),
            dialect: self.told.dialect.borrow().clone(),
            calls: self.told.calls(),
            instructions: self.instructions.get(),
        }
    }
}
