//! Encodes and decodes numbers and strings in the subjects and data of commands.

use tatu_plugin_api::{
    abi::tatu_slot,
    safe::{Fail, Result, Value},
};

/// Decodes little-endian values from the front of a byte slice, which is shortened by each read.
pub struct LittleEndianReader<'a>(pub &'a [u8]);

impl<'a> LittleEndianReader<'a> {
    /// Reads the next `n` bytes.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        if n > self.0.len() {
            return Err(Fail::argument("the data of the command is shorter than its arguments require"));
        }
        let (now, rest) = self.0.split_at(n);
        self.0 = rest;
        Ok(now)
    }
    /// Reads a 32-bit integer.
    pub fn i32(&mut self) -> Result<i32> {
        let mut four = [0; 4];
        four.copy_from_slice(self.take(4)?);
        Ok(i32::from_le_bytes(four))
    }
    /// Reads a 32-bit float.
    pub fn f32(&mut self) -> Result<f64> {
        let mut four = [0; 4];
        four.copy_from_slice(self.take(4)?);
        Ok(f64::from(f32::from_le_bytes(four)))
    }
    /// Reads `n` 32-bit floats as an array value.
    pub fn f32s(&mut self, n: usize) -> Result<Value> {
        Ok(Value::Floats((0..n).map(|_| self.f32()).collect::<Result<_>>()?))
    }
    /// Reads a 32-bit integer, such as a handle, as a value.
    pub fn int(&mut self) -> Result<Value> {
        Ok(Value::Int(self.i32()?.into()))
    }
    /// Reads a 32-bit float as a value.
    pub fn float(&mut self) -> Result<Value> {
        Ok(Value::Float(self.f32()?))
    }
    /// Reads a zero-terminated string.
    pub fn text(&mut self) -> Result<Vec<u8>> {
        let end = self
            .0
            .iter()
            .position(|b| *b == 0)
            .ok_or_else(|| Fail::argument("a string is not terminated by a zero byte"))?;
        let text = self.take(end)?.to_vec();
        self.take(1)?;
        Ok(text)
    }
    /// Reads all remaining bytes.
    pub fn rest(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.0).to_vec()
    }
    /// Reads all remaining bytes as an array of 32-bit integers.
    pub fn ints(&mut self) -> Result<Value> {
        let mut all = Vec::new();
        while !self.0.is_empty() {
            all.push(self.i32()?.into());
        }
        Ok(Value::Ints(all))
    }
}

/// A buffer to which little-endian values are appended.
#[derive(Default)]
pub struct LittleEndianWriter(pub Vec<u8>);

impl LittleEndianWriter {
    /// Appends a 32-bit integer.
    pub fn i32(&mut self, x: i64) -> &mut Self {
        self.0.extend_from_slice(&(x as i32).to_le_bytes());
        self
    }
    /// Appends a 32-bit float.
    pub fn f32(&mut self, x: f64) -> &mut Self {
        self.0.extend_from_slice(&(x as f32).to_le_bytes());
        self
    }
    /// Appends 32-bit floats.
    pub fn f32s(&mut self, all: &[f64]) -> &mut Self {
        all.iter().for_each(|x| {
            self.f32(*x);
        });
        self
    }
    /// Appends a byte.
    pub fn u8(&mut self, x: u8) -> &mut Self {
        self.0.push(x);
        self
    }
    /// Appends a zero-terminated string, which ends at the first zero byte in `text`.
    pub fn text(&mut self, text: &[u8]) -> &mut Self {
        self.0.extend(text.iter().take_while(|b| **b != 0));
        self.0.push(0);
        self
    }
    /// Appends bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.extend_from_slice(bytes);
        self
    }
}

/// Converts a result of a command to an integer. Floats are truncated, and objects become their handles.
pub fn int(value: Option<&Value>) -> Result<i64> {
    match value {
        Some(Value::Int(i)) => Ok(*i),
        Some(Value::Float(x)) => Ok(*x as i64),
        Some(Value::Bool(b)) => Ok(i64::from(*b)),
        Some(Value::Object(o)) => Ok(i64::from(tatu_slot(*o))),
        _ => Err(Fail::missing("the command did not return an integer")),
    }
}

/// Converts a result of a command to a float.
pub fn float(value: Option<&Value>) -> Result<f64> {
    match value {
        Some(Value::Float(x)) => Ok(*x),
        other => int(other).map(|i| i as f64),
    }
}

/// Converts a result of a command to a list of floats.
pub fn floats(value: Option<&Value>) -> Result<Vec<f64>> {
    match value {
        Some(Value::Floats(all)) => Ok(all.clone()),
        Some(Value::Ints(all)) => Ok(all.iter().map(|i| *i as f64).collect()),
        Some(Value::List(all)) => all.iter().map(|v| float(Some(v))).collect(),
        _ => Err(Fail::missing("the command did not return a list of numbers")),
    }
}

/// Returns the bytes of a result that is a string or a buffer.
pub fn bytes(value: Option<&Value>) -> Result<&[u8]> {
    match value {
        Some(Value::Text(b) | Value::Bytes(b)) => Ok(b),
        _ => Err(Fail::missing("the command did not return a string")),
    }
}
