//! Converts messages according to their types: values to JSON and CBOR, and JSON to values. Missing fields have the
//! default value of their type; unknown fields are an error.

use base64::{Engine, engine::general_purpose::STANDARD};
use ciborium::Value as Cbor;
use serde_json::{Map, Number, Value as Json, json};
use tatu_plugin_api::safe::{Fail, Result, Value};
use tatu_services_common::json;

use crate::types::{self, ArrayLength, FieldElementType, MessageField, RosVersion};

/// A message or a part of one, ready to be serialized.
#[derive(Debug, Clone, PartialEq)]
pub enum MessageNode {
    /// A boolean.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A floating-point number.
    Float(f64),
    /// A string.
    Text(String),
    /// An array of unsigned 8-bit integers.
    Bytes(Vec<u8>),
    /// An array of numbers of one type.
    Numbers(FieldElementType, Vec<f64>),
    /// Any other array.
    List(Vec<MessageNode>),
    /// A message: the name and value of each field.
    Map(Vec<(String, MessageNode)>),
    /// A message of an unknown type, which is passed on unchanged.
    Plain(Json),
}

/// Converts a value to a message of the type `plain`, with the field names and times of `ros`.
pub fn node(value: &Value, plain: &str, ros: RosVersion) -> Result<MessageNode> {
    let Some(fields) = types::fields(plain) else { return Ok(MessageNode::Plain(json::write(value))) };
    let entries: &[(Value, Value)] = match value {
        Value::Map(entries) => entries,
        Value::List(all) if all.is_empty() => &[],
        Value::Nil => &[],
        _ => return Err(Fail::argument(format!("a message of the type {plain} must be a table with its fields"))),
    };
    for (key, _) in entries {
        let known = matches!(key, Value::Text(k) if find(fields, plain, ros, &String::from_utf8_lossy(k)).is_some());
        if !known {
            let names: Vec<&str> = fields.iter().map(|f| f.name.as_str()).collect();
            let text = format!("{plain} has no field {}; it has: {}", json::write(key), names.join(", "));
            return Err(Fail::argument(text));
        }
    }
    let mut out = Vec::new();
    for field in fields {
        let Some(name) = ros.field(plain, &field.name) else { continue };
        let given = entries
            .iter()
            .find(|(k, _)| matches!(k, Value::Text(k) if k == field.name.as_bytes() || k == name.as_bytes()));
        let made = field_node(given.map(|(_, v)| v), field, ros).map_err(|e| field_error(&e, plain, &name))?;
        out.push((name, made));
    }
    Ok(MessageNode::Map(out))
}

/// Prepends the type of the message and the name of the field to an error.
fn field_error(e: &Fail, plain: &str, name: &str) -> Fail {
    Fail::with_code(e.code(), format!("{plain}: `{name}`: {}", e.text()))
}

/// Returns the field with a name, which may be that of ROS 1 or that of the version `ros`.
fn find<'f>(fields: &'f [MessageField], plain: &str, ros: RosVersion, name: &str) -> Option<&'f MessageField> {
    fields.iter().find(|f| f.name == name || ros.field(plain, &f.name).is_some_and(|n| n == name))
}

/// Converts the value of a field; `None` results in the default value.
fn field_node(given: Option<&Value>, field: &MessageField, ros: RosVersion) -> Result<MessageNode> {
    let given = given.filter(|v| **v != Value::Nil);
    if field.length == ArrayLength::One {
        return one(given, &field.element, ros);
    }
    let least = if let ArrayLength::Exactly(n) = field.length { n } else { 0 };
    let items = match given {
        None => Vec::new(),
        Some(Value::Bytes(b) | Value::Text(b)) if field.element == FieldElementType::Int(false, 8) => {
            return Ok(MessageNode::Bytes(b.clone()));
        }
        Some(Value::Floats(v)) => v.iter().map(|x| Value::Float(*x)).collect(),
        Some(Value::Ints(v)) => v.iter().map(|i| Value::Int(*i)).collect(),
        Some(Value::List(v)) => v.clone(),
        Some(Value::Map(v)) if v.is_empty() => Vec::new(),
        Some(_) => return Err(Fail::argument("expected an array")),
    };
    if least > 0 && !items.is_empty() && items.len() != least {
        return Err(Fail::argument(format!("expected {least} elements, found {}", items.len())));
    }
    let filled = items.iter().map(Some).chain(std::iter::repeat_n(None, least.saturating_sub(items.len())));
    let nodes = filled.map(|v| one(v, &field.element, ros)).collect::<Result<Vec<_>>>()?;
    Ok(match field.element {
        FieldElementType::Int(false, 8) => MessageNode::Bytes(nodes.iter().map(|n| number(n) as u8).collect()),
        FieldElementType::Int(..) | FieldElementType::Float(_) => {
            MessageNode::Numbers(field.element.clone(), nodes.iter().map(number).collect())
        }
        _ => MessageNode::List(nodes),
    })
}

