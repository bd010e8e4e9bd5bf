//! Reads and sets properties of live objects.

use nalgebra::Vector3;
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::texts::label;

use crate::{
    ALIAS_RULE, DerivedGeometry, Object, ObjectVariant, Scene,
    body_rules::has_special_surface,
    centre_of_mass, from_euler, inertia, is_alias, mass, mechanisms,
    object::any::MAX_COORDINATE,
    pose_from_array, pose_to_array,
    property::{ChangeEffect, PropertyOwner, copy_numbers, refuse},
    property_table::Property,
    to_euler,
};

fn refuse_unowned_property<T>(scene: &Scene, slot: u32, row: Property) -> Result<T, Refusal> {
    let kind = scene.get(slot).map_or("nothing", |o| o.kind().name());
    let owners = match row.spec().owner {
        PropertyOwner::Kind(k) => format!("objects of kind `{}`", k.name()),
        _ => "other objects".to_owned(),
    };
    let (key, path) = (row.key(), scene.path(slot));
    refuse(TATU_ERR_ARGUMENT, format!("object {slot} `{path}` is of kind `{kind}`; `{key}` is a property of {owners}"))
}

fn is_pose(row: Property) -> bool {
    matches!(
        row,
        Property::POSITION | Property::QUATERNION | Property::ORIENTATION | Property::POSE | Property::WORLD_POSE
    )
}

/// Returns whether a property is a numeric parameter of a joint's drive.
pub fn is_drive_parameter(row: Property) -> bool {
    row.spec().effect == ChangeEffect::Drive && row.spec().kind == TATU_F64
}

/// Returns a property of an object.
pub fn get(scene: &Scene, slot: u32, row: Property) -> Result<Value, Refusal> {
    let Some(o) = scene.get(slot) else { return refuse(TATU_ERR_MISSING, format!("there is no object {slot}")) };
    let info = row.spec();
    if !info.applies_to(Some(o.kind())) {
        return refuse_unowned_property(scene, slot, row);
    }
    let found = computed_value(scene, slot, o, row).or_else(|| (info.access.get)(o.property_store(info.owner)));
    found.map_or_else(
        || refuse(TATU_ERR_UNSUPPORTED, format!("`{}` can be read only from a running world", info.key)),
        Ok,
    )
}

/// Returns a property that is computed from others, or from the tree.
fn computed_value(scene: &Scene, slot: u32, o: &Object, row: Property) -> Option<Value> {
    Some(match row {
        Property::PATH => Value::text(scene.path(slot)),
        Property::PARENT => Value::Object(scene.id(o.parent)),
        Property::MODEL_BASE => Value::Bool(scene.is_model_base(slot)),
        Property::JOINT_SOLVER_USED => Value::text(mechanisms::solver_used(scene, slot)),
        Property::MASS => Value::Float(mass(o.shape()?)),
        Property::INERTIA => Value::Floats(inertia(o.shape()?).transpose().as_slice().to_vec()),
        Property::COM => Value::Floats(centre_of_mass(o.shape()?).as_slice().to_vec()),
        _ if is_pose(row) => {
            let mut out = [0.0; 7];
            let count = get_numbers(scene, slot, row, &mut out)?;
            Value::Floats(out[..count].to_vec())
        }
        _ => return None,
    })
}

/// Reads a numeric property into `out`, without allocating memory. Returns the number of values, or `None` if their
/// number exceeds the length of `out`, the object lacks the property, or this function does not support the property.
pub fn get_numbers(scene: &Scene, slot: u32, row: Property, out: &mut [f64]) -> Option<usize> {
    let o = scene.get(slot)?;
    match row {
        Property::POSITION => copy_numbers(out, scene.local(slot).translation.vector.as_slice()),
        Property::QUATERNION => copy_numbers(out, scene.local(slot).rotation.coords.as_slice()),
        Property::ORIENTATION => copy_numbers(out, &to_euler(&scene.local(slot).rotation)),
        Property::POSE => copy_numbers(out, &pose_to_array(&scene.local(slot))),
        Property::WORLD_POSE => copy_numbers(out, &pose_to_array(&scene.world(slot))),
        Property::MASS => copy_numbers(out, &[mass(o.shape()?)]),
        Property::COM => copy_numbers(out, centre_of_mass(o.shape()?).as_slice()),
        _ => (row.spec().access.read)(o.property_store(row.spec().owner), out),
    }
}

