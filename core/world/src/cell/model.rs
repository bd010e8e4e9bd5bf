//! The description from which a world was built.

use std::{cell::RefCell, sync::Arc};

use tatu_physics::EngineSettings;
use tatu_plugin_api::abi::*;
use tatu_plugins::Registry;
use tatu_scene::document::{Document, WorldSettings};

use crate::cell::{
    records::history::{EditHistory, Memento},
    swap_cell::SwapCell,
};

/// The description from which a world was built: the document, the registry of its kinds, the edits made since, and the
/// state that a stop restores.
pub(crate) struct WorldModel {
    pub registry: SwapCell<Registry>,
    pub document: SwapCell<Document>,
    /// Handle of each object of the document, or 0 if it was not created.
    pub origins: RefCell<Vec<tatu_object>>,
    pub settings: RefCell<WorldSettings>,
    /// The scene at the start of the run.
    pub initial: RefCell<Option<Memento>>,
    pub history: RefCell<EditHistory>,
}

impl WorldModel {
    pub fn new(
        document: Arc<Document>,
        registry: Arc<Registry>,
        settings: WorldSettings,
        origins: Vec<tatu_object>,
    ) -> Self {
        let mut history = EditHistory::default();
        if document.sources.are_recovered() {
            history.note_recovered();
        }
        WorldModel {
            registry: SwapCell::new(registry),
            document: SwapCell::new(document),
            origins: RefCell::new(origins),
            settings: RefCell::new(settings),
            initial: RefCell::default(),
            history: RefCell::new(history),
        }
    }
    /// Returns a seed derived from the scene's seed and `key`.
    pub fn seed_of(&self, key: &str) -> u64 {
        xxhash_rust::xxh3::xxh3_64_with_seed(key.as_bytes(), self.settings.borrow().seed)
    }
    /// Returns the settings of the physics engine.
    pub fn engine_settings(settings: &WorldSettings) -> EngineSettings {
        EngineSettings {
            gravity: settings.gravity,
            step: settings.physics_dt.min(settings.dt),
            substeps: settings.physics_substeps,
            sleep: settings.sleep,
            friction_rule: settings.friction_rule,
            contact_spring: settings.contact_spring,
        }
    }
}
