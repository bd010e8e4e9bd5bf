//! The readings of sensors, with the fields that their plugins declare.

use tatu_devices::sense::{OutlineEdge, edges};
use tatu_plugin_api::safe::Value;
use tatu_plugins::FieldSpec;

use super::World;
/// A sensor's last reading.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Path of the sensor.
    pub path: String,
    /// Id of the sensor's kind.
    pub kind: String,
    /// Schemas that the kind fills, such as `range_scan/1`.
    pub schemas: Vec<String>,
    /// Simulation time of the measurement, s.
    pub time: f64,
    /// Number of measurements so far; 0 if the sensor has not been measured.
    pub sequence: u64,
    /// Current pose of the sensor in the world frame: position x y z, m, and quaternion x y z w.
    pub pose: [f64; 7],
    /// Outline of the sensor's beams, in the sensor's frame.
    pub edges: Vec<OutlineEdge>,
    /// Fields of the reading, in the order of their declaration.
    pub fields: Vec<ReadingField>,
}

/// A field of a reading.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingField {
    /// Name of the field, `schema.field`.
    pub name: String,
    /// Unit of the field, if it has one.
    pub unit: Option<String>,
    /// Number of elements along each axis, outermost first; 1 for unused axes.
    pub dims: [u32; 3],
    /// Value of the field.
    pub value: Value,
}

impl Reading {
    /// Returns the values of a field, or `None` if there is no such field or its values are not floats.
    pub fn floats(&self, name: &str) -> Option<&[f64]> {
        match self.field(name)? {
            ReadingField { value: Value::Floats(f), .. } => Some(f),
            _ => None,
        }
    }
    /// Returns the field with this name.
    pub fn field(&self, name: &str) -> Option<&ReadingField> {
        self.fields.iter().find(|f| f.name == name)
    }
}

impl World {
    /// Returns the last payload of an event that a referee has published since the start. Events with this name that
    /// other scripts publish are ignored.
    pub fn verdict(&self, event: &str) -> Option<Value> {
        self.cell().run.connections.verdicts.borrow().get(event).cloned()
    }

    /// Returns the paths of all sensors, and of actuators that report readings, in the order in which they were
    /// created.
    pub fn sensors(&self) -> Vec<String> {
        let cell = self.cell();
        let (scene, sensing) = (cell.state.scene.borrow(), cell.devices.sensing.borrow());
        sensing.devices.iter().filter(|d| scene.get(d.slot).is_some()).map(|d| scene.path(d.slot)).collect()
    }

    /// Returns the path among those of [`sensors`](Self::sensors) that is most similar to a misspelt path or alias, for
    /// messages.
    pub fn nearest_sensor(&self, path: &str) -> Option<String> {
        let paths = self.sensors();
        let last = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
        let aliases: Vec<String> = paths.iter().map(|path| last(path)).collect();
        let nearest = tatu_errors::nearest(&last(path), aliases.iter().map(String::as_str))?;
        paths.into_iter().find(|path| last(path) == nearest)
    }

    /// Returns the path of an object, given its slot as stored in fields of readings, or `None` if it does not exist.
    pub fn path_of(&self, slot: i64) -> Option<String> {
        let scene = self.cell().state.scene.borrow();
        let slot = u32::try_from(slot).ok().filter(|s| *s != 0)?;
        scene.get(slot).map(|_| scene.path(slot))
    }

    /// Returns the last reading of a sensor, given by path or unique name, or `None` if it does not exist.
    pub fn reading(&self, path: &str) -> Option<Reading> {
        let cell = self.cell();
        let (scene, sensing) = (cell.state.scene.borrow(), cell.devices.sensing.borrow());
        let slot = scene.find(0, path)?;
        let device = sensing.device(slot)?;
        let kind = &cell.model.registry.sensors[device.kind];
        let field = |(i, f): (usize, &FieldSpec)| ReadingField {
            name: f.name.clone(),
            unit: f.unit.clone(),
            dims: device.view(kind, i).dims,
            value: device.value(kind, i),
        };
        Some(Reading {
            path: scene.path(slot),
            kind: kind.id.clone(),
            schemas: kind.schemas.clone(),
            time: device.time,
            sequence: device.sequence,
            pose: tatu_scene::pose_to_array(&scene.world(slot)),
            edges: edges(&device.layout.plan),
            fields: kind.fields.iter().enumerate().map(field).collect(),
        })
    }
}
