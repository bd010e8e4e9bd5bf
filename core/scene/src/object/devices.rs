//! Sensors, actuators and parts.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::safe::Value;

use super::ObjectKind;
use crate::{
    noise::NoiseSpec,
    property::{properties, text_of, unexpected},
};

/// A sensor. Data that most sensors lack is allocated separately, which keeps objects small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct SensorObject {
    /// Noise that is added to the fields of each measurement.
    pub noise: Option<Arc<NoiseSpec>>,
    /// Measurement rate, Hz; 0 stands for each step.
    pub rate: f64,
    /// Index of the sensor's kind in the registry.
    pub kind: usize,
    /// Name of the preset that was last set; empty if none was set.
    pub preset: Box<str>,
    /// Whether the sensor measures only on request.
    pub explicit: bool,
    /// The objects that the sensor detects; if `None`, all objects.
    pub view: Option<Arc<SensorTargets>>,
}

/// The objects that a sensor detects, by paths relative to the sensor. Each path includes all descendants of its
/// object; if paths are nested, the innermost one takes precedence.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorTargets {
    /// Paths of the objects that are detected; if empty, all objects.
    pub targets: Vec<String>,
    /// Paths of the objects that are not detected.
    pub ignored: Vec<String>,
}

impl SensorObject {
    /// Creates a sensor with default settings; `kind` is an index in the registry.
    pub fn new(kind: usize) -> Self {
        SensorObject { kind, explicit: false, rate: 0.0, preset: Box::default(), noise: None, view: None }
    }

    fn paths(&self, list: impl Fn(&SensorTargets) -> &Vec<String>) -> Value {
        Value::List(self.view.iter().flat_map(|v| list(v)).map(Value::text).collect())
    }

    fn set_paths(
        &mut self,
        value: &Value,
        list: impl Fn(&mut SensorTargets) -> &mut Vec<String>,
    ) -> Result<bool, String> {
        let mut view = self.view.as_deref().cloned().unwrap_or_default();
        *list(&mut view) = paths_in(value)?;
        self.view = (view != SensorTargets::default()).then(|| Arc::new(view));
        Ok(true)
    }
}

/// Returns the paths in a list.
fn paths_in(value: &Value) -> Result<Vec<String>, String> {
    let Value::List(all) = value else { return unexpected(value) };
    let path = |v: &Value| text_of(v).map_err(|found| format!("expected a list of paths as strings, {found} in it"));
    all.iter().map(path).collect()
}

/// The properties of an actuator or a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ActuatorObject {
    /// Index of its kind in the registry, among the kinds of actuators.
    pub kind: usize,
    /// Current values of the commands that its kind declares. They change during a run, and a stop resets
    /// them.
    pub commands: Vec<f64>,
    /// Paths of the actuator's targets, relative to the actuator; empty for a part.
    pub targets: Vec<String>,
}

/// Merges a noise declaration, in TOML, into that of the sensor; an empty declaration removes all noise.
fn set_noise(s: &mut SensorObject, value: &Value) -> Result<bool, String> {
    let text = text_of(value)?;
    let more = NoiseSpec::parse(&text, None).map_err(|w| w.with_line(&text).text)?;
    s.noise = more.merge_over(s.noise.as_deref()).map(Arc::new);
    Ok(true)
}

properties! { SENSOR: SensorObject, PropertyOwner::Kind(ObjectKind::Sensor) =>
    "sensor.kind" text, ReadOnly _: "Id of the sensor's kind.";
    "sensor.explicit" bool = false, Sensors explicit: "Whether the sensor measures only on request; sensors that measure in each physics step ignore this.";
    "sensor.preset" text = none, None { get |s: &SensorObject| Value::text(&*s.preset), set |s: &mut SensorObject, v| { s.preset = text_of(v)?.into(); Ok(true) } }: "Name of a preset of the sensor's kind; setting it applies all settings of the preset.";
    "sensor.rate" number in "Hz" from 0.0 = 0.0, Sensors rate: "Maximum rate at which the sensor measures; 0: in each step.";
    "sensor.noise" noise = none, Sensors { get |s: &SensorObject| Value::text(s.noise.as_ref().map_or(String::new(), |n| n.to_toml())), set set_noise }: "Noise of the sensor's fields, as TOML; setting it changes only the fields that the value contains; empty or `none` removes all noise.";
    "sensor.targets" list = none, Sensors { get |s: &SensorObject| s.paths(|v| &v.targets), set |s: &mut SensorObject, v| s.set_paths(v, |view| &mut view.targets) }: "Paths of the objects that the sensor detects, relative to the sensor, each with all descendants; empty: all. If the sensor's kind takes targets: the objects whose motion it receives.";
    "sensor.ignored" list = none, Sensors { get |s: &SensorObject| s.paths(|v| &v.ignored), set |s: &mut SensorObject, v| s.set_paths(v, |view| &mut view.ignored) }: "Paths of objects that the sensor does not detect, relative to the sensor, each with all descendants; if entries of both lists are nested, the innermost takes precedence.";
    "sensor.measured" int, ReadOnly _: "Number of measurements since the start, or since the reading was reset.";
    "sensor.beams" int, ReadOnly _: "Number of beams that the sensor emits; a volume is one beam.";
}

properties! { ACTUATOR: ActuatorObject, PropertyOwner::Kind(ObjectKind::Actuator) =>
    "actuator.kind" text, ReadOnly _: "Id of the actuator's kind.";
    "actuator.targets" list = none, None { get |a: &ActuatorObject| Value::List(a.targets.iter().map(Value::text).collect()), set |a: &mut ActuatorObject, v| { a.targets = paths_in(v)?; Ok(true) } }: "Paths of the objects on which the actuator acts, relative to the actuator; only for kinds that take targets.";
}

properties! { PART: ActuatorObject, PropertyOwner::Kind(ObjectKind::Part) =>
    "part.kind" text, ReadOnly _: "Id of the part's kind.";
    "part.calls" int, ReadOnly _: "Number of calls of the part's functions since its creation.";
}
