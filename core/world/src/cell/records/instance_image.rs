//! The state of a plugin instance, as stored in a snapshot.

use serde::{Deserialize, Serialize};

/// The bytes that an instance's `save` wrote, and its state block.
#[derive(Serialize, Deserialize, Default)]
pub struct InstanceImage {
    pub state: Vec<u64>,
    pub saved: Vec<u8>,
    /// The version of the saved state, as declared by the plugin that wrote it.
    pub version: u32,
    /// Whether the state could not be captured, in which case `saved` must not be loaded.
    pub missed: bool,
}
