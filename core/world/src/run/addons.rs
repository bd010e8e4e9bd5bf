//! Scripts that come from outside the document (add-ons): their options and single runs; `life` attaches them.

use tatu_plugin_api::safe::Value;

use super::World;
use crate::cell::Scripts;

impl World {
    /// Asks an attached script that has not begun: its text is run, then this callback; its answer, if that is a map.
    /// For a world of its own: the script has run once, and its state is not fresh any more.
    pub fn ask(&self, slot: u32, callback: &str) -> Option<Value> {
        Scripts::ask_first(&self.cell, slot, callback)
    }

    /// Runs an attached script once, and removes it: the text of a function, which has no life of its own.
    pub fn run_once(&self, slot: u32) {
        Scripts::run_once(&self.cell, slot);
        self.cell.run.outside.options.borrow_mut().remove(&slot);
    }

    /// What an attached script is started with, before it begins: keys and texts, of equal keys the last counts.
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
