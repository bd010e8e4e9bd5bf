//! Access to the parameters of a sensor, an actuator or a part, and commands by the key `<kind>.<key>`. A changed parameter is passed
//! to the instance if the plugin supports this; otherwise, the instance is recreated.

use std::rc::Rc;

use tatu_devices::sense::FieldLayout;
use tatu_errors::nearest;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{ParameterSpec, check_value};
use tatu_scene::{ObjectVariant, Scene};

use super::answer::{HostResult, busy, slot};
use crate::{
    cell::WorldCell,
    instances::{
        InstanceRef, configure, create_actuator, create_sensor, end_actuator, end_sensor, is_configurable,
        request_layout,
    },
};

/// The meaning of a key for an object.
enum DeviceKey {
    /// A parameter of a sensor of this kind.
    Sensor { kind: usize, at: usize },
    /// A parameter of an actuator of this kind.
    Actuator { kind: usize, at: usize },
    /// A command of an actuator of this kind.
    Command { kind: usize, at: usize },
}

fn resolve_key(world: &WorldCell, scene: &Scene, slot: u32, prop: tatu_prop) -> Option<DeviceKey> {
    match &scene.get(slot)?.data {
        ObjectVariant::Actuator(a) | ObjectVariant::Part(a) => {
            let info = world.model.registry.actuators.get(a.kind)?;
            let find = |props: &[u32]| props.iter().position(|p| *p == prop);
            let command = find(&info.command_props).map(|at| DeviceKey::Command { kind: a.kind, at });
            command.or_else(|| Some(DeviceKey::Actuator { kind: a.kind, at: find(&info.param_props)? }))
        }
        ObjectVariant::Sensor(s) => {
            let info = world.model.registry.sensors.get(s.kind)?;
            let key = world.model.registry.host().key(prop)?;
            let short = key.strip_prefix(info.id.as_str())?.strip_prefix('.')?;
            Some(DeviceKey::Sensor { kind: s.kind, at: info.params.iter().position(|p| p.key == short)? })
        }
        _ => None,
    }
}

/// Refuses an unknown key. The message suggests the most similar key or, if no key is similar, lists all keys of the
/// object's kind.
fn refuse_unknown_key(world: &WorldCell, scene: &Scene, slot: u32, prop: tatu_prop) -> tatu_status {
    let key = world.model.registry.host().key(prop).unwrap_or_default();
    let mut text = format!("object {slot} `{}` has no property `{key}`", scene.path(slot));
    let kind = scene.get(slot).and_then(|o| match &o.data {
        ObjectVariant::Actuator(a) | ObjectVariant::Part(a) => Some((true, a.kind)),
        ObjectVariant::Sensor(s) => Some((false, s.kind)),
        _ => None,
    });
    if let Some((is_actuator, kind)) = kind {
        let info = world.model.registry.device(is_actuator, kind);
        let known: Vec<String> = info.all_params().map(|d| format!("{}.{}", info.id, d.key)).collect();
        match nearest(&key, known.iter().map(String::as_str)) {
            Some(near) => text += &format!("; did you mean `{near}`?"),
            None if !known.is_empty() => text += &format!("; objects of its kind have {}", known.join(", ")),
            None => {}
        }
    }
    world.run.calls.refuse(TATU_ERR_MISSING, &text)
}

/// Reads a parameter or a command.
pub(super) fn read(world: &WorldCell, slot: u32, prop: tatu_prop) -> Result<Value, tatu_status> {
    let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
    let found = match resolve_key(world, &scene, slot, prop) {
        None => None,
        Some(DeviceKey::Command { at, .. }) => match scene.get(slot).map(|o| &o.data) {
            Some(ObjectVariant::Actuator(a) | ObjectVariant::Part(a)) => a.commands.get(at).map(|x| Value::Float(*x)),
            _ => None,
        },
        Some(DeviceKey::Sensor { at, .. }) => {
            let sensing = world.devices.sensing.try_borrow().map_err(|_| busy(world))?;
            sensing.device(slot).and_then(|d| d.params.get(at).cloned())
        }
        Some(DeviceKey::Actuator { at, .. }) => {
            let actuators = world.devices.actuators.try_borrow().map_err(|_| busy(world))?;
            actuators.device(scene.id(slot)).and_then(|d| d.params.get(at).cloned())
        }
    };
    found.ok_or_else(|| refuse_unknown_key(world, &scene, slot, prop))
}

