//! Hooks by which a validator of plugins can observe and change calls across the ABI. Ordinary runs have no inspector.

use std::time::Duration;

use tatu_plugin_api::abi::*;

use crate::{ActuatorKind, CommandEntry, SensorKind, guarded_copy::GuardedCopy, watchdog::PluginCall};

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
    /// Called when a command broke the contract, such as by a status that does not exist or by a write outside its
    /// results. The caller of the command may catch the error.
    fn breach(&self, command: &CommandEntry, text: &str) {
        let _ = (command, text);
    }
    /// Runs a function of a kind of sensors (`aim`, `measure` or `finish`) with this batch. Must call `run` at least
    /// once with the batch itself, or with tables that describe some of its sensors.
    fn sensors(
        &self,
        kind: &SensorKind,
        call: PluginCall,
        batch: &mut tatu_sensor_batch,
        run: &mut dyn FnMut(&tatu_sensor_batch) -> tatu_status,
    ) -> tatu_status {
        let _ = (kind, call);
        run(batch)
    }
    /// Runs the function `apply` of a kind of actuators, as [`sensors`](Self::sensors).
    fn actuators(
        &self,
        kind: &ActuatorKind,
        batch: &tatu_actuator_batch,
        run: &mut dyn FnMut(&tatu_actuator_batch) -> tatu_status,
    ) -> tatu_status {
        let _ = kind;
        run(batch)
    }
    /// Called after a sensor has filled this table in its `after_beams` function, whose stack frame was directly below
    /// the table.
    fn after_beams(&self, kind: &SensorKind, beams: &tatu_beams) {
        let _ = (kind, beams);
    }
    /// Called after the function `save` of an instance has written these bytes.
    fn after_save(&self, plugin: usize, bytes: &[u8]) {
        let _ = (plugin, bytes);
    }
    /// Called after the `barrier` of a service has returned. Returns whether the service holds the session.
    fn after_barrier(&self, plugin: usize, holds: bool, took: Duration) -> bool {
        let _ = (plugin, took);
        holds
    }
    /// Returns a copy of a file's contents, or of a script's text, to pass to the plugin in place of the original.
    fn copy_of_source(&self, plugin: usize, bytes: &[u8]) -> Option<GuardedCopy> {
        let _ = (plugin, bytes);
        None
    }
    /// Called before the function `load` of an instance is passed these bytes, which `save` wrote, and their version.
    /// `plugin` is the index of the plugin in the registry.
    fn before_load(&self, plugin: usize, bytes: &mut Vec<u8>, version: &mut u32) {
        let _ = (plugin, bytes, version);
    }
}
