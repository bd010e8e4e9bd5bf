//! Creates the instances of sensors, actuators and parts from the document, and recreates them when the scene is reset.

use super::{
    kinds::{create_actuator, create_sensor, end_actuator, end_sensor},
    targets::check_targets,
};
use tatu_errors::{Error, Fault, FaultKind, Result, SourceLocation};
use tatu_plugin_api::safe::Value;
use tatu_plugins::ParameterSpec;
use tatu_scene::{ObjectKind, document::DeviceSpec};

use super::params_with_defaults;
use crate::cell::WorldCell;

pub(crate) fn create_devices(cell: &WorldCell, slots: &[u32]) -> Result {
    let document = cell.model.document.shared();
    for (spec, slot) in document.objects.iter().zip(slots) {
        if let Some(device) = &spec.device {
            create_device(cell, *slot, device, spec.place.as_ref())?;
        }
    }
    Ok(())
}

/// Returns the slots, kinds and parameters of the current devices, for [`recreate_devices`].
pub(crate) fn current_devices(cell: &WorldCell) -> Vec<(u32, DeviceSpec)> {
    let (sensing, actuators) = (cell.devices.sensing.borrow(), cell.devices.actuators.borrow());
    let named = |declared: &[ParameterSpec], params: &[Value]| {
        declared.iter().map(|d| d.key.clone()).zip(params.iter().cloned()).filter(|(_, v)| *v != Value::Nil).collect()
    };
    // Sensors that publish the readings of actuators are created together with the actuators.
    let own = sensing.devices.iter().filter(|d| !cell.model.registry.sensors[d.kind].of_actuator);
    let sensors = own.map(|d| {
        (d.slot, DeviceSpec { kind: d.kind, params: named(&cell.model.registry.sensors[d.kind].params, &d.params) })
    });
    let actuators = actuators.devices.iter().map(|d| {
        (d.slot, DeviceSpec { kind: d.kind, params: named(&cell.model.registry.actuators[d.kind].params, &d.params) })
    });
    sensors.chain(actuators).collect()
}

/// Replaces all devices by those of an earlier state, with their earlier parameters, including devices of objects that
/// have been removed since. The scene must have been restored already. A device that cannot be created is reported as a
/// fault.
pub(crate) fn recreate_devices(cell: &WorldCell, devices: &[(u32, DeviceSpec)]) {
    end_devices(cell);
    for (slot, spec) in devices {
        if let Err(e) = create_device(cell, *slot, spec, None) {
            cell.report(Fault::new(FaultKind::Plugin, e.text));
        }
    }
}

pub(crate) fn end_devices(cell: &WorldCell) {
    let sensors = cell.devices.sensing.borrow_mut().remove_dead(|_| false);
    sensors.into_iter().for_each(|d| end_sensor(cell, d));
    let actuators = cell.devices.actuators.borrow_mut().remove_dead(|_| false);
    actuators.into_iter().for_each(|d| end_actuator(cell, d));
}

/// Creates the device of an object. No part of the world may be borrowed.
pub(crate) fn create_device(
    cell: &WorldCell,
    slot: u32,
    device: &DeviceSpec,
    place: Option<&SourceLocation>,
) -> Result {
    let (owner, name, path, object_kind) = {
        let scene = cell.state.scene.borrow();
        let Some(o) = scene.get(slot) else { return Ok(()) };
        (scene.id(slot), o.name(), scene.path(slot), o.kind())
    };
    cell.monitor.watch.set_object_name(slot, path.clone());
    let acts = matches!(object_kind, ObjectKind::Actuator | ObjectKind::Part);
    let info = cell.model.registry.device(acts, device.kind);
    let what = object_kind.name();
    let (params, commands) =
        (params_with_defaults(info.params, &device.params), params_with_defaults(info.commands, &device.params));
    let all = info.params.iter().zip(&params).chain(info.commands.iter().zip(&commands));
    // If an actuator is recreated, the scene already contains its commands.
    let known = |d: &ParameterSpec| acts && place.is_none() && info.commands.contains(d);
    if let Some((p, _)) = { all }.find(|(p, v)| **v == Value::Nil && !p.optional() && !known(p)) {
        let key = tatu_plugins::units::key_with_unit(&p.key, p.unit.as_deref());
        let text = format!("the {what} {path} lacks the required parameter `{key}`");
        return Err(Error::new("E104", text).expected(p.expectation()).at(place.cloned()));
    }
    let instance = cell.instance_info(owner, &name);
    for (c, v) in info.commands.iter().zip(&commands) {
        if matches!(v, Value::Float(x) if !x.is_finite()) {
            let text = format!("the command `{}` of the {what} {path} is not finite", c.key);
            return Err(Error::new("E102", text).expected(c.expectation()).at(place.cloned()));
        }
    }
    let refused = |text: String| {
        let plugin = &cell.model.registry.plugins[info.plugin].id;
        Error::new("E402", format!("the {what} {path} cannot be created: plugin `{plugin}`: {text}")).at(place.cloned())
    };
    if place.is_some() {
        check_targets(cell, slot)
            .map_err(|text| Error::new("E102", format!("`targets` of the {what} {path}: {text}")).at(place.cloned()))?;
    }
    if object_kind == ObjectKind::Sensor {
        let made = create_sensor(cell, device.kind, slot, instance, params).map_err(refused)?;
        cell.devices.sensing.borrow_mut().add(made);
        return Ok(());
    }
    let made = create_actuator(cell, device.kind, slot, instance, params).map_err(&refused)?;
    cell.devices.actuators.borrow_mut().add(made);
    if let Some(readings) = cell.model.registry.actuators[device.kind].readings {
        let instance = cell.instance_info(owner, &name);
        let reading = create_sensor(cell, readings, slot, instance, Vec::new()).map_err(refused)?;
        cell.devices.sensing.borrow_mut().add(reading);
    }
    if let Some(a) = cell.state.scene.borrow_mut().get_mut(slot).and_then(|o| o.data.actuator_or_part_mut())
        && a.commands.len() != commands.len()
    {
        a.commands = commands.iter().map(|v| if let Value::Float(x) = v { *x } else { 0.0 }).collect();
    }
    Ok(())
}