/// Checks a value against its declaration. An array of one number is accepted as a number.
fn check_against_declaration(
    world: &WorldCell,
    declared: &ParameterSpec,
    prop: tatu_prop,
    value: Value,
) -> Result<Value, tatu_status> {
    let value = match value {
        Value::Floats(v) if v.len() == 1 && declared.kind != TATU_F64S => Value::Float(v[0]),
        other => other,
    };
    check_value(declared, value).map_err(|e| {
        let key = world.model.registry.host().key(prop).unwrap_or_default();
        world.run.calls.refuse(TATU_ERR_ARGUMENT, &format!("`{key}`: {e}"))
    })
}

/// Sets a parameter or a command.
pub(super) fn write(world: &WorldCell, object: tatu_object, prop: tatu_prop, value: Value) -> HostResult {
    let (slot, owner, name, meaning) = {
        let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
        let slot = slot(world, &scene, object)?;
        let found =
            resolve_key(world, &scene, slot, prop).ok_or_else(|| refuse_unknown_key(world, &scene, slot, prop))?;
        (slot, scene.id(slot), scene.get(slot).map_or(String::new(), |o| o.name()), found)
    };
    match meaning {
        DeviceKey::Command { kind, at } => set_command(world, slot, kind, at, prop, value),
        DeviceKey::Sensor { kind, at } => {
            let value = check_against_declaration(world, &world.model.registry.sensors[kind].params[at], prop, value)?;
            set_sensor_param(world, (slot, owner, &name), (kind, at), value)
                .map_err(|stop| stop.status(world, slot, prop))
        }
        DeviceKey::Actuator { kind, at } => {
            let value =
                check_against_declaration(world, &world.model.registry.actuators[kind].params[at], prop, value)?;
            set_actuator_param(world, (slot, owner, &name), (kind, at), value)
                .map_err(|stop| stop.status(world, slot, prop))
        }
    }
}

/// The reason why a parameter could not be changed.
enum ParamError {
    /// A part of the world is in use.
    Busy,
    /// The instance no longer exists.
    Gone,
    /// The plugin or the host refused the value, with a message.
    Refused(String),
}

impl ParamError {
    fn status(self, world: &WorldCell, slot: u32, prop: tatu_prop) -> tatu_status {
        let key = || world.model.registry.host().key(prop).unwrap_or_default();
        let path = || world.state.scene.try_borrow().map_or(format!("object {slot}"), |s| s.path(slot));
        match self {
            ParamError::Busy => busy(world),
            ParamError::Gone => {
                world.run.calls.refuse(TATU_ERR_GONE, &format!("the instance of object {slot} has ended"))
            }
            ParamError::Refused(why) => {
                world.run.calls.refuse(TATU_ERR_ARGUMENT, &format!("`{}` of {}: {why}", key(), path()))
            }
        }
    }
}

/// The slot, the full handle and the name of a device's object.
type DeviceOwner<'a> = (u32, tatu_object, &'a str);

/// Changes a parameter of a sensor. If the parameter can be changed in a live instance, it is passed to the instance,
/// whose beams are then requested again. Otherwise, the instance is recreated. No borrow is held while the plugin is
/// called.
fn set_sensor_param(
    world: &WorldCell,
    whose: DeviceOwner<'_>,
    (kind, at): (usize, usize),
    value: Value,
) -> Result<(), ParamError> {
    let (slot, ..) = whose;
    let info = &world.model.registry.sensors[kind];
    let (old, data, id) = {
        let sensing = world.devices.sensing.try_borrow().map_err(|_| ParamError::Busy)?;
        let d = sensing.device(slot).ok_or(ParamError::Gone)?;
        (d.params.clone(), d.data, d.id)
    };
    let mut params = old.clone();
    params[at] = value;
    let of = InstanceRef { plugin: info.plugin, slot, data };
    if !is_configurable(&info.life, &info.params, at)
        || !configure(world, of, &info.life, &params, at).map_err(ParamError::Refused)?
    {
        return recreate_sensor(world, whose, kind, params);
    }
    let room = |layout: &Rc<FieldLayout>| match world.devices.sensing.try_borrow() {
        Ok(sensing) => sensing.check_memory(layout, sensing.device(slot).map(|d| &*d.layout)),
        Err(_) => Ok(()),
    };
    let layout = match request_layout(world, kind, slot, data).and_then(|layout| room(&layout).map(|()| layout)) {
        Ok(layout) => layout,
        // The instance accepted the value, but its beams are invalid: it is recreated with the previous parameters.
        Err(why) => return recreate_sensor(world, whose, kind, old).and(Err(ParamError::Refused(why))),
    };
    let mut sensing = world.devices.sensing.try_borrow_mut().map_err(|_| ParamError::Busy)?;
    // The sensor may have been removed or recreated during the call.
    let device = sensing.set_layout(slot, id, layout).ok_or(ParamError::Gone)?;
    device.params[at] = params.swap_remove(at);
    sensing.invalidate_rosters();
    Ok(())
}