/// Returns a numeric element as a float.
fn number(node: &MessageNode) -> f64 {
    match node {
        MessageNode::Int(i) => *i as f64,
        MessageNode::Float(x) => *x,
        _ => 0.0,
    }
}

/// Converts a single element; `None` results in the default value.
fn one(given: Option<&Value>, base: &FieldElementType, ros: RosVersion) -> Result<MessageNode> {
    let wrong = |what: &str| Err(Fail::argument(format!("expected {what}")));
    Ok(match (base, given) {
        (FieldElementType::Message(inner), v) => node(v.unwrap_or(&Value::Nil), inner, ros)?,
        (FieldElementType::Bool, None) => MessageNode::Bool(false),
        (FieldElementType::Bool, Some(Value::Bool(b))) => MessageNode::Bool(*b),
        (FieldElementType::Bool, Some(Value::Int(i))) => MessageNode::Bool(*i != 0),
        (FieldElementType::Bool, Some(_)) => return wrong("true or false"),
        (FieldElementType::Int(..), None) => MessageNode::Int(0),
        (FieldElementType::Int(..), Some(Value::Int(i))) => MessageNode::Int(*i),
        (FieldElementType::Int(..), Some(Value::Bool(b))) => MessageNode::Int((*b).into()),
        (FieldElementType::Int(..), Some(Value::Float(x))) if x.fract() == 0.0 => MessageNode::Int(*x as i64),
        (FieldElementType::Int(..), Some(_)) => return wrong("a whole number"),
        (FieldElementType::Float(_), None) => MessageNode::Float(0.0),
        (FieldElementType::Float(_), Some(Value::Int(i))) => MessageNode::Float(*i as f64),
        (FieldElementType::Float(_), Some(Value::Float(x))) => MessageNode::Float(*x),
        (FieldElementType::Float(_), Some(_)) => return wrong("a number"),
        (FieldElementType::Text, None) => MessageNode::Text(String::new()),
        (FieldElementType::Text, Some(Value::Text(t) | Value::Bytes(t))) => {
            MessageNode::Text(String::from_utf8_lossy(t).into_owned())
        }
        (FieldElementType::Text, Some(_)) => return wrong("a string"),
        (FieldElementType::Time, None) => time(0.0, ros),
        (FieldElementType::Time, Some(Value::Float(s))) => time(*s, ros),
        (FieldElementType::Time, Some(Value::Int(s))) => time(*s as f64, ros),
        (FieldElementType::Time, Some(Value::Map(entries))) => {
            let of = |names: [&str; 2]| {
                let found = entries.iter().find(|(k, _)| names.iter().any(|n| *k == Value::text(*n)));
                found.map_or(0, |(_, v)| if let Value::Int(i) = v { *i } else { 0 })
            };
            stamp(of(["secs", "sec"]), of(["nsecs", "nanosec"]), ros)
        }
        (FieldElementType::Time, Some(_)) => {
            return wrong("a time: seconds, or a table with sec and nanosec or secs and nsecs");
        }
    })
}

/// Converts a time in seconds to the fields of a ROS time.
fn time(seconds: f64, ros: RosVersion) -> MessageNode {
    let whole = seconds.floor();
    let nanos = ((seconds - whole) * 1e9).round() as i64;
    // Rounding may give 1e9 ns, which are carried into the seconds.
    stamp(whole as i64 + nanos / 1_000_000_000, nanos % 1_000_000_000, ros)
}

