//! What a validator of plugins may watch and replace at the ABI. Ordinary runs have no inspector.

use tatu_plugin_api::abi::*;

use crate::{CommandEntry, SensorKind};

/// Watches calls into plugins. Every method does nothing by default. Methods are called on the thread of the call.
pub trait Inspector: Send + Sync {
    /// Runs the function of a command, once, with this frame. Arguments may be moved to other memory for the time of
    /// the call; they are as the command declares them.
    fn command(
        &self,
        command: &CommandEntry,
        frame: *mut tatu_call,
        run: &mut dyn FnMut(*mut tatu_call) -> tatu_status,
    ) -> tatu_status {
        let _ = command;
        run(frame)
    }
    /// A command of this plugin failed with this status; neither it nor a service that it called gave a reason.
    fn gave_no_reason(&self, command: &CommandEntry, status: tatu_status) {
        let _ = (command, status);
    }
    /// A sensor has just filled this table in its `beams`, from a stack frame directly below the table.
    fn beams(&self, kind: &SensorKind, beams: &tatu_beams) {
        let _ = (kind, beams);
    }
    /// The `load` of an instance of this plugin (an index of the registry) is about to get these bytes, which `save`
    /// wrote, and this version.
    fn loads(&self, plugin: usize, bytes: &mut Vec<u8>, version: &mut u32) {
        let _ = (plugin, bytes, version);
    }
}
