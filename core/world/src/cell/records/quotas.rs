//! Size limit of the stores of a world, such as its signals (see `stores`).

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::Scene;

use crate::cell::{WorldCell, records::stores::bytes_of};

impl WorldCell {
    /// Returns the maximum size of each store, bytes.
    pub fn store_limit(&self) -> u64 {
        match self.borrow_part(|w| &w.model.settings).map_or(0, |s| s.memory) {
            0 => u64::MAX,
            room => room,
        }
    }
    /// Records that `what` was not stored because the limit would be exceeded, and returns the status.
    pub fn refuse_over_limit(&self, what: &str) -> tatu_status {
        let text = format!(
            "{what} of the scene would exceed {} MB, the memory limit of its scripts: remove some, or raise \
             `budget.memory_mb` in the scene",
            self.store_limit() >> 20
        );
        self.run.calls.refuse(TATU_ERR_SPACE, &text)
    }
    /// Returns an error if custom data of an object, or of the world if `slot` is 0, would exceed the limit.
    pub fn check_custom_data(&self, scene: &Scene, slot: u32, value: &Value) -> Result<(), tatu_status> {
        let fits = self.state.custom_data_size.try_reserve(scene, slot, bytes_of(value), self.store_limit());
        if fits { Ok(()) } else { Err(self.refuse_over_limit("custom data")) }
    }
}
