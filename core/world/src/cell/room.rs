//! How much room the stores of a world have.

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::Scene;

use super::{WorldCell, stores::bytes_of};

impl WorldCell {
    /// Bytes that each of the stores may take.
    pub fn store_room(&self) -> u64 {
        match self.see(|w| &w.model.settings).map_or(0, |s| s.memory) {
            0 => u64::MAX,
            room => room,
        }
    }
    /// Refuses what would not fit.
    pub fn no_room(&self, what: &str) -> tatu_status {
        let text = format!(
            "{what} of the scene would take more than {} MB, the memory that its scripts may use: remove some, or raise \
             `budget.memory_mb` of the scene",
            self.store_room() >> 20
        );
        self.run.calls.refuse(TATU_ERR_SPACE, &text)
    }
    /// Refuses free data of an object, or of the world (0), for which there is no room.
    pub fn check_notes(&self, scene: &Scene, slot: u32, value: &Value) -> Result<(), tatu_status> {
        let fits = self.state.noted.has_room(scene, slot, bytes_of(value), self.store_room());
        if fits { Ok(()) } else { Err(self.no_room("custom data")) }
    }
}
