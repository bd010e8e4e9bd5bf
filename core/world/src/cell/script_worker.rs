//! What a thread sees of a world while it runs scripts beside those of other threads (see `scripts::beside`).
//!
//! Such scripts do not touch the world. Their thread is in a *worker*: a cell of its own, with its own stack of calls,
//! errors and lines, which takes the world's place in every service. It looks at the world as it stood when the stage
//! began, through shared references. What scripts set, say and do wrong is noted as a [`DeferredEffect`], and done to
//! the world in the order of the scripts when all of them have run: what comes out does not depend on the number of
//! workers. Whatever else would change the world is refused.

use std::{
    cell::{Cell, RefCell},
    ptr::null,
};

use tatu_scene::{is_drive, rows::Row};

use super::{
    living,
    worker_view::{DeferredEffect, PartRef, WorkerView},
    world::{ScriptWorker, WorldCell},
};

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

impl ScriptWorker {
    /// A worker of a world.
    pub fn of(world: &WorldCell) -> Self {
        let settings = world.model.settings.borrow().clone();
        let (registry, document) = (world.model.registry.shared(), world.model.document.shared());
        let mut cell =
            WorldCell::new(document, registry, settings, Default::default(), Vec::new(), world.run.pool.clone());
        cell.border.watch = world.border.watch.beside(&world.model.registry.watches);
        cell.worker = Some(Box::new(WorkerView::new()));
        let cell = Box::new(cell);
        // What is not looked at through the world counts as in use: services that try refuse.
        std::mem::forget((
            cell.state.scene.borrow_mut(),
            cell.state.dynamics.borrow_mut(),
            cell.devices.sensing.borrow_mut(),
        ));
        std::mem::forget((
            cell.devices.actuators.borrow_mut(),
            cell.run.scripts.borrow_mut(),
            cell.state.signals.borrow_mut(),
        ));
        std::mem::forget((cell.devices.figures.borrow_mut(), cell.model.settings.borrow_mut()));
        ScriptWorker(cell)
    }

    /// At the start of a stage: updates the worker from the world.
    pub fn begin(&self, world: &WorldCell) {
        let cell = &*self.0;
        if !std::ptr::eq(&raw const *cell.model.registry, &raw const *world.model.registry) {
            cell.model.registry.set(world.model.registry.shared());
        }
        if !std::ptr::eq(&raw const *cell.model.document, &raw const *world.model.document) {
            cell.model.document.set(world.model.document.shared());
        }
        cell.state.clock.like(&world.state.clock);
        cell.state.phase.set(world.state.phase.get());
        cell.run.outside.clock.set(world.run.outside.clock.get());
        cell.run.outside.epoch.set(world.run.outside.epoch.get());
        cell.border.suspicious.set(world.border.suspicious.get());
        let Some(worker) = &cell.worker else { return };
        worker.begin(world.raw());
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
        living::forget();
        let _inside = Inside(WORKER.replace(&raw const *self.0));
        Some(f(&self.0, worker))
    }

    /// The effects of its chunks, and what it found about the floating-point mode.
    pub fn end(&self, world: &WorldCell) -> (Vec<DeferredEffect>, Vec<(usize, usize)>) {
        world.border.called.set(world.border.called.get() | self.0.border.called.take());
        if self.0.border.suspicious.get() {
            world.border.suspicious.set(true);
        }
        let Some(worker) = &self.0.worker else { return Default::default() };
        worker.take()
    }

    /// Takes the memory of effects back.
    pub fn reuse(&self, effects: Vec<DeferredEffect>) {
        if let Some(worker) = &self.0.worker {
            worker.reuse(effects);
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
            Some(worker) => unsafe {
                worker.world().cast::<WorldCell>().as_ref().map(|w| PartRef::Shared(&*part(w).as_ptr()))
            },
        }
    }

    /// In a worker: sets a number of a joint's drive, when all scripts of the stage have run. `Err`: why not.
    pub fn set_later(&self, slot: u32, row: Row, x: f64) -> Result<(), String> {
        let joint = self.see(|w| &w.state.scene).filter(|s| s.is_joint(slot)).map(|s| s.id(slot));
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