/// Builds a ROS time from seconds and nanoseconds; `ros` determines the names of its fields.
fn stamp(whole: i64, nanos: i64, ros: RosVersion) -> MessageNode {
    let [a, b] = if ros == RosVersion::One { ["secs", "nsecs"] } else { ["sec", "nanosec"] };
    MessageNode::Map(vec![(a.into(), MessageNode::Int(whole)), (b.into(), MessageNode::Int(nanos))])
}

impl MessageNode {
    /// Returns the message as JSON. Bytes are encoded in base64, and non-finite numbers become null.
    pub fn json(&self) -> Json {
        let float = |x: f64| Number::from_f64(x).map_or(Json::Null, Json::Number);
        match self {
            MessageNode::Bool(b) => json!(b),
            MessageNode::Int(i) => json!(i),
            MessageNode::Float(x) => float(*x),
            MessageNode::Text(t) => json!(t),
            MessageNode::Bytes(b) => json!(STANDARD.encode(b)),
            MessageNode::Numbers(FieldElementType::Int(..), v) => v.iter().map(|x| json!(*x as i64)).collect(),
            // 32-bit floats are written with their shortest decimal representation, not with that of a 64-bit float.
            MessageNode::Numbers(FieldElementType::Float(32), v) => {
                v.iter().map(|x| float((*x as f32).to_string().parse().unwrap_or(f64::NAN))).collect()
            }
            MessageNode::Numbers(_, v) => v.iter().map(|x| float(*x)).collect(),
            MessageNode::List(v) => v.iter().map(MessageNode::json).collect(),
            MessageNode::Map(v) => Json::Object(v.iter().map(|(k, n)| (k.clone(), n.json())).collect::<Map<_, _>>()),
            MessageNode::Plain(json) => json.clone(),
        }
    }

    /// Returns the message as CBOR. Arrays of numbers become typed arrays (RFC 8746, little-endian).
    pub fn cbor(&self) -> Cbor {
        match self {
            MessageNode::Bool(b) => Cbor::Bool(*b),
            MessageNode::Int(i) => Cbor::from(*i),
            MessageNode::Float(x) => Cbor::Float(*x),
            MessageNode::Text(t) => Cbor::Text(t.clone()),
            MessageNode::Bytes(b) => Cbor::Bytes(b.clone()),
            MessageNode::Numbers(base, v) => numbers(base, v),
            MessageNode::List(v) => Cbor::Array(v.iter().map(MessageNode::cbor).collect()),
            MessageNode::Map(v) => Cbor::Map(v.iter().map(|(k, n)| (Cbor::Text(k.clone()), n.cbor())).collect()),
            MessageNode::Plain(json) => Cbor::serialized(json).unwrap_or(Cbor::Null),
        }
    }
}

/// Returns a typed array of CBOR.
fn numbers(base: &FieldElementType, v: &[f64]) -> Cbor {
    fn bytes<const N: usize>(v: &[f64], of: impl Fn(f64) -> [u8; N]) -> Vec<u8> {
        v.iter().flat_map(|x| of(*x)).collect()
    }
    let (tag, bytes) = match base {
        FieldElementType::Int(false, 16) => (69, bytes(v, |x| (x as u16).to_le_bytes())),
        FieldElementType::Int(false, 32) => (70, bytes(v, |x| (x as u32).to_le_bytes())),
        FieldElementType::Int(false, _) => (71, bytes(v, |x| (x as u64).to_le_bytes())),
        FieldElementType::Int(true, 8) => (72, bytes(v, |x| (x as i8).to_le_bytes())),
        FieldElementType::Int(true, 16) => (77, bytes(v, |x| (x as i16).to_le_bytes())),
        FieldElementType::Int(true, 32) => (78, bytes(v, |x| (x as i32).to_le_bytes())),
        FieldElementType::Int(true, _) => (79, bytes(v, |x| (x as i64).to_le_bytes())),
        FieldElementType::Float(32) => (85, bytes(v, |x| (x as f32).to_le_bytes())),
        _ => (86, bytes(v, f64::to_le_bytes)),
    };
    Cbor::Tag(tag, Box::new(Cbor::Bytes(bytes)))
}

