//! Declarations of parameters as Rust types, and the check of values against them.

use tatu_plugin_api::{abi::*, safe::Value};

use crate::declared::Declared;

/// Maximum depth of nested tables with declared keys.
const MAX_KEY_DEPTH: u32 = 4;
/// Maximum number of keys of a parameter, including those of nested tables.
const MAX_KEYS: u32 = 1000;

/// A declared parameter, such as one of a sensor, a model or a command.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSpec {
    /// Key, such as "range".
    pub key: String,
    /// Type of the value, `TATU_BOOL` to `TATU_OBJECT`.
    pub kind: u32,
    /// Required number of elements of an array; 0 if any number is allowed.
    pub count: u32,
    /// Combination of `TATU_PARAM_*` flags.
    pub flags: u32,
    /// SI unit of the value, if it has one.
    pub unit: Option<String>,
    /// Minimum value, in SI units; negative infinity if there is none.
    pub lowest: f64,
    /// Maximum value, in SI units; infinity if there is none.
    pub highest: f64,
    /// Default value.
    pub fallback: Value,
    /// Whether the default could not be read; `fallback` is then nil.
    pub unreadable_default: bool,
    /// Allowed values of a string; if empty, any string is allowed.
    pub choices: Vec<String>,
    /// Declared keys of a table; if empty, all keys are allowed.
    pub keys: Vec<ParameterSpec>,
    /// Whether some of the keys were not read, because there are too many or they are nested too deeply.
    pub keys_cut: bool,
    /// Description in one sentence.
    pub text: String,
}

impl ParameterSpec {
    /// Reads a list of declarations.
    pub(super) fn read_list(list: &[Declared<'_, tatu_param>]) -> Vec<ParameterSpec> {
        list.iter().map(|p| Self::read(p, 0, &mut 0)).collect()
    }
    /// Reads the keys of a table, and returns whether some were left out. The depth and the number of keys are limited,
    /// because a declaration can refer to itself.
    fn read_keys(table: &Declared<'_, tatu_param>, depth: u32, read: &mut u32) -> (Vec<ParameterSpec>, bool) {
        let all = table.keys();
        if all.is_empty() {
            return (Vec::new(), false);
        }
        *read = read.saturating_add(u32::try_from(all.len()).unwrap_or(u32::MAX));
        if depth > MAX_KEY_DEPTH || *read > MAX_KEYS {
            return (Vec::new(), true);
        }
        let keys: Vec<_> = all.iter().map(|p| Self::read(p, depth, read)).collect();
        let cut = keys.iter().any(|k| k.keys_cut);
        (keys, cut)
    }
    fn read(raw: &Declared<'_, tatu_param>, depth: u32, read: &mut u32) -> ParameterSpec {
        // If both bounds are 0, the plugin has not set them, which means that the value is unbounded.
        let unset = raw.lowest == 0.0 && raw.highest == 0.0;
        let (keys, keys_cut) = match raw.type_ {
            TATU_MAP => Self::read_keys(raw, depth + 1, read),
            _ => (Vec::new(), false),
        };
        let fallback = raw.fallback().to_value();
        ParameterSpec {
            key: raw.key().unwrap_or_default(),
            kind: raw.type_,
            count: raw.count,
            flags: raw.flags,
            unit: raw.unit(),
            lowest: if unset { f64::NEG_INFINITY } else { raw.lowest },
            highest: if unset { f64::INFINITY } else { raw.highest },
            unreadable_default: fallback.is_err(),
            fallback: fallback.unwrap_or_default(),
            choices: raw.choices(),
            keys,
            keys_cut,
            text: raw.text().unwrap_or_default(),
        }
    }
    /// Returns whether the parameter can be omitted.
    pub fn optional(&self) -> bool {
        self.flags & TATU_PARAM_OPTIONAL != 0 || self.fallback != Value::Nil
    }
    /// Describes the expected value, for messages: "a number from 0 to 5".
    pub fn expectation(&self) -> String {
        let mut out = match self.kind {
            _ if self.flags & TATU_PARAM_ANY != 0 => "anything".to_owned(),
            TATU_BOOL => "true or false".into(),
            TATU_I64 => "an integer".into(),
            TATU_F64 => "a number".into(),
            TATU_TEXT | TATU_BYTES => "a text".into(),
            TATU_F64S if self.count > 0 => format!("{} numbers", self.count),
            TATU_F64S => "numbers".into(),
            TATU_LIST => "a list".into(),
            TATU_MAP if !self.keys.is_empty() => {
                let keys: Vec<&str> = self.keys.iter().map(|k| k.key.as_str()).collect();
                format!("a table with the keys {}", keys.join(", "))
            }
            TATU_MAP => "a table with keys".into(),
            TATU_FUNC => "a function".into(),
            TATU_OBJECT => "an object".into(),
            _ => "a value".into(),
        };
        if !self.choices.is_empty() {
            let quoted: Vec<_> = self.choices.iter().map(|c| format!("\"{c}\"")).collect();
            out = format!("one of {}", quoted.join(", "));
        }
        // The least number above 0 stands for a range that excludes 0.
        let above = self.lowest == f64::next_up(0.0);
        match self.bounds() {
            [Some(_), Some(high)] if above => out += &format!(" above 0, at most {high}"),
            [Some(_), None] if above => out += " above 0",
            [Some(low), Some(high)] => out += &format!(" from {low} to {high}"),
            [Some(low), None] => out += &format!(", at least {low}"),
            [None, Some(high)] => out += &format!(", at most {high}"),
            [None, None] => {}
        }
        out
    }
    /// Returns the minimum and the maximum value, if there are any. A range that ends at the greatest finite number
    /// only excludes infinity.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.lowest, self.highest].map(|x| Some(x).filter(|x| x.is_finite() && x.abs() < f64::MAX))
    }
}

