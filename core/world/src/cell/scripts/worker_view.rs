//! A worker's view of its world, and the effects of its scripts (see `worker`).

use std::{
    cell::{Cell, Ref, RefCell},
    ops::Deref,
    ptr::null_mut,
};

use tatu_errors::Fault;
use tatu_plugin_api::abi::*;
use tatu_plugins::border::ErrorSlot;
use tatu_scene::property_table::Property;

use crate::cell::records::lines::MAX_LINES;

/// An effect of a parallel script, to be applied to the world.
pub(crate) enum DeferredEffect {
    /// An effect that has already been applied.
    Done,
    /// The script logged a line at this level.
    Line(u32, String),
    /// A fault was reported, such as the failure of a command that the script called by an old-style name.
    Fault(Box<Fault>),
    /// The script set a property of a joint's drive.
    Set(tatu_object, Property, f64),
    /// The script failed: its position in the order, the status, its error, and the command that caused it.
    Failed(usize, tatu_status, Box<(ErrorSlot, Option<(String, String)>)>),
    /// The script, given by its position in the order, requested its end or restart.
    Settle(usize),
    /// The script, given by its position in the order, cannot run in parallel at present.
    Alone(usize),
}

/// The state that makes a cell a worker.
pub(crate) struct WorkerView {
    world: Cell<*mut tatu_world>,
    effects: RefCell<Vec<DeferredEffect>>,
    /// Values of drive properties that the running script has set, with one entry per property.
    own: RefCell<Vec<(tatu_object, Property, f64)>>,
    /// Number of lines logged by the scripts of the chunk.
    lines: Cell<usize>,
    /// Index of the first effect of the running script.
    begun: Cell<usize>,
    /// Chunks of scripts that this worker ran, each with the index of its first effect.
    pub chunks: RefCell<Vec<(usize, usize)>>,
}

impl WorkerView {
    pub fn new() -> Self {
        WorkerView {
            world: Cell::new(null_mut()),
            effects: RefCell::default(),
            own: RefCell::default(),
            lines: Cell::default(),
            begun: Cell::default(),
            chunks: RefCell::default(),
        }
    }
    /// Returns the pointer to the world that plugins receive.
    pub fn world(&self) -> *mut tatu_world {
        self.world.get()
    }
    /// Prepares the worker for a stage of a world.
    pub fn begin(&self, world: *mut tatu_world) {
        self.world.set(world);
        self.effects.borrow_mut().clear();
        self.chunks.borrow_mut().clear();
    }
    /// Takes all effects, and the chunks that they belong to.
    pub fn take(&self) -> (Vec<DeferredEffect>, Vec<(usize, usize)>) {
        (self.effects.take(), self.chunks.take())
    }
    /// Returns a vector of effects to the worker, which clears it and reuses its allocation.
    pub fn reuse(&self, mut effects: Vec<DeferredEffect>) {
        effects.clear();
        self.effects.replace(effects);
    }
    /// Starts a chunk, to which the scripts that run next belong.
    pub fn begin_chunk(&self, chunk: usize) {
        self.chunks.borrow_mut().push((chunk, self.effects.borrow().len()));
        self.lines.set(0);
    }
    /// Starts a script.
    pub fn begin_script(&self) {
        self.begun.set(self.effects.borrow().len());
    }
    /// Ends the running script, and converts the values that it has set to effects.
    pub fn end_script(&self) {
        let mut own = self.own.borrow_mut();
        self.effects.borrow_mut().extend(own.drain(..).map(|(object, row, x)| DeferredEffect::Set(object, row, x)));
    }
    /// Records an effect of the running script. Limits the number of log lines of a chunk as the world does, and only
    /// counts repeats of a fault.
    pub fn note(&self, effect: DeferredEffect) {
        let mut effects = self.effects.borrow_mut();
        match &effect {
            DeferredEffect::Line(..) if self.lines.replace(self.lines.get() + 1) > MAX_LINES => return,
            DeferredEffect::Fault(new) => {
                let begun = self.begun.get().min(effects.len());
                let known = effects[begun..].iter_mut().find_map(|effect| match effect {
                    DeferredEffect::Fault(known) if known.same_as(new) => Some(known),
                    _ => None,
                });
                if let Some(known) = known {
                    known.count += 1;
                    return;
                }
            }
            _ => {}
        }
        effects.push(effect);
    }
    pub fn set(&self, object: tatu_object, row: Property, x: f64) {
        let mut own = self.own.borrow_mut();
        match own.iter_mut().find(|(o, r, _)| (*o, *r) == (object, row)) {
            Some(known) => known.2 = x,
            None => own.push((object, row, x)),
        }
    }
    /// Returns the value that the running script has set for a property of an object, if any.
    pub fn number(&self, slot: u32, row: Property) -> Option<f64> {
        let own = self.own.borrow();
        own.iter().find(|(o, r, _)| tatu_slot(*o) == slot && *r == row).map(|(_, _, x)| *x)
    }
}

/// A shared borrow of a part of the world.
pub(crate) enum PartRef<'a, T> {
    /// A borrow taken by the world's own thread.
    Own(Ref<'a, T>),
    /// A reference taken by one of several worker threads.
    Shared(&'a T),
}

impl<T> Deref for PartRef<'_, T> {
    type Target = T;
    #[inline]
    fn deref(&self) -> &T {
        match self {
            PartRef::Own(part) => part,
            PartRef::Shared(part) => part,
        }
    }
}
