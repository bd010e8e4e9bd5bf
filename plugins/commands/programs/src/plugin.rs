//! The plugin, and what it keeps for a world.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use tatu_plugin_api::safe::Prop;

/// The plugin.
pub struct Programs {
    pub(crate) allow: Prop,
    pub(crate) file: Prop,
}

/// Ends the stand-ins of a world with it.
#[derive(Default)]
pub struct Running(pub(crate) Arc<AtomicBool>);

impl Drop for Running {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
