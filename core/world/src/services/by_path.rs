//! Properties of objects by path, for programs that drive a world: between two steps, without a plugin.

use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use super::{answer::Done, properties};
use crate::{cell::WorldCell, run::World};

impl World {
    /// A property of an object by path or unique name: a row such as `joint.position`, or a parameter or command of a
    /// sensor or actuator, `<kind>.<key>`. An empty path is the world itself: `scene.time`.
    ///
    /// # Errors
    /// There is no such object or property.
    pub fn get(&self, path: &str, key: &str) -> Result<Value, Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        properties::read(cell, object, number(cell, key)).map_err(|status| why(cell, status))
    }

    /// Sets a property of an object, likewise, as a script would. It stands in no input log.
    ///
    /// # Errors
    /// There is no such object or property, the value does not fit, or a plugin refuses it.
    pub fn set(&self, path: &str, key: &str, value: &Value) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        let done: Done = properties::write(cell, object, number(cell, key), value.clone());
        done.map_err(|status| why(cell, status))?;
        cell.restore_process_state("a change by the program");
        Ok(())
    }
}

/// Numbers of an object, found once by [`World::channel`] and then read or set in each step.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    object: tatu_object,
    source: Source,
    /// How many numbers it has, along each axis; empty for a single number.
    pub shape: Vec<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// A property.
    Property(tatu_prop),
    /// A field of a sensor's reading, by its index.
    Field(usize),
}

impl World {
    /// Finds numbers of an object, given by path or unique name: a field of its readings, such as `range_scan.ranges`,
    /// or a property, as for [`get`](Self::get).
    ///
    /// # Errors
    /// There is no such object, field or property, or it does not consist of numbers.
    pub fn channel(&self, path: &str, name: &str) -> Result<Channel, Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        if let Some((field, shape)) = field(cell, object, name) {
            return Ok(Channel { object, source: Source::Field(field), shape });
        }
        let prop = number(cell, name);
        let value = properties::read(cell, object, prop).map_err(|status| why(cell, status))?;
        let shape = match &value {
            Value::Bool(_) | Value::Int(_) | Value::Float(_) => Vec::new(),
            Value::Floats(v) => vec![v.len()],
            Value::Ints(v) => vec![v.len()],
            _ => return Err(Refusal(TATU_ERR_ARGUMENT, format!("`{name}` of `{path}` does not consist of numbers"))),
        };
        Ok(Channel { object, source: Source::Property(prop), shape })
    }

    /// Reads the current numbers of a channel into `out`, which has as many elements as its shape says. A reading that
    /// has become shorter is filled with NaN, and of a longer one the rest is left out.
    ///
    /// # Errors
    /// The object no longer exists, or has lost the property.
    pub fn read_channel(&self, channel: &Channel, out: &mut [f64]) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let value = match channel.source {
            Source::Property(prop) => {
                properties::read(cell, channel.object, prop).map_err(|status| why(cell, status))?
            }
            Source::Field(field) => {
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

    /// Sets the property of a channel; `numbers` has as many elements as its shape says.
    ///
    /// # Errors
    /// It is a reading, which cannot be set, or as for [`set`](Self::set).
    pub fn write_channel(&self, channel: &Channel, numbers: &[f64]) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let Source::Property(prop) = channel.source else {
            return Err(Refusal(TATU_ERR_ARGUMENT, "a reading of a sensor cannot be set".into()));
        };
        let value = match (channel.shape.as_slice(), numbers) {
            ([], [one]) => Value::Float(*one),
            _ => Value::Floats(numbers.to_vec()),
        };
        let done: Done = properties::write(cell, channel.object, prop, value);
        done.map_err(|status| why(cell, status))?;
        cell.restore_process_state("a change by the program");
        Ok(())
    }
}

/// Finds a field of a sensor's reading by name, with its shape.
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

/// Writes the numbers of a value, then NaN.
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

fn number(cell: &WorldCell, key: &str) -> tatu_prop {
    cell.model.registry.host().number(key)
}

/// The sentence of the last refusal.
fn why(cell: &WorldCell, status: tatu_status) -> Refusal {
    Refusal(status, cell.run.calls.last.borrow().text())
}
