//! The inside of a world: four owners of its parts, each part behind a `RefCell` of its own.
//!
//! Plugins call back while they are called. Whatever runs a plugin that may call back holds no borrow; a service borrows
//! one part, acts, and lets it go.

use std::{cell::RefCell, sync::Arc};

use tatu_plugin_api::abi::*;
use tatu_plugins::Registry;
use tatu_scene::{
    Scene,
    document::{Document, Settings},
};

use super::{
    border::Border, devices::Devices, living, model::Model, phase::Phase, run::Run, state::State,
    worker_view::WorkerView,
};

/// The inside of a world, at an address that stays: plugins hold it as `tatu_world *`.
pub(crate) struct WorldCell {
    pub model: Model,
    pub state: State,
    pub devices: Devices,
    pub run: Run,
    pub border: Border,
    /// Cells of threads that run scripts side by side, made when they are needed first.
    pub workers: RefCell<Vec<ScriptWorker>>,
    /// This is such a cell: what its thread sees of the world.
    pub worker: Option<Box<WorkerView>>,
}

/// A worker of a world; its cell stays where it is.
pub(crate) struct ScriptWorker(pub(super) Box<WorldCell>);

impl Drop for WorldCell {
    fn drop(&mut self) {
        living::remove(&raw const *self as *const tatu_world);
    }
}

impl WorldCell {
    /// A cell with a scene, and neither devices, scripts nor instances of plugins. `origins`: the object of each in the
    /// document.
    pub fn new(
        document: Arc<Document>,
        registry: Arc<Registry>,
        settings: Settings,
        scene: Scene,
        origins: Vec<tatu_object>,
        pool: Arc<rayon::ThreadPool>,
    ) -> Self {
        WorldCell {
            state: State::new(Model::engine_settings(&settings), settings.dt, scene),
            devices: Devices::default(),
            run: Run::new(document.file.as_deref(), pool),
            border: Border::new(registry.watches.watch()),
            workers: RefCell::default(),
            worker: None,
            model: Model::new(document, registry, settings, origins),
        }
    }
    /// Whether the world is started.
    pub fn running(&self) -> bool {
        self.state.phase.get() != Phase::Stopped
    }
    /// Whether something asked for a stop.
    pub fn stop_requested(&self) -> bool {
        self.state.requests.get() & (1 << TATU_REQUEST_STOP | 1 << TATU_REQUEST_QUIT) != 0
    }
    /// The pointer that plugins get.
    pub fn raw(&self) -> *mut tatu_world {
        match &self.worker {
            Some(worker) => worker.world(),
            None => (&raw const *self).cast_mut().cast(),
        }
    }
    /// The description that a new instance of an object gets.
    ///
    /// `key` names the owner by what does not change when other things are added: its seed follows from it.
    pub fn instance_info(&self, owner: tatu_object, key: &str) -> tatu_instance {
        self.instance_again(owner, key, self.devices.new_instance())
    }
    /// The same for one that takes the place of another, under a number that is given.
    pub fn instance_again(&self, owner: tatu_object, key: &str, id: u64) -> tatu_instance {
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
    /// The data and the state block of a plugin's instance in this world; null in a worker: they belong to the world's
    /// thread.
    #[inline]
    pub fn instance(&self, plugin: usize) -> (*mut std::ffi::c_void, *mut std::ffi::c_void) {
        self.devices.instance(plugin)
    }
}
