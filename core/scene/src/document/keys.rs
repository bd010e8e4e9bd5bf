//! Keys and values of scene files: source locations, types and units.

use std::{
    ops::Range,
    path::{Path, PathBuf},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_errors::{Error, Result, SourceLocation, nearest};
use tatu_plugin_api::{abi::TATU_PARAM_READ_ONLY, safe::Value};
use tatu_plugins::{ParameterSpec, check_value, units};
use toml_edit::{Item, TableLike};

use crate::{drive, property_table::FileForm, texture::KEYS as TEXTURE_KEYS};

/// The contents of a scene file, used to convert byte offsets to lines and columns.
pub struct SourceText<'a> {
    /// Path of the file.
    pub file: &'a Path,
    /// Contents of the file.
    pub text: &'a str,
    /// Byte offset of the start of each line.
    lines: Vec<usize>,
}

impl<'a> SourceText<'a> {
    /// Creates the value and finds the starts of the lines.
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        let breaks = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        SourceText { file, text, lines: std::iter::once(0).chain(breaks).collect() }
    }
}

impl SourceText<'_> {
    /// Returns the source location of a byte range, or the start of the file if the range is unknown.
    pub fn place(&self, span: Option<Range<usize>>) -> SourceLocation {
        let span = span.unwrap_or(0..0);
        let at = span.start.min(self.text.len());
        let line = self.lines.partition_point(|begin| *begin <= at);
        let column = at - self.lines.get(line.wrapping_sub(1)).copied().unwrap_or(0) + 1;
        SourceLocation { file: PathBuf::from(self.file), line, column, span }
    }
    /// Returns the source location of a key of a table.
    pub fn key(&self, table: &dyn TableLike, key: &str) -> SourceLocation {
        self.place(table.key(key).and_then(|k| k.span()))
    }
    /// Returns the source location of a value of a table.
    pub fn value(&self, table: &dyn TableLike, key: &str) -> SourceLocation {
        self.place(table.get(key).and_then(Item::span).or_else(|| table.key(key).and_then(|k| k.span())))
    }
}

/// Converts a TOML value, with numbers multiplied by the factor of their unit.
pub fn to_value(item: &Item, factor: f64) -> Result<Value> {
    match item {
        Item::Value(v) => value(v, factor),
        Item::None => Ok(Value::Nil),
        _ => Err(Error::new("E102", "expected a value, found a table")),
    }
}

/// Converts a value of a property from its form in scene files, with numbers multiplied by the factor of their unit.
pub fn read(form: FileForm, item: &Item, factor: f64) -> Result<Value> {
    match form {
        FileForm::Data => to_map(item),
        FileForm::Drive => table("a drive", drive::KEYS, item.as_table_like()),
        FileForm::Texture => table("a texture", TEXTURE_KEYS, item.as_table_like()),
        FileForm::Plain | FileForm::Mesh | FileForm::Parts | FileForm::Noise => to_value(item, factor),
    }
}

/// Converts a table with arbitrary keys to a map.
pub fn to_map(item: &Item) -> Result<Value> {
    let table = item.as_table_like().ok_or_else(|| Error::new("E102", "expected a table"))?;
    let entries = table.iter().map(|(k, v)| Ok((Value::text(k), custom_data_value(v)?)));
    Ok(Value::Map(entries.collect::<Result<_>>()?))
}

/// Converts a value of custom data. Bytes that are not valid UTF-8 are written as `{ base64 = "..." }`.
fn custom_data_value(item: &Item) -> Result<Value> {
    let coded = item.as_table_like().filter(|t| t.len() == 1).and_then(|t| t.get("base64")).and_then(Item::as_str);
    let Some(coded) = coded else { return to_value(item, 1.0) };
    STANDARD.decode(coded).map(Value::Text).map_err(|e| Error::new("E102", format!("invalid base64: {e}")))
}

fn value(v: &toml_edit::Value, factor: f64) -> Result<Value> {
    use toml_edit::Value as T;
    Ok(match v {
        T::String(s) => Value::text(s.value()),
        T::Integer(i) if factor == 1.0 => Value::Int(*i.value()),
        T::Integer(i) => Value::Float(*i.value() as f64 * factor),
        T::Float(f) => Value::Float(*f.value() * factor),
        T::Boolean(b) => Value::Bool(*b.value()),
        T::Datetime(d) => Value::text(d.value().to_string()),
        T::Array(a) => {
            let items = a.iter().map(|v| value(v, factor)).collect::<Result<Vec<_>>>()?;
            let number = |v: &Value| match v {
                Value::Int(i) => Some(*i as f64),
                Value::Float(f) => Some(*f),
                _ => None,
            };
            match items.iter().map(number).collect::<Option<Vec<_>>>() {
                Some(numbers) if !numbers.is_empty() => Value::Floats(numbers),
                _ => Value::List(items),
            }
        }
        // A table with the key `name` is not a part of a compound; the code that uses the value checks its keys.
        T::InlineTable(t) if t.contains_key("name") => {
            let entries = t.iter().map(|(k, v)| Ok((Value::text(k), value(v, 1.0)?)));
            Value::Map(entries.collect::<Result<_>>()?)
        }
        T::InlineTable(t) => part(t)?,
    })
}

