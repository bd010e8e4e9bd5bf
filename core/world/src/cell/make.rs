//! A world's cell before anything has been made in it.

use std::{
    cell::{Cell, RefCell},
    sync::Arc,
};

use tatu_devices::{actuators::Actuators, figures::Figures, sense::Sensing};
use tatu_plugin_api::abi::tatu_object;
use tatu_plugins::{Registry, guard::ProcessState};
use tatu_scene::{
    Dynamics, Scene,
    document::{Document, Settings},
};

use super::{clock::Clock, stand_ins::StandIns, swap::Swap};
use crate::cell::{CallbackMask, Calls, Folders, Noted, Outside, Scripts, WorldCell};
impl WorldCell {
    /// A cell with a scene, and neither devices, scripts nor instances of plugins. `origins`: the object of each in the
    /// document.
    pub(crate) fn new(
        document: Arc<Document>,
        registry: Arc<Registry>,
        settings: Settings,
        scene: Scene,
        origins: Vec<tatu_object>,
        pool: Arc<rayon::ThreadPool>,
    ) -> Self {
        WorldCell {
            dynamics: RefCell::new(Dynamics::new(WorldCell::engine_settings(&settings))),
            clock: Clock::new(settings.dt),
            settings: RefCell::new(settings),
            sensing: RefCell::new(Sensing::default()),
            actuators: RefCell::new(Actuators::default()),
            scripts: RefCell::new(Scripts::default()),
            callback_mask: CallbackMask::default(),
            signals: RefCell::default(),
            noted: Noted::default(),
            line_bytes: Cell::new(0),
            calls: Calls::new(),
            phase: Cell::default(),
            over: Cell::new(false),
            rested: Cell::new(false),
            requests: Cell::new(0),
            stages: RefCell::new(Vec::new()),
            folders: Folders::new(document.file.as_deref()),
            outside: Outside::default(),
            stand_ins: StandIns::default(),
            next_instance: Cell::new(1),
            next_replacement: Cell::new(1 << 31),
            instances: RefCell::new(Vec::new()),
            faults: RefCell::new(Vec::new()),
            lines: Default::default(),
            reaped: Cell::new(0),
            figures: RefCell::new(Figures::default()),
            initial: RefCell::new(None),
            initial_devices: RefCell::new(Vec::new()),
            pool,
            watch: registry.watches.watch(),
            home: RefCell::new(ProcessState::now()),
            called: Cell::new(0),
            called_lately: Cell::new(0),
            looks: Cell::new(0),
            suspicious: Cell::new(false),
            workers: RefCell::new(Vec::new()),
            worker: None,
            origins: RefCell::new(origins),
            scene: RefCell::new(scene),
            registry: Swap::new(registry),
            document: Swap::new(document),
        }
    }
}
