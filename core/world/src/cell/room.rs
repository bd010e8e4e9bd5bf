//! Size limit of the stores of a world, such as its signals (see `stores`).

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::Scene;

use super::{WorldCell, stores::bytes_of};

impl WorldCell {
    /// Returns the maximum size of each store, bytes.
    pub fn store_room(&self) -> u64 {
        match self.see(|w| &w.model.settings).map_or(0, |s| s.memory) {
            0 => u64::MAX,
            room => room,
        }
    }
    /// Refuses to store `what` because the limit would be exceeded, and returns the status.
    pub fn no_room(&self, what: &str) -> tatu_status {
        let text = format!(
            "{what} of the scene would exceed {} MB, the memory limit of its scripts: remove some, or raise \
             `budget.memory_mb` in the scene",
            self.store_room() >> 20
        );
        self.run.calls.refuse(TATU_ERR_SPACE, &text)
    }
    /// Returns an error if custom data of an object, or of the world if `slot` is 0, would exceed the limit.
    pub fn check_notes(&self, scene: &Scene, slot: u32, value: &Value) -> Result<(), tatu_status> {
        let fits = self.state.noted.has_room(scene, slot, bytes_of(value), self.store_room());
        if fits { Ok(()) } else { Err(self.no_room("custom data")) }
    }
}
