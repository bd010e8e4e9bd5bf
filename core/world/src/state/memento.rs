//! Captures the scene, and restores it at a stop, an undo or a redo.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::Value;
use tatu_scene::{Dynamics, ObjectVariant, Scene, property_table::Property};

use super::save::script_list;
use crate::{
    cell::{
        Scripts, WorldCell, WorldModel,
        records::history::{Memento, WORLD_UID},
    },
    instances::{current_devices, recreate_devices},
};

/// Label of the edit that combines all changes of scripts during a run.
const SCRIPT_EDIT_LABEL: &str = "Edit scripts during a run";

/// Captures the scene with its devices, scripts and settings.
pub(crate) fn capture(cell: &WorldCell) -> Memento {
    Memento {
        scene: cell.state.scene.borrow().clone(),
        devices: current_devices(cell),
        scripts: script_list(cell),
        settings: cell.model.settings.borrow().clone(),
        models: cell.model.history.borrow().models.clone(),
    }
}

/// Restores a captured state, including its handles and names.
pub(crate) fn restore_state(cell: &WorldCell, state: Memento) {
    let Memento { scene, devices, scripts, settings, models } = state;
    *cell.model.settings.borrow_mut() = settings;
    cell.model.history.borrow_mut().models = models;
    replace_scene(cell, scene);
    recreate_devices(cell, &devices);
    Scripts::end_removed(cell);
    Scripts::restore(cell, &scripts, true);
    cell.restore_process_state("an undo");
}

/// Restores the state at the start of a run, except for properties that a stop leaves unchanged: custom data, layers,
/// colours, masses, inertias, names, settings of the world, and sources of scripts.
pub(crate) fn end_run(cell: &WorldCell, mut start: Memento) {
    let history = &cell.model.history;
    if history.borrow_mut().take_scripts_changed() {
        history.borrow_mut().push(SCRIPT_EDIT_LABEL.to_owned(), String::new(), start.clone());
    }
    let made = carry_over_retained(&mut start.scene, &cell.state.scene.borrow());
    history.borrow_mut().run_changes.extend(made);
    replace_scene(cell, start.scene);
    recreate_devices(cell, &start.devices);
    Scripts::end_removed(cell);
    Scripts::restore(cell, &start.scripts, false);
}

/// Carries custom data over to the restored scene, except data whose tag begins with a control character; such tags are
/// reserved for plugins.
fn carry_over_custom_data(then: &mut BTreeMap<Vec<u8>, Vec<u8>>, now: &BTreeMap<Vec<u8>, Vec<u8>>) {
    let free = |tag: &[u8]| tag.first().is_none_or(|c| !c.is_ascii_control());
    then.retain(|tag, _| !free(tag));
    then.extend(now.iter().filter(|(tag, _)| free(tag)).map(|(tag, data)| (tag.clone(), data.clone())));
}

/// Properties that a stop leaves unchanged.
const RETAINED_PROPERTIES: &[Property] = &[
    Property::NAME,
    Property::LAYER,
    Property::NOTES,
    Property::COLOR,
    Property::OPACITY,
    Property::PART_COLORS,
    Property::PART_OPACITIES,
    Property::MASS,
    Property::INERTIA,
];

/// Carries the properties that a stop leaves unchanged over to `initial`. Returns the properties that differ, with
/// their present values.
fn carry_over_retained(initial: &mut Scene, scene: &Scene) -> Vec<((u64, Property), Value)> {
    let mut made = Vec::new();
    for (slot, now) in scene.slots() {
        if initial.get(slot).is_none_or(|o| o.uid != now.uid) {
            continue;
        }
        for row in RETAINED_PROPERTIES.iter().filter(|r| r.spec().applies_to(Some(now.kind()))) {
            let value = tatu_scene::get(scene, slot, *row).ok();
            if value != tatu_scene::get(initial, slot, *row).ok() {
                made.extend(value.map(|v| ((now.uid, *row), v)));
            }
        }
        initial.set_name(slot, now.alias(), now.suffix());
        if let Some(then) = initial.get_mut(slot) {
            then.layer = now.layer;
            carry_over_custom_data(&mut then.notes, &now.notes);
            if let (ObjectVariant::Shape(then), ObjectVariant::Shape(now)) = (&mut then.data, &now.data) {
                (then.color, then.opacity) = (now.color, now.opacity);
                for (then, now) in then.parts.iter_mut().zip(&now.parts) {
                    (then.color, then.opacity) = (now.color, now.opacity);
                }
                (then.mass, then.inertia) = (now.mass, now.inertia);
            }
        }
    }
    if initial.notes != scene.notes {
        carry_over_custom_data(&mut initial.notes, &scene.notes);
        made.push(((WORLD_UID, Property::WORLD_NOTES), tatu_scene::notes_value(&initial.notes)));
    }
    made
}

/// Replaces the live scene by `next`. All velocities are reset.
fn replace_scene(cell: &WorldCell, mut next: Scene) {
    let mut scene = cell.state.scene.borrow_mut();
    // The new version causes the engine and the beams to rebuild all data that they derive from the scene.
    next.versions.shape = scene.versions.shape + 1;
    next.discard_barrier_poses();
    *scene = next;
    *cell.state.dynamics.borrow_mut() = Dynamics::new(WorldModel::engine_settings(&cell.model.settings.borrow()));
    cell.devices.sensing.borrow_mut().discard_scene();
    for (slot, _) in scene.clone().slots() {
        match scene.get_mut(slot).map(|o| &mut o.data) {
            Some(ObjectVariant::Shape(s)) => s.body.0 = None,
            Some(ObjectVariant::Joint(j)) => (j.id, j.callback_called) = (None, false),
            _ => {}
        }
    }
    cell.state.dynamics.borrow_mut().update_bodies(&mut scene);
}
