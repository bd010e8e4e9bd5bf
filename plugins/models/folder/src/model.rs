//! The table `[model]`.

use std::ops::Range;

use tatu_plugin_api::safe::{ModelInfo, ModelNumber, ModelSlot, Param};
use toml_edit::{Document, Item, TableLike};

use crate::{
    error::{ModelError, Result},
    expression::{ExpressionValue, NamedValues, SizeBudget, value_of},
    params::{self, ComputedDefault},
    sections::{self, ModelEntry, TextSection},
    table::{
        check_keys, check_name, key_range, named_tables, optional_string, required_string, string_list, sub_table,
    },
};

/// A parsed `model.toml`: its text, its tables and entries, and the parameters and constants that it declares.
pub struct ParsedModel {
    /// The contents of `model.toml`.
    pub text: String,
    /// The contents of `model.toml` as a document, which keeps the ranges of its items.
    pub doc: Document<String>,
    /// The tables of the file with their ranges, in the order of the file.
    pub sections: Vec<TextSection>,
    /// The objects and imports, in the order of the file.
    pub entries: Vec<ModelEntry>,
    /// Index of the base in `entries`.
    pub base: usize,
    /// Keys of the parameters, and their defaults if these are expressions.
    pub params: Vec<(String, Option<ComputedDefault>)>,
    /// Names and values of the constants, and the ranges of the values in the text. A value can be an expression.
    pub numbers: Vec<(String, ExpressionValue, Range<usize>)>,
}

const MODEL_KEYS: &[&str] = &["text", "category", "licence", "mount", "base", "params", "numbers", "slots"];

/// Reads the text of a model; returns `None` if it has no table `[model]`.
pub fn read(text: &str) -> Result<Option<(ModelInfo, ParsedModel)>> {
    let doc = Document::parse(text.to_owned()).map_err(|e| toml_error(text, &e))?;
    let Some(table) = doc.get("model").and_then(Item::as_table_like) else { return Ok(None) };
    check_keys(table, MODEL_KEYS, "a model")?;
    let (sections, entries) = sections::divide(&doc)?;
    let (params, computed): (Vec<Param>, Vec<_>) = params::read(sub_table(table, "params")?)?.into_iter().unzip();
    let mut numbers = numbers(table, &params)?;
    let keys: Vec<&str> = params.iter().map(Param::key).collect();
    compute_for_defaults(&mut numbers, table, keys.into_iter().zip(&computed));
    let info = ModelInfo {
        text: required_string(table, "text", "a model")?,
        category: optional_string(table, "category")?,
        licence: optional_string(table, "licence")?,
        mounts: string_list(table, "mount")?,
        slots: slots(table, &entries)?,
        numbers: numbers.iter().map(|(n, ..)| n.clone()).collect(),
        params,
    };
    let model = ParsedModel {
        text: text.to_owned(),
        base: base(table, &entries)?,
        params: info.params.iter().map(|p| p.key().to_owned()).zip(computed).collect(),
        numbers: numbers.into_iter().map(|(n, value, span)| (n.name, value, span)).collect(),
        sections,
        entries,
        doc,
    };
    Ok(Some((info, model)))
}

/// Returns the error for a text that is not TOML.
fn toml_error(text: &str, e: &toml_edit::TomlError) -> ModelError {
    // Some errors, such as an exceeded recursion limit, have no position. Report them at the most deeply nested
    // bracket.
    let wrong =
        ModelError::new(format!("not a TOML file: {}", e.message())).at(e.span().or_else(|| deepest_bracket(text)));
    match text.contains("[[model]]") {
        true => wrong.help("in a file with `[model]`, models are placed by `[[object]]` with `model = ...`"),
        false => wrong,
    }
}

/// Returns the position of the most deeply nested bracket.
fn deepest_bracket(text: &str) -> Option<Range<usize>> {
    let (mut depth, mut most) = (0_usize, (0, None));
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'[' | b'{' => depth += 1,
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > most.0 {
            most = (depth, Some(at..at + 1));
        }
    }
    most.1
}

