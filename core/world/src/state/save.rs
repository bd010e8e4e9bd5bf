//! Converts a world to a document that describes its current state.

use tatu_plugin_api::safe::Value;
use tatu_plugins::ParameterSpec;
use tatu_scene::{
    ObjectVariant,
    document::{DeviceSpec, Document, ObjectAttachments, ScriptSpec},
};

use crate::cell::WorldCell;

/// Returns a document of an object and all its descendants, or of the whole scene if `base` is 0. It contains objects,
/// devices with their parameters, and scripts of the scene with their sources, but no velocities and no internal state
/// of scripts and devices.
pub(crate) fn document_of(cell: &WorldCell, base: u32) -> Document {
    let mut settings = cell.model.settings.borrow().clone();
    settings.allow.clear();
    let beside = ObjectAttachments { device: &|slot| device_of(cell, slot), scripts: &|slot| scripts_of(cell, slot) };
    let mut document = Document::of_scene(&cell.state.scene.borrow(), base, settings, &beside);
    if base == 0 {
        document.requests.services.clone_from(&cell.model.document.requests.services);
        document.requests.languages.clone_from(&cell.model.document.requests.languages);
        document.requests.env.clone_from(&cell.model.document.requests.env);
    }
    document
}

/// Returns the kind and the current parameters of an object's device.
pub(crate) fn device_of(cell: &WorldCell, slot: u32) -> Option<DeviceSpec> {
    let scene = cell.state.scene.borrow();
    let named = |declared: &[ParameterSpec], params: &[Value]| -> Vec<(String, Value)> {
        let pairs = declared.iter().map(|d| d.key.clone()).zip(params.iter().cloned());
        pairs.filter(|(_, v)| *v != Value::Nil).collect()
    };
    match scene.get(slot).map(|o| &o.data)? {
        ObjectVariant::Sensor(_) => {
            let sensing = cell.devices.sensing.borrow();
            let d = sensing.device(slot)?;
            Some(DeviceSpec { kind: d.kind, params: named(&cell.model.registry.sensors[d.kind].params, &d.params) })
        }
        ObjectVariant::Actuator(a) | ObjectVariant::Part(a) => {
            let actuators = cell.devices.actuators.borrow();
            let d = actuators.device(scene.id(slot))?;
            let kind = &cell.model.registry.actuators[d.kind];
            let mut params = named(&kind.params, &d.params);
            params.extend(kind.commands.iter().map(|c| c.key.clone()).zip(a.commands.iter().map(|x| Value::Float(*x))));
            Some(DeviceSpec { kind: d.kind, params })
        }
        _ => None,
    }
}

/// Returns the scripts of an object that are part of the scene. Add-ons are not.
pub(crate) fn scripts_of(cell: &WorldCell, slot: u32) -> Vec<ScriptSpec> {
    let (scene, scripts) = (cell.state.scene.borrow(), cell.run.scripts.borrow());
    let all = scene.scripts(slot).into_iter().filter_map(|s| scripts.by_slot(s));
    all.filter(|s| s.kind < crate::cell::ScriptKind::Addon).map(|s| s.spec(s.text.to_vec())).collect()
}

/// Returns the scripts of the scene with their slots, in the order in which they were added.
pub(crate) fn script_list(cell: &WorldCell) -> Vec<(u32, ScriptSpec)> {
    let scripts = cell.run.scripts.borrow();
    let all = scripts.list.iter().filter(|s| s.kind < crate::cell::ScriptKind::Addon);
    all.map(|s| (s.slot, s.spec(s.text.to_vec()))).collect()
}
