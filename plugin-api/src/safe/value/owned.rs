//! Owned values, and access to values that are borrowed in the form of the ABI.

use std::{borrow::Cow, mem::MaybeUninit, ptr::NonNull};

use crate::abi::*;
use crate::safe::{Fail, Result, ValueRef};

/// Maximum depth of nested lists and maps.
pub const MAX_DEPTH: usize = 32;

/// A value that owns its data, unlike [`ValueRef`].
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Value {
    /// No value.
    #[default]
    Nil,
    /// A boolean.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A floating-point number.
    Float(f64),
    /// Text, stored as bytes because it is not guaranteed to be UTF-8.
    Text(Vec<u8>),
    /// A byte string.
    Bytes(Vec<u8>),
    /// An array of floating-point numbers.
    Floats(Vec<f64>),
    /// An array of integers.
    Ints(Vec<i64>),
    /// A list of values of any types.
    List(Vec<Value>),
    /// Entries of key and value, in insertion order.
    Map(Vec<(Value, Value)>),
    /// A function of a script.
    Func(tatu_func),
    /// An object.
    Object(tatu_object),
}

impl Value {
    /// Creates a text.
    pub fn text(s: impl AsRef<[u8]>) -> Self {
        Value::Text(s.as_ref().to_vec())
    }

    /// Converts the value to the form of the ABI, and copies the data that it points to into `room`. The result must
    /// not be read after `room` has been dropped. Returns `None` if there is not enough space.
    pub fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        Some(match self {
            Value::Nil => raw_int(TATU_NIL, 0),
            Value::Bool(b) => raw_int(TATU_BOOL, i64::from(*b)),
            Value::Int(i) => raw_int(TATU_I64, *i),
            Value::Float(f) => tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f: *f } },
            Value::Text(t) => raw_span(TATU_TEXT, t, room)?,
            Value::Bytes(t) => raw_span(TATU_BYTES, t, room)?,
            Value::Floats(t) => raw_span(TATU_F64S, t, room)?,
            Value::Ints(t) => raw_span(TATU_I64S, t, room)?,
            Value::List(items) => {
                let raw = items.iter().map(|v| v.to_raw(room)).collect::<Option<Vec<_>>>()?;
                raw_span(TATU_LIST, &raw, room)?
            }
            Value::Map(items) => {
                let pair = |(k, v): &(Value, Value)| Some(tatu_pair { key: k.to_raw(room)?, value: v.to_raw(room)? });
                let raw = items.iter().map(pair).collect::<Option<Vec<_>>>()?;
                raw_span(TATU_MAP, &raw, room)?
            }
            Value::Func(f) => tatu_value { tag: TATU_FUNC, reserved: 0, u: tatu_payload { u: *f } },
            Value::Object(o) => tatu_value { tag: TATU_OBJECT, reserved: 0, u: tatu_payload { u: *o } },
        })
    }
}

/// Storage for data to which values of the ABI point. Stored data does not move.
pub trait Room {
    /// Allocates `n` words of 8 bytes. Returns `None` if there is not enough space.
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]>;
}

/// Returns memory from the host as a slice, or `None` for null.
///
/// # Safety
/// `at` must be null, or aligned to 8 bytes with room for `n` words that nothing else uses within `'a`.
pub(crate) unsafe fn given<'a>(at: *mut u8, n: usize) -> Option<&'a mut [MaybeUninit<u64>]> {
    // SAFETY: `at` is not null here, and the caller guarantees alignment, size and exclusive use.
    NonNull::new(at).map(|at| unsafe { std::slice::from_raw_parts_mut(at.cast().as_ptr(), n) })
}

/// Storage that owns its memory and has no limit.
#[derive(Default)]
pub struct Owned(Vec<Vec<MaybeUninit<u64>>>);

impl Room for Owned {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        self.0.push(vec![MaybeUninit::uninit(); n]);
        self.0.last_mut().map(Vec::as_mut_slice)
    }
}

