//! Options and single runs of scripts from outside the document (add-ons); `life` attaches them.

use tatu_plugin_api::safe::Value;

use super::World;
use crate::cell::Scripts;

impl World {
    /// Runs the source of an attached script that has not begun, then the given callback. Returns the result of the
    /// callback if it is a map. Use a separate world for this: the script's state is no longer fresh afterwards.
    pub fn ask(&self, slot: u32, callback: &str) -> Option<Value> {
        Scripts::ask_first(&self.cell, slot, callback)
    }

    /// Runs an attached script once and removes it. It is meant for a function, which has no life cycle.
    pub fn run_once(&self, slot: u32) {
        Scripts::run_once(&self.cell, slot);
        self.cell.run.outside.options.borrow_mut().remove(&slot);
    }

    /// Sets the options of an attached script before it begins, as keys and texts. If a key is repeated, the last value
    /// is used.
    pub fn give_options(&self, slot: u32, options: &[(String, String)]) {
        let mut all: Vec<(Value, Value)> = Vec::new();
        for (key, value) in options {
            let key = Value::text(key);
            all.retain(|(k, _)| *k != key);
            all.push((key, Value::text(value)));
        }
        self.cell.run.outside.options.borrow_mut().insert(slot, Value::Map(all));
    }
}
