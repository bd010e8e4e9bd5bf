//! Checked access to maps with a fixed set of keys.

use tatu_errors::{Refusal, nearest};
use tatu_plugin_api::{abi::*, safe::Value};

/// A map whose keys have been checked against a list.
pub struct CheckedMap<'a> {
    what: &'static str,
    entries: &'a [(Value, Value)],
}

impl<'a> CheckedMap<'a> {
    /// Checks that a value is a map with only known keys. `what` names the map in messages, with its article. The error
    /// for an unknown key suggests the nearest known one.
    pub fn new(what: &'static str, value: &'a Value, known: &[&str]) -> Result<Self, Refusal> {
        let Value::Map(entries) = value else {
            return Err(Refusal(TATU_ERR_ARGUMENT, format!("{what} must be a table with keys {}", known.join(", "))));
        };
        for (key, _) in entries {
            let Value::Text(key) = key else {
                return Err(Refusal(TATU_ERR_ARGUMENT, format!("the keys of {what} must be strings")));
            };
            let key = String::from_utf8_lossy(key);
            if !known.contains(&key.as_ref()) {
                let hint =
                    nearest(&key, known.iter().copied()).map_or(".".into(), |n| format!(": did you mean `{n}`?"));
                return Err(Refusal(
                    TATU_ERR_ARGUMENT,
                    format!("{what} has no key `{key}`{hint} Its keys are {}", known.join(", ")),
                ));
            }
        }
        Ok(CheckedMap { what, entries })
    }
    fn find(&self, key: &str) -> Option<&'a Value> {
        self.entries.iter().find(|(k, _)| matches!(k, Value::Text(t) if t == key.as_bytes())).map(|(_, v)| v)
    }
    /// Returns the error for a key whose value is not as expected.
    pub fn invalid_value<T>(&self, key: &str, expected: &str) -> Result<T, Refusal> {
        Err(Refusal(TATU_ERR_ARGUMENT, format!("{}: `{key}` must be {expected}", self.what)))
    }
    /// Returns a string, which is empty if the key is missing.
    pub fn text(&self, key: &str) -> Result<String, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(String::new()),
            Some(Value::Text(t) | Value::Bytes(t)) => Ok(String::from_utf8_lossy(t).into_owned()),
            Some(_) => self.invalid_value(key, "a string"),
        }
    }
    /// Returns a finite number, if the key exists.
    pub fn number(&self, key: &str) -> Result<Option<f64>, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(None),
            Some(Value::Float(x)) if x.is_finite() => Ok(Some(*x)),
            Some(Value::Int(i)) => Ok(Some(*i as f64)),
            Some(_) => self.invalid_value(key, "a finite number"),
        }
    }
    /// Returns a whole number within a range, if the key exists.
    pub fn count(&self, key: &str, range: std::ops::RangeInclusive<i64>) -> Result<Option<i64>, Refusal> {
        match self.number(key)? {
            None => Ok(None),
            Some(x) if x.fract() == 0.0 && range.contains(&(x as i64)) => Ok(Some(x as i64)),
            Some(_) => self.invalid_value(key, &format!("a whole number from {} to {}", range.start(), range.end())),
        }
    }
    /// Returns a list of non-empty strings; the list is empty if the key is missing.
    pub fn texts(&self, key: &str) -> Result<Vec<String>, Refusal> {
        let text = |v: &Value| match v {
            Value::Text(t) if !t.is_empty() => String::from_utf8(t.clone()).ok(),
            _ => None,
        };
        match self.find(key) {
            None | Some(Value::Nil) => Ok(Vec::new()),
            Some(Value::List(all)) => all
                .iter()
                .map(text)
                .collect::<Option<_>>()
                .map_or_else(|| self.invalid_value(key, "a list of strings"), Ok),
            Some(_) => self.invalid_value(key, "a list of strings"),
        }
    }
    /// Returns a list of finite numbers; the list is empty if the key is missing.
    pub fn numbers(&self, key: &str) -> Result<Vec<f64>, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(Vec::new()),
            Some(Value::Ints(all)) => Ok(all.iter().map(|i| *i as f64).collect()),
            Some(Value::Floats(all)) if all.iter().all(|x| x.is_finite()) => Ok(all.clone()),
            Some(_) => self.invalid_value(key, "a list of finite numbers"),
        }
    }
    /// Returns an object, or 0 if the key is missing.
    pub fn object(&self, key: &str) -> Result<tatu_object, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(0),
            Some(Value::Object(id)) => Ok(*id),
            Some(_) => self.invalid_value(key, "an object"),
        }
    }
    /// Returns a boolean, or `false` if the key is missing.
    pub fn flag(&self, key: &str) -> Result<bool, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(false),
            Some(Value::Bool(b)) => Ok(*b),
            Some(_) => self.invalid_value(key, "true or false"),
        }
    }
    /// Returns a list of booleans, or a single boolean as a list, if the key exists.
    pub fn flags(&self, key: &str) -> Result<Option<Vec<bool>>, Refusal> {
        let flag = |v: &Value| if let Value::Bool(b) = v { Some(*b) } else { None };
        match self.find(key) {
            None | Some(Value::Nil) => Ok(None),
            Some(Value::Bool(b)) => Ok(Some(vec![*b])),
            Some(Value::List(all)) => {
                let all = all.iter().map(flag).collect::<Option<_>>();
                all.map_or_else(|| self.invalid_value(key, "a list of booleans"), |all| Ok(Some(all)))
            }
            Some(_) => self.invalid_value(key, "a boolean or a list of booleans"),
        }
    }
    /// Returns red, green and blue, each from 0 to 1, if the key exists.
    pub fn color(&self, key: &str) -> Result<Option<[f64; 3]>, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(None),
            Some(Value::Floats(v)) if v.len() == 3 && v.iter().all(|x| (0.0..=1.0).contains(x)) => {
                Ok(Some([v[0], v[1], v[2]]))
            }
            Some(_) => self.invalid_value(key, "red, green and blue, each from 0 to 1"),
        }
    }
    /// Returns a string (as `Err`) or a number (as `Ok`), or `None` if the key is missing.
    pub fn text_or_number(&self, key: &str) -> Result<Option<Result<f64, String>>, Refusal> {
        match self.find(key) {
            None | Some(Value::Nil) => Ok(None),
            Some(Value::Text(t)) => Ok(Some(Err(String::from_utf8_lossy(t).into_owned()))),
            Some(_) => Ok(self.number(key)?.map(Ok)),
        }
    }
}

/// Builds a map from its entries.
pub fn map(entries: impl IntoIterator<Item = (&'static str, Value)>) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}