/// Converts JSON to a message of the type `plain` as a value. Times become seconds in ROS 1 and tables in ROS 2; arrays
/// of bytes become bytes.
pub fn value(json: &Json, plain: &str, ros: RosVersion) -> Result<Value> {
    let Some(fields) = types::fields(plain) else { return json::read(json) };
    let empty = Map::new();
    let entries = match json {
        Json::Object(entries) => entries,
        Json::Null => &empty,
        _ => return Err(Fail::argument(format!("a message of the type {plain} must be an object"))),
    };
    if let Some(key) = entries.keys().find(|k| find(fields, plain, RosVersion::Two, k).is_none()) {
        return Err(Fail::argument(format!("{plain} has no field `{key}`")));
    }
    let mut out = Vec::new();
    for field in fields {
        let Some(name) = ros.field(plain, &field.name) else { continue };
        let given = entries.get(&field.name).or_else(|| entries.get(&name)).filter(|v| !v.is_null());
        let made = read_field(given, field, ros).map_err(|e| field_error(&e, plain, &name))?;
        out.push((Value::text(name), made));
    }
    Ok(Value::Map(out))
}

/// Converts the JSON of a field; `None` results in the default value.
fn read_field(given: Option<&Json>, field: &MessageField, ros: RosVersion) -> Result<Value> {
    if field.length == ArrayLength::One {
        return read_one(given, &field.element, ros);
    }
    let least = if let ArrayLength::Exactly(n) = field.length { n } else { 0 };
    let items = match given {
        None => &[][..],
        Some(Json::String(text)) if field.element == FieldElementType::Int(false, 8) => {
            return Ok(Value::Bytes(STANDARD.decode(text).map_err(|_| Fail::argument("expected a string in base64"))?));
        }
        Some(Json::Array(items)) => items,
        Some(_) => return Err(Fail::argument("expected an array")),
    };
    let filled = items.iter().map(Some).chain(std::iter::repeat_n(None, least.saturating_sub(items.len())));
    let all = filled.map(|v| read_one(v, &field.element, ros)).collect::<Result<Vec<_>>>()?;
    let float = |v: &Value| if let Value::Float(x) = v { *x } else { 0.0 };
    let int = |v: &Value| if let Value::Int(i) = v { *i } else { 0 };
    Ok(match field.element {
        _ if all.is_empty() => Value::List(all),
        FieldElementType::Float(_) => Value::Floats(all.iter().map(float).collect()),
        FieldElementType::Int(false, 8) => Value::Bytes(all.iter().map(|v| int(v) as u8).collect()),
        FieldElementType::Int(..) => Value::Ints(all.iter().map(int).collect()),
        _ => Value::List(all),
    })
}

