//! Values: a view of one at the border, and one of our own.

use std::{borrow::Cow, marker::PhantomData};

use super::{Fail, Result, fail::bytes_of};
use crate::abi::*;

/// Lists and maps nest at most this deep.
pub const MAX_DEPTH: usize = 32;

/// A value of our own.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Value {
    /// Nothing.
    #[default]
    Nil,
    /// True or false.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A number.
    Float(f64),
    /// Text; UTF-8 by intention only, so kept as bytes.
    Text(Vec<u8>),
    /// Bytes.
    Bytes(Vec<u8>),
    /// Numbers.
    Floats(Vec<f64>),
    /// Integers.
    Ints(Vec<i64>),
    /// Values in order.
    List(Vec<Value>),
    /// Keys and values, in the order in which they were made.
    Map(Vec<(Value, Value)>),
    /// A function of a script.
    Func(tatu_func),
    /// An object.
    Object(tatu_object),
}

impl Value {
    /// A text.
    pub fn text(s: impl AsRef<[u8]>) -> Self {
        Value::Text(s.as_ref().to_vec())
    }

    /// The border form; spans are put into memory that `alloc` gives (8-byte aligned), which must outlive the use.
    /// `None` when there is no memory.
    pub fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        let span = |tag, ptr: *const u8, len: usize| tatu_value {
            tag,
            reserved: 0,
            u: tatu_payload { s: tatu_span_t { ptr: ptr.cast(), len: len as u64 } },
        };
        fn put<T: Copy>(data: &[T], alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<*const u8> {
            let to = alloc(size_of_val(data).max(1)).cast::<T>();
            if to.is_null() {
                return None;
            }
            // SAFETY: `alloc` gave room for exactly this, aligned for every type used here.
            unsafe { std::ptr::copy_nonoverlapping(data.as_ptr(), to, data.len()) };
            Some(to.cast())
        }
        Some(match self {
            Value::Nil => raw_int(TATU_NIL, 0),
            Value::Bool(b) => raw_int(TATU_BOOL, i64::from(*b)),
            Value::Int(i) => raw_int(TATU_I64, *i),
            Value::Float(f) => tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f: *f } },
            Value::Text(t) => span(TATU_TEXT, put(t, alloc)?, t.len()),
            Value::Bytes(t) => span(TATU_BYTES, put(t, alloc)?, t.len()),
            Value::Floats(t) => span(TATU_F64S, put(t, alloc)?, t.len()),
            Value::Ints(t) => span(TATU_I64S, put(t, alloc)?, t.len()),
            Value::List(items) => {
                let raw = items.iter().map(|v| v.to_raw(alloc)).collect::<Option<Vec<_>>>()?;
                span(TATU_LIST, put(&raw, alloc)?, raw.len())
            }
            Value::Map(items) => {
                let raw = items
                    .iter()
                    .map(|(k, v)| Some(tatu_pair { key: k.to_raw(alloc)?, value: v.to_raw(alloc)? }))
                    .collect::<Option<Vec<_>>>()?;
                span(TATU_MAP, put(&raw, alloc)?, raw.len())
            }
            Value::Func(f) => tatu_value { tag: TATU_FUNC, reserved: 0, u: tatu_payload { u: *f } },
            Value::Object(o) => tatu_value { tag: TATU_OBJECT, reserved: 0, u: tatu_payload { u: *o } },
        })
    }
}

/// Memory for what values point to in the form of the border; it must outlive their use.
#[derive(Default)]
pub(crate) struct Room(Vec<Vec<u64>>);

impl Room {
    /// A value in the form of the border.
    pub(crate) fn raw(&mut self, value: &Value) -> tatu_value {
        let raw = value.to_raw(&mut |bytes| {
            self.0.push(vec![0; bytes.div_ceil(8).max(1)]);
            self.0.last_mut().map_or(std::ptr::null_mut(), |r| r.as_mut_ptr().cast())
        });
        raw.unwrap_or(raw_int(TATU_NIL, 0))
    }
    /// Several of them.
    pub(crate) fn all(&mut self, values: &[Value]) -> Vec<tatu_value> {
        values.iter().map(|v| self.raw(v)).collect()
    }
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

/// A value at the border, valid for `'a`.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct ValueRef<'a> {
    raw: tatu_value,
    life: PhantomData<&'a ()>,
}