/// Keys of a part of a compound, with their units.
pub const PART_KEYS: &[(&str, &str)] = &[
    ("primitive", ""),
    ("size", "m"),
    ("position", "m"),
    ("orientation", "rad"),
    ("quaternion", ""),
    ("color", ""),
    ("opacity", ""),
    ("texture", ""),
    ("friction", ""),
    ("mesh", ""),
    ("convex", ""),
];

/// Converts a part of a compound, whose keys include units.
fn part(table: &toml_edit::InlineTable) -> Result<Value> {
    table.iter().map(|(k, v)| with_unit("a part", PART_KEYS, k, v)).collect::<Result<_>>().map(Value::Map)
}

/// Converts a table whose keys include units.
fn table(what: &str, known: &[(&str, &str)], table: Option<&dyn TableLike>) -> Result<Value> {
    let table = table.ok_or_else(|| Error::new("E102", "expected a table"))?;
    let entry = |(k, v): (&str, &Item)| match v {
        Item::Value(v) => with_unit(what, known, k, v),
        _ => Err(Error::new("E102", format!("`{k}`: expected a value, found a table"))),
    };
    table.iter().map(entry).collect::<Result<_>>().map(Value::Map)
}

/// Converts an entry of a table whose keys include units.
fn with_unit(what: &str, known: &[(&str, &str)], written: &str, v: &toml_edit::Value) -> Result<(Value, Value)> {
    let found = known.iter().find_map(|(k, u)| units::factor(written, k, Some(u)).map(|f| (*k, f)));
    let Some((key, factor)) = found else {
        let known: Vec<String> = known.iter().map(|(k, u)| units::key_with_unit(k, Some(u))).collect();
        return Err(Error::new("E101", format!("{what} has no key `{written}`"))
            .expected(known.join(", "))
            .nearest(written, known.iter().map(String::as_str)));
    };
    match v {
        toml_edit::Value::InlineTable(of) if key == "texture" => {
            Ok((Value::text(key), table("a texture", TEXTURE_KEYS, Some(of))?))
        }
        _ => Ok((Value::text(key), value(v, factor)?)),
    }
}

/// Checks a value against its declaration; the error for a misspelt choice suggests the nearest one.
pub fn check(declared: &ParameterSpec, written: &str, value: Value) -> Result<Value> {
    let text = match &value {
        Value::Text(t) => String::from_utf8_lossy(t).into_owned(),
        _ => String::new(),
    };
    check_value(declared, value).map_err(|e| {
        Error::new("E102", format!("`{written}`: {e}")).nearest(&text, declared.choices.iter().map(String::as_str))
    })
}

/// Reads a parameter of `owner`: returns the key without its unit, and the checked value.
pub fn param(declared: &[ParameterSpec], owner: &str, written: &str, item: &Item) -> Result<(String, Value)> {
    let declared: Vec<(ParameterSpec, ())> = declared.iter().map(|p| (p.clone(), ())).collect();
    let (entry, factor) = find(written, &declared, owner)?;
    let value = check(&entry.0, written, to_value(item, factor)?)?;
    Ok((entry.0.key.clone(), value))
}

/// Finds the declaration that a written key refers to, and the factor of its unit.
pub fn find<'d, T>(
    written: &str,
    declared: &'d [(ParameterSpec, T)],
    owner: &str,
) -> Result<(&'d (ParameterSpec, T), f64)> {
    for entry in declared {
        if let Some(factor) = units::factor(written, &entry.0.key, entry.0.unit.as_deref()) {
            return Ok((entry, factor));
        }
    }
    for (d, _) in declared {
        if units::wrong_unit(written, &d.key, d.unit.as_deref()) {
            let right = units::key_with_unit(&d.key, d.unit.as_deref());
            let what = if written == d.key { "lacks its unit" } else { "has the wrong unit" };
            return Err(Error::new("E103", format!("`{written}` {what}"))
                .expected(match &d.unit {
                    Some(unit) => format!("`{right}`: {} is in {}", d.key, unit.replace('|', " or ")),
                    None => format!("`{right}`, which has no unit"),
                })
                .help(format!("write `{right}`")));
        }
    }
    let known: Vec<String> = declared
        .iter()
        .filter(|(d, _)| d.flags & TATU_PARAM_READ_ONLY == 0)
        .map(|(d, _)| units::key_with_unit(&d.key, d.unit.as_deref()))
        .collect();
    let error = Error::new("E101", format!("unknown key `{written}` for {owner}")).expected(known.join(", "));
    // Without its unit, a misspelt key is closer to the intended one.
    let stem = written.rsplit_once('_').map_or(written, |(s, _)| s);
    let near = nearest(written, known.iter().map(String::as_str)).map(str::to_owned).or_else(|| {
        nearest(stem, declared.iter().map(|(d, _)| d.key.as_str()))
            .and_then(|k| declared.iter().find(|(d, _)| d.key == k))
            .map(|(d, _)| units::key_with_unit(&d.key, d.unit.as_deref()))
    });
    Err(match near {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error,
    })
}
