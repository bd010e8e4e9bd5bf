//! Values of parameters, constants and expressions.

use tatu_plugin_api::safe;

use crate::error::{ModelError, Result};

/// Maximum length of a string in messages, bytes; longer strings are truncated to this number of characters.
const MAX_MESSAGE_CHARS: usize = 80;

/// The value of a parameter, constant or expression.
#[derive(Debug, Clone, PartialEq)]
pub enum ExpressionValue {
    /// A number. Integers are numbers without a fractional part.
    Number(f64),
    /// A boolean.
    Bool(bool),
    /// A string.
    Text(String),
    /// A list of values, such as a vector or a list of vectors.
    List(Vec<ExpressionValue>),
}

impl ExpressionValue {
    /// Describes the value for messages.
    pub fn describe(&self) -> String {
        match self {
            ExpressionValue::Number(x) => format!("the number {x}"),
            ExpressionValue::Bool(b) => b.to_string(),
            ExpressionValue::Text(t) if t.len() > MAX_MESSAGE_CHARS => {
                format!("the string '{}...'", t.chars().take(MAX_MESSAGE_CHARS).collect::<String>())
            }
            ExpressionValue::Text(t) => format!("the string '{t}'"),
            ExpressionValue::List(l) => format!("a list of length {}", l.len()),
        }
    }

    /// Formats the value as TOML, on one line. Returns an error if a number is not finite.
    pub fn to_toml(&self) -> Result<String> {
        Ok(match self {
            ExpressionValue::Number(x) if x.is_finite() => format!("{x:?}"),
            ExpressionValue::Number(x) => {
                return Err(ModelError::new(format!("the result is {x}, which is not a finite number")));
            }
            ExpressionValue::Bool(b) => b.to_string(),
            ExpressionValue::Text(t) => quote(t),
            ExpressionValue::List(l) => {
                format!("[{}]", l.iter().map(ExpressionValue::to_toml).collect::<Result<Vec<_>>>()?.join(", "))
            }
        })
    }

    /// Converts a TOML value; returns `None` for dates and tables, and for arrays that contain them.
    pub fn from_toml(value: &toml_edit::Value) -> Option<ExpressionValue> {
        use toml_edit::Value as T;
        Some(match value {
            T::String(s) => ExpressionValue::Text(s.value().clone()),
            T::Integer(i) => ExpressionValue::Number(*i.value() as f64),
            T::Float(f) => ExpressionValue::Number(*f.value()),
            T::Boolean(b) => ExpressionValue::Bool(*b.value()),
            T::Array(a) => ExpressionValue::List(a.iter().map(ExpressionValue::from_toml).collect::<Option<_>>()?),
            _ => return None,
        })
    }

    /// Converts a value of the host, or returns `None` if expressions do not support its type.
    pub fn from_host(value: &safe::Value) -> Option<ExpressionValue> {
        use safe::Value as H;
        Some(match value {
            H::Bool(b) => ExpressionValue::Bool(*b),
            H::Int(i) => ExpressionValue::Number(*i as f64),
            H::Float(f) => ExpressionValue::Number(*f),
            H::Text(t) => ExpressionValue::Text(String::from_utf8_lossy(t).into_owned()),
            H::Floats(f) => ExpressionValue::List(f.iter().map(|x| ExpressionValue::Number(*x)).collect()),
            H::List(l) => ExpressionValue::List(l.iter().map(ExpressionValue::from_host).collect::<Option<_>>()?),
            _ => return None,
        })
    }

    /// Converts the value for the host: numbers as `Float`, lists of numbers as `Floats`.
    pub fn to_host(&self) -> safe::Value {
        use safe::Value as H;
        match self {
            ExpressionValue::Number(x) => H::Float(*x),
            ExpressionValue::Bool(b) => H::Bool(*b),
            ExpressionValue::Text(t) => H::text(t),
            ExpressionValue::List(l) => {
                let numbers = l.iter().map(|v| if let ExpressionValue::Number(x) = v { Some(*x) } else { None });
                numbers
                    .collect::<Option<Vec<_>>>()
                    .map_or_else(|| H::List(l.iter().map(ExpressionValue::to_host).collect()), H::Floats)
            }
        }
    }
}

/// Formats a string as a TOML basic string, with escaped control characters.
fn quote(text: &str) -> String {
    let mut out = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out += "\\n",
            c if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
