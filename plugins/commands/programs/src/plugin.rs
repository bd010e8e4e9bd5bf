//! The plugin and its state per world.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use tatu_plugin_api::safe::Prop;

/// The plugin, with the properties that determine which programs a script may start.
pub struct Programs {
    pub(crate) allow: Prop,
    pub(crate) file: Prop,
}

/// Stops the built-in servers of a world when the world is dropped.
#[derive(Default)]
pub struct ServerGuard(pub(crate) Arc<AtomicBool>);

impl Drop for ServerGuard {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
