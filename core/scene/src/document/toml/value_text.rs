//! Formatting of values for scene files. Numbers are as short as possible without changing their bits when they are
//! read back.

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_plugin_api::safe::Value;
use tatu_plugins::units;

use super::keys::PART_KEYS;
use crate::{drive::KEYS as DRIVE_KEYS, property_table::FileForm, texture::KEYS as TEXTURE_KEYS};

/// Formats a key and its value as a line of a table, such as `limits_deg = [-90.0, 90.0]`. Returns `None` if files
/// cannot express the value.
pub fn line(key: &str, unit: Option<&str>, value: &Value) -> Option<String> {
    let units = units::suffixes(unit.unwrap_or(""));
    let written = |(suffix, factor): &(&str, f64)| Some(format!("{key}{suffix} = {}", text(value, *factor)?));
    units.iter().find_map(written)
}

/// Returns a string in quotes, as TOML.
pub fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}

/// Returns a TOML key, in quotes if necessary.
fn key(text: &str) -> String {
    toml_edit::Key::new(text).to_string()
}

/// Formats a value, with numbers divided by the factor of their unit. Returns `None` if a number would not be read back
/// exactly, or if files cannot express this type.
pub fn text(value: &Value, factor: f64) -> Option<String> {
    let list = |items: Option<Vec<String>>| Some(format!("[{}]", items?.join(", ")));
    Some(match value {
        Value::Bool(b) => b.to_string(),
        Value::Int(i) if factor == 1.0 => i.to_string(),
        Value::Int(i) => number(divided(*i as f64, factor)?),
        Value::Float(x) => number(divided(*x, factor)?),
        Value::Floats(v) => list(v.iter().map(|x| divided(*x, factor).map(number)).collect())?,
        Value::Ints(v) => list(v.iter().map(|i| Some(i.to_string())).collect())?,
        Value::Text(t) => quoted(std::str::from_utf8(t).ok()?),
        Value::List(items) if items.iter().any(|i| matches!(i, Value::Map(_))) => {
            let items: Option<Vec<String>> =
                items.iter().map(|i| Some(format!("    {},\n", text(i, factor)?))).collect();
            format!("[\n{}]", items?.concat())
        }
        Value::List(items) => list(items.iter().map(|i| text(i, factor)).collect())?,
        Value::Map(entries) => table(entries)?,
        _ => return None,
    })
}

/// Formats a part of a compound, whose keys include units, or a table with the key `name`, whose keys do not.
fn table(entries: &[(Value, Value)]) -> Option<String> {
    let named = entries.iter().any(|(k, _)| *k == Value::text("name"));
    table_with_units(entries, if named { &[] } else { PART_KEYS })
}

/// Formats a property as a line of a table, in its form in scene files. Returns `None` if files cannot express the
/// value.
pub fn line_in_form(form: FileForm, key: &str, unit: Option<&str>, value: &Value) -> Option<String> {
    let text = match (form, value) {
        (FileForm::Data, _) => custom_data_text(value)?,
        (FileForm::Drive, Value::Map(entries)) => table_with_units(entries, DRIVE_KEYS)?,
        (FileForm::Texture, Value::Map(entries)) => table_with_units(entries, TEXTURE_KEYS)?,
        _ => return line(key, unit, value),
    };
    Some(format!("{key} = {text}"))
}

/// Formats a table whose keys include units.
fn table_with_units(entries: &[(Value, Value)], known: &[(&str, &str)]) -> Option<String> {
    let entry = |(k, v): &(Value, Value)| {
        let Value::Text(k) = k else { return None };
        let k = std::str::from_utf8(k).ok()?;
        if k == "texture" {
            return line_in_form(FileForm::Texture, k, None, v);
        }
        line(k, known.iter().find(|(known, _)| *known == k).map(|(_, unit)| *unit), v)
    };
    let there = entries.iter().filter(|(_, v)| *v != Value::Nil);
    Some(format!("{{ {} }}", there.map(entry).collect::<Option<Vec<_>>>()?.join(", ")))
}

/// Formats custom data as an inline table, keyed by tag. Returns `None` if the value is not a map, or a tag is not
/// text.
pub fn custom_data_text(value: &Value) -> Option<String> {
    let Value::Map(entries) = value else { return None };
    let entry = |(tag, data): &(Value, Value)| match (tag, data) {
        (Value::Text(tag) | Value::Bytes(tag), Value::Text(data) | Value::Bytes(data)) => {
            let data = match std::str::from_utf8(data) {
                Ok(text) => quoted(text),
                Err(_) => format!("{{ base64 = {} }}", quoted(&STANDARD.encode(data))),
            };
            Some(format!("{} = {data}", key(std::str::from_utf8(tag).ok()?)))
        }
        _ => None,
    };
    Some(format!("{{ {} }}", entries.iter().map(entry).collect::<Option<Vec<_>>>()?.join(", ")))
}

/// Formats a number for TOML, with as many digits as are required to read back the same value.
fn number(x: f64) -> String {
    if x.is_nan() { "nan".into() } else { format!("{x:?}") }
}

/// Returns a number, short if possible, that yields exactly `x` when multiplied by `factor`; `None` if none is found.
pub fn divided(x: f64, factor: f64) -> Option<f64> {
    if factor == 1.0 {
        return Some(x);
    }
    let near = x / factor;
    let short = format!("{near:.11e}").parse().unwrap_or(near);
    [short, near, near.next_up(), near.next_down()].into_iter().find(|n| (n * factor).to_bits() == x.to_bits())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn numbers_are_formatted_in_their_shortest_form() {
        assert_eq!(line("a", Some("rad"), &Value::Float(PI / 2.0)).unwrap(), "a_deg = 90.0");
        assert_eq!(line("a", Some("rad"), &Value::Floats(vec![f64::INFINITY, 0.0])).unwrap(), "a_deg = [inf, 0.0]");
        assert_eq!(line("b", Some("m"), &Value::Float(1e-7)).unwrap(), "b_m = 1e-7");
        assert_eq!(line("c", None, &Value::text("a \"b\"")).unwrap(), "c = 'a \"b\"'");
    }

    #[test]
    fn parts_have_units_and_custom_data_round_trips_any_bytes() {
        let part = Value::Map(vec![(Value::text("size"), Value::Floats(vec![1.0, 2.0, 3.0]))]);
        assert_eq!(
            line("parts", None, &Value::List(vec![part])).unwrap(),
            "parts = [\n    { size_m = [1.0, 2.0, 3.0] },\n]"
        );
        let data = Value::Map(vec![
            (Value::text("\u{1}tag"), Value::text("text")),
            (Value::text("b"), Value::Text(vec![0xFF, 0])),
        ]);
        let text = custom_data_text(&data).unwrap();
        let read: toml_edit::DocumentMut = format!("data = {text}").parse().unwrap();
        assert_eq!(super::super::keys::to_map(&read["data"]).unwrap(), data);
    }

    proptest! {
        #[test]
        fn every_angle_round_trips(x in -10.0..10.0) {
            let written = line("a", Some("rad"), &Value::Float(x)).unwrap();
            let (key, number) = written.split_once(" = ").unwrap();
            let number: f64 = number.parse().unwrap();
            let factor = units::factor(key, "a", Some("rad")).unwrap();
            prop_assert_eq!((number * factor).to_bits(), x.to_bits());
        }
    }
}
