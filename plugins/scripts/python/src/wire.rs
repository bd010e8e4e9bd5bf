//! Values on the wire between the plugin and the interpreter's process, little-endian: a tag, then the payload.
//!
//! `runtime/wire.py` is the other side. The process belongs to a script that may send anything, so reading checks every
//! length against what was received, before memory is allocated for it.

use tatu_plugin_api::{abi::*, safe::*};

const NIL: u8 = 0;
const FALSE: u8 = 1;
const TRUE: u8 = 2;
const INT: u8 = 3;
const FLOAT: u8 = 4;
const TEXT: u8 = 5;
const BYTES: u8 = 6;
const FLOATS: u8 = 7;
const INTS: u8 = 8;
const LIST: u8 = 9;
const MAP: u8 = 10;
/// A function of the script itself, by its local number.
const OWN_FUNCTION: u8 = 11;
/// A function of another script or of a client.
const FUNCTION: u8 = 12;

/// Appends a value. `own` is the instance of the script that receives it.
pub(crate) fn write(out: &mut Vec<u8>, value: ValueRef<'_>, own: u64) {
    let tag = value.tag();
    match tag {
        TATU_BOOL => out.push(if value.as_bool() == Some(true) { TRUE } else { FALSE }),
        TATU_I64 => number(out, INT, value.as_i64().unwrap_or(0).to_le_bytes()),
        TATU_OBJECT => number(out, INT, value.as_object().unwrap_or(0).to_le_bytes()),
        TATU_F64 => number(out, FLOAT, value.as_f64().unwrap_or(0.0).to_le_bytes()),
        TATU_TEXT | TATU_BYTES => {
            let bytes = value.as_bytes().unwrap_or_default();
            head(out, if tag == TATU_TEXT { TEXT } else { BYTES }, bytes.len());
            out.extend_from_slice(bytes);
        }
        TATU_F64S | TATU_F32S => {
            head(out, FLOATS, value.len());
            (0..value.len()).for_each(|i| out.extend(value.number(i).unwrap_or(f64::NAN).to_le_bytes()));
        }
        TATU_I64S => {
            head(out, INTS, value.len());
            let numbers = value.span_bytes().as_chunks::<8>().0;
            numbers.iter().for_each(|i| out.extend(i64::from_ne_bytes(*i).to_le_bytes()));
        }
        TATU_I32S | TATU_U8S => {
            head(out, INTS, value.len());
            (0..value.len()).for_each(|i| out.extend((value.number(i).unwrap_or(0.0) as i64).to_le_bytes()));
        }
        TATU_LIST => {
            let items = value.list().unwrap_or_default();
            head(out, LIST, items.len());
            items.iter().for_each(|item| write(out, *item, own));
        }
        TATU_MAP => {
            let entries = value.map().unwrap_or_default();
            head(out, MAP, entries.len());
            entries.as_flattened().iter().for_each(|item| write(out, *item, own));
        }
        TATU_FUNC => {
            let func = value.as_func().unwrap_or(0);
            match func >> 32 == own {
                true => number(out, OWN_FUNCTION, (func as u32).to_le_bytes()),
                false => number(out, FUNCTION, func.to_le_bytes()),
            }
        }
        _ => out.push(NIL),
    }
}

/// Appends the values of an argument list or of results, after their number.
pub(crate) fn write_all(out: &mut Vec<u8>, values: &[ValueRef<'_>], own: u64) {
    out.extend((values.len() as u32).to_le_bytes());
    values.iter().for_each(|value| write(out, *value, own));
}

/// Appends a text after its length.
pub(crate) fn write_text(out: &mut Vec<u8>, text: &[u8]) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend_from_slice(text);
}

fn number<const N: usize>(out: &mut Vec<u8>, tag: u8, bytes: [u8; N]) {
    out.push(tag);
    out.extend(bytes);
}

fn head(out: &mut Vec<u8>, tag: u8, len: usize) {
    number(out, tag, (len as u32).to_le_bytes());
}

/// A message of the process was malformed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Malformed;

/// Reads a message of the process.
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    own: u64,
}

impl<'a> Reader<'a> {
    /// Creates a reader; `own` is the instance of the script that sent the bytes.
    pub fn new(bytes: &'a [u8], own: u64) -> Self {
        Reader { rest: bytes, own }
    }

