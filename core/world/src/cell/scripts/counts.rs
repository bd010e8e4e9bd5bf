//! Counts the calls of scripts, for the summary of a run.

use std::{cell::RefCell, collections::BTreeMap};

/// The activity of one script since its world was created.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptSummary {
    /// Path of the object that the script belongs to.
    pub object: String,
    /// Kind of the script, such as "child", "customization" or "main".
    pub kind: String,
    /// The dialect chosen for the script; empty if it could not be loaded.
    pub dialect: String,
    /// Number of calls, by callback.
    pub calls: BTreeMap<String, u64>,
    /// Instructions executed, as the language counts them.
    pub instructions: u64,
}

/// Numbers of calls of a script, by callback.
#[derive(Debug, Default)]
pub(crate) struct CallCounts {
    /// Counts by callback. They are searched linearly, because there are few of them and the frequent ones are first.
    counts: RefCell<Vec<CallbackCount>>,
    pub dialect: RefCell<String>,
}

#[derive(Debug)]
struct CallbackCount {
    /// The language's id of the callback, or 0 if it has none at present.
    id: u32,
    calls: u64,
    name: String,
}

impl CallCounts {
    /// Records the id that the language has assigned to a callback.
    pub fn set_id(&self, id: u32, name: &[u8]) {
        let mut counts = self.counts.borrow_mut();
        if id == 0 || counts.iter().any(|c| c.id == id) {
            return;
        }
        let name = String::from_utf8_lossy(name);
        match counts.iter_mut().find(|c| c.name == name && c.id == 0) {
            Some(count) => count.id = id,
            None => counts.push(CallbackCount { id, calls: 0, name: name.into_owned() }),
        }
    }
    /// Counts a call of the callback with this id.
    pub fn count(&self, id: u32) {
        if let Some(count) = self.counts.borrow_mut().iter_mut().find(|c| c.id == id) {
            count.calls += 1;
        }
    }
    /// Returns the number of calls of each callback.
    pub fn calls(&self) -> BTreeMap<String, u64> {
        let mut calls = BTreeMap::new();
        for count in self.counts.borrow().iter().filter(|c| c.calls > 0) {
            *calls.entry(count.name.clone()).or_insert(0) += count.calls;
        }
        calls
    }
    /// Restores the counts that `calls` returned.
    pub fn restore(&self, calls: BTreeMap<String, u64>) {
        let mut counts = self.counts.borrow_mut();
        counts.iter_mut().for_each(|c| c.calls = 0);
        for (name, calls) in calls {
            match counts.iter_mut().find(|c| c.name == name) {
                Some(count) => count.calls = calls,
                None => counts.push(CallbackCount { id: 0, calls, name }),
            }
        }
    }
    /// Clears all ids, because the next instance assigns new ones.
    pub fn clear_ids(&self) {
        self.counts.borrow_mut().iter_mut().for_each(|c| c.id = 0);
    }
}