/// Reads the constants in `[model.numbers]`, whose names must differ from those of the parameters.
fn numbers(model: &dyn TableLike, params: &[Param]) -> Result<Vec<(ModelNumber, ExpressionValue, Range<usize>)>> {
    let mut out = Vec::new();
    for (name, table, place) in named_tables(sub_table(model, "numbers")?, "a number")? {
        let what = format!("the number `{name}`");
        check_name(name).map_err(|e| e.at(place.clone()))?;
        if params.iter().any(|p| p.key() == name) {
            return Err(ModelError::new(format!("`{name}` is both a parameter and a number")).at(place));
        }
        check_keys(table, &["value", "unit", "source"], &what)?;
        let span = key_range(table, Some("value"));
        let value = table.get("value").and_then(Item::as_value).and_then(ExpressionValue::from_toml);
        let value = value.ok_or_else(|| {
            let wrong = ModelError::new(format!("{what} has no value"))
                .help("write a number, `value = 0.0975`, or an expression, `value = \"=length / 2\"`");
            wrong.at(span.clone())
        })?;
        let source = required_string(table, "source", &what)
            .map_err(|e| e.help("write `source = \"DOCUMENT, page N\"`, or `\"estimate: REASONING\"`"))?;
        let number = ModelNumber {
            name: name.to_owned(),
            value: value.to_host(),
            unit: optional_string(table, "unit")?,
            source,
        };
        out.push((number, value, span.unwrap_or_default()));
    }
    Ok(out)
}

/// Replaces the declared values of the numbers, which may be expressions, by those that they have for the defaults of
/// the parameters. Errors are left to the building of the model, which reports them.
fn compute_for_defaults<'a>(
    numbers: &mut [(ModelNumber, ExpressionValue, Range<usize>)],
    model: &dyn TableLike,
    params: impl Iterator<Item = (&'a str, &'a Option<ComputedDefault>)>,
) {
    let (mut names, room) = (NamedValues::new(), SizeBudget::default());
    let declared = model.get("params").and_then(Item::as_table_like);
    for (key, computed) in params {
        let written = || declared?.get(key)?.as_table_like()?.get("default")?.as_value();
        let value = match computed {
            Some(computed) => computed.value(&names, &room).ok(),
            None => written().and_then(ExpressionValue::from_toml),
        };
        names.extend(value.map(|v| (key.to_owned(), v)));
    }
    for (number, value, _) in numbers {
        let Ok(value) = value_of(value, &names, &room) else { continue };
        number.value = value.to_host();
        names.insert(number.name.clone(), value);
    }
}

/// Reads `[model.slots]`. A slot must name an object of the file, unless the file places a model or import, whose
/// objects are unknown here, or repeats an entry.
fn slots(model: &dyn TableLike, entries: &[ModelEntry]) -> Result<Vec<ModelSlot>> {
    let mut out = Vec::new();
    let aliases = || entries.iter().filter_map(|e| e.alias.as_deref());
    for (alias, table, place) in named_tables(sub_table(model, "slots")?, "a slot")? {
        check_keys(table, &["mount", "text", "payload_kg"], &format!("the slot `{alias}`"))?;
        if aliases().all(|a| a != alias) && !entries.iter().any(|e| e.opaque || e.repeat.is_some()) {
            let wrong = ModelError::new(format!("the slot `{alias}` requires an object with this alias"));
            return Err(wrong.suggest(alias, aliases()).at(place));
        }
        let (mount, text) = (optional_string(table, "mount")?, optional_string(table, "text")?);
        out.push(ModelSlot { alias: alias.to_owned(), mount, text, payload: payload(table)? });
    }
    Ok(out)
}

/// Returns the maximum payload of a slot, kg, or 0 if the file does not declare it.
fn payload(table: &dyn TableLike) -> Result<f64> {
    let Some(item) = table.get("payload_kg") else { return Ok(0.0) };
    let number = item.as_float().or_else(|| item.as_integer().map(|i| i as f64)).filter(|x| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| {
        ModelError::new("`payload_kg`: expected a mass in kg, greater than 0").at(key_range(table, Some("payload_kg")))
    })
}

/// Returns the index of the base: the entry with the alias in `base`, or the first entry if there is no `base`.
fn base(model: &dyn TableLike, entries: &[ModelEntry]) -> Result<usize> {
    let alias = optional_string(model, "base")?;
    let span = key_range(model, Some("base"));
    if entries.is_empty() {
        return Err(ModelError::new("the model has no [[object]]").at(key_range(model, None)));
    }
    if alias.is_empty() {
        return Ok(0);
    }
    entries.iter().position(|e| e.alias.as_deref() == Some(&alias)).ok_or_else(|| {
        let aliases = entries.iter().filter_map(|e| e.alias.as_deref());
        ModelError::new(format!("`base`: no object has the alias `{alias}`")).suggest(&alias, aliases).at(span)
    })
}
