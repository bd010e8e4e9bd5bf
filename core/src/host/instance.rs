//! Making the instance of a device: what sensors and actuators have in common.

use std::ffi::c_void;

use tatu_plugin_api::{abi::*, safe::Value};

use super::{Declared, watchdog::Call};
use crate::{
    calls::{ErrorSlot, answer},
    world::WorldCell,
};

/// What a plugin keeps for one device, and the state block that the host keeps for it.
pub(crate) struct Made {
    pub id: u64,
    pub data: *mut c_void,
    /// Its address stays until the instance ends.
    pub state: Vec<u64>,
}

/// Makes an instance with the values of its declared parameters. Must be called without any borrow of the world.
pub(crate) fn make(
    world: &WorldCell,
    plugin: usize,
    life: &tatu_life,
    slot: u32,
    instance: tatu_instance,
    params: &[Value],
) -> Result<Made, String> {
    let mut room: Vec<Vec<u64>> = Vec::new();
    let raw: Vec<tatu_value> = params
        .iter()
        .filter_map(|p| {
            p.to_raw(&mut |n| {
                room.push(vec![0; n.div_ceil(8).max(1)]);
                room.last_mut().map_or(std::ptr::null_mut(), |r| r.as_mut_ptr().cast())
            })
        })
        .collect();
    let mut state = vec![0u64; (life.state_bytes as usize).div_ceil(8)];
    let info = tatu_instance {
        n_params: raw.len() as u32,
        params: raw.as_ptr(),
        state: state.as_mut_ptr().cast(),
        ..instance
    };
    let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
    if let Some(create) = life.create {
        let me = world.registry.plugins[plugin].me;
        // SAFETY: by the contract of the extension; `info` and what it points to live through the call.
        let made = || unsafe { answer(create(me, &info, &mut data, error.raw()), false, error.raw()) };
        if world.cross(plugin, Call::Create, slot, made) < 0 {
            return Err(format!("{} [{}]", error.text(), Call::Create.text()));
        }
    }
    Ok(Made { id: info.id, data, state })
}

/// Values of declared parameters from what a document gives, defaults filled in.
pub(crate) fn filled(declared: &[Declared], given: &[(String, Value)]) -> Vec<Value> {
    declared
        .iter()
        .map(|p| given.iter().rev().find(|(k, _)| *k == p.key).map_or_else(|| p.fallback.clone(), |(_, v)| v.clone()))
        .collect()
}