/// Sets several parameters of a sensor at once and recreates it. If they were set one by one, they might contradict
/// each other in between.
pub(super) fn write_params(world: &WorldCell, object: tatu_object, new: Vec<(usize, Value)>) -> HostResult {
    let (slot, owner, name) = {
        let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
        let slot = slot(world, &scene, object)?;
        (slot, scene.id(slot), scene.get(slot).map_or(String::new(), |o| o.name()))
    };
    let found = {
        let sensing = world.devices.sensing.try_borrow().map_err(|_| busy(world))?;
        sensing.device(slot).map(|d| (d.kind, d.params.clone()))
    };
    let Some((kind, mut params)) = found else { return Err(ParamError::Gone.status(world, slot, 0)) };
    new.into_iter().for_each(|(at, value)| params[at] = value);
    let preset = world.model.registry.host().number("sensor.preset");
    recreate_sensor(world, (slot, owner, &name), kind, params).map_err(|stop| stop.status(world, slot, preset))
}

fn recreate_sensor(
    world: &WorldCell,
    (slot, owner, name): DeviceOwner<'_>,
    kind: usize,
    params: Vec<Value>,
) -> Result<(), ParamError> {
    let mut instance = world.instance_info(owner, name);
    if let Some(old) = world.devices.sensing.try_borrow().map_err(|_| ParamError::Busy)?.device(slot) {
        // The sensor keeps its seed, even if it was renamed, so that its random numbers continue.
        instance.seed = old.seed;
    }
    let mut made = create_sensor(world, kind, slot, instance, params).map_err(ParamError::Refused)?;
    let old = {
        let mut sensing = world.devices.sensing.try_borrow_mut().map_err(|_| ParamError::Busy)?;
        // The settings in the scene must be applied before the sensor is measured.
        sensing.invalidate_settings();
        let place = sensing.devices.iter_mut().find(|d| d.slot == slot);
        place.map(|d| {
            (made.drawn, made.schedule.period, made.noise) = (d.drawn, d.schedule.period, d.noise.take());
            made.discard_reading();
            std::mem::replace(d, made)
        })
    };
    old.into_iter().for_each(|d| end_sensor(world, d));
    Ok(())
}

/// Like `set_sensor_param`, but for an actuator or a part, which has no beams.
fn set_actuator_param(
    world: &WorldCell,
    (slot, owner, name): DeviceOwner<'_>,
    (kind, at): (usize, usize),
    value: Value,
) -> Result<(), ParamError> {
    let info = &world.model.registry.actuators[kind];
    let (mut params, data, is_called) = {
        let actuators = world.devices.actuators.try_borrow().map_err(|_| ParamError::Busy)?;
        let d = actuators.device(owner).ok_or(ParamError::Gone)?;
        (d.params.clone(), d.data, d.part.as_deref().is_some_and(|p| p.running))
    };
    params[at] = value;
    let of = InstanceRef { plugin: info.plugin, slot, data };
    if is_configurable(&info.life, &info.params, at)
        && configure(world, of, &info.life, &params, at).map_err(ParamError::Refused)?
    {
        let mut actuators = world.devices.actuators.try_borrow_mut().map_err(|_| ParamError::Busy)?;
        let device =
            actuators.devices.iter_mut().find(|d| d.object == owner && d.data == data).ok_or(ParamError::Gone)?;
        device.params[at] = params.swap_remove(at);
        return Ok(());
    }
    if is_called {
        let why = "a change recreates the part, which is being called; set it from elsewhere";
        return Err(ParamError::Refused(why.to_owned()));
    }
    let made =
        create_actuator(world, kind, slot, world.instance_info(owner, name), params).map_err(ParamError::Refused)?;
    let old = {
        let mut actuators = world.devices.actuators.try_borrow_mut().map_err(|_| ParamError::Busy)?;
        let place = actuators.devices.iter_mut().find(|d| d.object == owner);
        place.map(|d| std::mem::replace(d, made))
    };
    old.into_iter().for_each(|d| end_actuator(world, d));
    Ok(())
}

fn set_command(world: &WorldCell, slot: u32, kind: usize, at: usize, prop: tatu_prop, value: Value) -> HostResult {
    let declared = &world.model.registry.actuators[kind].commands[at];
    let Value::Float(x) = check_against_declaration(world, declared, prop, value)? else {
        return Err(TATU_ERR_ARGUMENT);
    };
    if !x.is_finite() {
        let text = format!("`{}`: expected a finite number, found {x}", declared.key);
        return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &text));
    }
    let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
    if let Some(a) = scene.get_mut(slot).and_then(|o| o.data.actuator_or_part_mut())
        && let Some(place) = a.commands.get_mut(at)
    {
        *place = x;
    }
    Ok(())
}
