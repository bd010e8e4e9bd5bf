//! Access to properties of objects, sensors, scripts and the world itself.

use nalgebra::Vector3;
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{
    self, ObjectVariant,
    document::{KeyTarget, preset_settings},
    noise::NoiseSpec,
    property_table::{Property, PropertyOwner},
};

use super::{
    answer::{HostResult, busy, slot},
    devices,
};
use crate::{
    cell::{WorldCell, WorldModel, scripts::stand_in_use},
    instances::set_targets,
};

pub(super) fn refuse_with(world: &WorldCell, r: Refusal) -> tatu_status {
    world.run.calls.refuse(r.0, &r.1)
}

pub(super) fn read(world: &WorldCell, object: tatu_object, prop: tatu_prop) -> Result<Value, tatu_status> {
    let value = read_row(world, object, prop);
    match value {
        Err(TATU_ERR_ARGUMENT) if stand_in_use::infer_kind_from_property(world, object, Property::of(prop)) => {
            read_row(world, object, prop)
        }
        value => value,
    }
}

fn read_row(world: &WorldCell, object: tatu_object, prop: tatu_prop) -> Result<Value, tatu_status> {
    let scene = world.borrow_part(|w| &w.state.scene).ok_or_else(|| busy(world))?;
    let row = Property::of(prop);
    if row == Property::WORLD_NOTES {
        return Ok(tatu_scene::notes_value(&scene.notes));
    }
    if object == 0 || row.spec().owner == PropertyOwner::World && row != Property::NONE {
        return read_world(world, row);
    }
    let slot = slot(world, &scene, object)?;
    if let Some(set) = world.worker.as_ref().and_then(|worker| worker.number(slot, row)) {
        return Ok(Value::Float(set));
    }
    match (row, scene.get(slot).map(|o| &o.data)) {
        (Property::NONE, _) => {
            drop(scene);
            devices::read(world, slot, prop)
        }
        (Property::SENSOR_KIND, Some(ObjectVariant::Sensor(s))) => {
            Ok(Value::text(world.model.registry.sensors.get(s.kind).map_or("", |k| k.id.as_str())))
        }
        (Property::SENSOR_MEASURED | Property::SENSOR_BEAMS, Some(ObjectVariant::Sensor(_))) => {
            let sensing = world.borrow_part(|w| &w.devices.sensing).ok_or_else(|| busy(world))?;
            let device = sensing.index(slot).map(|i| &sensing.devices[i]);
            Ok(Value::Int(device.map_or(0, |d| match row {
                Property::SENSOR_BEAMS => d.layout.plan.count() as i64,
                _ => d.sequence as i64,
            })))
        }
        (Property::TWIST | Property::LOCAL_TWIST, Some(_)) => {
            let dynamics = world.borrow_part(|w| &w.state.dynamics).ok_or_else(|| busy(world))?;
            let twist = world.state.twist(&scene, &dynamics, slot);
            if row == Property::TWIST {
                return Ok(Value::Floats(twist.to_vec()));
            }
            let [vx, vy, vz, wx, wy, wz] = twist;
            let own = scene.world(slot).rotation.inverse();
            let (v, w) = (own * Vector3::new(vx, vy, vz), own * Vector3::new(wx, wy, wz));
            Ok(Value::Floats(v.iter().chain(&w).copied().collect()))
        }
        (Property::PART_CALLS, Some(ObjectVariant::Part(_))) => {
            let actuators = world.borrow_part(|w| &w.devices.actuators).ok_or_else(|| busy(world))?;
            let part = actuators.device(scene.id(slot)).and_then(|d| d.part.as_deref());
            Ok(Value::Int(part.map_or(0, |p| p.calls as i64)))
        }
        (Property::ACTUATOR_KIND | Property::PART_KIND, Some(ObjectVariant::Actuator(a) | ObjectVariant::Part(a))) => {
            Ok(Value::text(world.model.registry.actuators.get(a.kind).map_or("", |k| k.id.as_str())))
        }
        (
            Property::SCRIPT_LANGUAGE
            | Property::SCRIPT_DIALECT
            | Property::SCRIPT_KIND
            | Property::SCRIPT_NAME
            | Property::SCRIPT_CALLS
            | Property::SCRIPT_INSTRUCTIONS,
            Some(ObjectVariant::Script),
        ) => {
            let script = world.run.scripts.try_borrow().map_err(|_| busy(world))?.by_slot(slot);
            let Some(s) = script else { return Err(world.run.calls.refuse(TATU_ERR_GONE, "the script has ended")) };
            Ok(match row {
                Property::SCRIPT_LANGUAGE => Value::text(&world.model.registry.scripting.languages[s.language].id),
                Property::SCRIPT_DIALECT => {
                    let dialect = s.instance.dialect.get();
                    // SAFETY: the string is owned by the script's instance, which is alive until the string has been
                    // copied.
                    Value::text(unsafe { tatu_plugins::border::bytes(dialect) })
                }
                Property::SCRIPT_KIND => Value::text(&s.kind_name),
                Property::SCRIPT_NAME => Value::text(&s.name),
                Property::SCRIPT_INSTRUCTIONS => Value::Int(s.counters.instructions.get() as i64),
                _ => Value::Int(s.counters.calls.get() as i64),
            })
        }
        _ => tatu_scene::get(&scene, slot, row).map_err(|r| refuse_with(world, r)),
    }
}

