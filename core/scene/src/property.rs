//! Declarations of properties. One row states everything about a property: its key, type, unit, range, default and
//! meaning, the effect of a change, and where the value is stored.
//!
//! Each kind of object has a table of rows beside the struct that stores its values, written with [`properties`]:
//!
//! ```text
//! properties! { ROWS: Shape, Of::Kind(Kind::Shape) =>
//!     "shape.friction" number from 0.0 = 1.0, Rebuild friction: "Friction coefficient.";
//! }
//! ```
//!
//! - the key, and the type: `bool`, `int`, `number`, `text`, `numbers` (with their count, if it is fixed), `list`, `map`,
//!   `object`, or a type that scene files write in a form of its own (`mesh`, `parts`, `texture`, `data`, `drive`,
//!   `noise`);
//! - optionally, in this order: `in "unit"`; `of (choices)` for a text; the range, `from` and `to` with their bounds,
//!   `above` and `below` without them (numbers must always be finite); `= default`, which is `none` for an empty value;
//! - the [`Effect`] of a change, and the place of the value: a field, a path of fields in parentheses, closures in
//!   braces, or `_` if a higher layer reads and sets the property.

use std::any::Any;

use nalgebra::{UnitQuaternion, Vector3};
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use crate::{object::Kind, pose_from_array};

/// The objects that have a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// The world itself.
    World,
    /// Every object.
    Any,
    /// Objects of one kind.
    Kind(Kind),
}

/// What a change of a property affects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// The property is read-only.
    ReadOnly,
    /// Nothing but the value.
    None,
    /// Pictures show the object or no longer show it.
    Look,
    /// The colours in pictures and images.
    Colour,
    /// The settings that sensors are measured with.
    Sensors,
    /// The drive of a joint.
    Drive,
    /// The friction of a surface.
    Surface,
    /// The object and its descendants have moved.
    Moved,
    /// Bodies are recreated.
    Rebuild,
    /// Bodies are recreated, and what was computed from the form of the shape is discarded.
    Form,
    /// Bodies are recreated, and the descendants have moved.
    Motion,
    /// A graph is recreated from its declaration.
    Graph,
}

/// The form in which scene files contain a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InFiles {
    /// A plain value, in the unit that its key names.
    Plain,
    /// The name of a mesh file.
    Mesh,
    /// A list of tables with units, which name mesh and image files.
    Parts,
    /// A table with units, which names an image file.
    Texture,
    /// A table of custom data with any keys.
    Data,
    /// A table that describes a wheel drive.
    Drive,
    /// A table or text that describes noise.
    Noise,
}

/// The default of a property.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum Usual {
    /// The default is not fixed, or the property cannot be set.
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(&'static str),
    Floats(&'static [f64]),
    /// An empty list.
    List,
    /// An empty table.
    Map,
}

/// A row of a table, which describes one property.
#[derive(Clone, Copy)]
pub struct Property {
    /// Key, such as "joint.position".
    pub key: &'static str,
    /// The objects that have the property.
    pub of: Of,
    /// Type of the value, `TATU_BOOL` to `TATU_OBJECT`.
    pub kind: u32,
    /// Required number of elements of an array; 0 if any number is allowed.
    pub count: u32,
    /// Unit of the value, if it has one; `|` separates the units for revolute and prismatic joints.
    pub unit: Option<&'static str>,
    /// Allowed values of a string; if empty, any string is allowed.
    pub choices: &'static [&'static str],
    /// Lowest and highest value of each number.
    pub range: (f64, f64),
    /// The default.
    pub usual: Usual,
    /// What a change affects.
    pub effect: Effect,
    /// The form in scene files.
    pub in_files: InFiles,
    /// Description in one sentence.
    pub text: &'static str,
    pub(crate) access: Access,
}

/// Whether a value differs from the previous one, or why it was refused; `None` if it is not stored here.
pub(crate) type Changed = Option<Result<bool, String>>;

/// The functions that read and set a value in the struct that stores it. They return `None` if the struct is of a
/// different type, or if a higher layer reads or sets the property.
#[derive(Clone, Copy)]
pub(crate) struct Access {
    pub get: fn(&dyn Any) -> Option<Value>,
    /// Sets a value of the declared type and range; returns whether it differs from the previous one.
    pub set: fn(&mut dyn Any, &Value) -> Changed,
    /// Copies numbers without allocating memory; returns how many.
    pub read: fn(&dyn Any, &mut [f64]) -> Option<usize>,
    /// As `set`, for numbers.
    pub write: fn(&mut dyn Any, &[f64]) -> Changed,
}

