//! The lists of targets of sensors and actuators.

use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{ObjectVariant, property_table::Property};

use super::kinds::request_layout;
use crate::cell::WorldCell;

/// The list of targets of a device, and its kind.
struct TargetList {
    paths: Vec<String>,
    /// Whether the kind takes targets.
    takes: bool,
    kind: String,
    is_actuator: bool,
}

fn list_of(world: &WorldCell, slot: u32) -> Option<TargetList> {
    let scene = world.state.scene.try_borrow().ok()?;
    match &scene.get(slot)?.data {
        ObjectVariant::Sensor(s) => {
            let kind = world.model.registry.sensors.get(s.kind)?;
            let paths = s.view.as_ref().map_or_else(Vec::new, |view| view.targets.clone());
            let takes = kind.raw.inputs & TATU_IN_TARGETS != 0;
            Some(TargetList { paths, takes, kind: kind.id.clone(), is_actuator: false })
        }
        ObjectVariant::Actuator(a) => {
            let kind = world.model.registry.actuators.get(a.kind)?;
            let takes = kind.raw.inputs & TATU_IN_TARGETS != 0;
            Some(TargetList { paths: a.targets.clone(), takes, kind: kind.id.clone(), is_actuator: true })
        }
        _ => None,
    }
}

fn takes_none(kind: &str) -> String {
    format!("the actuator kind `{kind}` takes no targets")
}

/// Checks the targets that a scene lists for a device, when all objects of the scene exist. A path that leads to no object
/// is only warned about, because the object may be added later.
pub(super) fn check_targets(world: &WorldCell, slot: u32) -> Result<(), String> {
    let Some(list) = list_of(world, slot).filter(|list| !list.paths.is_empty()) else { return Ok(()) };
    if !list.takes {
        return if list.is_actuator { Err(takes_none(&list.kind)) } else { Ok(()) };
    }
    let scene = world.state.scene.borrow();
    let own = scene.path(slot);
    let missing: Vec<&String> = list.paths.iter().filter(|path| scene.find(slot, path).is_none()).collect();
    drop(scene);
    for path in missing {
        let text = format!("there is no object `{path}`, which is one of the `targets` of {own}");
        world.log(TATU_LOG_WARNING, &text);
    }
    Ok(())
}

/// Sets the targets of a sensor or an actuator. If the kind of a sensor takes targets, its beams are requested again, since
/// their number and the sizes of fields may depend on the number of targets; if they are invalid, nothing changes.
pub(crate) fn set_targets(world: &WorldCell, slot: u32, row: Property, value: &Value) -> Result<(), Refusal> {
    let refuse = |text: String| Err(Refusal(TATU_ERR_ARGUMENT, format!("`{}`: {text}", row.key())));
    let list = list_of(world, slot);
    if let Some(list) = list.as_ref().filter(|list| list.is_actuator && !list.takes)
        && !matches!(value, Value::List(paths) if paths.is_empty())
    {
        return refuse(takes_none(&list.kind));
    }
    world.set_property(slot, row, value)?;
    let Some(list) = list.filter(|list| list.takes && !list.is_actuator) else { return Ok(()) };
    if let Err(text) = update_layout(world, slot) {
        world.set_property(slot, row, &Value::List(list.paths.iter().map(Value::text).collect()))?;
        return refuse(text);
    }
    Ok(())
}

/// Requests the beams of a sensor again. No part of the world may be borrowed.
fn update_layout(world: &WorldCell, slot: u32) -> Result<(), String> {
    let busy = || "a running measurement uses the sensor; set the property after it".to_owned();
    let (kind, id, data) = {
        let sensing = world.devices.sensing.try_borrow().map_err(|_| busy())?;
        // An object whose instance has not been created yet has no layout.
        let Some(d) = sensing.device(slot) else { return Ok(()) };
        (d.kind, d.id, d.data)
    };
    let layout = request_layout(world, kind, slot, data)?;
    let mut sensing = world.devices.sensing.try_borrow_mut().map_err(|_| busy())?;
    sensing.check_memory(&layout, sensing.device(slot).map(|d| &*d.layout))?;
    sensing.set_layout(slot, id, layout);
    sensing.invalidate_rosters();
    Ok(())
}
