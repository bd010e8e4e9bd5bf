//! Judges the numbers of readings.

use tatu_core::plugins::{FieldSpec, SensorKind, schemas};
use tatu_plugin_api::{abi::*, safe::Value};

use super::finding::error;

/// Reports NaN, and infinite values that are not marked as missing by `valid` or `nothing`. `values` are the numbers of
/// each field.
pub fn judge(kind: &SensorKind, values: &[Vec<f64>]) {
    let place = format!("sensor `{}`", kind.id);
    let of_name = |name: &str| kind.fields.iter().position(|f| f.name == name).and_then(|k| values.get(k));
    for (info, numbers) in kind.fields.iter().zip(values) {
        let valid = valid_of(info).and_then(|name| of_name(&name));
        let nothing = nothing_of(info);
        let step = valid.map_or(1, |v| (numbers.len() / v.len().max(1)).max(1));
        for (i, x) in numbers.iter().enumerate() {
            let says = valid.and_then(|v| v.get(i / step)).copied();
            if x.is_nan() {
                error(&place, format!("`{}` is not a number (NaN)", info.name));
                break;
            } else if x.is_infinite() && says.is_some_and(|v| v != 0.0) {
                let which = valid_of(info).unwrap_or_default();
                error(
                    &place,
                    format!("`{}` is infinite, although `{which}` is 1 and states that it was measured", info.name),
                );
                break;
            } else if x.is_infinite() && says.is_none() && !nothing.contains("inf") {
                error(
                    &place,
                    format!("`{}` is infinite, which neither `valid` nor `nothing` of the field allows", info.name),
                );
                break;
            }
        }
    }
}

/// Returns the numbers of a reading's field.
pub fn numbers_of(value: &Value) -> Vec<f64> {
    match value {
        Value::Floats(f) => f.clone(),
        Value::Ints(i) => i.iter().map(|i| *i as f64).collect(),
        Value::Float(x) => vec![*x],
        Value::Int(i) => vec![*i as f64],
        Value::Bool(b) => vec![f64::from(u8::from(*b))],
        _ => Vec::new(),
    }
}

/// Returns the numbers that the bytes of a field represent.
pub fn numbers(elem: u32, bytes: &[u8]) -> Vec<f64> {
    fn all<const N: usize>(bytes: &[u8], number: fn([u8; N]) -> f64) -> Vec<f64> {
        bytes.as_chunks::<N>().0.iter().map(|b| number(*b)).collect()
    }
    match elem {
        TATU_ELEM_F64 => all(bytes, f64::from_ne_bytes),
        TATU_ELEM_F32 => all(bytes, |b| f32::from_ne_bytes(b).into()),
        TATU_ELEM_I32 => all(bytes, |b| i32::from_ne_bytes(b).into()),
        TATU_ELEM_U16 => all(bytes, |b| u16::from_ne_bytes(b).into()),
        TATU_ELEM_U8 => all(bytes, |[b]: [u8; 1]| b.into()),
        _ => Vec::new(),
    }
}

fn of_schema(field: &FieldSpec) -> Option<&'static schemas::SchemaField> {
    schemas::all_schemas().iter().flat_map(|s| &s.fields).find(|f| f.name == field.name)
}

fn valid_of(field: &FieldSpec) -> Option<String> {
    field.valid.clone().or_else(|| of_schema(field)?.valid.clone())
}

fn nothing_of(field: &FieldSpec) -> String {
    let schema = of_schema(field).map(|f| format!("{} {}", f.nothing, f.text.to_lowercase())).unwrap_or_default();
    format!("{} {schema}", field.nothing.clone().unwrap_or_default())
}