impl Access {
    pub const NONE: Access = Access { get: |_| None, set: |_, _| None, read: |_, _| None, write: |_, _| None };
}

impl Property {
    /// The row before the first, which stands for no property.
    pub(crate) const NONE: Property = Property {
        key: "",
        of: Of::World,
        kind: TATU_NIL,
        count: 0,
        unit: None,
        choices: &[],
        range: (f64::MIN, f64::MAX),
        usual: Usual::None,
        effect: Effect::ReadOnly,
        in_files: InFiles::Plain,
        text: "",
        access: Access::NONE,
    };

    /// Returns whether objects of a kind have the property, or whether the world has it if `kind` is `None`.
    pub fn is_of(&self, kind: Option<Kind>) -> bool {
        match (self.of, kind) {
            (Of::World, None) | (Of::Any, Some(_)) => true,
            (Of::Kind(k), Some(kind)) => k == kind,
            _ => false,
        }
    }

    /// Returns whether the property can be set.
    pub fn is_settable(&self) -> bool {
        self.effect != Effect::ReadOnly
    }

    /// Returns whether a change takes effect at the next stage, when bodies are recreated.
    pub fn rebuilds(&self) -> bool {
        matches!(self.effect, Effect::Rebuild | Effect::Form | Effect::Motion)
    }

    /// Returns the part of the key after the dot.
    pub fn short(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(_, s)| s)
    }

    /// Returns whether numbers are in the range.
    pub(crate) fn spans(&self, numbers: &[f64]) -> bool {
        numbers.iter().all(|x| (self.range.0..=self.range.1).contains(x))
    }

    /// Returns whether a value has the declared type, length and range, and is one of the choices.
    pub(crate) fn fits(&self, value: &Value) -> bool {
        match (self.kind, value) {
            (TATU_F64, Value::Float(x)) => self.spans(&[*x]),
            (TATU_I64, Value::Int(i)) => self.spans(&[*i as f64]),
            (TATU_F64S, Value::Floats(v)) => (self.count == 0 || v.len() == self.count as usize) && self.spans(v),
            (TATU_TEXT, Value::Text(t)) => {
                self.choices.is_empty() || self.choices.iter().any(|c| c.as_bytes() == t.as_slice())
            }
            (TATU_BOOL, Value::Bool(_)) | (TATU_LIST, Value::List(_)) => true,
            (TATU_MAP, Value::Map(_)) | (TATU_OBJECT, Value::Object(_)) => true,
            _ => false,
        }
    }

    /// Returns the default; nil if it is not fixed.
    pub fn default(&self) -> Value {
        match self.usual {
            Usual::None => Value::Nil,
            Usual::Bool(b) => Value::Bool(b),
            Usual::Int(i) => Value::Int(i),
            Usual::Float(x) => Value::Float(x),
            Usual::Text(t) => Value::text(t),
            Usual::Floats(v) => Value::Floats(v.to_vec()),
            Usual::List => Value::List(Vec::new()),
            Usual::Map => Value::Map(Vec::new()),
        }
    }

    /// Returns the property in the form in which plugins declare their parameters.
    pub fn param(&self) -> tatu_plugins::Declared {
        tatu_plugins::Declared {
            key: self.short().to_owned(),
            kind: self.kind,
            count: self.count,
            flags: if self.is_settable() { 0 } else { TATU_PARAM_READ_ONLY },
            unit: self.unit.map(str::to_owned),
            lowest: self.range.0,
            highest: self.range.1,
            fallback: self.default(),
            unreadable_default: false,
            choices: self.choices.iter().map(|s| (*s).to_owned()).collect(),
            keys: Vec::new(),
            keys_cut: false,
            text: self.text.to_owned(),
        }
    }
}

/// A type of values that properties store.
pub(crate) trait Stored {
    /// Returns the value.
    fn value(&self) -> Value;
    /// Sets a value of the declared type and range; returns whether it differs from the previous one.
    fn store(&mut self, value: &Value) -> Result<bool, String>;
    /// Copies the numbers that the value consists of.
    fn read(&self, _out: &mut [f64]) -> Option<usize> {
        None
    }
    /// As `store`, for numbers.
    fn write(&mut self, _numbers: &[f64]) -> Changed {
        None
    }
}

