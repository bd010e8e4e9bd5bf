//! The declaration of a property, as stated in one row of a table.

use std::any::Any;

use tatu_plugin_api::{abi::*, safe::Value};

use crate::object::ObjectKind;

/// The objects that have a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PropertyOwner {
    /// The world itself.
    World,
    /// Every object.
    Any,
    /// Objects of one kind.
    Kind(ObjectKind),
}

/// The effect of a change of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeEffect {
    /// The property is read-only.
    ReadOnly,
    /// Only the value changes.
    None,
    /// Pictures show the object or no longer show it.
    Look,
    /// The colours in pictures and images.
    Colour,
    /// The settings of sensors, such as rate and noise.
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
pub enum FileForm {
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
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum DefaultValue {
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
pub struct PropertySpec {
    /// Key, such as "joint.position".
    pub key: &'static str,
    /// The objects that have the property.
    pub owner: PropertyOwner,
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
    pub default_value: DefaultValue,
    /// The effect of a change.
    pub effect: ChangeEffect,
    /// The form in scene files.
    pub file_form: FileForm,
    /// Description in one sentence.
    pub text: &'static str,
    pub(crate) access: PropertyAccess,
}

/// Whether a value differs from the previous one, or why it was refused; `None` if it is not stored here.
pub(crate) type SetOutcome = Option<Result<bool, String>>;

/// The functions that read and set a value in the struct that stores it. They return `None` if the struct is of a
/// different type, or if a higher layer reads or sets the property.
#[derive(Clone, Copy)]
pub(crate) struct PropertyAccess {
    pub get: fn(&dyn Any) -> Option<Value>,
    /// Sets a value of the declared type and range; returns whether it differs from the previous one.
    pub set: fn(&mut dyn Any, &Value) -> SetOutcome,
    /// Copies numbers without allocating memory; returns how many.
    pub read: fn(&dyn Any, &mut [f64]) -> Option<usize>,
    /// As `set`, for numbers.
    pub write: fn(&mut dyn Any, &[f64]) -> SetOutcome,
}

impl PropertyAccess {
    pub const NONE: PropertyAccess =
        PropertyAccess { get: |_| None, set: |_, _| None, read: |_, _| None, write: |_, _| None };
}

impl PropertySpec {
    /// The row at index 0, which stands for no property.
    pub(crate) const NONE: PropertySpec = PropertySpec {
        key: "",
        owner: PropertyOwner::World,
        kind: TATU_NIL,
        count: 0,
        unit: None,
        choices: &[],
        range: (f64::MIN, f64::MAX),
        default_value: DefaultValue::None,
        effect: ChangeEffect::ReadOnly,
        file_form: FileForm::Plain,
        text: "",
        access: PropertyAccess::NONE,
    };

    /// Returns whether objects of a kind have the property, or whether the world has it if `kind` is `None`.
    pub fn applies_to(&self, kind: Option<ObjectKind>) -> bool {
        match (self.owner, kind) {
            (PropertyOwner::World, None) | (PropertyOwner::Any, Some(_)) => true,
            (PropertyOwner::Kind(k), Some(kind)) => k == kind,
            _ => false,
        }
    }

    /// Returns whether the property can be set.
    pub fn is_settable(&self) -> bool {
        self.effect != ChangeEffect::ReadOnly
    }

    /// Returns whether a change takes effect at the next stage, when bodies are recreated.
    pub fn rebuilds(&self) -> bool {
        matches!(self.effect, ChangeEffect::Rebuild | ChangeEffect::Form | ChangeEffect::Motion)
    }

    /// Returns the part of the key after the dot.
    pub fn short_key(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(_, s)| s)
    }

    /// Returns whether numbers are in the range.
    pub(crate) fn contains_all(&self, numbers: &[f64]) -> bool {
        numbers.iter().all(|x| (self.range.0..=self.range.1).contains(x))
    }

    /// Returns whether a value has the declared type, length and range, and is one of the choices.
    pub(crate) fn accepts(&self, value: &Value) -> bool {
        match (self.kind, value) {
            (TATU_F64, Value::Float(x)) => self.contains_all(&[*x]),
            (TATU_I64, Value::Int(i)) => self.contains_all(&[*i as f64]),
            (TATU_F64S, Value::Floats(v)) => {
                (self.count == 0 || v.len() == self.count as usize) && self.contains_all(v)
            }
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
        match self.default_value {
            DefaultValue::None => Value::Nil,
            DefaultValue::Bool(b) => Value::Bool(b),
            DefaultValue::Int(i) => Value::Int(i),
            DefaultValue::Float(x) => Value::Float(x),
            DefaultValue::Text(t) => Value::text(t),
            DefaultValue::Floats(v) => Value::Floats(v.to_vec()),
            DefaultValue::List => Value::List(Vec::new()),
            DefaultValue::Map => Value::Map(Vec::new()),
        }
    }

    /// Returns the property in the form in which plugins declare their parameters.
    pub fn as_parameter(&self) -> tatu_plugins::ParameterSpec {
        tatu_plugins::ParameterSpec {
            key: self.short_key().to_owned(),
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
