//! Converts values to JSON and back. A value that JSON cannot represent directly, such as bytes or an infinite number,
//! becomes an object with a single reserved key.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Map, Number, Value as Json, json};
use tatu_plugin_api::safe::{Fail, Result, Value};

/// Keys that, as the only key of a JSON object, mark a value that JSON cannot represent directly.
const RESERVED: [&str; 4] = ["bytes", "number", "object", "pairs"];

/// Converts a value to JSON. Functions become the string `<function>`.
pub fn write(value: &Value) -> Json {
    match value {
        Value::Nil => Json::Null,
        Value::Bool(b) => json!(b),
        Value::Int(i) => json!(i),
        Value::Float(f) => float(*f),
        Value::Text(t) => match std::str::from_utf8(t) {
            Ok(t) => json!(t),
            Err(_) => json!({ "bytes": STANDARD.encode(t) }),
        },
        Value::Bytes(b) => json!({ "bytes": STANDARD.encode(b) }),
        Value::Floats(f) => f.iter().map(|x| float(*x)).collect(),
        Value::Ints(i) => json!(i),
        Value::List(l) => l.iter().map(write).collect(),
        Value::Map(m) => map(m),
        Value::Func(_) => json!("<function>"),
        Value::Object(o) => json!({ "object": o }),
    }
}

/// Converts a float, which may be infinite or NaN.
fn float(x: f64) -> Json {
    // JSON has no infinite numbers and no NaN.
    Number::from_f64(x).map_or_else(|| json!({ "number": x.to_string() }), Json::Number)
}

/// Converts a table: to a JSON object if all keys are UTF-8 strings and the object does not look like one with a
/// reserved key, otherwise to a list of pairs.
fn map(entries: &[(Value, Value)]) -> Json {
    let mut out = Map::new();
    for (key, value) in entries {
        let Value::Text(key) = key else { return pairs(entries) };
        let Ok(key) = std::str::from_utf8(key) else { return pairs(entries) };
        out.insert(key.to_owned(), write(value));
    }
    let only = out.keys().next().filter(|_| out.len() == 1);
    if only.is_some_and(|k| RESERVED.contains(&k.as_str())) { pairs(entries) } else { Json::Object(out) }
}

fn pairs(entries: &[(Value, Value)]) -> Json {
    json!({ "pairs": entries.iter().map(|(k, v)| json!([write(k), write(v)])).collect::<Json>() })
}

/// Converts JSON to a value. Fails if the content of an object with a reserved key is invalid.
pub fn read(json: &Json) -> Result<Value> {
    Ok(match json {
        Json::Null => Value::Nil,
        Json::Bool(b) => Value::Bool(*b),
        Json::Number(n) => match n.as_i64() {
            Some(i) => Value::Int(i),
            None => Value::Float(n.as_f64().ok_or_else(|| Fail::argument(format!("the number {n} is out of range")))?),
        },
        Json::String(s) => Value::text(s),
        Json::Array(a) => array(a)?,
        Json::Object(o) => match o.iter().next().filter(|_| o.len() == 1) {
            Some((key, inner)) if RESERVED.contains(&key.as_str()) => reserved_value(key, inner)?,
            _ => Value::Map(o.iter().map(|(k, v)| Ok((Value::text(k), read(v)?))).collect::<Result<_>>()?),
        },
    })
}

/// Converts a JSON array: to an array of integers or floats if it is not empty and all elements are numbers, otherwise
/// to a list.
fn array(items: &[Json]) -> Result<Value> {
    let values = items.iter().map(read).collect::<Result<Vec<_>>>()?;
    let ints = values.iter().map(|v| if let Value::Int(i) = v { Some(*i) } else { None });
    if let Some(ints) = ints.collect::<Option<Vec<_>>>().filter(|i| !i.is_empty()) {
        return Ok(Value::Ints(ints));
    }
    let floats = values.iter().map(|v| match v {
        Value::Int(i) => Some(*i as f64),
        Value::Float(f) => Some(*f),
        _ => None,
    });
    Ok(match floats.collect::<Option<Vec<_>>>().filter(|f| !f.is_empty()) {
        Some(floats) => Value::Floats(floats),
        None => Value::List(values),
    })
}

/// Converts the content of a JSON object with the reserved key `key`.
fn reserved_value(key: &str, inner: &Json) -> Result<Value> {
    let wrong = |what: &str| Fail::argument(format!("`{key}`: expected {what}, found {inner}"));
    Ok(match key {
        "bytes" => {
            let text = inner.as_str().ok_or_else(|| wrong("a string in base64"))?;
            Value::Bytes(STANDARD.decode(text).map_err(|_| wrong("a string in base64"))?)
        }
        "number" => match inner.as_str() {
            Some("inf") => Value::Float(f64::INFINITY),
            Some("-inf") => Value::Float(f64::NEG_INFINITY),
            Some("NaN") => Value::Float(f64::NAN),
            _ => return Err(wrong("\"inf\", \"-inf\" or \"NaN\"")),
        },
        "object" => Value::Object(inner.as_u64().ok_or_else(|| wrong("a non-negative integer"))?),
        _ => {
            let pairs = inner.as_array().ok_or_else(|| wrong("a list of pairs"))?;
            let pair = |p: &Json| match p.as_array().map(Vec::as_slice) {
                Some([k, v]) => Ok((read(k)?, read(v)?)),
                _ => Err(wrong("a list of pairs")),
            };
            Value::Map(pairs.iter().map(pair).collect::<Result<_>>()?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Value {
        read(&serde_json::from_str(text).unwrap()).unwrap()
    }

    #[test]
    fn integers_stay_integers_and_floats_floats() {
        assert_eq!(parsed("3"), Value::Int(3));
        assert_eq!(parsed("3.0"), Value::Float(3.0));
        assert_eq!(parsed("[1, 2]"), Value::Ints(vec![1, 2]));
        assert_eq!(parsed("[1, 2.5]"), Value::Floats(vec![1.0, 2.5]));
        assert_eq!(parsed("[]"), Value::List(vec![]));
        assert_eq!(write(&Value::Float(3.0)).to_string(), "3.0");
        assert_eq!(write(&Value::Int(3)).to_string(), "3");
    }

    #[test]
    fn values_without_json_form_round_trip_as_reserved_objects() {
        let all = [
            Value::Bytes(vec![0, 255, 10]),
            Value::Float(f64::INFINITY),
            Value::Object(5 << 20 | 3),
            Value::Map(vec![(Value::Int(2), Value::text("two"))]),
            // A table whose only key is reserved must be escaped, so that it is read as a table again.
            Value::Map(vec![(Value::text("bytes"), Value::text("AA=="))]),
            Value::Map(vec![(Value::text("a"), Value::Nil), (Value::text("b"), Value::Bool(true))]),
        ];
        for v in all {
            assert_eq!(read(&write(&v)).unwrap(), v, "{}", write(&v));
        }
    }

    #[test]
    fn invalid_reserved_objects_are_refused() {
        for text in [r#"{"bytes": "?"}"#, r#"{"bytes": 1}"#, r#"{"number": "x"}"#, r#"{"pairs": [[1]]}"#] {
            assert!(read(&serde_json::from_str(text).unwrap()).is_err(), "{text}");
        }
    }
}
