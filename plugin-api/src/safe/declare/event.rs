//! Declarations of the events that a plugin publishes.

use crate::abi::*;
use crate::safe::{Param, value::table_arena::TableArena};

/// An event that a plugin publishes with [`World::publish`](crate::safe::World::publish).
pub struct Event {
    name: String,
    text: String,
    fields: Vec<Param>,
}

impl Event {
    /// Creates an event. Its name begins with the plugin's namespace: "gripper.closed".
    pub fn new(name: impl Into<String>) -> Self {
        Event { name: name.into(), text: String::new(), fields: Vec::new() }
    }
    /// Sets the description: one sentence that states when the event is published.
    pub fn text(mut self, text: impl Into<String>) -> Self {
        self.text = text.into();
        self
    }
    /// Adds the next field of its payload.
    pub fn field(mut self, field: Param) -> Self {
        self.fields.push(field);
        self
    }

    pub(crate) fn into_table(self, keep: &mut TableArena) -> *const tatu_event {
        let fields = self.fields.iter().map(|f| f.to_table(keep)).collect();
        let raw = tatu_event {
            size: size_of::<tatu_event>() as u32,
            reserved: 0,
            name: keep.text(&self.name),
            text: keep.text(&self.text),
            fields: keep.list(fields),
        };
        keep.table(raw)
    }
}