pub(super) fn read_world(world: &WorldCell, row: Property) -> Result<Value, tatu_status> {
    let phase = world.state.phase.get();
    Ok(match row {
        Property::TIME => Value::Float(world.state.clock.time.get()),
        Property::CLOCK_TIME => {
            Value::Float(world.run.connections.clocks.clock.get().unwrap_or(world.state.clock.time.get()))
        }
        Property::EPOCH => Value::Int(world.run.connections.clocks.epoch.get()),
        Property::DT => Value::Float(world.state.clock.dt.get()),
        Property::STEP => Value::Int(world.state.clock.step.get() as i64),
        Property::SCENE_FILE => {
            Value::text(world.model.document.file.as_ref().map_or(String::new(), |f| f.display().to_string()))
        }
        Property::SCENE_NOTES => {
            Value::List(world.model.document.reports.iter().map(|r| Value::text(r.text.as_str())).collect())
        }
        Property::RUNNING => Value::Bool(world.running()),
        Property::STOPPING => Value::Bool(phase.is_ending()),
        Property::PHASE => Value::Int(phase as i64),
        _ => {
            let settings = world.borrow_part(|w| &w.model.settings).ok_or_else(|| busy(world))?;
            return row.setting(&settings).ok_or_else(|| {
                world.run.calls.refuse(TATU_ERR_MISSING, &format!("the world has no property `{}`", row.key()))
            });
        }
    })
}

pub(super) fn write(world: &WorldCell, object: tatu_object, prop: tatu_prop, value: Value) -> HostResult {
    let row = Property::of(prop);
    if world.worker.is_some() {
        let Some(x) = number(&value) else { return Err(busy(world)) };
        return defer_set(world, object, row, x);
    }
    if row == Property::NONE {
        return devices::write(world, object, prop, value);
    }
    let value =
        row.check(value).map_err(|e| world.run.calls.refuse(TATU_ERR_ARGUMENT, &add_object_path(world, object, e)))?;
    if row == Property::WORLD_NOTES {
        let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
        world.check_custom_data(&scene, 0, &value)?;
        scene.notes = tatu_scene::notes(&value).map_err(|r| refuse_with(world, r))?;
        return Ok(());
    }
    if row.spec().owner == PropertyOwner::World {
        return write_world(world, row, &value);
    }
    let value = match row {
        Property::PRESET | Property::NOISE => resolve_kind_value(world, object, row, value)?,
        _ => value,
    };
    let set = || {
        let slot = {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            let slot = slot(world, &scene, object)?;
            if row == Property::NOTES {
                world.check_custom_data(&scene, slot, &value)?;
            }
            slot
        };
        let done = match row {
            Property::SENSOR_TARGETS | Property::ACTUATOR_TARGETS => set_targets(world, slot, row, &value),
            _ => world.set_property(slot, row, &value),
        };
        done.map_err(|Refusal(status, text)| {
            let text = if status == TATU_ERR_ARGUMENT { add_object_path(world, object, text) } else { text };
            refuse_with(world, Refusal(status, text))
        })
    };
    match set() {
        Err(TATU_ERR_ARGUMENT) if stand_in_use::infer_kind_from_property(world, object, row) => set(),
        done => done,
    }
}

/// Adds the object to a message that begins with the key of a property.
fn add_object_path(world: &WorldCell, object: tatu_object, text: String) -> String {
    let path = world.state.scene.try_borrow().ok().and_then(|s| Some(s.path(s.resolve(object).ok()?)));
    match (path, text.split_once("`: ")) {
        (Some(path), Some((key, rest))) => format!("{key}` of {path}: {rest}"),
        _ => text,
    }
}