    pub fn take(&mut self, n: usize) -> Result<&'a [u8], Malformed> {
        let (taken, rest) = self.rest.split_at_checked(n).ok_or(Malformed)?;
        self.rest = rest;
        Ok(taken)
    }
    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or(Malformed)?;
        self.rest = rest;
        Ok(*taken)
    }
    pub fn u8(&mut self) -> Result<u8, Malformed> {
        self.array::<1>().map(|[b]| b)
    }
    pub fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }
    pub fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }
    pub fn i32(&mut self) -> Result<i32, Malformed> {
        self.array().map(i32::from_le_bytes)
    }
    /// Returns everything that has not been read.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }
    /// Reads bytes after their length.
    pub fn bytes(&mut self) -> Result<&'a [u8], Malformed> {
        let n = self.u32()?;
        self.take(n as usize)
    }
    /// Reads a text after its length; invalid UTF-8 is replaced.
    pub fn text(&mut self) -> Result<String, Malformed> {
        Ok(String::from_utf8_lossy(self.bytes()?).into_owned())
    }
    /// Reads the values of an argument list or of results, after their number.
    pub fn values(&mut self) -> Result<Vec<Value>, Malformed> {
        let n = self.u32()? as usize;
        self.sequence(n, 1, 0)
    }

    /// Reads `n` values, each of which takes at least `least` bytes.
    fn sequence(&mut self, n: usize, least: usize, depth: usize) -> Result<Vec<Value>, Malformed> {
        if n > self.rest.len() / least {
            return Err(Malformed);
        }
        (0..n).map(|_| self.nested(depth)).collect()
    }

    fn nested(&mut self, depth: usize) -> Result<Value, Malformed> {
        if depth > MAX_DEPTH {
            return Err(Malformed);
        }
        Ok(match self.u8()? {
            NIL => Value::Nil,
            FALSE => Value::Bool(false),
            TRUE => Value::Bool(true),
            INT => Value::Int(i64::from_le_bytes(self.array()?)),
            FLOAT => Value::Float(f64::from_le_bytes(self.array()?)),
            TEXT => Value::Text(self.bytes()?.to_vec()),
            BYTES => Value::Bytes(self.bytes()?.to_vec()),
            FLOATS => Value::Floats(self.words()?.iter().map(|b| f64::from_le_bytes(*b)).collect()),
            INTS => Value::Ints(self.words()?.iter().map(|b| i64::from_le_bytes(*b)).collect()),
            LIST => {
                let n = self.u32()? as usize;
                Value::List(self.sequence(n, 1, depth + 1)?)
            }
            MAP => {
                let n = self.u32()? as usize;
                let mut flat = self.sequence(n.saturating_mul(2), 1, depth + 1)?.into_iter();
                Value::Map(std::iter::from_fn(|| flat.next().zip(flat.next())).collect())
            }
            OWN_FUNCTION => Value::Func(self.own << 32 | u64::from(self.u32()?)),
            FUNCTION => Value::Func(self.u64()?),
            _ => return Err(Malformed),
        })
    }

    fn words(&mut self) -> Result<&'a [[u8; 8]], Malformed> {
        let n = self.u32()? as usize;
        Ok(self.take(n.checked_mul(8).ok_or(Malformed)?)?.as_chunks().0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(value: &Value) -> Vec<u8> {
        let mut out = Vec::new();
        write(&mut out, tatu_plugin_api::safe::Owned::default().value(value), 7);
        out
    }

    #[test]
    fn values_of_every_type_survive_the_way_there_and_back() {
        let map = Value::Map(vec![(Value::text("a"), Value::Ints(vec![1, -2])), (Value::Int(3), Value::Nil)]);
        for value in [
            Value::Nil,
            Value::Bool(true),
            Value::Int(i64::MIN),
            Value::Float(-0.0),
            Value::Text(vec![b'x', 0xFF]),
            Value::Bytes(vec![0, 1]),
            Value::Floats(vec![1.5, f64::INFINITY]),
            Value::List(vec![map.clone(), Value::List(Vec::new())]),
            map,
            Value::Func(7 << 32 | 5),
            Value::Func(8 << 32 | 5),
        ] {
            assert_eq!(Reader::new(&written(&value), 7).nested(0), Ok(value));
        }
    }

    #[test]
    fn malformed_values_are_refused_without_allocating_what_they_claim() {
        let huge = [LIST, 0xFF, 0xFF, 0xFF, 0xFF];
        for bytes in [&huge[..], &[MAP, 0xFF, 0xFF, 0xFF, 0xFF, 0], &[FLOATS, 0xFF, 0xFF, 0xFF, 0xFF], &[99], &[]] {
            assert_eq!(Reader::new(bytes, 7).nested(0), Err(Malformed), "{bytes:?}");
        }
        let deep = [LIST, 1, 0, 0, 0].repeat(MAX_DEPTH + 2);
        assert_eq!(Reader::new(&deep, 7).nested(0), Err(Malformed));
    }
}
