//! Decodes requests and encodes answers, which are CBOR.

use ciborium::Value as Cbor;
use tatu_plugin_api::{
    abi::tatu_slot,
    safe::{Fail, Result, Value},
};

/// A request from a client.
#[derive(Debug, Default)]
pub struct RemoteRequest {
    /// The name of the function to call.
    pub func: String,
    /// Arguments of the call.
    pub args: Vec<Value>,
    /// Id of the client; `None` in the first version of the protocol.
    pub uuid: Option<String>,
}

/// Maximum nesting depth of lists and maps.
const MAX_DEPTH: usize = 64;

/// Parses a request. Unknown keys are ignored.
pub fn read(bytes: &[u8]) -> Result<RemoteRequest> {
    let wrong = |why: &str| Fail::argument(format!("the message is not a valid request: {why}"));
    let message: Cbor =
        ciborium::de::from_reader_with_recursion_limit(bytes, MAX_DEPTH).map_err(|e| wrong(&e.to_string()))?;
    let Cbor::Map(entries) = message else { return Err(wrong("expected a map")) };
    let mut request = RemoteRequest::default();
    for (key, entry) in entries {
        match (key.as_text(), entry) {
            (Some("func"), Cbor::Text(name)) => request.func = name,
            (Some("args"), Cbor::Array(args)) => request.args = args.into_iter().map(value).collect::<Result<_>>()?,
            (Some("uuid"), Cbor::Text(uuid)) => request.uuid = Some(uuid),
            (Some("func" | "args" | "uuid"), _) => {
                return Err(wrong("`func` and `uuid` must be strings, and `args` must be an array"));
            }
            _ => {}
        }
    }
    if request.func.is_empty() { Err(wrong("`func` is missing or empty")) } else { Ok(request) }
}

/// The string by which clients represent nil in arguments.
const NIL: &str = "_*NIL*_";

/// Converts a CBOR value. Tags are ignored, and integers that exceed 64 bits become floats.
fn value(cbor: Cbor) -> Result<Value> {
    Ok(match cbor {
        Cbor::Null => Value::Nil,
        Cbor::Bool(b) => Value::Bool(b),
        Cbor::Integer(i) => {
            let i = i128::from(i);
            i64::try_from(i).map_or(Value::Float(i as f64), Value::Int)
        }
        Cbor::Float(x) => Value::Float(x),
        Cbor::Text(t) if t == NIL => Value::Nil,
        Cbor::Text(t) => Value::text(t),
        Cbor::Bytes(b) => Value::Bytes(b),
        Cbor::Array(items) => array(items.into_iter().map(value).collect::<Result<_>>()?),
        Cbor::Map(entries) => {
            Value::Map(entries.into_iter().map(|(k, v)| Ok((value(k)?, value(v)?))).collect::<Result<_>>()?)
        }
        Cbor::Tag(_, inner) => value(*inner)?,
        _ => return Err(Fail::argument("the request contains a CBOR value of an unsupported type")),
    })
}

/// Converts an array: to an array of integers or floats if it is not empty and all elements are numbers, otherwise to a
/// list.
fn array(values: Vec<Value>) -> Value {
    if values.is_empty() {
        return Value::List(values);
    }
    if let Some(ints) = values.iter().map(|v| if let Value::Int(i) = v { Some(*i) } else { None }).collect() {
        return Value::Ints(ints);
    }
    let numbers = values.iter().map(|v| match v {
        Value::Int(i) => Some(*i as f64),
        Value::Float(x) => Some(*x),
        _ => None,
    });
    match numbers.collect() {
        Some(numbers) => Value::Floats(numbers),
        None => Value::List(values),
    }
}

