//! Access to properties of objects by path, for programs that drive a world, between two steps.

use tatu_errors::{Refusal, nearest};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{
    ObjectVariant,
    property_table::{Property, properties_of},
};

use super::{answer::HostResult, properties};
use crate::{cell::WorldCell, run::World};

impl World {
    /// Returns a property of an object, given by path or unique name. `key` is a property such as `joint.position`, or
    /// a parameter or command of a sensor or actuator in the form `<kind>.<key>`. An empty path stands for the world
    /// itself, which has keys such as `scene.time`.
    ///
    /// # Errors
    /// There is no such object or property.
    pub fn get(&self, path: &str, key: &str) -> Result<Value, Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        properties::read(cell, object, property_number(cell, key))
            .map_err(|status| refusal_with_hint(cell, status, object, key))
    }

    /// Sets a property of an object, as a script would; path and key are as for [`get`](Self::get). The change is not
    /// recorded in the input log.
    ///
    /// # Errors
    /// There is no such object or property, the value is invalid, or a plugin refuses it.
    pub fn set(&self, path: &str, key: &str, value: &Value) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        let done: HostResult = properties::write(cell, object, property_number(cell, key), value.clone());
        done.map_err(|status| refusal_with_hint(cell, status, object, key))?;
        cell.restore_process_state("a change by the program");
        Ok(())
    }
}

/// Numeric values of an object that are looked up once by [`World::channel`], and can then be read or set in each step.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    object: tatu_object,
    source: ChannelSource,
    /// Number of elements along each axis; empty for a single number.
    pub shape: Vec<usize>,
    /// Lowest and highest value of each number, if the declaration of the property limits it.
    pub bounds: [Option<f64>; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ChannelSource {
    /// A property.
    Property(tatu_prop),
    /// A field of a sensor's reading, by its index.
    Field(usize),
}

impl World {
    /// Looks up numeric values of an object, given by path or unique name: a field of its readings, such as
    /// `range_scan.ranges`, or a property, as for [`get`](Self::get).
    ///
    /// # Errors
    /// There is no such object, field or property, or the field or property does not consist of numbers.
    pub fn channel(&self, path: &str, name: &str) -> Result<Channel, Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        if let Some((field, shape)) = field(cell, object, name) {
            return Ok(Channel { object, source: ChannelSource::Field(field), shape, bounds: [None; 2] });
        }
        let prop = property_number(cell, name);
        let value =
            properties::read(cell, object, prop).map_err(|status| refusal_with_hint(cell, status, object, name))?;
        let shape = match &value {
            Value::Bool(_) | Value::Int(_) | Value::Float(_) => Vec::new(),
            Value::Floats(v) => vec![v.len()],
            Value::Ints(v) => vec![v.len()],
            _ => return Err(Refusal(TATU_ERR_ARGUMENT, format!("`{name}` of `{path}` does not consist of numbers"))),
        };
        let bounds = Property::of(prop).declaration().bounds();
        Ok(Channel { object, source: ChannelSource::Property(prop), shape, bounds })
    }

    /// Reads the current values of a channel into `out`, which must have as many elements as the shape of the channel.
    /// If a reading has become shorter, the rest of `out` is filled with NaN; if it has become longer, its excess is
    /// omitted.
    ///
    /// # Errors
    /// The object or the property no longer exists.
    pub fn read_channel(&self, channel: &Channel, out: &mut [f64]) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let value = match channel.source {
            ChannelSource::Property(prop) => {
                properties::read(cell, channel.object, prop).map_err(|status| last_refusal(cell, status))?
            }
            ChannelSource::Field(field) => {
                let (scene, sensing) = (cell.state.scene.borrow(), cell.devices.sensing.borrow());
                let device = scene.resolve(channel.object).ok().and_then(|slot| sensing.device(slot));
                let Some(device) = device else {
                    return Err(Refusal(TATU_ERR_GONE, "the sensor no longer exists".into()));
                };
                device.value(&cell.model.registry.sensors[device.kind], field)
            }
        };
        fill(&value, out);
        Ok(())
    }

    /// Sets the property of a channel; `numbers` must have as many elements as the shape of the channel.
    ///
    /// # Errors
    /// The channel is a reading, which cannot be set; otherwise as for [`set`](Self::set).
    pub fn write_channel(&self, channel: &Channel, numbers: &[f64]) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let ChannelSource::Property(prop) = channel.source else {
            return Err(Refusal(TATU_ERR_ARGUMENT, "a reading of a sensor cannot be set".into()));
        };
        let value = match (channel.shape.as_slice(), numbers) {
            ([], [one]) => Value::Float(*one),
            _ => Value::Floats(numbers.to_vec()),
        };
        let done: HostResult = properties::write(cell, channel.object, prop, value);
        done.map_err(|status| last_refusal(cell, status))?;
        cell.restore_process_state("a change by the program");
        Ok(())
    }
}

