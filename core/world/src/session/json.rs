//! Converts values to and from JSON without loss: reading returns exactly the bits that were written.
//!
//! Null, Booleans, integers, finite floats (always with a point or an exponent), UTF-8 strings and lists are plain
//! JSON. All other values are objects with a single key: `floats`, `ints`, `bytes` (base64), `text` (a string that is
//! not UTF-8, as base64), `map` (pairs), `bits` (a float that is not finite), `func` or `object`.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::Value;

pub(super) fn write(value: &Value) -> Json {
    match value {
        Value::Nil => Json::Null,
        Value::Bool(b) => json!(b),
        Value::Int(i) => json!(i),
        Value::Float(f) => float(*f),
        Value::Text(t) => match std::str::from_utf8(t) {
            Ok(t) => json!(t),
            Err(_) => json!({ "text": STANDARD.encode(t) }),
        },
        Value::Bytes(b) => json!({ "bytes": STANDARD.encode(b) }),
        Value::Floats(f) => json!({ "floats": f.iter().map(|x| float(*x)).collect::<Json>() }),
        Value::Ints(i) => json!({ "ints": i }),
        Value::List(l) => l.iter().map(write).collect(),
        Value::Map(m) => json!({ "map": m.iter().map(|(k, v)| json!([write(k), write(v)])).collect::<Json>() }),
        Value::Func(f) => json!({ "func": f }),
        Value::Object(o) => json!({ "object": o }),
    }
}

fn float(x: f64) -> Json {
    if x.is_finite() { json!(x) } else { json!({ "bits": format!("{:016x}", x.to_bits()) }) }
}

/// Converts the output of [`write`] back to a value. Returns `None` if `json` is not such output.
pub(super) fn read(json: &Json) -> Option<Value> {
    Some(match json {
        Json::Null => Value::Nil,
        Json::Bool(b) => Value::Bool(*b),
        Json::Number(n) => match n.as_i64() {
            Some(i) => Value::Int(i),
            None => Value::Float(n.as_f64().filter(|_| n.is_f64())?),
        },
        Json::String(s) => Value::text(s),
        Json::Array(a) => Value::List(a.iter().map(read).collect::<Option<_>>()?),
        Json::Object(o) => {
            let (key, inner) = o.iter().next().filter(|_| o.len() == 1)?;
            let bytes = |v: &Json| STANDARD.decode(v.as_str()?).ok();
            let list = |v: &'_ Json| v.as_array().cloned();
            match key.as_str() {
                "text" => Value::Text(bytes(inner)?),
                "bytes" => Value::Bytes(bytes(inner)?),
                "bits" => Value::Float(f64::from_bits(u64::from_str_radix(inner.as_str()?, 16).ok()?)),
                "floats" => Value::Floats(
                    list(inner)?
                        .iter()
                        .map(|x| match read(x) {
                            Some(Value::Float(f)) => Some(f),
                            _ => None,
                        })
                        .collect::<Option<_>>()?,
                ),
                "ints" => Value::Ints(list(inner)?.iter().map(Json::as_i64).collect::<Option<_>>()?),
                "map" => Value::Map(
                    list(inner)?
                        .iter()
                        .map(|pair| match pair.as_array().map(Vec::as_slice) {
                            Some([k, v]) => Some((read(k)?, read(v)?)),
                            _ => None,
                        })
                        .collect::<Option<_>>()?,
                ),
                "func" => Value::Func(inner.as_u64()?),
                "object" => Value::Object(inner.as_u64()?),
                _ => return None,
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_value() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            Just(Value::Nil),
            any::<bool>().prop_map(Value::Bool),
            any::<i64>().prop_map(Value::Int),
            any::<u64>().prop_map(|bits| Value::Float(f64::from_bits(bits))),
            any::<Vec<u8>>().prop_map(Value::Text),
            ".*".prop_map(Value::text),
            any::<Vec<u8>>().prop_map(Value::Bytes),
            prop::collection::vec(any::<u64>().prop_map(f64::from_bits), 0..4).prop_map(Value::Floats),
            any::<Vec<i64>>().prop_map(Value::Ints),
            any::<u64>().prop_map(Value::Object),
        ];
        leaf.prop_recursive(4, 32, 6, |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..6).prop_map(Value::List),
                prop::collection::vec((inner.clone(), inner), 0..6).prop_map(Value::Map),
            ]
        })
    }

    /// Formats a value with every bit of its floats, so that equal NaNs compare equal.
    fn bits(v: &Value) -> String {
        match v {
            Value::Float(f) => format!("{:x}", f.to_bits()),
            Value::Floats(f) => format!("{:x?}", f.iter().map(|x| x.to_bits()).collect::<Vec<_>>()),
            Value::List(l) => format!("{:?}", l.iter().map(bits).collect::<Vec<_>>()),
            Value::Map(m) => format!("{:?}", m.iter().map(|(k, v)| (bits(k), bits(v))).collect::<Vec<_>>()),
            other => format!("{other:?}"),
        }
    }

    proptest! {
        #[test]
        fn values_round_trip_bit_for_bit(value in any_value()) {
            let text = write(&value).to_string();
            let back = read(&serde_json::from_str(&text).unwrap()).unwrap();
            prop_assert_eq!(bits(&back), bits(&value));
        }
    }

    #[test]
    fn invalid_encodings_are_refused() {
        for text in ["{}", r#"{"a":1}"#, r#"{"bytes":"?"}"#, r#"{"map":[[1]]}"#, r#"{"floats":[1]}"#, "1e999"] {
            assert!(serde_json::from_str(text).ok().and_then(|j| read(&j)).is_none(), "{text}");
        }
    }
}