/// Converts a value to CBOR. Strings that are not UTF-8 become byte strings, objects become handles, and functions
/// become null. Bytes, which may be images, are moved, not copied.
pub fn write(value: Value) -> Cbor {
    match value {
        Value::Nil | Value::Func(_) => Cbor::Null,
        Value::Bool(b) => Cbor::Bool(b),
        Value::Int(i) => Cbor::Integer(i.into()),
        Value::Float(x) => Cbor::Float(x),
        Value::Text(t) => String::from_utf8(t).map_or_else(|e| Cbor::Bytes(e.into_bytes()), Cbor::Text),
        Value::Bytes(b) => Cbor::Bytes(b),
        Value::Floats(all) => Cbor::Array(all.into_iter().map(Cbor::Float).collect()),
        Value::Ints(all) => Cbor::Array(all.into_iter().map(|i| Cbor::Integer(i.into())).collect()),
        Value::List(all) => Cbor::Array(all.into_iter().map(write).collect()),
        Value::Map(all) => Cbor::Map(all.into_iter().map(|(k, v)| (write(k), write(v))).collect()),
        Value::Object(o) => Cbor::Integer(tatu_slot(o).into()),
    }
}

/// Encodes a message, given its keys and values.
fn encode(message: Vec<(&str, Cbor)>) -> Vec<u8> {
    let message = Cbor::Map(message.into_iter().map(|(k, v)| (Cbor::Text(k.to_owned()), v)).collect());
    let mut out = Vec::new();
    // Writing into memory cannot fail.
    let _ = ciborium::into_writer(&message, &mut out);
    out
}

/// Builds the answer to a successful call. `first` is whether the client uses the first version of the protocol.
pub fn encode_results(values: Vec<Cbor>, first: bool) -> Vec<u8> {
    let mut message = vec![("ret", Cbor::Array(values))];
    if first {
        message.push(("success", Cbor::Bool(true)));
    }
    encode(message)
}

/// Builds an answer that calls a function of the client.
pub fn encode_call(name: &str, args: &[Value]) -> Vec<u8> {
    let args = args.iter().cloned().map(write).collect();
    encode(vec![("func", Cbor::Text(name.to_owned())), ("args", Cbor::Array(args))])
}

/// Builds the answer to a failed call. `first` is whether the client uses the first version of the protocol.
pub fn encode_error(text: &str, first: bool) -> Vec<u8> {
    if first {
        return encode(vec![("success", Cbor::Bool(false)), ("error", Cbor::Text(text.to_owned()))]);
    }
    encode(vec![("err", Cbor::Text(text.to_owned()))])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_of_a_real_client_is_read() {
        // sim.f(7, b'\x00\xff', [1.0, -2], 'txt', None, True, {'k': 1}), as encoded by the Python client.
        let args = b"\x87\x07\x42\x00\xff\x82\xfb\x3f\xf0\0\0\0\0\0\0\x21\x63txt\xf6\xf5\xa1\x61k\x01";
        let bytes = [b"\xa3\x64func\x65sim.f\x64args", &args[..], b"\x64uuid\x62ab"].concat();
        let request = read(&bytes).unwrap();
        assert_eq!((request.func.as_str(), request.uuid.as_deref()), ("sim.f", Some("ab")));
        assert_eq!(
            request.args,
            [
                Value::Int(7),
                Value::Bytes(vec![0, 255]),
                Value::Floats(vec![1.0, -2.0]),
                Value::text("txt"),
                Value::Nil,
                Value::Bool(true),
                Value::Map(vec![(Value::text("k"), Value::Int(1))]),
            ]
        );
    }

    #[test]
    fn invalid_requests_are_refused() {
        for bytes in
            [&b""[..], b"\x01", b"\xa0", b"\xa1\x64func\x01", b"\x9f\x9f\x9f", b"\x9b\x7f\xff\xff\xff\xff\xff\xff\xff"]
        {
            assert!(read(bytes).is_err(), "{bytes:?}");
        }
        assert!(read(&[0x81; 100_000]).is_err());
    }

    #[test]
    fn answers_are_those_of_the_protocol() {
        assert_eq!(encode_results(vec![Cbor::Integer(42.into())], false), b"\xa1\x63ret\x81\x18\x2a");
        assert!(encode_error("no", true).windows(7).any(|w| w == b"success"));
    }
}
