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

mod stored;
mod tables;

use std::any::Any;

use tatu_plugin_api::{abi::*, safe::Value};

pub(crate) use stored::{Stored, numbers_of, put, refuse, refused, text_of, unexpected, words};
pub(crate) use tables::{access, get_of, properties, set_of, type_of, usual_of};

use crate::object::Kind;

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