/// Processes properties of a sensor that depend on its kind: applies a preset, or checks the noise and replaces the
/// names of its fields by their full names.
fn resolve_kind_value(
    world: &WorldCell,
    object: tatu_object,
    row: Property,
    value: Value,
) -> Result<Value, tatu_status> {
    let kind = {
        let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
        match scene.get(slot(world, &scene, object)?).map(|o| &o.data) {
            Some(ObjectVariant::Sensor(s)) => world.model.registry.sensors.get(s.kind),
            _ => None,
        }
    };
    // Other objects do not have these properties, which is reported when the property is set.
    let (Some(kind), Value::Text(text)) = (kind, &value) else { return Ok(value) };
    let text = String::from_utf8_lossy(text);
    let refuse = |e: tatu_errors::Error| {
        let help = e.help.as_ref().map_or(String::new(), |h| format!("; {h}"));
        world.run.calls.refuse(TATU_ERR_ARGUMENT, &format!("`{}`: {}{help}", row.key(), e.text))
    };
    if row == Property::NOISE {
        let noise = NoiseSpec::parse(&text, Some(kind)).map_err(|w| refuse(w.with_line(&text)))?;
        return Ok(Value::text(noise.to_toml()));
    }
    if !text.is_empty() {
        let (mut params, mut rows) = (Vec::new(), Vec::new());
        for setting in preset_settings(&world.model.registry, kind, &text).map_err(refuse)? {
            match setting.target {
                KeyTarget::Param(at) => params.push((at, setting.value)),
                KeyTarget::Property(row) => rows.push((row, setting.value)),
            }
        }
        if !params.is_empty() {
            devices::write_params(world, object, params)?;
        }
        for (row, value) in rows {
            write(world, object, row.number(), value)?;
        }
    }
    Ok(value)
}

pub(super) fn write_world(world: &WorldCell, row: Property, value: &Value) -> HostResult {
    match (row, value) {
        (Property::GRAVITY, Value::Floats(v)) => {
            let mut settings = world.model.settings.try_borrow_mut().map_err(|_| busy(world))?;
            settings.gravity = nalgebra::Vector3::new(v[0], v[1], v[2]);
            let engine = WorldModel::engine_settings(&settings);
            world.state.dynamics.try_borrow_mut().map_err(|_| busy(world))?.configure(engine);
            Ok(())
        }
        _ => {
            Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, &format!("`{}` cannot be changed by plugins", row.key())))
        }
    }
}

pub(super) fn read_numbers(world: &WorldCell, object: tatu_object, prop: tatu_prop, out: &mut [f64]) -> HostResult {
    let row = Property::of(prop);
    if let ([x], Property::TIME) = (&mut *out, row) {
        *x = world.state.clock.time.get();
        return Ok(());
    }
    let scene = world.borrow_part(|w| &w.state.scene).ok_or_else(|| busy(world))?;
    if object != 0 {
        let slot = slot(world, &scene, object)?;
        if let (Some(worker), [x]) = (&world.worker, &mut *out)
            && let Some(set) = worker.number(slot, row)
        {
            *x = set;
            return Ok(());
        }
        if tatu_scene::get_numbers(&scene, slot, row, out) == Some(out.len()) {
            return Ok(());
        }
    }
    drop(scene);
    match read(world, object, prop) {
        Ok(Value::Float(x)) if out.len() == 1 => out[0] = x,
        Ok(Value::Int(i)) if out.len() == 1 => out[0] = i as f64,
        Ok(Value::Floats(v)) if v.len() == out.len() => out.copy_from_slice(&v),
        Ok(_) => {
            let key = world.model.registry.host().key(prop).unwrap_or_default();
            let text = format!("`{key}` does not consist of {} numbers", out.len());
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &text));
        }
        Err(status) => return Err(status),
    }
    Ok(())
}

pub(super) fn write_numbers(world: &WorldCell, object: tatu_object, prop: tatu_prop, v: &[f64]) -> HostResult {
    let row = Property::of(prop);
    if let (Some(_), [x]) = (&world.worker, v) {
        return defer_set(world, object, row, *x);
    }
    if object != 0 {
        let slot = {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            slot(world, &scene, object)?
        };
        if let Some(done) = world.set_numbers(slot, row, v) {
            return done.map_err(|r| refuse_with(world, r));
        }
    }
    let value = match v {
        [x] if row.spec().kind == TATU_F64 => Value::Float(*x),
        _ => Value::Floats(v.to_vec()),
    };
    write(world, object, prop, value)
}

/// In a parallel script, records a new value for a property of a joint's drive, which is applied after all scripts of
/// the stage have run.
fn defer_set(world: &WorldCell, object: tatu_object, row: Property, x: f64) -> HostResult {
    let slot = {
        let scene = world.borrow_part(|w| &w.state.scene).ok_or_else(|| busy(world))?;
        slot(world, &scene, object)?
    };
    world.defer_set(slot, row, x).map_err(|text| world.run.calls.refuse(TATU_ERR_BUSY, &text))
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(x) => Some(*x),
        Value::Int(i) => Some(*i as f64),
        _ => None,
    }
}
