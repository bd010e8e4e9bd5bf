//! The types of values that properties store, and their conversion to and from those of scripts and plugins.

use nalgebra::{UnitQuaternion, Vector3};
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use super::declaration::SetOutcome;
use crate::pose_from_array;

/// A type of values that properties store.
pub(crate) trait StoredValue {
    /// Returns the value.
    fn value(&self) -> Value;
    /// Sets a value of the declared type and range; returns whether it differs from the previous one.
    fn store(&mut self, value: &Value) -> Result<bool, String>;
    /// Copies the numbers that the value consists of.
    fn read(&self, _out: &mut [f64]) -> Option<usize> {
        None
    }
    /// As `store`, for numbers.
    fn write(&mut self, _numbers: &[f64]) -> SetOutcome {
        None
    }
}

/// Copies numbers; returns how many.
pub(crate) fn copy_numbers(out: &mut [f64], from: &[f64]) -> Option<usize> {
    out.get_mut(..from.len())?.copy_from_slice(from);
    Some(from.len())
}

pub(crate) fn refuse<T>(status: tatu_status, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(status, text.into()))
}

/// Converts the error of a result from a refusal to its message.
pub(crate) fn refusal_as_text<T>(result: Result<T, Refusal>) -> Result<T, String> {
    result.map_err(|refusal| refusal.1)
}

/// Returns the error for a value of the wrong type.
pub(crate) fn unexpected<T>(value: &Value) -> Result<T, String> {
    Err(format!("found {}", tatu_plugins::describe_value(value)))
}

/// Returns the text of a value.
pub(crate) fn text_of(value: &Value) -> Result<String, String> {
    match value {
        Value::Text(t) | Value::Bytes(t) => Ok(String::from_utf8_lossy(t).into_owned()),
        other => unexpected(other),
    }
}

/// Returns the numbers of a value.
pub(crate) fn numbers_of(value: &Value) -> Result<&[f64], String> {
    match value {
        Value::Floats(v) => Ok(v),
        Value::Float(x) => Ok(std::slice::from_ref(x)),
        other => unexpected(other),
    }
}

fn replace<T: PartialEq>(place: &mut T, value: T) -> bool {
    let differs = *place != value;
    *place = value;
    differs
}

impl StoredValue for f64 {
    fn value(&self) -> Value {
        Value::Float(*self)
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        if let Value::Float(x) = value { Ok(replace(self, *x)) } else { unexpected(value) }
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        copy_numbers(out, &[*self])
    }
    fn write(&mut self, numbers: &[f64]) -> SetOutcome {
        if let [x] = numbers { Some(Ok(replace(self, *x))) } else { None }
    }
}

impl StoredValue for bool {
    fn value(&self) -> Value {
        Value::Bool(*self)
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        let Value::Bool(b) = value else { return unexpected(value) };
        *self = *b;
        Ok(true)
    }
}

impl StoredValue for String {
    fn value(&self) -> Value {
        Value::text(self)
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        *self = text_of(value)?;
        Ok(true)
    }
}

impl StoredValue for [f64; 3] {
    fn value(&self) -> Value {
        Value::Floats(self.to_vec())
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        let Ok(three) = numbers_of(value)?.try_into() else { return unexpected(value) };
        *self = three;
        Ok(true)
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        copy_numbers(out, self)
    }
}

impl StoredValue for Vector3<f64> {
    fn value(&self) -> Value {
        Value::Floats(self.as_slice().to_vec())
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        let [x, y, z] = *numbers_of(value)? else { return unexpected(value) };
        *self = Vector3::new(x, y, z);
        Ok(true)
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        copy_numbers(out, self.as_slice())
    }
}

impl StoredValue for UnitQuaternion<f64> {
    fn value(&self) -> Value {
        Value::Floats(self.coords.as_slice().to_vec())
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        self.write(numbers_of(value)?).unwrap_or_else(|| unexpected(value))
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        copy_numbers(out, self.coords.as_slice())
    }
    fn write(&mut self, numbers: &[f64]) -> SetOutcome {
        let [x, y, z, w] = *numbers else { return None };
        Some(match pose_from_array(&[0.0, 0.0, 0.0, x, y, z, w]) {
            Some(pose) => {
                *self = pose.rotation;
                Ok(true)
            }
            None => Err("the quaternion must not be zero".into()),
        })
    }
}

macro_rules! stored_integers {
    ($($type:ty),*) => {
        $(impl StoredValue for $type {
            fn value(&self) -> Value {
                Value::Int(*self as i64)
            }
            fn store(&mut self, value: &Value) -> Result<bool, String> {
                let Value::Int(i) = value else { return unexpected(value) };
                let Ok(fits) = <$type>::try_from(*i) else { return unexpected(value) };
                *self = fits;
                Ok(true)
            }
        })*
    };
}
stored_integers!(u16, u32, u64, usize);

/// Gives the variants of an enum their names in scene files.
macro_rules! words {
    ($type:ident { $($variant:ident $word:literal),* $(,)? }) => {
        impl $type {
            /// All names.
            pub const WORDS: &'static [&'static str] = &[$($word),*];

            /// Returns the variant with a name.
            pub fn parse(word: &str) -> Option<Self> {
                match word {
                    $($word => Some(Self::$variant),)*
                    _ => None,
                }
            }
            /// Returns the name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)*
                }
            }
        }

        impl $crate::property::StoredValue for $type {
            fn value(&self) -> tatu_plugin_api::safe::Value {
                tatu_plugin_api::safe::Value::text(self.name())
            }
            fn store(&mut self, value: &tatu_plugin_api::safe::Value) -> Result<bool, String> {
                let word = $crate::property::text_of(value)?;
                let Some(found) = Self::parse(&word) else { return $crate::property::unexpected(value) };
                *self = found;
                Ok(true)
            }
        }
    };
}
pub(crate) use words;
