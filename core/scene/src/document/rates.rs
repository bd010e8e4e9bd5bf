//! Rates of sensors that a scene cannot reach, because a sensor measures at most once in each step.

use tatu_plugin_api::safe::Value;

use super::{BuildReport, Document, ObjectSpec};
use crate::property_table::{ObjectKind, Property};

/// Relative excess that is attributed to rounding: a step of 0.0133 s is meant for 75 Hz.
const TOLERANCE: f64 = 0.005;

/// Returns a note if sensors have a higher rate than the steps. It names the first of them.
pub(super) fn unreached(document: &Document) -> Option<BuildReport> {
    let steps_hz = 1.0 / document.settings.dt;
    let is_fast = |rate: f64| rate > steps_hz * (1.0 + TOLERANCE);
    let sensors = document.objects.iter().filter(|o| o.kind == ObjectKind::Sensor);
    let fast: Vec<(&ObjectSpec, f64)> = sensors.map(|o| (o, rate(o))).filter(|(_, rate)| is_fast(*rate)).collect();
    let (first, rate) = fast.first()?;
    let at = first.place.as_ref().map(|at| format!("{}:{}: ", at.file.display(), at.line)).unwrap_or_default();
    let others = match fast.len() - 1 {
        0 => String::new(),
        n => format!(" (and {n} other sensors)"),
    };
    let highest = fast.iter().map(|(_, rate)| *rate).fold(0.0, f64::max);
    let rounded = |x: f64| (x * 1e4).round() / 1e4;
    Some(BuildReport::note(format!(
        "{at}the sensor `{}`{others} has a rate of {} Hz, but measures at {} Hz, once in each step: its rate needs a \
         `dt_s` of the scene of at most {} s",
        first.alias,
        rounded(*rate),
        rounded(steps_hz),
        (1e4 / highest).floor() / 1e4,
    )))
}

/// Returns the rate of a sensor, Hz; 0: in each step.
fn rate(sensor: &ObjectSpec) -> f64 {
    match sensor.properties.iter().rev().find(|(row, _)| *row == Property::SENSOR_RATE) {
        Some((_, Value::Float(rate))) => *rate,
        Some((_, Value::Int(rate))) => *rate as f64,
        _ => 0.0,
    }
}
