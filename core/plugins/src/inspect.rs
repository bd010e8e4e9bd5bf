//! Hooks by which a validator of plugins can observe and change calls across the ABI. Ordinary runs have no inspector.

use tatu_plugin_api::abi::*;

use crate::{CommandEntry, SensorKind};

/// Observes calls into plugins. Every method does nothing by default, and is called on the thread of the call.
pub trait Inspector: Send + Sync {
    /// Runs the function of a command exactly once, with this frame. The arguments conform to the command's
    /// declaration, and can be moved to other memory for the duration of the call.
    fn command(
        &self,
        command: &CommandEntry,
        frame: *mut tatu_call,
        run: &mut dyn FnMut(*mut tatu_call) -> tatu_status,
    ) -> tatu_status {
        let _ = command;
        run(frame)
    }
    /// Called if a command failed with this status, and neither it nor a service that it called gave a reason.
    fn failed_without_reason(&self, command: &CommandEntry, status: tatu_status) {
        let _ = (command, status);
    }
    /// Called after a sensor has filled this table in its `after_beams` function, whose stack frame was directly below
    /// the table.
    fn after_beams(&self, kind: &SensorKind, beams: &tatu_beams) {
        let _ = (kind, beams);
    }
    /// Called before the function `load` of an instance is passed these bytes, which `save` wrote, and their version.
    /// `plugin` is the index of the plugin in the registry.
    fn before_load(&self, plugin: usize, bytes: &mut Vec<u8>, version: &mut u32) {
        let _ = (plugin, bytes, version);
    }
}