/// Returns the index and the shape of a field of a sensor's reading.
fn field(cell: &WorldCell, object: tatu_object, name: &str) -> Option<(usize, Vec<usize>)> {
    let (scene, sensing) = (cell.state.scene.borrow(), cell.devices.sensing.borrow());
    let device = sensing.device(scene.resolve(object).ok()?)?;
    let kind = &cell.model.registry.sensors[device.kind];
    let at = kind.fields.iter().position(|f| f.name == name)?;
    let view = device.view(kind, at);
    let mut shape: Vec<usize> = view.dims.iter().map(|d| *d as usize).collect();
    while shape.len() > 1 && shape.last() == Some(&1) {
        shape.pop();
    }
    match shape.iter().product::<usize>() as u64 == view.len {
        true if shape == [1] => Some((at, Vec::new())),
        true => Some((at, shape)),
        false => Some((at, vec![view.len as usize])),
    }
}

/// Copies the numbers of a value to `out`, and fills the rest with NaN.
fn fill(value: &Value, out: &mut [f64]) {
    fn put(out: &mut [f64], numbers: impl Iterator<Item = f64>) -> usize {
        let mut n = 0;
        for (to, x) in out.iter_mut().zip(numbers) {
            *to = x;
            n += 1;
        }
        n
    }
    let n = match value {
        Value::Bool(b) => put(out, std::iter::once(f64::from(u8::from(*b)))),
        Value::Int(i) => put(out, std::iter::once(*i as f64)),
        Value::Float(x) => put(out, std::iter::once(*x)),
        Value::Floats(v) => put(out, v.iter().copied()),
        Value::Ints(v) => put(out, v.iter().map(|i| *i as f64)),
        Value::Bytes(v) => put(out, v.iter().map(|b| f64::from(*b))),
        _ => 0,
    };
    out[n..].fill(f64::NAN);
}

fn find(cell: &WorldCell, path: &str) -> Result<tatu_object, Refusal> {
    if path.is_empty() {
        return Ok(0);
    }
    let scene = cell.state.scene.borrow();
    if let Some(slot) = scene.find(0, path) {
        return Ok(scene.id(slot));
    }
    let near = scene.nearest(path).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    Err(Refusal(TATU_ERR_MISSING, format!("there is no object `{path}`{near}")))
}

fn property_number(cell: &WorldCell, key: &str) -> tatu_prop {
    cell.model.registry.host().number(key)
}

/// Returns a refusal with this status and the message of the last refusal.
fn last_refusal(cell: &WorldCell, status: tatu_status) -> Refusal {
    Refusal(status, cell.run.calls.last_refusal.borrow().text())
}

/// Like [`last_refusal`], but if the object does not have the property, the message suggests a similar one.
fn refusal_with_hint(cell: &WorldCell, status: tatu_status, object: tatu_object, key: &str) -> Refusal {
    let mut refusal = last_refusal(cell, status);
    if matches!(status, TATU_ERR_MISSING | TATU_ERR_ARGUMENT)
        && let Some(near) = nearest_property(cell, object, key)
    {
        refusal.1.push_str(&format!("; did you mean `{near}`?"));
    }
    refusal
}

/// Returns the property or field of an object whose name is most similar to `key`, or `None` if it has the property
/// `key`.
fn nearest_property(cell: &WorldCell, object: tatu_object, key: &str) -> Option<String> {
    let scene = cell.state.scene.borrow();
    let data = scene.resolve(object).ok().and_then(|slot| scene.get(slot));
    let mut names: Vec<String> = properties_of(data.map(|o| o.kind())).map(|row| row.key().to_owned()).collect();
    let registry = &cell.model.registry;
    let declared = match data.map(|o| &o.data) {
        Some(ObjectVariant::Sensor(s)) => {
            names.extend(registry.sensors[s.kind].fields.iter().map(|f| f.name.clone()));
            Some((&registry.sensors[s.kind].id, &registry.sensors[s.kind].params))
        }
        Some(ObjectVariant::Actuator(a) | ObjectVariant::Part(a)) => {
            Some((&registry.actuators[a.kind].id, &registry.actuators[a.kind].params))
        }
        _ => None,
    };
    if let Some((kind, params)) = declared {
        names.extend(params.iter().map(|p| format!("{kind}.{}", p.key)));
    }
    if names.iter().any(|name| name == key) {
        return None;
    }
    // The last part of the name has precedence: `target_velocity` probably means `joint.target_velocity`.
    let last = |name: &str| name.rsplit('.').next().map(str::to_owned);
    let same = names.iter().find(|name| last(name) == last(key));
    same.map(String::as_str).or_else(|| nearest(key, names.iter().map(String::as_str))).map(str::to_owned)
}