impl<'a> ValueRef<'a> {
    /// Nothing.
    pub const NIL: ValueRef<'static> =
        ValueRef { raw: tatu_value { tag: TATU_NIL, reserved: 0, u: tatu_payload { i: 0 } }, life: PhantomData };

    /// Wraps a border value.
    ///
    /// # Safety
    /// Whatever `raw` points to must be valid for `'a`.
    pub unsafe fn new(raw: tatu_value) -> Self {
        ValueRef { raw, life: PhantomData }
    }
    /// A slice of border values as views.
    ///
    /// # Safety
    /// `ptr` points to `n` values, valid for `'a` with all they point to; or `n` is 0.
    pub unsafe fn slice(ptr: *const tatu_value, n: usize) -> &'a [ValueRef<'a>] {
        if ptr.is_null() || n == 0 {
            return &[];
        }
        // SAFETY: `ValueRef` is transparent over `tatu_value`.
        unsafe { std::slice::from_raw_parts(ptr.cast(), n) }
    }
    /// The border form.
    pub fn raw(self) -> tatu_value {
        self.raw
    }
    /// One of `TATU_NIL` .. `TATU_OBJECT`.
    pub fn tag(self) -> u32 {
        self.raw.tag
    }
    /// Whether it is nothing.
    pub fn is_nil(self) -> bool {
        self.raw.tag == TATU_NIL
    }
    /// A number: float or integer.
    pub fn as_f64(self) -> Option<f64> {
        // SAFETY: the tag says which member is set.
        unsafe {
            match self.raw.tag {
                TATU_F64 => Some(self.raw.u.f),
                TATU_I64 => Some(self.raw.u.i as f64),
                _ => None,
            }
        }
    }
    /// An integer; floats are truncated toward zero.
    pub fn as_i64(self) -> Option<i64> {
        // SAFETY: the tag says which member is set.
        unsafe {
            match self.raw.tag {
                TATU_F64 => Some(self.raw.u.f as i64),
                TATU_I64 => Some(self.raw.u.i),
                _ => None,
            }
        }
    }
    /// A truth value.
    pub fn as_bool(self) -> Option<bool> {
        // SAFETY: all members are plain numbers, whatever the tag says.
        let i = unsafe { self.raw.u.i };
        (self.raw.tag == TATU_BOOL).then_some(i != 0)
    }
    /// What scripts take for true: anything but nil and false.
    pub fn truthy(self) -> bool {
        !self.is_nil() && self.as_bool() != Some(false)
    }
    /// An object: an object value, or the number of one as a script gives it.
    pub fn as_object(self) -> Option<tatu_object> {
        // SAFETY: all members are plain numbers, whatever the tag says.
        let id = unsafe { self.raw.u.u };
        match self.raw.tag {
            TATU_OBJECT => Some(id),
            _ => self.as_i64().and_then(|i| u64::try_from(i).ok()),
        }
    }
    /// A function.
    pub fn as_func(self) -> Option<tatu_func> {
        // SAFETY: all members are plain numbers, whatever the tag says.
        let func = unsafe { self.raw.u.u };
        (self.raw.tag == TATU_FUNC).then_some(func)
    }
    /// Text or bytes.
    pub fn as_bytes(self) -> Option<&'a [u8]> {
        if !matches!(self.raw.tag, TATU_TEXT | TATU_BYTES) {
            return None;
        }
        // SAFETY: spans are valid for 'a.
        unsafe {
            let s = self.raw.u.s;
            Some(bytes_of(tatu_str { ptr: s.ptr.cast(), len: s.len }))
        }
    }
    /// Text; bytes that are not UTF-8 are replaced.
    pub fn as_str(self) -> Option<Cow<'a, str>> {
        self.as_bytes().map(String::from_utf8_lossy)
    }
    /// How many elements an array, list or map has.
    pub fn len(self) -> usize {
        match self.raw.tag {
            // SAFETY: the tag says which member is set.
            TATU_TEXT..=TATU_MAP if !unsafe { self.raw.u.s.ptr }.is_null() => unsafe { self.raw.u.s.len as usize },
            _ => 0,
        }
    }
    /// Whether it has no elements.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
    /// Element `i` of a numeric array, or of a list, if it is a number.
    pub fn number(self, i: usize) -> Option<f64> {
        if i >= self.len() {
            return None;
        }
        // SAFETY: `i` lies within the span, whose elements the tag names.
        unsafe {
            let p = self.raw.u.s.ptr;
            Some(match self.raw.tag {
                TATU_F64S => *p.cast::<f64>().add(i),
                TATU_F32S => f64::from(*p.cast::<f32>().add(i)),
                TATU_I64S => *p.cast::<i64>().add(i) as f64,
                TATU_I32S => f64::from(*p.cast::<i32>().add(i)),
                TATU_U8S => f64::from(*p.cast::<u8>().add(i)),
                TATU_LIST => return ValueRef::new(*p.cast::<tatu_value>().add(i)).as_f64(),
                _ => return None,
            })
        }
    }
    /// All numbers of an array, or of a list of numbers.
    pub fn numbers(self) -> Option<Vec<f64>> {
        matches!(self.raw.tag, TATU_F64S..=TATU_LIST).then(|| (0..self.len()).map(|i| self.number(i)).collect())?
    }
    /// Exactly `N` numbers.
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
    /// The values of a list.
    pub fn list(self) -> Option<&'a [ValueRef<'a>]> {
        // SAFETY: spans are valid for 'a.
        (self.raw.tag == TATU_LIST).then(|| unsafe { Self::slice(self.raw.u.s.ptr.cast(), self.len()) })
    }
    /// The entries of a map.
    pub fn map(self) -> Option<&'a [tatu_pair]> {
        if self.raw.tag != TATU_MAP || self.is_empty() {
            return (self.raw.tag == TATU_MAP).then_some(&[]);
        }
        // SAFETY: spans are valid for 'a.
        Some(unsafe { std::slice::from_raw_parts(self.raw.u.s.ptr.cast(), self.len()) })
    }
    /// The value of a text key of a map.
    pub fn get(self, key: &str) -> Option<ValueRef<'a>> {
        let pairs = self.map()?;
        // SAFETY: keys and values of a map are valid as long as the map.
        unsafe {
            pairs
                .iter()
                .find(|p| ValueRef::new(p.key).as_bytes() == Some(key.as_bytes()))
                .map(|p| ValueRef::new(p.value))
        }
    }
    /// A copy of our own. Fails when it is nested too deep or has an unknown tag.
    pub fn to_value(self) -> Result<Value> {
        self.copy(0)
    }

    fn copy(self, depth: usize) -> Result<Value> {
        if depth > MAX_DEPTH {
            return Err(Fail::argument(format!("a table is nested deeper than {MAX_DEPTH}")));
        }
        // SAFETY: the tag says which member is set; spans are valid for 'a.
        unsafe {
            Ok(match self.raw.tag {
                TATU_NIL => Value::Nil,
                TATU_BOOL => Value::Bool(self.raw.u.i != 0),
                TATU_I64 => Value::Int(self.raw.u.i),
                TATU_F64 => Value::Float(self.raw.u.f),
                TATU_TEXT => Value::Text(self.as_bytes().unwrap_or_default().to_vec()),
                TATU_BYTES => Value::Bytes(self.as_bytes().unwrap_or_default().to_vec()),
                TATU_F64S | TATU_F32S => Value::Floats(self.numbers().unwrap_or_default()),
                TATU_I64S | TATU_I32S | TATU_U8S => {
                    let p = self.raw.u.s.ptr;
                    let at = |i: usize| match self.raw.tag {
                        TATU_I64S => *p.cast::<i64>().add(i),
                        TATU_I32S => i64::from(*p.cast::<i32>().add(i)),
                        _ => i64::from(*p.cast::<u8>().add(i)),
                    };
                    Value::Ints((0..self.len()).map(at).collect())
                }
                TATU_LIST => {
                    let items = self.list().unwrap_or_default();
                    Value::List(items.iter().map(|v| v.copy(depth + 1)).collect::<Result<_>>()?)
                }
                TATU_MAP => Value::Map(
                    self.map()
                        .unwrap_or_default()
                        .iter()
                        .map(|p| Ok((ValueRef::new(p.key).copy(depth + 1)?, ValueRef::new(p.value).copy(depth + 1)?)))
                        .collect::<Result<_>>()?,
                ),
                TATU_FUNC => Value::Func(self.raw.u.u),
                TATU_OBJECT => Value::Object(self.raw.u.u),
                tag => return Err(Fail::argument(format!("a value has the unknown tag {tag}"))),
            })
        }
    }
}

/// The name of a type, for messages.
pub fn type_name(tag: u32) -> &'static str {
    match tag {
        TATU_NIL => "nil",
        TATU_BOOL => "a truth value",
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
