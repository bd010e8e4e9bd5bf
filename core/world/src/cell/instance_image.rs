//! The state of an instance, as it stands in a snapshot.

use serde::{Deserialize, Serialize};

/// What `save` of an instance wrote, and its state block.
#[derive(Serialize, Deserialize, Default)]
pub struct InstanceImage {
    pub state: Vec<u64>,
    pub saved: Vec<u8>,
    /// The writer's version of both.
    pub version: u32,
    /// It could not be captured: `saved` is not to be loaded.
    pub missed: bool,
}