/// Sets a pose, a part of a pose, or a number. Returns `None` for other properties, which [`set`] supports, and if the
/// object does not exist or lacks the property.
pub fn set_numbers(scene: &mut Scene, slot: u32, row: Property, v: &[f64]) -> Option<Result<ChangeEffect, Refusal>> {
    let info = row.spec();
    scene.get(slot).filter(|_| info.is_settable())?;
    if !info.contains_all(v) {
        return None;
    }
    if is_pose(row) {
        return set_pose(scene, slot, row, v);
    }
    let special = info.effect == ChangeEffect::Surface && has_special_surface(scene, slot);
    let o = scene.get_mut(slot)?;
    let done = (info.access.write)(o.property_store_mut(info.owner), v)?;
    Some(apply_effect(scene, slot, row, done, special))
}

fn set_pose(scene: &mut Scene, slot: u32, row: Property, v: &[f64]) -> Option<Result<ChangeEffect, Refusal>> {
    let mut local = scene.local(slot);
    let whole = match (row, v) {
        (Property::QUATERNION, [x, y, z, w]) => pose_from_array(&[0.0, 0.0, 0.0, *x, *y, *z, *w]),
        (Property::POSE | Property::WORLD_POSE, _) => pose_from_array(v.try_into().ok()?),
        (Property::POSITION, [x, y, z]) => {
            local.translation.vector = Vector3::new(*x, *y, *z);
            Some(local)
        }
        (Property::ORIENTATION, angles) => {
            local.rotation = from_euler(angles.try_into().ok()?);
            Some(local)
        }
        _ => return None,
    };
    let Some(whole) = whole else {
        return Some(refuse(TATU_ERR_ARGUMENT, format!("`{}`: the quaternion must not be zero", row.key())));
    };
    if whole.translation.vector.amax() > MAX_COORDINATE {
        let text =
            format!("`{}`: coordinates must be between {:e} and {MAX_COORDINATE:e} m", row.key(), -MAX_COORDINATE);
        return Some(refuse(TATU_ERR_ARGUMENT, text));
    }
    local = match row {
        Property::WORLD_POSE => scene.parent_frame(slot).inverse() * whole,
        Property::QUATERNION => {
            local.rotation = whole.rotation;
            local
        }
        _ => whole,
    };
    scene.set_local(slot, local);
    Some(Ok(ChangeEffect::Moved))
}

/// Sets a property of an object. Returns the effect of the change on the engine and on graphs, which the caller
/// applies.
pub fn set(scene: &mut Scene, slot: u32, row: Property, value: &Value) -> Result<ChangeEffect, Refusal> {
    let info = row.spec();
    let Some(o) = scene.get(slot) else { return refuse(TATU_ERR_MISSING, format!("there is no object {slot}")) };
    if !info.applies_to(Some(o.kind())) {
        return refuse_unowned_property(scene, slot, row);
    }
    if !info.is_settable() {
        return refuse(TATU_ERR_UNSUPPORTED, format!("`{}` is read-only", info.key));
    }
    let converted;
    let value = match info.accepts(value) {
        true => value,
        false => {
            converted = row.check(value.clone()).map_err(|e| Refusal(TATU_ERR_ARGUMENT, e))?;
            &converted
        }
    };
    if let Some(done) = set_in_tree(scene, slot, row, value) {
        return done;
    }
    let special = info.effect == ChangeEffect::Surface && has_special_surface(scene, slot);
    let done = scene.get_mut(slot).and_then(|o| (info.access.set)(o.property_store_mut(info.owner), value));
    match done {
        Some(done) => apply_effect(scene, slot, row, done, special),
        None => refuse(TATU_ERR_UNSUPPORTED, format!("`{}` can be set only in a scene file", info.key)),
    }
}

