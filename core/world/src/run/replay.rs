//! Replays an input log.

use std::sync::Arc;

use tatu_errors::Result;
use tatu_plugins::Registry;
use tatu_scene::document::Document;

use super::World;
use crate::cell::InputRecord;

/// Creates a world of a document, and runs `step` steps in which the inputs of a log are repeated. The world is then
/// before the next barrier; the rest of the log remains attached and is repeated as the world continues.
///
/// A stop in the log may end the run earlier; compare [`World::steps`] with `step`.
pub fn replay_to(document: Arc<Document>, registry: Arc<Registry>, log: &[InputRecord], step: u64) -> Result<World> {
    let world = World::new(document, registry)?;
    world.attach_log(log.into());
    world.start();
    while world.steps() < step && !world.stop_requested() && world.step() {}
    Ok(world)
}
