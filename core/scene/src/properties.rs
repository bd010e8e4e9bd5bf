//! Reads and sets properties of live objects.

use nalgebra::Vector3;
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::texts::label;

use crate::{
    ALIAS, Data, Derived, Object, Scene,
    body_rules::has_special_surface,
    centre_of_mass, from_euler, inertia, is_alias, mass, mechanisms, pose_from_array, pose_to_array,
    property::{Effect, Of, put, refuse},
    rows::Row,
    to_euler,
};

fn lacks<T>(scene: &Scene, slot: u32, row: Row) -> Result<T, Refusal> {
    let kind = scene.get(slot).map_or("nothing", |o| o.kind().name());
    let owners = match row.info().of {
        Of::Kind(k) => format!("objects of kind `{}`", k.name()),
        _ => "other objects".to_owned(),
    };
    let (key, path) = (row.key(), scene.path(slot));
    refuse(TATU_ERR_ARGUMENT, format!("object {slot} `{path}` is of kind `{kind}`; `{key}` is a property of {owners}"))
}

fn is_pose(row: Row) -> bool {
    matches!(row, Row::POSITION | Row::QUATERNION | Row::ORIENTATION | Row::POSE | Row::WORLD_POSE)
}

/// Returns whether a property is a numeric parameter of a joint's drive.
pub fn is_drive(row: Row) -> bool {
    row.info().effect == Effect::Drive && row.info().kind == TATU_F64
}

/// Returns a property of an object.
pub fn get(scene: &Scene, slot: u32, row: Row) -> Result<Value, Refusal> {
    let Some(o) = scene.get(slot) else { return refuse(TATU_ERR_MISSING, format!("there is no object {slot}")) };
    let info = row.info();
    if !info.is_of(Some(o.kind())) {
        return lacks(scene, slot, row);
    }
    let found = computed(scene, slot, o, row).or_else(|| (info.access.get)(o.place(info.of)));
    found.map_or_else(|| refuse(TATU_ERR_UNSUPPORTED, format!("`{}` cannot be read here", info.key)), Ok)
}

/// Returns a property that is computed from others, or from the tree.
fn computed(scene: &Scene, slot: u32, o: &Object, row: Row) -> Option<Value> {
    Some(match row {
        Row::PATH => Value::text(scene.path(slot)),
        Row::PARENT => Value::Object(scene.id(o.parent)),
        Row::MODEL_BASE => Value::Bool(scene.is_model_base(slot)),
        Row::JOINT_SOLVER_USED => Value::text(mechanisms::solver_used(scene, slot)),
        Row::MASS => Value::Float(mass(o.shape()?)),
        Row::INERTIA => Value::Floats(inertia(o.shape()?).transpose().as_slice().to_vec()),
        Row::COM => Value::Floats(centre_of_mass(o.shape()?).as_slice().to_vec()),
        _ if is_pose(row) => {
            let mut out = [0.0; 7];
            let count = numbers(scene, slot, row, &mut out)?;
            Value::Floats(out[..count].to_vec())
        }
        _ => return None,
    })
}

/// Reads a numeric property into `out`, without allocating memory. Returns the number of values, or `None` if their
/// number exceeds the length of `out`, the object lacks the property, or this function does not support the property.
pub fn numbers(scene: &Scene, slot: u32, row: Row, out: &mut [f64]) -> Option<usize> {
    let o = scene.get(slot)?;
    match row {
        Row::POSITION => put(out, scene.local(slot).translation.vector.as_slice()),
        Row::QUATERNION => put(out, scene.local(slot).rotation.coords.as_slice()),
        Row::ORIENTATION => put(out, &to_euler(&scene.local(slot).rotation)),
        Row::POSE => put(out, &pose_to_array(&scene.local(slot))),
        Row::WORLD_POSE => put(out, &pose_to_array(&scene.world(slot))),
        Row::MASS => put(out, &[mass(o.shape()?)]),
        Row::COM => put(out, centre_of_mass(o.shape()?).as_slice()),
        _ => (row.info().access.read)(o.place(row.info().of), out),
    }
}

/// Sets a pose, a part of a pose, or a number. Returns `None` for other properties, which [`set`] supports, and if the
/// object does not exist or lacks the property.
pub fn set_numbers(scene: &mut Scene, slot: u32, row: Row, v: &[f64]) -> Option<Result<Effect, Refusal>> {
    let info = row.info();
    scene.get(slot).filter(|_| info.is_settable())?;
    if !info.spans(v) {
        return None;
    }
    if is_pose(row) {
        return set_pose(scene, slot, row, v);
    }
    let special = info.effect == Effect::Surface && has_special_surface(scene, slot);
    let o = scene.get_mut(slot)?;
    let done = (info.access.write)(o.place_mut(info.of), v)?;
    Some(affected(scene, slot, row, done, special))
}