/// Sets a property that concerns the tree of objects; returns `None` for other properties.
fn set_in_tree(scene: &mut Scene, slot: u32, row: Property, value: &Value) -> Option<Result<ChangeEffect, Refusal>> {
    let text = match value {
        Value::Text(t) => String::from_utf8_lossy(t),
        _ => "".into(),
    };
    match (row, value) {
        (_, Value::Floats(v)) if is_pose(row) => return set_pose(scene, slot, row, v),
        (Property::MODEL_BASE, Value::Bool(on)) => scene.set_model_base(slot, *on),
        (Property::PARENT, Value::Object(id)) => {
            let parent = if *id == 0 { Ok(0) } else { scene.resolve(*id) };
            let Ok(parent) = parent else { return Some(refuse(TATU_ERR_GONE, "the new parent does not exist")) };
            if !scene.set_parent(slot, parent) {
                let text = "the new parent must not be the object or its descendant";
                return Some(refuse(TATU_ERR_ARGUMENT, text));
            }
        }
        (Property::ALIAS, _) => {
            if !is_alias(&text) {
                let text = format!("`{}` cannot be an alias: expected {ALIAS_RULE}", label(text.as_bytes()));
                return Some(refuse(TATU_ERR_ARGUMENT, text));
            }
            let suffix = scene.get(slot)?.suffix;
            scene.set_name(slot, &text, suffix);
        }
        (Property::NAME, _) => {
            if scene.find_name(&text).is_some_and(|s| s != slot) {
                return Some(refuse(TATU_ERR_ARGUMENT, format!("another object already has the name `{text}`")));
            }
            let (alias, suffix) = text.split_once('#').map_or((&*text, Ok(-1)), |(a, n)| (a, n.parse()));
            let Some(suffix) = suffix.ok().filter(|_| is_alias(alias)) else {
                let shown = label(text.as_bytes());
                let text = format!("`{shown}` is not a name: expected an alias, or `alias#n`");
                return Some(refuse(TATU_ERR_ARGUMENT, text));
            };
            scene.set_name(slot, alias, suffix);
        }
        _ => return None,
    }
    Some(Ok(ChangeEffect::None))
}

/// Applies the effect of a change to the tree, and returns it.
fn apply_effect(
    scene: &mut Scene,
    slot: u32,
    row: Property,
    done: Result<bool, String>,
    was_special: bool,
) -> Result<ChangeEffect, Refusal> {
    let info = row.spec();
    match done {
        Err(text) => return refuse(TATU_ERR_ARGUMENT, format!("`{}`: {text}", info.key)),
        Ok(false) => return Ok(ChangeEffect::None),
        Ok(true) => {}
    }
    match info.effect {
        ChangeEffect::Look => scene.versions.seen += 1,
        ChangeEffect::Colour => scene.versions.color += 1,
        ChangeEffect::Sensors => scene.versions.sensor += 1,
        ChangeEffect::Moved => scene.refresh(slot),
        ChangeEffect::Rebuild => scene.touch(slot),
        ChangeEffect::Motion => {
            scene.touch(slot);
            scene.refresh(slot);
        }
        ChangeEffect::Form => {
            if let Some(ObjectVariant::Shape(s)) = scene.get_mut(slot).map(|o| &mut o.data) {
                s.derived = DerivedGeometry::default();
            }
            scene.touch(slot);
        }
        // The solver of a mechanism depends on whether its surfaces are special.
        ChangeEffect::Surface if has_special_surface(scene, slot) != was_special => scene.versions.shape += 1,
        ChangeEffect::Surface
        | ChangeEffect::Drive
        | ChangeEffect::Graph
        | ChangeEffect::None
        | ChangeEffect::ReadOnly => {}
    }
    Ok(info.effect)
}
