//! Options and single runs of add-ons, which are scripts that are not part of the document. `life` attaches them.

use tatu_plugin_api::safe::Value;

use super::World;
use crate::cell::Scripts;

impl World {
    /// Runs the source of an attached script that has not begun, then the given callback. Returns the result of the
    /// callback if it is a map. Use a separate world for this, because the script's state is no longer fresh
    /// afterwards.
    pub fn query_script(&self, slot: u32, callback: &str) -> Option<Value> {
        Scripts::call_first(&self.cell, slot, callback)
    }

    /// Runs an attached script once, up to its `init`, and removes it. This is meant for add-ons that are single
    /// functions, without a life cycle.
    pub fn run_once(&self, slot: u32) {
        Scripts::run_once(&self.cell, slot);
        self.cell.run.connections.options.borrow_mut().remove(&slot);
    }

    /// Sets the options of an attached script, as keys and values, before it begins. If a key is repeated, its last
    /// value is used.
    pub fn set_script_options(&self, slot: u32, options: &[(String, String)]) {
        let mut all: Vec<(Value, Value)> = Vec::new();
        for (key, value) in options {
            let key = Value::text(key);
            all.retain(|(k, _)| *k != key);
            all.push((key, Value::text(value)));
        }
        self.cell.run.connections.options.borrow_mut().insert(slot, Value::Map(all));
    }
}
