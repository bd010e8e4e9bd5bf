//! Declarations of the events that a plugin publishes, and the events that it receives.

use std::{ffi::c_void, ops::Deref};

use crate::abi::*;
use crate::safe::{
    Heard, Param, PerWorld, Plugin, ValueRef, World,
    declare::plugin::StartedPlugin,
    entry::{
        life::{self, WorldState},
        panics,
    },
    value::{fail::bytes_of, table_arena::TableArena},
};

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

impl<'a, P: Plugin> Deref for Heard<'a, P> {
    type Target = World<'a>;
    fn deref(&self) -> &World<'a> {
        &self.world
    }
}

impl<'a, P: Plugin> Heard<'a, P> {
    /// Returns the plugin.
    pub fn plugin(&self) -> &'a P {
        self.plugin
    }
    /// Returns the name of the event.
    pub fn name(&self) -> &'a str {
        self.name
    }
    /// Returns the payload, a map.
    pub fn payload(&self) -> ValueRef<'a> {
        self.payload
    }
    /// Returns the plugin's state of this world, or `None` if the plugin has not called
    /// [`Offer::per_world`](crate::safe::Offer::per_world).
    pub fn instance(&self) -> Option<&'a P::World>
    where
        P: PerWorld,
    {
        // SAFETY: `instance` is null or the `data` that `create` made for this plugin, which lives until the world ends.
        (!self.instance.is_null()).then(|| unsafe { &life::instance_at::<WorldState<P>>(self.instance).0 })
    }
}

pub(crate) unsafe extern "C" fn heard<P: Plugin>(
    me: *mut c_void,
    instance: *mut c_void,
    _: *mut c_void,
    world: *mut tatu_world,
    name: tatu_str,
    payload: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: `me` was created by `init` and is live; the world, the name and the payload are valid during the call.
        let (started, world, name, payload) = unsafe {
            let started = &*me.cast::<StartedPlugin<P>>();
            (started, World::new(world, &started.host), bytes_of(name), ValueRef::slice(payload, 1))
        };
        if let Some(heard) = started.heard {
            let (name, payload) = (String::from_utf8_lossy(name), payload.first().copied().unwrap_or(ValueRef::NIL));
            heard(&Heard { world, plugin: &started.plugin, instance, name: &name, payload })?;
        }
        Ok(TATU_OK)
    })
}
