//! Rates of sensors that a scene cannot reach, because a sensor measures at most once in each step.

use tatu_errors::SourceLocation;
use tatu_plugin_api::safe::Value;

use crate::property_table::Property;

/// Relative excess that is attributed to rounding: a step of 0.0133 s is meant for 75 Hz.
const TOLERANCE: f64 = 0.005;

/// A sensor of a document.
pub(super) struct RatedSensor<'a> {
    pub alias: &'a str,
    /// Where the document describes it.
    pub place: Option<&'a SourceLocation>,
    pub properties: &'a [(Property, Value)],
}

/// Returns a note if sensors have a higher rate than steps of `dt`, s. It names the first of them.
pub(super) fn unreached<'a>(dt: f64, sensors: impl Iterator<Item = RatedSensor<'a>>) -> Option<String> {
    let steps_hz = 1.0 / dt;
    let is_fast = |rate: f64| rate > steps_hz * (1.0 + TOLERANCE);
    let rated = sensors.map(|sensor| (rate(sensor.properties), sensor));
    let fast: Vec<(f64, RatedSensor<'_>)> = rated.filter(|(rate, _)| is_fast(*rate)).collect();
    let (rate, first) = fast.first()?;
    let at = first.place.map(|at| format!("{}:{}: ", at.file.display(), at.line)).unwrap_or_default();
    let others = match fast.len() - 1 {
        0 => String::new(),
        1 => " (and another sensor)".into(),
        n => format!(" (and {n} other sensors)"),
    };
    let highest = fast.iter().map(|(rate, _)| *rate).fold(0.0, f64::max);
    let rounded = |x: f64| (x * 1e4).round() / 1e4;
    Some(format!(
        "{at}the sensor `{}`{others} has a rate of {} Hz, but measures at {} Hz, once in each step: its rate needs a \
         `dt_s` of the scene of at most {} s",
        first.alias,
        rounded(*rate),
        rounded(steps_hz),
        (1e4 / highest).floor() / 1e4,
    ))
}

/// Returns the rate of a sensor, Hz; 0: in each step.
fn rate(properties: &[(Property, Value)]) -> f64 {
    match properties.iter().rev().find(|(row, _)| *row == Property::SENSOR_RATE) {
        Some((_, Value::Float(rate))) => *rate,
        Some((_, Value::Int(rate))) => *rate as f64,
        _ => 0.0,
    }
}
