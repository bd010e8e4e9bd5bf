//! Unpacks tables that V-REP has packed in its own format or as CBOR. V-REP's scenes contain such data.
//!
//! The format was inferred from files (tests/facts/script-api.md, 7): a byte 0 (5 since 4.5), followed by the table.

use tatu_plugin_api::safe::{MAX_DEPTH, Value};

/// Decodes a value in either format; returns `None` if the bytes are in neither.
pub(crate) fn read(data: &[u8]) -> Option<Value> {
    match data {
        [0 | 5, rest @ ..] => table(&mut &*rest, 0),
        [0x80..=0x9b | 0x9f..=0xbb | 0xbf, ..] => cbor(&ciborium::from_reader(data).ok()?, 0),
        _ => None,
    }
}

fn take<'a>(rest: &mut &'a [u8], n: usize) -> Option<&'a [u8]> {
    let (head, tail) = rest.split_at_checked(n)?;
    *rest = tail;
    Some(head)
}

fn count(rest: &mut &[u8]) -> Option<usize> {
    let n = i32::from_le_bytes(take(rest, 4)?.try_into().ok()?);
    // Each element occupies at least one byte, so a larger count is invalid.
    usize::try_from(n).ok().filter(|n| *n <= rest.len())
}

fn table(rest: &mut &[u8], depth: usize) -> Option<Value> {
    let kind = take(rest, 1)?[0];
    let n = count(rest)?;
    match kind {
        1 => Some(Value::List((0..n).map(|_| value(rest, depth)).collect::<Option<_>>()?)),
        0 => Some(Value::Map(
            (0..n / 2).map(|_| Some((value(rest, depth)?, value(rest, depth)?))).collect::<Option<_>>()?,
        )),
        _ => None,
    }
}

fn value(rest: &mut &[u8], depth: usize) -> Option<Value> {
    if depth > MAX_DEPTH {
        return None;
    }
    Some(match take(rest, 1)?[0] {
        0 => Value::Nil,
        1 => Value::Float(f64::from_le_bytes(take(rest, 8)?.try_into().ok()?)),
        // This encoding is an assumption, because none of the examined files contains a boolean.
        2 => Value::Bool(take(rest, 1)?[0] != 0),
        3 => {
            let n = count(rest)?;
            Value::Text(take(rest, n)?.to_vec())
        }
        4 => return table(rest, depth + 1),
        9 => Value::Int(i64::from_le_bytes(take(rest, 8)?.try_into().ok()?)),
        _ => return None,
    })
}

fn cbor(v: &ciborium::Value, depth: usize) -> Option<Value> {
    use ciborium::Value as Cbor;
    if depth > MAX_DEPTH {
        return None;
    }
    Some(match v {
        Cbor::Null => Value::Nil,
        Cbor::Bool(b) => Value::Bool(*b),
        Cbor::Integer(i) => i64::try_from(*i).map_or_else(|_| Value::Float(i128::from(*i) as f64), Value::Int),
        Cbor::Float(x) => Value::Float(*x),
        Cbor::Text(t) => Value::text(t),
        Cbor::Bytes(b) => Value::Bytes(b.clone()),
        Cbor::Array(all) => Value::List(all.iter().map(|v| cbor(v, depth + 1)).collect::<Option<_>>()?),
        Cbor::Map(all) => Value::Map(
            all.iter().map(|(k, v)| Some((cbor(k, depth + 1)?, cbor(v, depth + 1)?))).collect::<Option<_>>()?,
        ),
        Cbor::Tag(_, inner) => return cbor(inner, depth + 1),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_files_are_read() {
        let old = b"\0\0\x04\0\0\0\x03\x07\0\0\0version\x01\0\0\0\0\0\0\0\0\x03\x05\0\0\0sizes\x04\x01\x02\0\0\0\
            \x01\0\0\0\0\0\0\x14@\x01\0\0\0\0\0\0\x14@";
        let sizes = Value::List(vec![Value::Float(5.0), Value::Float(5.0)]);
        let wanted = Value::Map(vec![(Value::text("version"), Value::Float(0.0)), (Value::text("sizes"), sizes)]);
        assert_eq!(read(old), Some(wanted));
        let new = b"\x05\0\x02\0\0\0\x03\x05\0\0\0xSize\x09\x05\0\0\0\0\0\0\0\x02\xff";
        assert_eq!(read(new), Some(Value::Map(vec![(Value::text("xSize"), Value::Int(5))])));
        assert_eq!(read(b"\xa1\x61a\x83\x01\xf5\x62hi").map(|v| matches!(v, Value::Map(_))), Some(true));
    }

    #[test]
    fn damaged_tables_are_refused() {
        for bytes in
            [&b""[..], b"\0", b"\0\x02\0\0\0\0", b"\0\x01\xff\xff\xff\x7f", b"\0\x01\x01\0\0\0\x07", b"\x81", b"\x01"]
        {
            assert_eq!(read(bytes), None, "{bytes:?}");
        }
        let deep: Vec<u8> =
            b"\0\x01\x01\0\0\0".iter().copied().chain((0..10_000).flat_map(|_| *b"\x04\x01\x01\0\0\0")).collect();
        assert_eq!(read(&deep), None);
    }
}
