//! Converts readings, faults and log lines to the form that tests receive.

use tatu_core::{
    LogLine, Reading, World,
    errors::{Fault, nearest},
};
use tatu_plugin_api::{abi::*, safe::Value};

use crate::answer::CallError;

/// Returns the last reading of a sensor. Fails if there is no such object, or if it is not a sensor.
pub fn reading(world: &World, path: &str) -> Result<Reading, CallError> {
    if let Some(reading) = world.reading(path) {
        return Ok(reading);
    }
    if let Some(other) = world.observe(path) {
        return Err(CallError::missing(format!("{} is not a sensor", other.path)));
    }
    let near = world.nearest(path).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    Err(CallError::missing(format!("there is no object `{path}`{near}")))
}

/// Returns a field of the last reading of a sensor, with bytes converted to integers. Fails if the sensor has not
/// measured yet.
pub fn field(world: &World, path: &str, name: &str) -> Result<Value, CallError> {
    let reading = reading(world, path)?;
    let names: Vec<&str> = reading.fields.iter().map(|f| f.name.as_str()).collect();
    let Some(field) = reading.field(name) else {
        let near = nearest(name, names.iter().copied()).map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        let text = format!("the sensor {} of kind `{}` has no field `{name}`{near}", reading.path, reading.kind);
        return Err(CallError::missing(format!("{text}\n  expected: one of {}", names.join(", "))));
    };
    if reading.sequence == 0 {
        let text = format!("the sensor {} has not measured yet\n  help: run a step first", reading.path);
        return Err(CallError::missing(text));
    }
    Ok(numbers(&field.value))
}

fn numbers(value: &Value) -> Value {
    match value {
        Value::Bytes(bytes) => Value::Ints(bytes.iter().map(|b| i64::from(*b)).collect()),
        other => other.clone(),
    }
}

/// Converts a whole reading to a map with the keys `kind`, `time`, `sequence` and `fields`.
pub fn reading_map(reading: &Reading) -> Value {
    let fields = reading.fields.iter().map(|f| (Value::text(&f.name), numbers(&f.value))).collect();
    Value::Map(vec![
        (Value::text("kind"), Value::text(&reading.kind)),
        (Value::text("time"), Value::Float(reading.time)),
        (Value::text("sequence"), Value::Int(reading.sequence as i64)),
        (Value::text("fields"), Value::Map(fields)),
    ])
}

/// Formats a fault as a line of text; `times` is the number of its occurrences to report.
pub fn fault_line(fault: &Fault, times: u64) -> String {
    let place = match (&fault.file, fault.line) {
        (Some(file), Some(line)) => format!("{file}:{line}: "),
        _ => String::new(),
    };
    let object = fault.object.as_ref().map_or(String::new(), |o| format!(" [{o}]"));
    let help = fault.help.as_ref().map_or(String::new(), |h| format!(" ({h})"));
    let times = if times > 1 { format!(", {times} times") } else { String::new() };
    format!("[{}] {place}{}{object}{help}{times}", fault.code, fault.message)
}

/// Formats a line of the log, with its level unless the level is "information".
pub fn log_line(line: &LogLine) -> String {
    match line.level {
        TATU_LOG_ERROR => format!("error: {}", line.text),
        TATU_LOG_WARNING => format!("warning: {}", line.text),
        TATU_LOG_DEBUG => format!("debug: {}", line.text),
        _ => line.text.clone(),
    }
}
