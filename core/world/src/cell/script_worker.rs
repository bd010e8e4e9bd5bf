//! What a thread sees of a world while it runs scripts beside those of other threads (see `scripts::beside`).
//!
//! Such scripts do not touch the world. Their thread is in a *worker*: a cell of its own, with its own stack of calls,
//! errors and lines, which takes the world's place in every service. It looks at the world as it stood when the stage
//! began, through shared references. What scripts set, say and do wrong is noted as a [`DeferredEffect`], and done to the world in
//! the order of the scripts when all of them have run: what comes out does not depend on the number of workers. Whatever
//! else would change the world is refused.

use std::{
    cell::{Cell, Ref, RefCell},
    ops::Deref,
    ptr::null,
};

use tatu_errors::Fault;
use tatu_plugin_api::abi::*;
use tatu_plugins::border::ErrorSlot;
use tatu_scene::{is_drive, rows::Row};

use crate::cell::{WorldCell, report::MAX_LINES};

thread_local! {
    /// The worker that this thread is in.
    static WORKER: Cell<*const WorldCell> = const { Cell::new(null()) };
}

/// The cell of the worker that this thread is in.
#[inline]
pub(crate) fn of_this_thread<'a>() -> Option<&'a WorldCell> {
    // SAFETY: set by `ScriptWorker::enter` only, for as long as the worker is borrowed.
    unsafe { WORKER.get().as_ref() }
}

/// What a script did, to be done to the world.
pub(crate) enum DeferredEffect {
    /// It has been done.
    Done,
    /// It told a line of a level.
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

/// A worker of a world; its cell stays where it is.
pub(crate) struct ScriptWorker(Box<WorldCell>);

/// The part of a cell that makes it a worker.
pub(crate) struct WorkerView {
    world: Cell<*const WorldCell>,
    effects: RefCell<Vec<DeferredEffect>>,
    /// What the running script has set: each number once.
    own: RefCell<Vec<(tatu_object, Row, f64)>>,
    /// Lines that the scripts of the chunk have told.
    lines: Cell<usize>,
    /// Where the effects of the running script begin.
    begun: Cell<usize>,
    /// Chunks of scripts that have run here, and where their effects begin.
    pub chunks: RefCell<Vec<(usize, usize)>>,
}

impl ScriptWorker {
    /// A worker of a world.
    pub fn of(world: &WorldCell) -> Self {
        let settings = world.settings.borrow().clone();
        let (registry, document) = (world.registry.shared(), world.document.shared());
        let mut cell = WorldCell::new(document, registry, settings, Default::default(), Vec::new(), world.pool.clone());
        cell.watch = world.watch.beside(&world.registry.watches);
        cell.worker = Some(Box::new(WorkerView {
            world: Cell::new(null()),
            effects: RefCell::default(),
            own: RefCell::default(),
            lines: Cell::new(0),
            begun: Cell::new(0),
            chunks: RefCell::default(),
        }));
        let cell = Box::new(cell);
        // What is not looked at through the world counts as in use: services that try refuse.
        std::mem::forget((cell.scene.borrow_mut(), cell.dynamics.borrow_mut(), cell.sensing.borrow_mut()));
        std::mem::forget((cell.actuators.borrow_mut(), cell.scripts.borrow_mut(), cell.signals.borrow_mut()));
        std::mem::forget((cell.figures.borrow_mut(), cell.settings.borrow_mut()));
        ScriptWorker(cell)
    }

    /// A stage begins: the worker takes up what the world is now.
    pub fn begin(&self, world: &WorldCell) {
        let cell = &*self.0;
        if !std::ptr::eq(&raw const *cell.registry, &raw const *world.registry) {
            cell.registry.set(world.registry.shared());
        }
        if !std::ptr::eq(&raw const *cell.document, &raw const *world.document) {
            cell.document.set(world.document.shared());
        }
        cell.clock.like(&world.clock);
        cell.phase.set(world.phase.get());
        cell.outside.clock.set(world.outside.clock.get());
        cell.outside.epoch.set(world.outside.epoch.get());
        cell.suspicious.set(world.suspicious.get());
        let Some(worker) = &cell.worker else { return };
        worker.world.set(world);
        worker.effects.borrow_mut().clear();
        worker.chunks.borrow_mut().clear();
    }