/// Copies numbers; returns how many.
pub(crate) fn put(out: &mut [f64], from: &[f64]) -> Option<usize> {
    out.get_mut(..from.len())?.copy_from_slice(from);
    Some(from.len())
}

pub(crate) fn refuse<T>(status: tatu_status, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(status, text.into()))
}

/// Returns the text of a refusal as the error.
pub(crate) fn refused<T>(result: Result<T, Refusal>) -> Result<T, String> {
    result.map_err(|refusal| refusal.1)
}

/// Returns the error for a value of the wrong type.
pub(crate) fn unexpected<T>(value: &Value) -> Result<T, String> {
    Err(format!("found {}", tatu_plugins::describe(value)))
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

impl Stored for f64 {
    fn value(&self) -> Value {
        Value::Float(*self)
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        if let Value::Float(x) = value { Ok(replace(self, *x)) } else { unexpected(value) }
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        put(out, &[*self])
    }
    fn write(&mut self, numbers: &[f64]) -> Changed {
        if let [x] = numbers { Some(Ok(replace(self, *x))) } else { None }
    }
}

impl Stored for bool {
    fn value(&self) -> Value {
        Value::Bool(*self)
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        let Value::Bool(b) = value else { return unexpected(value) };
        *self = *b;
        Ok(true)
    }
}

impl Stored for String {
    fn value(&self) -> Value {
        Value::text(self)
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        *self = text_of(value)?;
        Ok(true)
    }
}

impl Stored for [f64; 3] {
    fn value(&self) -> Value {
        Value::Floats(self.to_vec())
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        let Ok(three) = numbers_of(value)?.try_into() else { return unexpected(value) };
        *self = three;
        Ok(true)
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        put(out, self)
    }
}

impl Stored for Vector3<f64> {
    fn value(&self) -> Value {
        Value::Floats(self.as_slice().to_vec())
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        let [x, y, z] = *numbers_of(value)? else { return unexpected(value) };
        *self = Vector3::new(x, y, z);
        Ok(true)
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        put(out, self.as_slice())
    }
}

impl Stored for UnitQuaternion<f64> {
    fn value(&self) -> Value {
        Value::Floats(self.coords.as_slice().to_vec())
    }
    fn store(&mut self, value: &Value) -> Result<bool, String> {
        self.write(numbers_of(value)?).unwrap_or_else(|| unexpected(value))
    }
    fn read(&self, out: &mut [f64]) -> Option<usize> {
        put(out, self.coords.as_slice())
    }
    fn write(&mut self, numbers: &[f64]) -> Changed {
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
        $(impl Stored for $type {
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

        impl $crate::property::Stored for $type {
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

pub(crate) fn get_of<T: 'static>(of: &dyn Any, get: impl Fn(&T) -> Value) -> Option<Value> {
    of.downcast_ref().map(get)
}

pub(crate) fn set_of<T: 'static>(
    of: &mut dyn Any,
    value: &Value,
    set: impl Fn(&mut T, &Value) -> Result<bool, String>,
) -> Changed {
    of.downcast_mut().map(|of| set(of, value))
}

/// Returns the place of a value, as for [`properties`].
macro_rules! access {
    ($type:ty, _) => {
        $crate::property::Access::NONE
    };
    ($type:ty, $field:ident) => {
        $crate::property::access!($type, ($field))
    };
    ($type:ty, ($($path:tt)+)) => {
        $crate::property::Access {
            get: |of| of.downcast_ref::<$type>().map(|of| $crate::property::Stored::value(&of.$($path)+)),
            set: |of, value| {
                of.downcast_mut::<$type>().map(|of| $crate::property::Stored::store(&mut of.$($path)+, value))
            },
            read: |of, out| {
                of.downcast_ref::<$type>().and_then(|of| $crate::property::Stored::read(&of.$($path)+, out))
            },
            write: |of, numbers| {
                of.downcast_mut::<$type>().and_then(|of| $crate::property::Stored::write(&mut of.$($path)+, numbers))
            },
        }
    };
    ($type:ty, { get $get:expr }) => {
        $crate::property::Access {
            get: |of| $crate::property::get_of::<$type>(of, $get),
            ..$crate::property::Access::NONE
        }
    };
    ($type:ty, { set $set:expr }) => {
        $crate::property::Access {
            set: |of, value| $crate::property::set_of::<$type>(of, value, $set),
            ..$crate::property::Access::NONE
        }
    };
    ($type:ty, { get $get:expr, set $set:expr }) => {
        $crate::property::Access {
            get: |of| $crate::property::get_of::<$type>(of, $get),
            set: |of, value| $crate::property::set_of::<$type>(of, value, $set),
            ..$crate::property::Access::NONE
        }
    };
    ($type:ty, { number $field:ident, set $set:expr }) => {
        $crate::property::Access {
            set: |of, value| {
                $crate::property::set_of::<$type>(of, value, |of, value| {
                    $set(of, $crate::property::numbers_of(value)?[0]);
                    Ok(true)
                })
            },
            write: |of, numbers| {
                let ([x], Some(of)) = (numbers, of.downcast_mut::<$type>()) else { return None };
                $set(of, *x);
                Some(Ok(true))
            },
            ..$crate::property::access!($type, $field)
        }
    };
}
pub(crate) use access;

/// Returns the type of a value, and its form in scene files, as for [`properties`].
macro_rules! type_of {
    (bool) => {
        (TATU_BOOL, InFiles::Plain)
    };
    (int) => {
        (TATU_I64, InFiles::Plain)
    };
    (number) => {
        (TATU_F64, InFiles::Plain)
    };
    (text) => {
        (TATU_TEXT, InFiles::Plain)
    };
    (numbers) => {
        (TATU_F64S, InFiles::Plain)
    };
    (list) => {
        (TATU_LIST, InFiles::Plain)
    };
    (map) => {
        (TATU_MAP, InFiles::Plain)
    };
    (object) => {
        (TATU_OBJECT, InFiles::Plain)
    };
    (mesh) => {
        (TATU_I64, InFiles::Mesh)
    };
    (parts) => {
        (TATU_LIST, InFiles::Parts)
    };
    (texture) => {
        (TATU_MAP, InFiles::Texture)
    };
    (data) => {
        (TATU_MAP, InFiles::Data)
    };
    (drive) => {
        (TATU_MAP, InFiles::Drive)
    };
    (noise) => {
        (TATU_TEXT, InFiles::Noise)
    };
}
pub(crate) use type_of;

/// Returns a default, as for [`properties`].
macro_rules! usual_of {
    (bool $x:tt) => {
        Usual::Bool($x)
    };
    (int $x:tt) => {
        Usual::Int($x)
    };
    (number $x:tt) => {
        Usual::Float($x)
    };
    (numbers none) => {
        Usual::Floats(&[])
    };
    (numbers $x:tt) => {
        Usual::Floats(&$x)
    };
    (list none) => {
        Usual::List
    };
    (parts none) => {
        Usual::List
    };
    (text none) => {
        Usual::Text("")
    };
    (noise none) => {
        Usual::Text("")
    };
    (text $x:tt) => {
        Usual::Text($x)
    };
    ($map:ident none) => {
        Usual::Map
    };
}
pub(crate) use usual_of;

/// Declares a table of properties, which are stored in a struct; see the top of `property.rs`.
macro_rules! properties {
    ($name:ident: $type:ty, $of:expr => $(
        $key:literal $kind:ident $($count:literal)? $(in $unit:literal)? $(of $choices:tt)?
        $(from $from:tt)? $(above $above:tt)? $(to $to:tt)? $(below $below:tt)? $(= $usual:tt)?,
        $effect:ident $access:tt: $text:literal;
    )*) => {
        #[allow(unused_parens, reason = "a bound of several tokens stands in parentheses")]
        pub(crate) const $name: &[$crate::property::Property] = {
            use tatu_plugin_api::abi::*;
            #[allow(unused_imports, reason = "not every table uses all of them")]
            use $crate::property::{Effect, InFiles, Of, Property, Usual, access, type_of, usual_of};
            &[$(Property {
                key: $key,
                of: $of,
                kind: type_of!($kind).0,
                $(count: $count,)?
                $(unit: Some($unit),)?
                $(choices: $choices,)?
                range: {
                    #[allow(unused_mut, reason = "not every row has a range")]
                    let mut range: (f64, f64) = Property::NONE.range;
                    $(range.0 = $from;)?
                    $(range.0 = f64::next_up($above);)?
                    $(range.1 = $to;)?
                    $(range.1 = f64::next_down($below);)?
                    range
                },
                $(usual: usual_of!($kind $usual),)?
                effect: Effect::$effect,
                in_files: type_of!($kind).1,
                text: $text,
                access: access!($type, $access),
                ..Property::NONE
            }),*]
        };
    };
}
pub(crate) use properties;