impl Owned {
    /// Converts a value to the form of the ABI.
    pub fn value(&mut self, value: &Value) -> ValueRef<'_> {
        let raw = self.raw(value);
        // SAFETY: the value's data is stored in `self`, which frees nothing before it is dropped; the returned value
        // borrows `self`.
        unsafe { ValueRef::new(raw) }
    }
    /// Converts several values to the form of the ABI.
    pub fn values(&mut self, values: &[Value]) -> Vec<ValueRef<'_>> {
        let raw: Vec<_> = values.iter().map(|v| self.raw(v)).collect();
        // SAFETY: the values' data is stored in `self`, which frees nothing before it is dropped; the returned values
        // borrow `self`.
        raw.into_iter().map(|raw| unsafe { ValueRef::new(raw) }).collect()
    }
    /// Converts a value for a table of the ABI; its data must not be read after `self` has been dropped.
    pub fn raw(&mut self, value: &Value) -> tatu_value {
        value.to_raw(self).unwrap_or(raw_int(TATU_NIL, 0))
    }
}

/// Builds a value that contains a copy of `data`, whose type `T` must match the tag. Returns `None` if there is not
/// enough space.
pub(crate) fn raw_span<T: Copy>(tag: u32, data: &[T], room: &mut dyn Room) -> Option<tatu_value> {
    let bytes = size_of_val(data);
    let words = room.words(bytes.div_ceil(8).max(1)).filter(|words| size_of_val(*words) >= bytes)?;
    let to = words.as_mut_ptr();
    // SAFETY: `words` was checked to have at least `bytes` bytes, and is newly allocated, so it does not overlap
    // `data`.
    unsafe { std::ptr::copy_nonoverlapping(data.as_ptr().cast::<u8>(), to.cast::<u8>(), bytes) };
    Some(tatu_value {
        tag,
        reserved: 0,
        u: tatu_payload { s: tatu_span_t { ptr: to.cast_const().cast(), len: data.len() as u64 } },
    })
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        Value::Float(x)
    }
}
impl From<i64> for Value {
    fn from(x: i64) -> Self {
        Value::Int(x)
    }
}
impl From<i32> for Value {
    fn from(x: i32) -> Self {
        Value::Int(x.into())
    }
}
impl From<bool> for Value {
    fn from(x: bool) -> Self {
        Value::Bool(x)
    }
}
impl From<&str> for Value {
    fn from(x: &str) -> Self {
        Value::text(x)
    }
}
impl From<u32> for Value {
    fn from(x: u32) -> Self {
        Value::Int(x.into())
    }
}
impl From<String> for Value {
    fn from(x: String) -> Self {
        Value::Text(x.into_bytes())
    }
}
impl From<Vec<i64>> for Value {
    fn from(x: Vec<i64>) -> Self {
        Value::Ints(x)
    }
}
impl<const N: usize> From<[f64; N]> for Value {
    fn from(x: [f64; N]) -> Self {
        Value::Floats(x.to_vec())
    }
}
impl From<Vec<f64>> for Value {
    fn from(x: Vec<f64>) -> Self {
        Value::Floats(x)
    }
}

pub(crate) fn raw_int(tag: u32, i: i64) -> tatu_value {
    tatu_value { tag, reserved: 0, u: tatu_payload { i } }
}