/// Converts the JSON of a single element; `None` results in the default value.
fn read_one(given: Option<&Json>, base: &FieldElementType, ros: RosVersion) -> Result<Value> {
    let given = given.filter(|v| !v.is_null());
    let wrong = |what: &str| Fail::argument(format!("expected {what}"));
    Ok(match base {
        FieldElementType::Message(inner) => value(given.unwrap_or(&Json::Null), inner, ros)?,
        FieldElementType::Bool => Value::Bool(match given {
            None => false,
            Some(v) => v.as_bool().or_else(|| v.as_i64().map(|i| i != 0)).ok_or_else(|| wrong("true or false"))?,
        }),
        FieldElementType::Int(..) => Value::Int(match given {
            None => 0,
            Some(v) => {
                let whole = |x: f64| (x.fract() == 0.0).then_some(x as i64);
                v.as_i64().or_else(|| v.as_f64().and_then(whole)).ok_or_else(|| wrong("a whole number"))?
            }
        }),
        // A null is treated as a missing element, although it may represent a non-finite number.
        FieldElementType::Float(_) => {
            Value::Float(given.map_or(Ok(0.0), |v| v.as_f64().ok_or_else(|| wrong("a number")))?)
        }
        FieldElementType::Text => Value::text(given.map_or(Ok(""), |v| v.as_str().ok_or_else(|| wrong("a string")))?),
        FieldElementType::Time => {
            let of = |names: [&str; 2]| {
                let found = given.and_then(|v| names.iter().find_map(|n| v.get(*n)));
                found.and_then(Json::as_i64).unwrap_or(0)
            };
            let (whole, nanos) = (of(["secs", "sec"]), of(["nsecs", "nanosec"]));
            match ros {
                RosVersion::One => Value::Float(whole as f64 + nanos as f64 * 1e-9),
                RosVersion::Two => Value::Map(vec![
                    (Value::text("sec"), Value::Int(whole)),
                    (Value::text("nanosec"), Value::Int(nanos)),
                ]),
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, plain: &str, ros: RosVersion) -> Result<Value> {
        value(&serde_json::from_str(text).unwrap(), plain, ros)
    }

    #[test]
    fn missing_fields_have_defaults_and_unknown_fields_are_refused() {
        let twist = read(r#"{"linear": {"x": 1}}"#, "geometry_msgs/Twist", RosVersion::One).unwrap();
        let written = node(&twist, "geometry_msgs/Twist", RosVersion::One).unwrap().json();
        let zero = json!({ "x": 0.0, "y": 0.0, "z": 0.0 });
        assert_eq!(written, json!({ "linear": { "x": 1.0, "y": 0.0, "z": 0.0 }, "angular": zero }));
        let wrong = read(r#"{"linaer": {}}"#, "geometry_msgs/Twist", RosVersion::One).unwrap_err();
        assert!(wrong.text().contains("has no field `linaer`"), "{wrong}");
        let wrong = read(r#"{"linear": {"x": "fast"}}"#, "geometry_msgs/Twist", RosVersion::One).unwrap_err();
        assert!(wrong.text().contains("`linear`") && wrong.text().contains("a number"), "{wrong}");
        assert_eq!(
            read(r#"{"any": 1}"#, "own_msgs/Thing", RosVersion::One).unwrap(),
            json::read(&json!({ "any": 1 })).unwrap()
        );
    }

    #[test]
    fn times_and_field_names_follow_the_ros_version() {
        let value = Value::Map(vec![(Value::text("stamp"), Value::Float(1.25))]);
        let one = node(&value, "std_msgs/Header", RosVersion::One).unwrap().json();
        assert_eq!(one, json!({ "seq": 0, "stamp": { "secs": 1, "nsecs": 250_000_000 }, "frame_id": "" }));
        let two = node(&value, "std_msgs/Header", RosVersion::Two).unwrap().json();
        assert_eq!(two, json!({ "stamp": { "sec": 1, "nanosec": 250_000_000 }, "frame_id": "" }));
        // Rounding carries into the seconds.
        assert_eq!(time(0.999_999_999_9, RosVersion::One), stamp(1, 0, RosVersion::One));
        let info = node(&Value::Nil, "sensor_msgs/CameraInfo", RosVersion::Two).unwrap().json();
        assert!(info.get("k").is_some_and(|k| k.as_array().unwrap().len() == 9) && info.get("K").is_none(), "{info}");
        let range = |ros| node(&Value::Nil, "sensor_msgs/Range", ros).unwrap().json().get("variance").is_some();
        assert!(range(RosVersion::Two) && !range(RosVersion::One), "only ROS 2 has the variance of a range");
    }

    #[test]
    fn bytes_are_base64_and_non_finite_numbers_are_null() {
        let image = Value::Map(vec![(Value::text("data"), Value::Bytes(vec![1, 2, 255]))]);
        let image = node(&image, "sensor_msgs/Image", RosVersion::One).unwrap();
        assert_eq!(image.json()["data"], "AQL/");
        let scan = Value::Map(vec![(Value::text("ranges"), Value::Floats(vec![0.1, f64::INFINITY]))]);
        let scan = node(&scan, "sensor_msgs/LaserScan", RosVersion::One).unwrap();
        assert_eq!(scan.json()["ranges"], json!([0.1, null]));
        let Cbor::Map(fields) = scan.cbor() else { unreachable!() };
        let ranges = fields.iter().find(|(k, _)| *k == Cbor::Text("ranges".into())).unwrap();
        let bytes: Vec<u8> = [0.1_f32, f32::INFINITY].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(ranges.1, Cbor::Tag(85, Box::new(Cbor::Bytes(bytes))));
    }
}
