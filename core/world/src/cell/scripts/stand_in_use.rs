//! Creates a stand-in when a script looks up an object that does not exist, and changes its kind to the one that its
//! use implies.

use tatu_plugin_api::abi::*;
use tatu_scene::{
    ObjectKind, ObjectVariant, Scene, Shape,
    document::DeviceSpec,
    property_table::{Property, PropertyOwner},
};

use crate::cell::{
    WorldCell,
    scripts::stand_ins::{StandIn, StandIns},
};

/// Enables stand-ins and the recording of their use. Every object of the document is a stand-in, too. `values` are the
/// names of the values, such as signals, that this run provides.
pub(crate) fn begin(world: &WorldCell, values: &[String]) {
    let (scene, origins) = (world.state.scene.borrow(), world.model.origins.borrow());
    let schema = |d: &DeviceSpec| world.model.registry.sensors.get(d.kind).and_then(|k| k.schemas.first().cloned());
    let list = world
        .model
        .document
        .objects
        .iter()
        .zip(origins.iter())
        .map(|(spec, id)| {
            let suffix = scene.resolve(*id).ok().and_then(|s| scene.get(s)).map_or(-1, |o| o.suffix());
            let kind = match spec.kind {
                ObjectKind::Sensor => spec.device.as_ref().and_then(schema),
                _ => None,
            };
            let kind = kind.unwrap_or_else(|| spec.kind.name().to_owned());
            (
                *id,
                StandIn {
                    parent: spec.parent,
                    alias: spec.alias.clone(),
                    suffix,
                    kind,
                    script: !spec.scripts.is_empty(),
                },
            )
        })
        .collect();
    world.run.stand_ins.begin(list, values);
}

/// Returns the object with a path or unique name, creating it if it does not exist. `from` is the object that "."
/// refers to and under which objects with unique names are created. Returns `None` if `name` is not a valid name, or if
/// there are too many stand-ins.
pub(crate) fn find_or_create(world: &WorldCell, from: u32, name: &str) -> Option<tatu_object> {
    let mut scene = world.state.scene.try_borrow_mut().ok()?;
    let scene = &mut *scene;
    if let Some(slot) = scene.find(from, name) {
        return Some(scene.id(slot));
    }
    let stand_ins = &world.run.stand_ins;
    if name.starts_with(['/', '.', ':']) {
        let (mut at, rest) = scene.start_of(from, name)?;
        for part in rest.split('/').filter(|p| !p.is_empty()) {
            at = match scene.find_below(at, part) {
                Some(slot) => slot,
                None => create_path_part(stand_ins, scene, at, part)?,
            };
        }
        return (at != 0).then(|| scene.id(at));
    }
    let (alias, suffix) = match name.split_once('#') {
        Some((alias, n)) => (alias, n.parse().unwrap_or(-1)),
        None => (name, -1),
    };
    // Smaller suffixes are created first, so that the object gets the requested suffix.
    for _ in -1..suffix.clamp(-1, 63) + 1 {
        stand_ins.add(scene, from, &alias.replace('/', "_"))?;
        if let Some(slot) = scene.find_name(name) {
            return Some(scene.id(slot));
        }
    }
    None
}

/// Creates the object that one part of a path refers to, with as many siblings before it as its index requires.
fn create_path_part(stand_ins: &StandIns, scene: &mut Scene, at: u32, part: &str) -> Option<u32> {
    let alias = part.split(['[', '{']).next()?.replace(['*', '?'], "x");
    for _ in 0..64 {
        let made = stand_ins.add(scene, at, &alias)?;
        if let Some(slot) = scene.find_below(at, part) {
            return Some(slot);
        }
        // A wildcard that matches no existing name matches the new one.
        if !part.contains(['[', '{']) {
            return Some(made);
        }
    }
    None
}

/// Records that an object was used as a kind of object, or as a sensor with a schema. Returns whether it now has that
/// kind.
pub(crate) fn infer_kind(world: &WorldCell, object: tatu_object, kind: &str) -> bool {
    if !world.run.stand_ins.is_on() {
        return false;
    }
    let Ok(mut scene) = world.state.scene.try_borrow_mut() else { return false };
    let Ok(slot) = scene.resolve(object) else { return false };
    if !world.run.stand_ins.set_kind(scene.id(slot), kind) {
        return false;
    }
    let data = match ObjectKind::parse(kind) {
        Some(ObjectKind::Shape) => {
            ObjectVariant::Shape(Box::new(Shape { dynamic: true, respondable: true, ..Default::default() }))
        }
        Some(kind @ (ObjectKind::Joint | ObjectKind::ForceSensor)) => ObjectVariant::of_kind(kind, 0),
        // Sensors and actuators can be created only with the next document.
        _ => return false,
    };
    scene.change_kind(slot, data)
}

/// Records that a property was accessed that only a different kind of object has. Returns whether the object now has
/// that kind.
pub(crate) fn infer_kind_from_property(world: &WorldCell, object: tatu_object, row: Property) -> bool {
    match row.spec().owner {
        PropertyOwner::Kind(kind) if world.run.stand_ins.is_on() => infer_kind(world, object, kind.name()),
        _ => false,
    }
}