impl<'a> ValueRef<'a> {
    /// Returns the payload of a value that is not a span.
    fn bits(self) -> u64 {
        // SAFETY: every member of the union consists of at least 8 initialized bytes, for which any `u64` is valid.
        unsafe { self.raw().u.u }
    }
    /// Returns the elements of a span, whose type `T` must match the tag.
    fn span<T>(self) -> &'a [T] {
        // SAFETY: callers choose `T` by the tag, which guarantees that `s` is the active member of the union and has
        // elements of that type; they live for `'a`.
        unsafe {
            match self.raw().u.s {
                s if s.ptr.is_null() || s.len == 0 => &[],
                s => std::slice::from_raw_parts(s.ptr.cast(), s.len as usize),
            }
        }
    }
    /// Returns the tag, one of `TATU_NIL` .. `TATU_OBJECT`.
    pub fn tag(self) -> u32 {
        self.raw().tag
    }
    /// Returns whether the value is nil.
    pub fn is_nil(self) -> bool {
        self.tag() == TATU_NIL
    }
    /// Returns a float or integer as a float, or `None` for a value of another type.
    pub fn as_f64(self) -> Option<f64> {
        match self.tag() {
            TATU_F64 => Some(f64::from_bits(self.bits())),
            TATU_I64 => Some(self.bits() as i64 as f64),
            _ => None,
        }
    }
    /// Returns an integer, or a float truncated toward zero, or `None` for a value of another type.
    pub fn as_i64(self) -> Option<i64> {
        match self.tag() {
            TATU_F64 => Some(f64::from_bits(self.bits()) as i64),
            TATU_I64 => Some(self.bits() as i64),
            _ => None,
        }
    }
    /// Returns a boolean, or `None` for a value of another type.
    pub fn as_bool(self) -> Option<bool> {
        (self.tag() == TATU_BOOL).then(|| self.bits() != 0)
    }
    /// Returns whether scripts treat the value as true, as they do all values except nil and false.
    pub fn truthy(self) -> bool {
        !self.is_nil() && self.as_bool() != Some(false)
    }
    /// Returns an object, from an object value or from a number that is not negative, such as a handle that a script
    /// passes. Returns `None` for other values.
    pub fn as_object(self) -> Option<tatu_object> {
        match self.tag() {
            TATU_OBJECT => Some(self.bits()),
            _ => self.as_i64().and_then(|i| u64::try_from(i).ok()),
        }
    }
    /// Returns a function, or `None` for a value of another type.
    pub fn as_func(self) -> Option<tatu_func> {
        (self.tag() == TATU_FUNC).then(|| self.bits())
    }
    /// Returns the bytes of a text or byte string, or `None` for a value of another type.
    pub fn as_bytes(self) -> Option<&'a [u8]> {
        matches!(self.tag(), TATU_TEXT | TATU_BYTES).then(|| self.span())
    }
    /// Returns a text or byte string as text, with invalid UTF-8 replaced, or `None` for a value of another type.
    pub fn as_str(self) -> Option<Cow<'a, str>> {
        self.as_bytes().map(String::from_utf8_lossy)
    }
    /// Returns the number of elements of an array, list or map, or of bytes of a text or byte string; otherwise 0.
    pub fn len(self) -> usize {
        match self.tag() {
            TATU_F64S => self.span::<f64>().len(),
            TATU_I64S => self.span::<i64>().len(),
            TATU_F32S => self.span::<f32>().len(),
            TATU_I32S => self.span::<i32>().len(),
            TATU_TEXT | TATU_BYTES | TATU_U8S => self.span::<u8>().len(),
            TATU_LIST => self.span::<ValueRef<'a>>().len(),
            TATU_MAP => self.span::<[ValueRef<'a>; 2]>().len(),
            _ => 0,
        }
    }
    /// Returns the bytes of the elements of an array, or of a text or byte string; otherwise an empty slice.
    pub fn span_bytes(self) -> &'a [u8] {
        match self.tag() {
            TATU_TEXT | TATU_BYTES | TATU_U8S => self.span(),
            TATU_F64S | TATU_I64S => self.span::<[u8; 8]>().as_flattened(),
            TATU_F32S | TATU_I32S => self.span::<[u8; 4]>().as_flattened(),
            _ => &[],
        }
    }
    /// Returns whether the value has no elements.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
    /// Returns element `i` of a numeric array, or of a list if that element is a number.
    pub fn number(self, i: usize) -> Option<f64> {
        match self.tag() {
            TATU_F64S => self.span().get(i).copied(),
            TATU_F32S => self.span::<f32>().get(i).map(|x| f64::from(*x)),
            TATU_I64S => self.span::<i64>().get(i).map(|x| *x as f64),
            TATU_I32S => self.span::<i32>().get(i).map(|x| f64::from(*x)),
            TATU_U8S => self.span::<u8>().get(i).map(|x| f64::from(*x)),
            TATU_LIST => self.span::<ValueRef<'a>>().get(i)?.as_f64(),
            _ => None,
        }
    }
    /// Returns all numbers of a numeric array or of a list that contains only numbers; otherwise `None`.
    pub fn numbers(self) -> Option<Vec<f64>> {
        matches!(self.tag(), TATU_F64S..=TATU_LIST).then(|| (0..self.len()).map(|i| self.number(i)).collect())?
    }
    /// Returns the numbers of an array or list if it contains exactly `N` of them; otherwise `None`.
    pub fn array<const N: usize>(self) -> Option<[f64; N]> {
        if self.len() != N {
            return None;
        }
        let mut out = [0.0; N];
        for (i, x) in out.iter_mut().enumerate() {
            *x = self.number(i)?;
        }
        Some(out)
    }
    /// Returns the values of a list, or `None` for a value of another type.
    pub fn list(self) -> Option<&'a [ValueRef<'a>]> {
        (self.tag() == TATU_LIST).then(|| self.span())
    }
    /// Returns the entries of a map, each a key and a value, or `None` for a value of another type.
    pub fn map(self) -> Option<&'a [[ValueRef<'a>; 2]]> {
        (self.tag() == TATU_MAP).then(|| self.span())
    }
    /// Returns the value of the entry of a map with this text key, or `None` if there is no such entry.
    pub fn get(self, key: &str) -> Option<ValueRef<'a>> {
        self.map()?.iter().find(|[k, _]| k.as_bytes() == Some(key.as_bytes())).map(|[_, v]| *v)
    }
    /// Returns an owned copy. Fails if the value is nested too deep or has an unknown tag.
    pub fn to_value(self) -> Result<Value> {
        self.copy(0)
    }

    fn copy(self, depth: usize) -> Result<Value> {
        if depth > MAX_DEPTH {
            return Err(Fail::argument(format!("lists and maps must be nested at most {MAX_DEPTH} deep")));
        }
        Ok(match self.tag() {
            TATU_NIL => Value::Nil,
            TATU_BOOL => Value::Bool(self.bits() != 0),
            TATU_I64 => Value::Int(self.bits() as i64),
            TATU_F64 => Value::Float(f64::from_bits(self.bits())),
            TATU_TEXT => Value::Text(self.span().to_vec()),
            TATU_BYTES => Value::Bytes(self.span().to_vec()),
            TATU_F64S => Value::Floats(self.span().to_vec()),
            TATU_F32S => Value::Floats(self.span::<f32>().iter().map(|x| f64::from(*x)).collect()),
            TATU_I64S => Value::Ints(self.span().to_vec()),
            TATU_I32S => Value::Ints(self.span::<i32>().iter().map(|x| i64::from(*x)).collect()),
            TATU_U8S => Value::Ints(self.span::<u8>().iter().map(|x| i64::from(*x)).collect()),
            TATU_LIST => {
                let items = self.span::<ValueRef<'a>>();
                Value::List(items.iter().map(|v| v.copy(depth + 1)).collect::<Result<_>>()?)
            }
            TATU_MAP => {
                let pairs = self.span::<[ValueRef<'a>; 2]>();
                let copy = |[k, v]: &[ValueRef<'a>; 2]| Ok((k.copy(depth + 1)?, v.copy(depth + 1)?));
                Value::Map(pairs.iter().map(copy).collect::<Result<_>>()?)
            }
            TATU_FUNC => Value::Func(self.bits()),
            TATU_OBJECT => Value::Object(self.bits()),
            tag => return Err(Fail::argument(format!("a value has the tag {tag}, which is not defined"))),
        })
    }
}

/// Returns the name of a type, for messages.
pub fn type_name(tag: u32) -> &'static str {
    match tag {
        TATU_NIL => "nil",
        TATU_BOOL => "a boolean",
        TATU_I64 => "an integer",
        TATU_F64 => "a number",
        TATU_TEXT => "a text",
        TATU_BYTES => "bytes",
        TATU_F64S..=TATU_U8S => "a table of numbers",
        TATU_LIST => "a table",
        TATU_MAP => "a table with keys",
        TATU_FUNC => "a function",
        TATU_OBJECT => "an object",
        _ => "a value of unknown type",
    }
}