/// Converts a value to the declared type, such as an integer to a float, a list to an array of numbers or a string to
/// the number that it represents. Then checks its range, length, choices and keys. The error describes the value found.
pub fn check_value(declared: &ParameterSpec, value: Value) -> Result<Value, String> {
    if declared.flags & TATU_PARAM_ANY != 0 {
        return Ok(value);
    }
    let found = describe_value(&value);
    let number = |t: &[u8]| std::str::from_utf8(t).ok().and_then(|s| s.trim().parse::<f64>().ok());
    let converted = match (declared.kind, value) {
        (TATU_F64, Value::Float(f)) => Some(Value::Float(f)),
        (TATU_F64, Value::Int(i)) => Some(Value::Float(i as f64)),
        (TATU_F64, Value::Text(t)) => number(&t).map(Value::Float),
        (TATU_I64, Value::Int(i)) => Some(Value::Int(i)),
        (TATU_I64, Value::Float(f)) => to_integer(f).map(Value::Int),
        (TATU_I64, Value::Text(t)) => number(&t).and_then(to_integer).map(Value::Int),
        (TATU_I64, Value::Object(o)) => Some(Value::Int(i64::from(tatu_slot(o)))),
        (TATU_BOOL, Value::Bool(b)) => Some(Value::Bool(b)),
        (TATU_TEXT, Value::Text(t) | Value::Bytes(t)) => Some(Value::Text(t)),
        (TATU_BYTES, Value::Text(t) | Value::Bytes(t)) => Some(Value::Bytes(t)),
        (TATU_TEXT, Value::Int(i)) => Some(Value::text(i.to_string())),
        (TATU_TEXT, Value::Float(f)) => Some(Value::text(format!("{f}"))),
        (TATU_BYTES, Value::Int(i)) => Some(Value::Bytes(i.to_string().into_bytes())),
        (TATU_BYTES, Value::Float(f)) => Some(Value::Bytes(f.to_string().into_bytes())),
        (TATU_F64S, Value::Floats(f)) => Some(Value::Floats(f)),
        (TATU_F64S, Value::Ints(i)) => Some(Value::Floats(i.into_iter().map(|x| x as f64).collect())),
        (TATU_F64S, Value::List(l)) => l
            .iter()
            .map(|v| match v {
                Value::Float(f) => Some(*f),
                Value::Int(i) => Some(*i as f64),
                Value::Text(t) => number(t),
                _ => None,
            })
            .collect::<Option<Vec<_>>>()
            .map(Value::Floats),
        (TATU_LIST, Value::Floats(f)) => Some(Value::List(f.into_iter().map(Value::Float).collect())),
        (TATU_LIST, Value::Ints(f)) => Some(Value::List(f.into_iter().map(Value::Int).collect())),
        (TATU_LIST, v @ Value::List(_)) => Some(v),
        // Scripts cannot distinguish a list from a table with the keys 1, 2, 3, nor an empty list from an empty table.
        (TATU_MAP, Value::Map(m)) => Some(Value::Map(check_keys(declared, m)?)),
        (TATU_MAP, Value::List(l)) => Some(Value::Map(check_keys(declared, numbered_entries(l))?)),
        (TATU_MAP, Value::Floats(f)) => {
            Some(Value::Map(check_keys(declared, numbered_entries(f.into_iter().map(Value::Float)))?))
        }
        (TATU_MAP, Value::Ints(i)) => {
            Some(Value::Map(check_keys(declared, numbered_entries(i.into_iter().map(Value::Int)))?))
        }
        (TATU_LIST, Value::Map(m)) if m.is_empty() => Some(Value::List(Vec::new())),
        (TATU_F64S, Value::Map(m)) if m.is_empty() => Some(Value::Floats(Vec::new())),
        (TATU_FUNC, v @ Value::Func(_)) => Some(v),
        (TATU_OBJECT, Value::Object(o)) => Some(Value::Object(o)),
        (TATU_OBJECT, Value::Int(i)) => u64::try_from(i).ok().map(Value::Object),
        (TATU_OBJECT, Value::Float(f)) => to_integer(f).and_then(|i| u64::try_from(i).ok()).map(Value::Object),
        _ => None,
    };
    let Some(value) = converted else {
        return Err(format!("expected {}, found {found}", declared.expectation()));
    };
    let fits = match &value {
        Value::Float(f) => *f >= declared.lowest && *f <= declared.highest,
        Value::Int(i) => *i as f64 >= declared.lowest && *i as f64 <= declared.highest,
        Value::Floats(f) => {
            (declared.count == 0 || f.len() == declared.count as usize)
                && f.iter().all(|x| *x >= declared.lowest && *x <= declared.highest)
        }
        Value::Text(t) | Value::Bytes(t) => {
            declared.choices.is_empty() || declared.choices.iter().any(|c| c.as_bytes() == t)
        }
        _ => true,
    };
    if matches!(&value, Value::Floats(f) if f.iter().any(|x| x.is_nan())) {
        return Err(format!("expected {}, found a value that is not a number", declared.expectation()));
    }
    if fits {
        return Ok(value);
    }
    let found = match &value {
        Value::Floats(f) if declared.count == 0 || f.len() == declared.count as usize => {
            let outside = f.iter().enumerate().find(|(_, x)| **x < declared.lowest || **x > declared.highest);
            outside.map_or(found, |(i, x)| format!("{x} as number {}", i + 1))
        }
        _ => found,
    };
    Err(format!("expected {}, found {found}", declared.expectation()))
}

