//! Creates and ends the instances of sensors, actuators and command plugins.

use std::{ffi::c_void, rc::Rc};

use tatu_devices::{
    actuators::{Actuator, ActuatorReading, PartRecord},
    sense::{BeamPlan, FieldLayout, SensorDevice},
};
use tatu_errors::{Error, Fault, FaultKind, Result};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{border::ErrorSlot, state_block::StateBlock, watchdog::PluginCall};
use tatu_scene::ObjectVariant;

use super::{NewInstance, create_instance};
use crate::cell::{CommandInstance, WorldCell};

/// Creates the instance of a sensor and requests its beams. No part of the world may be borrowed.
pub(crate) fn create_sensor(
    world: &WorldCell,
    kind_index: usize,
    slot: u32,
    instance: tatu_instance,
    params: Vec<Value>,
) -> Result<SensorDevice, String> {
    let kind = &world.model.registry.sensors[kind_index];
    let seed = instance.seed;
    let NewInstance { id, data, state } = create_instance(world, kind.plugin, &kind.life, slot, instance, &params)?;
    let mut device = SensorDevice::new(kind_index, slot, seed, (id, data, state), params);
    let room = |layout: &Rc<FieldLayout>| match world.devices.sensing.try_borrow() {
        Ok(sensing) => sensing.check_memory(layout, None),
        Err(_) => Ok(()),
    };
    match request_layout(world, kind_index, slot, device.data).and_then(|layout| room(&layout).map(|()| layout)) {
        Ok(layout) => device.set_layout(layout),
        Err(text) => {
            end_sensor(world, device);
            return Err(text);
        }
    }
    Ok(device)
}

/// Ends the instance of a sensor. No part of the world may be borrowed.
pub(crate) fn end_sensor(world: &WorldCell, sensor: SensorDevice) {
    let kind = &world.model.registry.sensors[sensor.kind];
    if let Some(destroy) = kind.life.destroy {
        // SAFETY: `sensor.data` was made by this kind's `create` function, from a plugin that is never unloaded. It is
        // destroyed only once, since `sensor` is consumed.
        world.call_plugin_reporting(kind.plugin, PluginCall::Destroy, sensor.slot, || unsafe { destroy(sensor.data) });
    }
}

/// Requests the beams of an instance, and returns their layout, which sensors with equal layouts share. No part of the
/// world may be borrowed.
pub(crate) fn request_layout(
    world: &WorldCell,
    kind: usize,
    slot: u32,
    data: *mut c_void,
) -> Result<Rc<FieldLayout>, String> {
    let kind = &world.model.registry.sensors[kind];
    let n_targets = match kind.raw.inputs & TATU_IN_TARGETS {
        0 => 0,
        _ => match world.state.scene.borrow().get(slot).map(|o| &o.data) {
            Some(ObjectVariant::Sensor(s)) => s.view.as_ref().map_or(0, |view| view.targets.len() as u32),
            _ => 0,
        },
    };
    let inspector = world.model.registry.inspector.as_deref();
    // SAFETY: `data` points to a live instance of this kind, and the caller holds no borrow of the world.
    let asked = world.call_plugin(kind.plugin, PluginCall::Beams, slot, || unsafe {
        kind.request_beams(data, n_targets, inspector)
    });
    let plan = asked.and_then(BeamPlan::new).map_err(|text| format!("{text} [{}]", PluginCall::Beams.text()))?;
    let layout = FieldLayout::new(plan, n_targets, kind)?;
    let like_it = world.devices.sensing.try_borrow().ok().and_then(|s| s.shared_layout(&layout));
    Ok(like_it.unwrap_or_else(|| Rc::new(layout)))
}

/// Creates the instance of an actuator or a part. No part of the world may be borrowed.
pub(crate) fn create_actuator(
    world: &WorldCell,
    kind: usize,
    slot: u32,
    instance: tatu_instance,
    params: Vec<Value>,
) -> Result<Actuator, String> {
    let info = &world.model.registry.actuators[kind];
    let object = instance.owner;
    let report = match info.readings {
        None => None,
        Some(readings) => {
            let layout = request_layout(world, readings, slot, std::ptr::null_mut())?;
            Some(ActuatorReading::new(layout))
        }
    };
    let NewInstance { data, state, .. } = create_instance(world, info.plugin, &info.life, slot, instance, &params)?;
    world.run.connections.bus.add_natives(&info.events);
    let part = info.part.map(|_| Box::<PartRecord>::default());
    Ok(Actuator { object, slot, kind, data, state, params, off: false, idle_reported: false, report, part })
}

/// Ends the instance of an actuator or a part. No part of the world may be borrowed.
pub(crate) fn end_actuator(world: &WorldCell, actuator: Actuator) {
    let kind = &world.model.registry.actuators[actuator.kind];
    if let Some(destroy) = kind.life.destroy {
        // SAFETY: `actuator.data` was made by this kind's `create` function, from a plugin that is never unloaded. It
        // is destroyed only once, since `actuator` is consumed.
        world.call_plugin_reporting(kind.plugin, PluginCall::Destroy, actuator.slot, || unsafe {
            destroy(actuator.data)
        });
    }
}

impl CommandInstance {
    /// Creates a command plugin's instance for a world. No part of the world may be borrowed.
    pub fn create(cell: &WorldCell, plugin: usize, life: &tatu_life, id: u64) -> Result<Self> {
        let state = StateBlock::new(life.state_bytes);
        let info = tatu_instance { state: state.data_ptr(), ..cell.instance_info_with_id(0, "", id) };
        let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
        let p = &cell.model.registry.plugins[plugin];
        if let Some(create) = life.create {
            // SAFETY: `create` is from a plugin that is never unloaded. `info`, `data` and `error` live until the call
            // has returned, and the state block lives as long as the instance.
            let made = |error| unsafe { create(p.me, &info, &mut data, error) };
            if cell.call_plugin_checked((plugin, PluginCall::Create, 0), &mut error, made) < 0 {
                let (why, call) = (error.text(), PluginCall::Create.text());
                let text = format!("plugin `{}` cannot serve this world: {why} [{call}]", p.id);
                return Err(Error::new("E403", text));
            }
        }
        Ok(CommandInstance { data, state, destroy: life.destroy })
    }

    /// Notifies the instance that the scripts of the run have ended. Returns whether it can continue to serve the
    /// world, or must be recreated; an error is reported.
    pub fn end_run(&self, cell: &WorldCell, plugin: usize, life: &tatu_life) -> bool {
        let Some(end_run) = life.end_run else { return false };
        let p = &cell.model.registry.plugins[plugin];
        let mut error = ErrorSlot::new();
        // SAFETY: `self.data` was made by `create` and is alive, `error` lives until the call has returned, and no
        // borrow of the world is active.
        let ended = |error| unsafe { end_run(p.me, self.data, cell.raw(), error) };
        if cell.call_plugin_checked((plugin, PluginCall::EndRun, 0), &mut error, ended) >= 0 {
            return true;
        }
        let text = format!(
            "the instance of plugin `{}` is recreated after the run: {} [{}]",
            p.id,
            error.text(),
            PluginCall::EndRun.text()
        );
        cell.report(Fault::new(FaultKind::Plugin, text));
        false
    }

    /// Ends the instance.
    pub fn end(self, cell: &WorldCell, plugin: usize) {
        if let Some(destroy) = self.destroy {
            // SAFETY: `self.data` was made by `create`, from a plugin that is never unloaded. It is destroyed only
            // once, since `self` is consumed.
            cell.call_plugin_reporting(plugin, PluginCall::Destroy, 0, || unsafe { destroy(self.data) });
        }
    }
}
