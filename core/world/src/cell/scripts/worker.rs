//! A thread's view of a world while it runs scripts in parallel with other threads (see `scripts::parallel_scripts`).
//!
//! Parallel scripts do not modify the world. Their thread is in a *worker*: a cell with a separate call stack, errors
//! and lines, which host functions use in place of the world. The worker reads the world through shared references, in
//! its state at the beginning of the stage. Values that the scripts set, lines that they log and their errors are
//! recorded as [`DeferredEffect`]s, which are applied to the world in script order after all scripts have run, so the
//! result does not depend on the number of workers. Any other change of the world is refused.

use std::{
    cell::{Cell, RefCell},
    ptr::null,
};

use tatu_plugin_api::safe::Value;
use tatu_scene::{is_drive_parameter, property_table::Property};

use crate::cell::{
    live_worlds,
    scripts::worker_view::{DeferredEffect, PartRef, WorkerView},
    world::{ScriptWorker, WorldCell},
};

thread_local! {
    /// The worker that this thread is in, or null.
    static CURRENT_WORKER: Cell<*const WorldCell> = const { Cell::new(null()) };
}

/// Returns the cell of the worker that this thread is in.
#[inline]
pub(crate) fn current_worker<'a>() -> Option<&'a WorldCell> {
    // SAFETY: the pointer is null or was set by `ScriptWorker::enter`, which keeps the boxed cell borrowed until it
    // restores the previous pointer.
    unsafe { CURRENT_WORKER.get().as_ref() }
}

impl ScriptWorker {
    /// Creates a worker for a world.
    pub fn of(world: &WorldCell) -> Self {
        let settings = world.model.settings.borrow().clone();
        let (registry, document) = (world.model.registry.shared(), world.model.document.shared());
        let mut cell =
            WorldCell::new(document, registry, settings, Default::default(), Vec::new(), world.run.pool.clone());
        cell.monitor.watch = world.monitor.watch.for_parallel_thread(&world.model.registry.call_watches.watches);
        cell.worker = Some(Box::new(WorkerView::new()));
        let cell = Box::new(cell);
        // Parts of the cell that workers read from the world instead remain borrowed forever, so that host functions
        // that try to use the cell's own parts are refused.
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

    /// Updates the worker from the world at the start of a stage.
    pub fn begin(&self, world: &WorldCell) {
        let cell = &*self.0;
        if !std::ptr::eq(&raw const *cell.model.registry, &raw const *world.model.registry) {
            cell.model.registry.set(world.model.registry.shared());
        }
        if !std::ptr::eq(&raw const *cell.model.document, &raw const *world.model.document) {
            cell.model.document.set(world.model.document.shared());
        }
        cell.state.clock.copy_from(&world.state.clock);
        cell.state.phase.set(world.state.phase.get());
        cell.run.connections.clocks.clock.set(world.run.connections.clocks.clock.get());
        cell.run.connections.clocks.epoch.set(world.run.connections.clocks.epoch.get());
        cell.monitor.suspicious.set(world.monitor.suspicious.get());
        let Some(worker) = &cell.worker else { return };
        worker.begin(world.raw());
    }

    /// Runs `f` in the worker.
    ///
    /// # Safety
    /// The world that was passed to `begin` must be alive and must not change during the call.
    pub unsafe fn enter<T>(&self, f: impl FnOnce(&WorldCell, &WorkerView) -> T) -> Option<T> {
        /// Restores the previous worker, even on unwinding.
        struct WorkerGuard(*const WorldCell);
        impl Drop for WorkerGuard {
            fn drop(&mut self) {
                CURRENT_WORKER.set(self.0);
            }
        }
        let worker = self.0.worker.as_deref()?;
        live_worlds::clear_last_found();
        let _inside = WorkerGuard(CURRENT_WORKER.replace(&raw const *self.0));
        Some(f(&self.0, worker))
    }

    /// Returns the effects of the worker's scripts and the chunks to which they belong. Passes on to the world which
    /// plugins were called and whether the floating-point mode is suspicious.
    pub fn end(&self, world: &WorldCell) -> (Vec<DeferredEffect>, Vec<(usize, usize)>) {
        world.monitor.called.set(world.monitor.called.get() | self.0.monitor.called.take());
        if self.0.monitor.suspicious.get() {
            world.monitor.suspicious.set(true);
        }
        let Some(worker) = &self.0.worker else { return Default::default() };
        worker.take()
    }

    /// Returns the vector of effects to the worker, which clears it and reuses its allocation.
    pub fn reuse(&self, effects: Vec<DeferredEffect>) {
        if let Some(worker) = &self.0.worker {
            worker.reuse(effects);
        }
    }
}

impl WorldCell {
    /// Borrows a part of the world for reading; returns `None` if a caller further up the stack has borrowed it
    /// mutably.
    #[inline]
    pub fn borrow_part<T>(&self, part: impl Fn(&WorldCell) -> &RefCell<T>) -> Option<PartRef<'_, T>> {
        match &self.worker {
            None => part(self).try_borrow().ok().map(PartRef::Own),
            // SAFETY: `ScriptWorker::enter` guarantees that the world that the pointer refers to is alive and unchanged
            // while its workers run, so shared references to its parts are sound.
            Some(worker) => unsafe {
                worker.world().cast::<WorldCell>().as_ref().map(|w| PartRef::Shared(&*part(w).as_ptr()))
            },
        }
    }

    /// In a worker, records a new value for a property of a joint's drive, which is applied after all scripts of the
    /// stage have run. If it is refused, returns the reason as an error.
    pub fn defer_set(&self, slot: u32, row: Property, x: f64) -> Result<(), String> {
        let joint = self.borrow_part(|w| &w.state.scene).filter(|s| s.is_joint(slot)).map(|s| s.id(slot));
        match (&self.worker, joint.filter(|_| is_drive_parameter(row))) {
            (Some(worker), Some(joint)) => {
                row.check(Value::Float(x))?;
                worker.set(joint, row, x);
                Ok(())
            }
            _ => Err(format!("scripts that run in parallel with others (`side_by_side`) cannot set `{}`", row.key())),
        }
    }
}
