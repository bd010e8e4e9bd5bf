//! Declared parameters, in Rust's words, and the check of values against them.

use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};

use super::tables;

/// A declared parameter of a sensor, model or command.
#[derive(Debug, Clone, PartialEq)]
pub struct Declared {
    /// "range"
    pub key: String,
    /// `TATU_BOOL` .. `TATU_OBJECT`
    pub kind: u32,
    /// Elements of an array; 0: any number.
    pub count: u32,
    /// `TATU_PARAM_*`
    pub flags: u32,
    /// Unit of the SI value.
    pub unit: Option<String>,
    /// Least value.
    pub lowest: f64,
    /// Greatest value.
    pub highest: f64,
    /// The default.
    pub fallback: Value,
    /// The default was a value that cannot be read; `fallback` is none.
    pub unreadable_default: bool,
    /// Allowed texts; empty: any.
    pub choices: Vec<String>,
    /// One sentence.
    pub text: String,
}

impl Declared {
    /// # Safety
    /// The list and its tables are as the header tells.
    pub(super) unsafe fn read_list(list: *const *const tatu_param) -> Vec<Declared> {
        // SAFETY: the caller promises it.
        unsafe { tables::list(list).into_iter().map(|(_, p)| Self::read(&p)).collect() }
    }
    unsafe fn read(raw: &tatu_param) -> Declared {
        // Both bounds zero is a table that somebody zeroed and did not fill: no bounds.
        let unset = raw.lowest == 0.0 && raw.highest == 0.0;
        // SAFETY: texts of a declaration live as long as its plugin.
        unsafe {
            let fallback = ValueRef::new(raw.fallback).to_value();
            Declared {
                key: tables::label(raw.key).unwrap_or_default(),
                kind: raw.type_,
                count: raw.count,
                flags: raw.flags,
                unit: tables::text(raw.unit),
                lowest: if unset { f64::NEG_INFINITY } else { raw.lowest },
                highest: if unset { f64::INFINITY } else { raw.highest },
                unreadable_default: fallback.is_err(),
                fallback: fallback.unwrap_or_default(),
                choices: tables::pointers(raw.choices).into_iter().filter_map(|c| tables::text(c)).collect(),
                text: tables::text(raw.text).unwrap_or_default(),
            }
        }
    }
    /// Whether it may be left out.
    pub fn optional(&self) -> bool {
        self.flags & TATU_PARAM_OPTIONAL != 0 || self.fallback != Value::Nil
    }
    /// What it wants, for messages: "a number in m, 0 to 5".
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
            TATU_MAP => "a table with keys".into(),
            TATU_FUNC => "a function".into(),
            TATU_OBJECT => "an object".into(),
            _ => "a value".into(),
        };
        if !self.choices.is_empty() {
            let quoted: Vec<_> = self.choices.iter().map(|c| format!("\"{c}\"")).collect();
            out = format!("one of {}", quoted.join(", "));
        }
        match (self.lowest.is_finite(), self.highest.is_finite()) {
            (true, true) => out += &format!(" from {} to {}", self.lowest, self.highest),
            (true, false) => out += &format!(", at least {}", self.lowest),
            (false, true) => out += &format!(", at most {}", self.highest),
            (false, false) => {}
        }
        out
    }
}

/// A value as the declaration wants it: integers become floats where floats are declared, lists become numbers, a
/// text that is a number becomes one. The error says what was found.
pub fn check_value(declared: &Declared, value: Value) -> Result<Value, String> {
    if declared.flags & TATU_PARAM_ANY != 0 {
        return Ok(value);
    }
    let found = describe(&value);
    let number = |t: &[u8]| std::str::from_utf8(t).ok().and_then(|s| s.trim().parse::<f64>().ok());
    let converted = match (declared.kind, value) {
        (TATU_F64, Value::Float(f)) => Some(Value::Float(f)),
        (TATU_F64, Value::Int(i)) => Some(Value::Float(i as f64)),
        (TATU_F64, Value::Text(t)) => number(&t).map(Value::Float),
        (TATU_I64, Value::Int(i)) => Some(Value::Int(i)),
        (TATU_I64, Value::Float(f)) => whole(f).map(Value::Int),
        (TATU_I64, Value::Text(t)) => number(&t).and_then(whole).map(Value::Int),
        (TATU_I64, Value::Object(o)) => Some(Value::Int((o & 0xF_FFFF) as i64)),
        (TATU_BOOL, Value::Bool(b)) => Some(Value::Bool(b)),
        (TATU_TEXT | TATU_BYTES, v @ (Value::Text(_) | Value::Bytes(_))) => Some(v),
        (TATU_TEXT | TATU_BYTES, Value::Int(i)) => Some(Value::text(i.to_string())),
        (TATU_TEXT | TATU_BYTES, Value::Float(f)) => Some(Value::text(format!("{f}"))),
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
        (TATU_MAP, v @ Value::Map(_)) => Some(v),
        // An empty table of a script is a list; it is an empty map just as well.
        (TATU_MAP, Value::List(l)) if l.is_empty() => Some(Value::Map(Vec::new())),
        (TATU_MAP, v @ (Value::List(_) | Value::Floats(_) | Value::Ints(_))) => Some(v),
        (TATU_FUNC, v @ Value::Func(_)) => Some(v),
        (TATU_OBJECT, Value::Object(o)) => Some(Value::Object(o)),
        (TATU_OBJECT, Value::Int(i)) => u64::try_from(i).ok().map(Value::Object),
        (TATU_OBJECT, Value::Float(f)) => whole(f).and_then(|i| u64::try_from(i).ok()).map(Value::Object),
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
        return Err(format!("expected {}, found one that is not a number", declared.expectation()));
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

/// A number without a fraction as an integer.
fn whole(f: f64) -> Option<i64> {
    // Beyond 2^53 floats have no fractions, and beyond 2^63 there are no integers for them.
    (f.fract() == 0.0 && f.abs() < 9.2e18).then_some(f as i64)
}

/// A value in a few words, for messages.
pub fn describe(value: &Value) -> String {
    match value {
        Value::Nil => "nothing".into(),
        Value::Bool(b) => b.to_string(),
        Value::Int(i) => i.to_string(),
        Value::Float(f) => f.to_string(),
        Value::Text(t) => format!("the text \"{}\"", String::from_utf8_lossy(&t[..t.len().min(40)])),
        Value::Bytes(b) => format!("{} bytes", b.len()),
        Value::Floats(f) => format!("{} numbers", f.len()),
        Value::Ints(f) => format!("{} integers", f.len()),
        Value::List(l) => format!("a list of {}", l.len()),
        Value::Map(m) => format!("a table with {} keys", m.len()),
        Value::Func(_) => "a function".into(),
        Value::Object(o) => format!("object {}", o & 0xF_FFFF),
    }
}
