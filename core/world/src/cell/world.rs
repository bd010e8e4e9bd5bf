//! The interior of a world: the components `model`, `state`, `devices` and `run`, whose fields are in separate
//! `RefCell`s.
//!
//! A plugin function can call host functions while it runs. Code that calls such a function therefore holds no borrow;
//! a host function borrows one part, uses it, and releases it.

use std::{cell::RefCell, sync::Arc};

use tatu_plugin_api::abi::*;
use tatu_plugins::Registry;
use tatu_scene::{
    Scene,
    document::{Document, WorldSettings},
};

use crate::cell::{
    calls::monitor::PluginMonitor, devices::WorldDevices, live_worlds, model::WorldModel, phase::Phase,
    run::WorldRuntime, scripts::worker_view::WorkerView, state::SimulationState,
};

/// The interior of a world, at a stable address. Plugins receive a pointer to it, as `tatu_world *`.
pub(crate) struct WorldCell {
    pub model: WorldModel,
    pub state: SimulationState,
    pub devices: WorldDevices,
    pub run: WorldRuntime,
    pub monitor: PluginMonitor,
    /// Cells of the threads that run scripts in parallel, created when first needed.
    pub workers: RefCell<Vec<ScriptWorker>>,
    /// If this cell is such a worker, its view of the world.
    pub worker: Option<Box<WorkerView>>,
}

/// A worker of a world. Its cell is boxed, so its address is stable.
pub(crate) struct ScriptWorker(pub(in crate::cell) Box<WorldCell>);

impl Drop for WorldCell {
    fn drop(&mut self) {
        live_worlds::remove(&raw const *self as *const tatu_world);
    }
}

impl WorldCell {
    /// Creates a cell with a scene, but without devices, scripts and plugin instances. `origins` contains the handle in
    /// the scene of each object of the document.
    pub fn new(
        document: Arc<Document>,
        registry: Arc<Registry>,
        settings: WorldSettings,
        scene: Scene,
        origins: Vec<tatu_object>,
        pool: Arc<rayon::ThreadPool>,
    ) -> Self {
        let run = WorldRuntime::new(document.file.as_deref(), pool);
        registry.listeners.iter().for_each(|l| run.connections.bus.add_natives(&l.names));
        WorldCell {
            state: SimulationState::new(WorldModel::engine_settings(&settings), settings.dt, scene),
            devices: WorldDevices::default(),
            run,
            monitor: PluginMonitor::new(registry.call_watches.watches.add_thread()),
            workers: RefCell::default(),
            worker: None,
            model: WorldModel::new(document, registry, settings, origins),
        }
    }
    /// Returns whether the simulation has been started and is not stopped.
    pub fn running(&self) -> bool {
        self.state.phase.get() != Phase::Stopped
    }
    /// Returns whether a stop has been requested.
    pub fn stop_requested(&self) -> bool {
        self.state.requests.get() & (1 << TATU_REQUEST_STOP | 1 << TATU_REQUEST_QUIT) != 0
    }
    /// Returns whether the running script must return, because it has not done so within a second after a stop was
    /// requested from outside. Scripts that run in parallel are short.
    pub fn is_overdue(&self) -> bool {
        self.worker.is_none() && self.run.connections.has_external_stop() && self.run.calls.cost.is_overdue()
    }
    /// Returns the pointer that is passed to plugins.
    pub fn raw(&self) -> *mut tatu_world {
        match &self.worker {
            Some(worker) => worker.world(),
            None => (&raw const *self).cast_mut().cast(),
        }
    }
    /// Returns the description passed to a new plugin instance of an object.
    ///
    /// `key` identifies the owner independently of other objects; the instance's seed is derived from it.
    pub fn instance_info(&self, owner: tatu_object, key: &str) -> tatu_instance {
        self.instance_info_with_id(owner, key, self.devices.next_instance_id())
    }
    /// Like `instance_info`, but with a given id, for example for an instance that replaces an existing one.
    pub fn instance_info_with_id(&self, owner: tatu_object, key: &str, id: u64) -> tatu_instance {
        tatu_instance {
            size: size_of::<tatu_instance>() as u32,
            n_params: 0,
            world: self.raw(),
            owner,
            id,
            seed: self.model.seed_of(key),
            params: std::ptr::null(),
            state: std::ptr::null_mut(),
            session: std::ptr::null_mut(),
        }
    }
    /// Returns the data and the state block of a plugin's instance in this world. Both are null in a worker, since they
    /// belong to the world's thread.
    #[inline]
    pub fn instance(&self, plugin: usize) -> (*mut std::ffi::c_void, *mut std::ffi::c_void) {
        self.devices.instance(plugin)
    }
}
