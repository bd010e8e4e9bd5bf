//! Packs values into bytes, and unpacks them.
//!
//! The format is a marker byte followed by the value, which consists of a letter for its type and its little-endian
//! bytes. Strings, lists and maps start with their length.

use tatu_plugin_api::{
    abi::{TATU_ERR_SPACE, tatu_value},
    safe::{Fail, Result, Value},
};

use super::{
    arguments::{STAND_IN_DATA, handle},
    foreign_tables,
};

const FORMAT_MARK: u8 = 0xF7;

/// Maximum total size of the values of a call, bytes; the limit of the host.
const MAX_BYTES: usize = 256 << 20;

/// Checks, before values are created from packed data, that `n` values of `each` bytes do not exceed the limit of the
/// values of a call.
pub(crate) fn check_count(n: usize, each: usize) -> Result {
    match n.checked_mul(each) {
        Some(bytes) if bytes <= MAX_BYTES => Ok(()),
        _ => Err(Fail::with_code(
            TATU_ERR_SPACE,
            format!("{n} values exceed the limit of {} MB for the values of a call", MAX_BYTES >> 20),
        )
        .help("unpack the data in several parts")),
    }
}

/// Size of a value in a list or map, bytes.
const VALUE_BYTES: usize = size_of::<tatu_value>();

/// Packs a value in this plugin's format. Fails if the value is or contains a function.
pub(crate) fn pack(v: &Value) -> Result<Vec<u8>> {
    let mut out = vec![FORMAT_MARK];
    write(v, &mut out)?;
    Ok(out)
}

fn write(v: &Value, out: &mut Vec<u8>) -> Result {
    let head = |out: &mut Vec<u8>, letter: u8, n: usize| {
        out.push(letter);
        out.extend((n as u32).to_le_bytes());
    };
    match v {
        Value::Nil => out.push(b'n'),
        Value::Bool(b) => out.extend([b'b', u8::from(*b)]),
        Value::Int(i) => {
            out.push(b'i');
            out.extend(i.to_le_bytes());
        }
        Value::Float(x) => {
            out.push(b'f');
            out.extend(x.to_le_bytes());
        }
        Value::Text(t) | Value::Bytes(t) => {
            head(out, b's', t.len());
            out.extend(t);
        }
        Value::Floats(l) => {
            head(out, b'l', l.len());
            l.iter().try_for_each(|x| write(&Value::Float(*x), out))?;
        }
        Value::Ints(l) => {
            head(out, b'l', l.len());
            l.iter().try_for_each(|x| write(&Value::Int(*x), out))?;
        }
        Value::List(l) => {
            head(out, b'l', l.len());
            l.iter().try_for_each(|x| write(x, out))?;
        }
        Value::Map(m) => {
            head(out, b'm', m.len());
            m.iter().try_for_each(|(k, v)| write(k, out).and_then(|()| write(v, out)))?;
        }
        Value::Func(_) => return Err(Fail::argument("a table with functions cannot be packed")),
        Value::Object(o) => write(&Value::Int(handle(*o)), out)?,
    }
    Ok(())
}

/// Unpacks a value that this plugin or V-REP has packed.
pub(crate) fn unpack(data: &[u8]) -> Result<Value> {
    let garbage = || Fail::argument("the data is not a packed table, or it is damaged");
    if data == STAND_IN_DATA {
        return Ok(Value::List(Vec::new()));
    }
    let Some(mut rest) = data.strip_prefix(&[FORMAT_MARK]) else {
        // In the formats of V-REP, a value can occupy a single byte.
        check_count(data.len(), VALUE_BYTES)?;
        return foreign_tables::read(data).ok_or_else(garbage);
    };
    let (mut count, most) = (0, MAX_BYTES / VALUE_BYTES);
    let v = read(&mut rest, 0, &mut count);
    if count > most {
        check_count(count, VALUE_BYTES)?;
    }
    let v = v.ok_or_else(garbage)?;
    if rest.is_empty() { Ok(v) } else { Err(garbage()) }
}

/// Reads a value, and adds the number of values in it to `read_so_far`. Returns `None` if the data is invalid, or if it
/// contains more values than a call can pass.
fn read(rest: &mut &[u8], depth: usize, read_so_far: &mut usize) -> Option<Value> {
    fn take<'a>(rest: &mut &'a [u8], n: usize) -> Option<&'a [u8]> {
        let (head, tail) = rest.split_at_checked(n)?;
        *rest = tail;
        Some(head)
    }
    let count = |rest: &mut &[u8]| Some(u32::from_le_bytes(take(rest, 4)?.try_into().ok()?) as usize);
    *read_so_far += 1;
    if depth > tatu_plugin_api::safe::MAX_DEPTH || *read_so_far > MAX_BYTES / VALUE_BYTES {
        return None;
    }
    Some(match take(rest, 1)?[0] {
        b'n' => Value::Nil,
        b'b' => Value::Bool(take(rest, 1)?[0] != 0),
        b'i' => Value::Int(i64::from_le_bytes(take(rest, 8)?.try_into().ok()?)),
        b'f' => Value::Float(f64::from_le_bytes(take(rest, 8)?.try_into().ok()?)),
        b's' => {
            let n = count(rest)?;
            Value::Text(take(rest, n)?.to_vec())
        }
        b'l' => Value::List((0..count(rest)?).map(|_| read(rest, depth + 1, read_so_far)).collect::<Option<_>>()?),
        b'm' => Value::Map(
            (0..count(rest)?)
                .map(|_| Some((read(rest, depth + 1, read_so_far)?, read(rest, depth + 1, read_so_far)?)))
                .collect::<Option<_>>()?,
        ),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_before_allocation() {
        assert!(check_count(MAX_BYTES / 8, 8).is_ok());
        assert!(check_count(MAX_BYTES / 8 + 1, 8).is_err());
        assert!(check_count(usize::MAX, 8).is_err());
        let n = MAX_BYTES / VALUE_BYTES + 1;
        let mut data = vec![FORMAT_MARK, b'l'];
        data.extend((n as u32).to_le_bytes());
        data.resize(data.len() + n, b'n');
        assert_eq!(unpack(&data).unwrap_err().code(), TATU_ERR_SPACE);
    }

    #[test]
    fn packed_values_are_unpacked_unchanged() {
        let v = Value::Map(vec![
            (Value::text("a"), Value::List(vec![Value::Int(1), Value::Float(0.5), Value::Nil, Value::Bool(true)])),
            (Value::Int(7), Value::text("\0x")),
        ]);
        assert_eq!(unpack(&pack(&v).unwrap()).unwrap(), v);
        assert!(unpack(b"garbage").is_err());
        assert!(unpack(&[FORMAT_MARK, b'l', 255, 255, 255, 255]).is_err());
        assert!(pack(&Value::Func(1)).is_err());
    }
}
