//! Reads TOML tables, and reports missing and unknown keys.

use std::ops::Range;

use toml_edit::{Item, TableLike};

use crate::{
    error::{ModelError, Result},
    expression::RESERVED,
};

/// Returns the range of a key's value. Without a key, or if the key is missing, returns the range of the table's first
/// key.
pub fn key_range(table: &dyn TableLike, key: Option<&str>) -> Option<Range<usize>> {
    let of = |key: &str| table.get(key).and_then(Item::span).or_else(|| table.key(key).and_then(|k| k.span()));
    key.and_then(of).or_else(|| table.iter().find_map(|(k, _)| table.key(k).and_then(|k| k.span())))
}

/// Returns an error if the table has a key that is not in `known`.
pub fn check_keys(table: &dyn TableLike, known: &[&str], what: &str) -> Result {
    match table.iter().find(|(k, _)| !known.contains(k)) {
        None => Ok(()),
        Some((key, _)) => {
            let span = table.key(key).and_then(|k| k.span());
            Err(ModelError::new(format!("{what} has no key `{key}`")).suggest(key, known.iter().copied()).at(span))
        }
    }
}

/// Returns the string of a key, or an empty string if the key is missing. Returns an error if the value is not a
/// string.
pub fn optional_string(table: &dyn TableLike, key: &str) -> Result<String> {
    let Some(item) = table.get(key) else { return Ok(String::new()) };
    let text = item.as_str().map(str::to_owned);
    text.ok_or_else(|| ModelError::new(format!("`{key}`: expected a string")).at(key_range(table, Some(key))))
}

/// Returns the string of a key, or an error if the key is missing or the string is empty.
pub fn required_string(table: &dyn TableLike, key: &str, what: &str) -> Result<String> {
    match optional_string(table, key)? {
        text if text.is_empty() => Err(ModelError::new(format!("{what} has no `{key}`")).at(key_range(table, None))),
        text => Ok(text),
    }
}

/// Returns a list of strings. A single string becomes a list of one, and a missing key an empty list.
pub fn string_list(table: &dyn TableLike, key: &str) -> Result<Vec<String>> {
    let Some(list) = table.get(key).and_then(Item::as_array) else {
        return optional_string(table, key).map(|t| if t.is_empty() { Vec::new() } else { vec![t] });
    };
    let all: Option<Vec<String>> = list.iter().map(|v| v.as_str().map(str::to_owned)).collect();
    all.ok_or_else(|| ModelError::new(format!("`{key}`: expected a list of strings")).at(key_range(table, Some(key))))
}

/// Returns the table of a key, or `None` if the key is missing.
pub fn sub_table<'t>(table: &'t dyn TableLike, key: &str) -> Result<Option<&'t dyn TableLike>> {
    let Some(item) = table.get(key) else { return Ok(None) };
    let inner = item.as_table_like().map(Some);
    inner.ok_or_else(|| ModelError::new(format!("`{key}` is not a table")).at(key_range(table, Some(key))))
}

/// The name of a table, the table, and the range of the name.
pub type NamedTable<'t> = (&'t str, &'t dyn TableLike, Option<Range<usize>>);

/// Returns the named tables within a table; each entry must be a table.
pub fn named_tables<'t>(table: Option<&'t dyn TableLike>, what: &str) -> Result<Vec<NamedTable<'t>>> {
    let Some(table) = table else { return Ok(Vec::new()) };
    let entry = |(name, item): (&'t str, &'t Item)| match item.as_table_like() {
        Some(inner) => Ok((name, inner, table.key(name).and_then(|k| k.span()).or_else(|| key_range(inner, None)))),
        None => Err(ModelError::new(format!("{what} `{name}` is not a table")).at(key_range(table, Some(name)))),
    };
    table.iter().map(entry).collect()
}

/// Returns an error if a name cannot be used in expressions.
pub fn check_name(name: &str) -> Result {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.starts_with(|c: char| c.is_ascii_digit()) || !name.chars().all(fits) || name.is_empty() {
        let wrong = ModelError::new(format!("`{name}` is not a valid name for expressions"));
        return Err(wrong.help("use letters, digits and `_`, and start with a letter or `_`, such as wheel_radius"));
    }
    if RESERVED.contains(&name) {
        return Err(ModelError::new(format!("`{name}` is a reserved name in expressions")).help("choose another name"));
    }
    Ok(())
}