/// Converts the entries of a list to those of a table with the keys 1, 2, 3.
fn numbered_entries(values: impl IntoIterator<Item = Value>) -> Vec<(Value, Value)> {
    (1..).map(Value::Int).zip(values).collect()
}

/// Checks the entries of a table against its declared keys, fills in defaults, and returns the entries in the order of
/// declaration. Without declared keys, the entries are unchanged.
fn check_keys(declared: &ParameterSpec, entries: Vec<(Value, Value)>) -> Result<Vec<(Value, Value)>, String> {
    if declared.keys.is_empty() {
        return Ok(entries);
    }
    let mut given: Vec<Option<Value>> = vec![None; declared.keys.len()];
    for (key, value) in entries {
        let place = key_text(&key).and_then(|k| declared.keys.iter().position(|d| d.key == k));
        let Some(place) = place else {
            let known: Vec<&str> = declared.keys.iter().map(|d| d.key.as_str()).collect();
            let near = key_text(&key).and_then(|k| tatu_errors::nearest(k, known.iter().copied()));
            let near = near.map_or(String::new(), |n| format!(", did you mean `{n}`?"));
            return Err(format!("there is no key {}{near} (keys are {})", quoted_key(&key), known.join(", ")));
        };
        given[place] = Some(value);
    }
    let mut out = Vec::new();
    for (key, value) in declared.keys.iter().zip(given) {
        let value = match value {
            None | Some(Value::Nil) if key.fallback != Value::Nil => key.fallback.clone(),
            None | Some(Value::Nil) if key.optional() => continue,
            None | Some(Value::Nil) => return Err(format!("the key `{}` is missing: {}", key.key, key.expectation())),
            Some(value) => check_value(key, value).map_err(|e| format!("key `{}`: {e}", key.key))?,
        };
        out.push((Value::text(key.key.as_str()), value));
    }
    Ok(out)
}

/// Returns a key as a string, if it is one.
fn key_text(key: &Value) -> Option<&str> {
    match key {
        Value::Text(t) | Value::Bytes(t) => std::str::from_utf8(t).ok(),
        _ => None,
    }
}

/// Formats a key for messages.
fn quoted_key(key: &Value) -> String {
    key_text(key).map_or_else(|| describe_value(key), |k| format!("`{}`", k.chars().take(40).collect::<String>()))
}

/// Returns a number without a fraction as an integer.
fn to_integer(f: f64) -> Option<i64> {
    // Floats beyond 2^53 have no fraction. The limit is just below 2^63, the first value that an `i64` cannot
    // represent.
    (f.fract() == 0.0 && f.abs() < 9.2e18).then_some(f as i64)
}

/// Describes a value briefly, for messages.
pub fn describe_value(value: &Value) -> String {
    match value {
        Value::Nil => "nothing".into(),
        Value::Bool(b) => b.to_string(),
        Value::Int(i) => i.to_string(),
        Value::Float(f) => f.to_string(),
        Value::Text(t) => format!("the text \"{}\"", String::from_utf8_lossy(&t[..t.len().min(40)])),
        Value::Bytes(b) => format!("{} bytes", b.len()),
        Value::Floats(f) => format!("{} numbers", f.len()),
        Value::Ints(f) => format!("{} integers", f.len()),
        Value::List(l) => format!("a list of {} elements", l.len()),
        Value::Map(m) => format!("a table with {} keys", m.len()),
        Value::Func(_) => "a function".into(),
        Value::Object(o) => format!("object {}", tatu_slot(*o)),
    }
}
