//! Creates, configures, saves and ends the instances of plugins in a world.
//!
//! - this module: functions for all instances; `kinds`: instances of sensors, actuators and command plugins;
//! - `devices`: instances from the document, and those that a stop restores;
//! - `save`: the saved state of an instance; `targets`: the lists of targets of sensors and actuators.

mod devices;
mod kinds;
mod save;
mod targets;

use std::ffi::c_void;

use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value},
};
use tatu_plugins::{
    ParameterSpec,
    border::ErrorSlot,
    state_block::{PAST_STATE, StateBlock},
    watchdog::PluginCall,
};

use crate::cell::WorldCell;

pub(crate) use devices::{create_device, create_devices, current_devices, end_devices, recreate_devices};
pub(crate) use kinds::{create_actuator, create_sensor, end_actuator, end_sensor, request_layout};
pub use save::UnsavedInstance;
pub(crate) use save::{load_instance, save_instance, saved_state_block};
pub(crate) use targets::set_targets;

/// A plugin's data for one device, and the state block that the host allocated for it.
pub(crate) struct NewInstance {
    pub id: u64,
    pub data: *mut c_void,
    /// The state block, whose address is stable until the instance ends.
    pub state: StateBlock,
}

/// Converts values to ABI form; also returns the memory of their spans.
pub(crate) fn to_raw_values(params: &[Value]) -> (Vec<tatu_value>, Owned) {
    let mut owned = Owned::default();
    (params.iter().map(|p| owned.raw(p)).collect(), owned)
}

/// Creates an instance with the values of its declared parameters. No part of the world may be borrowed.
pub(crate) fn create_instance(
    world: &WorldCell,
    plugin: usize,
    life: &tatu_life,
    slot: u32,
    instance: tatu_instance,
    params: &[Value],
) -> Result<NewInstance, String> {
    let (raw, _room) = to_raw_values(params);
    let state = StateBlock::new(life.state_bytes);
    let info = tatu_instance { n_params: raw.len() as u32, params: raw.as_ptr(), state: state.data_ptr(), ..instance };
    let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
    if let Some(create) = life.create {
        let me = world.model.registry.plugins[plugin].me;
        // SAFETY: `create` is from a plugin that is never unloaded. `info`, the data that it points to, `data` and
        // `error` live until the call has returned.
        let made = |error| unsafe { create(me, &info, &mut data, error) };
        if world.call_plugin_checked((plugin, PluginCall::Create, slot), &mut error, made) < 0 {
            return Err(format!("{} [{}]", error.text(), PluginCall::Create.text()));
        }
        if !state.guards_intact() {
            return Err(format!("{PAST_STATE} [{}]", PluginCall::Create.text()));
        }
    }
    Ok(NewInstance { id: info.id, data, state })
}

/// A live instance: the index of its plugin, the slot of its object, and the plugin's data.
#[derive(Clone, Copy)]
pub(crate) struct InstanceRef {
    pub plugin: usize,
    pub slot: u32,
    pub data: *mut c_void,
}

/// Returns whether a change of the parameter at `at` is passed to the live instance instead of recreating the instance.
pub(crate) fn is_configurable(life: &tatu_life, declared: &[ParameterSpec], at: usize) -> bool {
    let rebuilds = declared.get(at).is_none_or(|d| d.flags & TATU_PARAM_REBUILDS != 0);
    // The mask of changed parameters has 64 bits.
    life.configure.is_some() && !rebuilds && at < 64
}

/// Passes all parameters to an instance after the one at `at` has changed. Returns `false` if the instance must be
/// recreated instead. No part of the world may be borrowed.
pub(crate) fn configure(
    world: &WorldCell,
    of: InstanceRef,
    life: &tatu_life,
    params: &[Value],
    at: usize,
) -> Result<bool, String> {
    let Some(configure) = life.configure else { return Ok(false) };
    // `configure` may itself set parameters, so it is counted as a nested call.
    let Some(_level) = world.run.calls.enter() else { return Err("calls are nested too deeply".to_owned()) };
    let (raw, _room) = to_raw_values(params);
    let mut error = ErrorSlot::new();
    // SAFETY: `of.data` points to a live instance of the plugin, which is never unloaded; the values and the error
    // object live until the call has returned.
    let run = |error| unsafe { configure(of.data, raw.as_ptr(), raw.len() as u32, 1 << at, error) };
    let status = world.call_plugin_checked((of.plugin, PluginCall::Configure, of.slot), &mut error, run);
    if status == TATU_ERR_UNSUPPORTED && !error.has_error() {
        return Ok(false);
    }
    if status < 0 {
        let plugin = &world.model.registry.plugins[of.plugin].id;
        return Err(format!("plugin `{plugin}`: {} [{}]", error.text(), PluginCall::Configure.text()));
    }
    Ok(true)
}

/// Returns the values of declared parameters: the values given in a document, otherwise the defaults.
pub(crate) fn params_with_defaults(declared: &[ParameterSpec], given: &[(String, Value)]) -> Vec<Value> {
    declared
        .iter()
        .map(|p| given.iter().rev().find(|(k, _)| *k == p.key).map_or_else(|| p.fallback.clone(), |(_, v)| v.clone()))
        .collect()
}