fn set_pose(scene: &mut Scene, slot: u32, row: Row, v: &[f64]) -> Option<Result<Effect, Refusal>> {
    let mut local = scene.local(slot);
    let whole = match (row, v) {
        (Row::QUATERNION, [x, y, z, w]) => pose_from_array(&[0.0, 0.0, 0.0, *x, *y, *z, *w]),
        (Row::POSE | Row::WORLD_POSE, _) => pose_from_array(v.try_into().ok()?),
        (Row::POSITION, [x, y, z]) => {
            local.translation.vector = Vector3::new(*x, *y, *z);
            Some(local)
        }
        (Row::ORIENTATION, angles) => {
            local.rotation = from_euler(angles.try_into().ok()?);
            Some(local)
        }
        _ => return None,
    };
    let Some(whole) = whole else {
        return Some(refuse(TATU_ERR_ARGUMENT, format!("`{}`: the quaternion must not be zero", row.key())));
    };
    local = match row {
        Row::WORLD_POSE => scene.parent_frame(slot).inverse() * whole,
        Row::QUATERNION => {
            local.rotation = whole.rotation;
            local
        }
        _ => whole,
    };
    scene.set_local(slot, local);
    Some(Ok(Effect::Moved))
}

/// Sets a property of an object. Returns the effect of the change on the engine and on graphs, which the caller applies.
pub fn set(scene: &mut Scene, slot: u32, row: Row, value: &Value) -> Result<Effect, Refusal> {
    let info = row.info();
    let Some(o) = scene.get(slot) else { return refuse(TATU_ERR_MISSING, format!("there is no object {slot}")) };
    if !info.is_of(Some(o.kind())) {
        return lacks(scene, slot, row);
    }
    if !info.is_settable() {
        return refuse(TATU_ERR_UNSUPPORTED, format!("`{}` is read-only", info.key));
    }
    let converted;
    let value = match info.fits(value) {
        true => value,
        false => {
            converted = row.check(value.clone()).map_err(|e| Refusal(TATU_ERR_ARGUMENT, e))?;
            &converted
        }
    };
    if let Some(done) = set_in_tree(scene, slot, row, value) {
        return done;
    }
    let special = info.effect == Effect::Surface && has_special_surface(scene, slot);
    let done = scene.get_mut(slot).and_then(|o| (info.access.set)(o.place_mut(info.of), value));
    match done {
        Some(done) => affected(scene, slot, row, done, special),
        None => refuse(TATU_ERR_UNSUPPORTED, format!("`{}` can be set only in a scene file", info.key)),
    }
}

/// Sets a property that concerns the tree of objects; returns `None` for other properties.
fn set_in_tree(scene: &mut Scene, slot: u32, row: Row, value: &Value) -> Option<Result<Effect, Refusal>> {
    let text = match value {
        Value::Text(t) => String::from_utf8_lossy(t),
        _ => "".into(),
    };
    match (row, value) {
        (_, Value::Floats(v)) if is_pose(row) => return set_pose(scene, slot, row, v),
        (Row::MODEL_BASE, Value::Bool(on)) => scene.set_model_base(slot, *on),
        (Row::PARENT, Value::Object(id)) => {
            let parent = if *id == 0 { Ok(0) } else { scene.resolve(*id) };
            let Ok(parent) = parent else { return Some(refuse(TATU_ERR_GONE, "the new parent does not exist")) };
            if !scene.set_parent(slot, parent) {
                let text = "the new parent must not be the object or its descendant";
                return Some(refuse(TATU_ERR_ARGUMENT, text));
            }
        }
        (Row::ALIAS, _) => {
            if !is_alias(&text) {
                let text = format!("`{}` cannot be an alias: expected {ALIAS}", label(text.as_bytes()));
                return Some(refuse(TATU_ERR_ARGUMENT, text));
            }
            let suffix = scene.get(slot)?.suffix;
            scene.set_name(slot, &text, suffix);
        }
        (Row::NAME, _) => {
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
    Some(Ok(Effect::None))
}

/// Applies the effect of a change to the tree, and returns it.
fn affected(
    scene: &mut Scene,
    slot: u32,
    row: Row,
    done: Result<bool, String>,
    was_special: bool,
) -> Result<Effect, Refusal> {
    let info = row.info();
    match done {
        Err(text) => return refuse(TATU_ERR_ARGUMENT, format!("`{}`: {text}", info.key)),
        Ok(false) => return Ok(Effect::None),
        Ok(true) => {}
    }
    match info.effect {
        Effect::Look => scene.seen_version += 1,
        Effect::Colour => scene.color_version += 1,
        Effect::Sensors => scene.sensor_version += 1,
        Effect::Moved => scene.refresh(slot),
        Effect::Rebuild => scene.touch(slot),
        Effect::Motion => {
            scene.touch(slot);
            scene.refresh(slot);
        }
        Effect::Form => {
            if let Some(Data::Shape(s)) = scene.get_mut(slot).map(|o| &mut o.data) {
                s.derived = Derived::default();
            }
            scene.touch(slot);
        }
        // The solver of a mechanism depends on whether its surfaces are special.
        Effect::Surface if has_special_surface(scene, slot) != was_special => scene.shape_version += 1,
        Effect::Surface | Effect::Drive | Effect::Graph | Effect::None | Effect::ReadOnly => {}
    }
    Ok(info.effect)
}
