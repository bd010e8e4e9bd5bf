//! Values of parameters, constants and expressions.

use tatu_plugin_api::safe;

use crate::wrong::{Result, Wrong};

/// Maximum length of a string in messages, bytes; longer strings are truncated to this number of characters.
const LONGEST: usize = 80;

/// The value of a parameter, constant or expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number. Integers are numbers without a fractional part.
    Number(f64),
    /// A boolean.
    Bool(bool),
    /// A string.
    Text(String),
    /// A list of values, such as a vector or a list of vectors.
    List(Vec<Value>),
}

impl Value {
    /// Describes the value for messages.
    pub fn describe(&self) -> String {
        match self {
            Value::Number(x) => format!("the number {x}"),
            Value::Bool(b) => b.to_string(),
            Value::Text(t) if t.len() > LONGEST => {
                format!("the string '{}...'", t.chars().take(LONGEST).collect::<String>())
            }
            Value::Text(t) => format!("the string '{t}'"),
            Value::List(l) => format!("a list of length {}", l.len()),
        }
    }

    /// Formats the value as TOML, on one line. Returns an error if a number is not finite.
    pub fn to_toml(&self) -> Result<String> {
        Ok(match self {
            Value::Number(x) if x.is_finite() => format!("{x:?}"),
            Value::Number(x) => return Err(Wrong::new(format!("the result is {x}, which is not a finite number"))),
            Value::Bool(b) => b.to_string(),
            Value::Text(t) => quoted(t),
            Value::List(l) => format!("[{}]", l.iter().map(Value::to_toml).collect::<Result<Vec<_>>>()?.join(", ")),
        })
    }

    /// Converts a TOML value; returns `None` for dates and tables, and for arrays that contain them.
    pub fn of_toml(value: &toml_edit::Value) -> Option<Value> {
        use toml_edit::Value as T;
        Some(match value {
            T::String(s) => Value::Text(s.value().clone()),
            T::Integer(i) => Value::Number(*i.value() as f64),
            T::Float(f) => Value::Number(*f.value()),
            T::Boolean(b) => Value::Bool(*b.value()),
            T::Array(a) => Value::List(a.iter().map(Value::of_toml).collect::<Option<_>>()?),
            _ => return None,
        })
    }

    /// Converts a value of the host, or returns `None` if expressions do not support its type.
    pub fn of_host(value: &safe::Value) -> Option<Value> {
        use safe::Value as H;
        Some(match value {
            H::Bool(b) => Value::Bool(*b),
            H::Int(i) => Value::Number(*i as f64),
            H::Float(f) => Value::Number(*f),
            H::Text(t) => Value::Text(String::from_utf8_lossy(t).into_owned()),
            H::Floats(f) => Value::List(f.iter().map(|x| Value::Number(*x)).collect()),
            H::List(l) => Value::List(l.iter().map(Value::of_host).collect::<Option<_>>()?),
            _ => return None,
        })
    }

    /// Converts the value for the host: numbers as `Float`, lists of numbers as `Floats`.
    pub fn to_host(&self) -> safe::Value {
        use safe::Value as H;
        match self {
            Value::Number(x) => H::Float(*x),
            Value::Bool(b) => H::Bool(*b),
            Value::Text(t) => H::text(t),
            Value::List(l) => {
                let numbers = l.iter().map(|v| if let Value::Number(x) = v { Some(*x) } else { None });
                numbers
                    .collect::<Option<Vec<_>>>()
                    .map_or_else(|| H::List(l.iter().map(Value::to_host).collect()), H::Floats)
            }
        }
    }
}

/// Formats a string as a TOML basic string, with escaped control characters.
fn quoted(text: &str) -> String {
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