    /// Runs something in the worker.
    ///
    /// # Safety
    /// The world that the worker began with is not changed meanwhile.
    pub unsafe fn enter<T>(&self, f: impl FnOnce(&WorldCell, &WorkerView) -> T) -> Option<T> {
        /// Leaves it, however it is left.
        struct Inside(*const WorldCell);
        impl Drop for Inside {
            fn drop(&mut self) {
                WORKER.set(self.0);
            }
        }
        let worker = self.0.worker.as_deref()?;
        super::scope::forget();
        let _inside = Inside(WORKER.replace(&raw const *self.0));
        Some(f(&self.0, worker))
    }

    /// The effects of its chunks, and what it found about the floating-point mode.
    pub fn end(&self, world: &WorldCell) -> (Vec<DeferredEffect>, Vec<(usize, usize)>) {
        world.called.set(world.called.get() | self.0.called.take());
        if self.0.suspicious.get() {
            world.suspicious.set(true);
        }
        let Some(worker) = &self.0.worker else { return Default::default() };
        (worker.effects.take(), worker.chunks.take())
    }

    /// Takes the memory of effects back.
    pub fn reuse(&self, mut effects: Vec<DeferredEffect>) {
        if let Some(worker) = &self.0.worker {
            effects.clear();
            worker.effects.replace(effects);
        }
    }
}

impl WorkerView {
    /// The world itself, for plugins to know it by.
    pub fn world(&self) -> *const WorldCell {
        self.world.get()
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
    fn set(&self, object: tatu_object, row: Row, x: f64) {
        let mut own = self.own.borrow_mut();
        match own.iter_mut().find(|(o, r, _)| (*o, *r) == (object, row)) {
            Some(known) => known.2 = x,
            None => own.push((object, row, x)),
        }
    }
    /// What the running script has set a number of an object to.
    pub fn number(&self, slot: u32, row: Row) -> Option<f64> {
        let own = self.own.borrow();
        own.iter().find(|(o, r, _)| (o & 0xF_FFFF == u64::from(slot)) && *r == row).map(|(_, _, x)| *x)
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

impl WorldCell {
    /// A look at a part of the world; `None`: it is in use by a caller further up.
    #[inline]
    pub fn see<T>(&self, part: impl Fn(&WorldCell) -> &RefCell<T>) -> Option<PartRef<'_, T>> {
        match &self.worker {
            None => part(self).try_borrow().ok().map(PartRef::Own),
            // SAFETY: nobody changes the world while its workers are in use (`ScriptWorker::enter`).
            Some(worker) => unsafe { worker.world.get().as_ref().map(|w| PartRef::Shared(&*part(w).as_ptr())) },
        }
    }

    /// In a worker: sets a number of a joint's drive, when all scripts of the stage have run. `Err`: why not.
    pub fn set_later(&self, slot: u32, row: Row, x: f64) -> Result<(), String> {
        let joint = self.see(|w| &w.scene).filter(|s| s.is_joint(slot)).map(|s| s.id(slot));
        match (&self.worker, joint.filter(|_| is_drive(row))) {
            _ if !x.is_finite() => Err(format!("`{}`: expected finite numbers", row.info().key)),
            (Some(worker), Some(joint)) => {
                // As it would be kept.
                worker.set(joint, row, if row == Row::Slip { x.max(0.0) } else { x });
                Ok(())
            }
            _ => Err(format!("scripts that run side by side with others do not set `{}`", row.info().key)),
        }
    }
}
