//! Builds examples: TOML that is valid in a scene.

use std::fmt::Write;

use tatu_core::{
    plugins::units,
    plugins::{ParameterSpec, check_value},
};
use tatu_plugin_api::{abi::*, safe::Value};

/// Returns the key of a parameter in scene files.
pub fn key(p: &ParameterSpec) -> String {
    // For units that depend on the joint type, the example uses the rotational one.
    let unit = p.unit.as_deref().map(|u| u.split_once('|').map_or(u, |(turn, _)| turn));
    units::key_with_unit(&p.key, unit)
}

/// Returns an example of a sensor.
pub fn sensor(id: &str, params: &[ParameterSpec]) -> String {
    format!("[[object]]\nkind = \"sensor\"\nsensor = {}\nalias = \"my_sensor\"\n{}", quoted(id), lines(params))
}

/// Returns an example of an actuator, on a body that it can push.
pub fn actuator(id: &str, params: &[ParameterSpec]) -> String {
    let body = "[[object]]\nkind = \"shape\"\nalias = \"my_body\"\ndynamic = true\n\n";
    let own = format!("kind = \"actuator\"\nactuator = {}\nparent = \"my_body\"", quoted(id));
    format!("{body}[[object]]\n{own}\nalias = \"my_actuator\"\n{}", lines(params))
}

/// Returns an example of a part, on an object.
pub fn part(id: &str, params: &[ParameterSpec]) -> String {
    let own = format!("kind = \"part\"\npart = {}\nparent = \"my_robot\"", quoted(id));
    format!("[[object]]\n{own}\nalias = \"my_part\"\n{}", lines(params))
}

/// Returns an example of a service.
pub fn service(id: &str, params: &[ParameterSpec]) -> String {
    format!("[[service]]\nid = {}\n{}", quoted(id), lines(params))
}

/// Returns an example of a model.
pub fn model(id: &str, params: &[ParameterSpec]) -> String {
    format!("[[model]]\nmodel = {}\nposition_m = [0.0, 0.0, 0.0]\n{}", quoted(id), lines(params))
}

/// Returns an example of a model in a file.
pub fn model_file(file: &str) -> String {
    format!("[[model]]\nfile = {}\nposition_m = [0.0, 0.0, 0.0]\n", quoted(file))
}

/// Returns an example of a file that an importer reads.
pub fn importer(suffix: &str, params: &[ParameterSpec]) -> String {
    let file = quoted(&format!("my_file{suffix}"));
    format!("[[import]]\nfile = {file}\nposition_m = [0.0, 0.0, 0.0]\n{}", lines(params))
}

/// Returns an example of a script in a language.
pub fn script(id: &str, params: &[ParameterSpec]) -> String {
    let object = format!("[[object]]\nkind = \"dummy\"\nscript = {{ language = {}, text = \"\" }}\n", quoted(id));
    match params {
        [] => object,
        _ => format!("{object}\n[language.{id}]\n{}", lines(params)),
    }
}

/// Returns a line for each parameter with its default; a required parameter gets a valid value. An optional parameter
/// without a default is commented out. Parameters that are read-only, or for which no valid value can be written, are
/// omitted.
fn lines(params: &[ParameterSpec]) -> String {
    let mut out = String::new();
    for p in params.iter().filter(|p| p.flags & TATU_PARAM_READ_ONLY == 0) {
        let suffix = key(p)[p.key.len()..].to_owned();
        let found = units::factor(&key(p), &p.key, p.unit.as_deref()).unwrap_or(1.0);
        let value = if p.fallback == Value::Nil { example_value(p) } else { p.fallback.clone() };
        let Some(text) = written(&value, found).filter(|_| fits(p, &value, found)) else { continue };
        let comment = if p.fallback == Value::Nil && p.optional() { "# " } else { "" };
        let _ = writeln!(out, "{comment}{}{suffix} = {text}", p.key);
    }
    out
}

/// Returns whether the value is still valid after it was written in the file's unit and read again.
fn fits(p: &ParameterSpec, value: &Value, factor: f64) -> bool {
    let back = |x: f64| short(x / factor).parse::<f64>().unwrap_or(x) * factor;
    let value = match value {
        Value::Float(x) => Value::Float(back(*x)),
        Value::Floats(f) => Value::Floats(f.iter().map(|x| back(*x)).collect()),
        other => other.clone(),
    };
    check_value(p, value).is_ok()
}

/// Returns a valid value of a parameter.
fn example_value(p: &ParameterSpec) -> Value {
    let number = 1.0_f64.max(p.lowest).min(p.highest);
    match p.kind {
        TATU_BOOL => Value::Bool(false),
        TATU_I64 => Value::Int(number as i64),
        TATU_F64 => Value::Float(number),
        TATU_TEXT | TATU_BYTES => Value::text(p.choices.first().map_or("", String::as_str)),
        TATU_F64S => Value::Floats(vec![number; p.count.max(1) as usize]),
        TATU_LIST => Value::List(Vec::new()),
        _ => Value::Nil,
    }
}

fn written(value: &Value, factor: f64) -> Option<String> {
    let number = |x: f64| short(x / factor);
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    Some(match value {
        Value::Bool(b) => b.to_string(),
        Value::Int(i) if factor == 1.0 => i.to_string(),
        Value::Int(i) => number(*i as f64),
        Value::Float(f) => number(*f),
        Value::Text(t) | Value::Bytes(t) => quoted(&String::from_utf8_lossy(t)),
        Value::Floats(f) => list(f.iter().map(|x| number(*x)).collect()),
        Value::Ints(i) => list(i.iter().map(i64::to_string).collect()),
        Value::List(l) => list(l.iter().map(|v| written(v, factor)).collect::<Option<_>>()?),
        _ => return None,
    })
}

/// Formats a float for TOML without rounding noise of its unit: 30.0, not 29.999999999999996.
fn short(x: f64) -> String {
    let rounded = format!("{x:.9}").parse::<f64>().unwrap_or(x);
    let near = (rounded - x).abs() <= 1e-12 * x.abs();
    format!("{:?}", if near { rounded } else { x })
}

/// Formats a string for TOML.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
