//! Doing again what an input log holds.

use std::sync::Arc;

use tatu_errors::Result;
use tatu_plugins::Registry;
use tatu_scene::document::Document;

use super::World;
use crate::cell::Record;

/// A new world of a document in which everything of a log happened again, `step` steps after its start. It stands
/// before the barrier of that step; the rest of the log stays attached and is fed as the world goes on.
///
/// A stop in the log ends the way there early: compare [`World::steps`].
pub fn replay_to(document: Arc<Document>, registry: Arc<Registry>, log: &[Record], step: u64) -> Result<World> {
    let world = World::new(document, registry)?;
    world.feed(log.into());
    world.start();
    while world.steps() < step && !world.stop_requested() && world.step() {}
    Ok(world)
}
