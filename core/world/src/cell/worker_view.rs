//! What a worker sees of its world, and what its scripts did (see `script_worker`).

use std::{
    cell::{Cell, Ref, RefCell},
    ops::Deref,
    ptr::null_mut,
};

use tatu_errors::Fault;
use tatu_plugin_api::abi::*;
use tatu_plugins::border::ErrorSlot;
use tatu_scene::rows::Row;

use super::lines::MAX_LINES;

/// What a script did, to be done to the world.
pub(crate) enum DeferredEffect {
    /// It has been done.
    Done,
    /// It logged a line of a level.
    Line(u32, String),
    /// A command that it called failed, and gave a value all the same.
    Fault(Box<Fault>),
    /// It set a number of a joint's drive.
    Set(tatu_object, Row, f64),
    /// An error left it: its place in the order, the status, and what was said.
    Failed(usize, tatu_status, Box<(ErrorSlot, Option<(String, String)>)>),
    /// It asked for its end.
    Settle(usize),
    /// It is none that can run beside others now.
    Alone(usize),
}

/// The part of a cell that makes it a worker.
pub(crate) struct WorkerView {
    world: Cell<*mut tatu_world>,
    effects: RefCell<Vec<DeferredEffect>>,
    /// What the running script has set: each number once.
    own: RefCell<Vec<(tatu_object, Row, f64)>>,
    /// Lines that the scripts of the chunk have logged.
    lines: Cell<usize>,
    /// Where the effects of the running script begin.
    begun: Cell<usize>,
    /// Chunks of scripts that have run here, and where their effects begin.
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
    /// The world itself, for plugins to know it by.
    pub fn world(&self) -> *mut tatu_world {
        self.world.get()
    }
    /// A stage of a world begins.
    pub fn begin(&self, world: *mut tatu_world) {
        self.world.set(world);
        self.effects.borrow_mut().clear();
        self.chunks.borrow_mut().clear();
    }
    /// The effects of its chunks.
    pub fn take(&self) -> (Vec<DeferredEffect>, Vec<(usize, usize)>) {
        (self.effects.take(), self.chunks.take())
    }
    /// Takes the memory of effects back.
    pub fn reuse(&self, mut effects: Vec<DeferredEffect>) {
        effects.clear();
        self.effects.replace(effects);
    }
    /// The next scripts are those of a chunk.
    pub fn begin_chunk(&self, chunk: usize) {
        self.chunks.borrow_mut().push((chunk, self.effects.borrow().len()));
        self.lines.set(0);
    }
    /// Another script begins.
    pub fn begin_script(&self) {
        self.begun.set(self.effects.borrow().len());
    }
    /// The script has run: what it has set becomes effects.
    pub fn end_script(&self) {
        let mut own = self.own.borrow_mut();
        self.effects.borrow_mut().extend(own.drain(..).map(|(object, row, x)| DeferredEffect::Set(object, row, x)));
    }
    /// Notes a effect of the running script. Of lines no more than the world would keep of the chunk's; of equal faults one.
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
    pub fn set(&self, object: tatu_object, row: Row, x: f64) {
        let mut own = self.own.borrow_mut();
        match own.iter_mut().find(|(o, r, _)| (*o, *r) == (object, row)) {
            Some(known) => known.2 = x,
            None => own.push((object, row, x)),
        }
    }
    /// What the running script has set a number of an object to.
    pub fn number(&self, slot: u32, row: Row) -> Option<f64> {
        let own = self.own.borrow();
        own.iter().find(|(o, r, _)| tatu_slot(*o) == slot && *r == row).map(|(_, _, x)| *x)
    }
}

/// A part of the world that is looked at.
pub(crate) enum PartRef<'a, T> {
    /// By its only thread.
    Own(Ref<'a, T>),
    /// By one of several.
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
