//! The card of a model: measured behaviour, compared with the model's data sheet.
//!
//! A folder `models/NAME` may contain `card.toml`, which is read here, and `card.lua` with one function for each
//! measure. `grade` derives the grade of the model; `measure.lua` contains helper functions for measures.

pub mod grade;

use std::{
    ops::Range,
    path::{Path, PathBuf},
};

use tatu_core::errors::{Error, SourceLocation};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};
use toml_edit::{Document, DocumentMut, Item, Table, value};

/// Default tolerance of a measure, relative to the expected value.
const DEFAULT_TOLERANCE: f64 = 0.02;
/// Keys of a card; those of a measure are in `MEASURE_KEYS`.
const CARD_KEYS: &[&str] = &["format", "not_shown", "params", "scene", "measure"];
const MEASURE_KEYS: &[&str] =
    &["name", "text", "unit", "expected", "source", "tolerance", "within", "params", "scene", "seconds", "measured"];

/// The contents of a model's `card.toml`.
pub struct Card {
    pub file: PathBuf,
    /// Properties of the device that the model does not simulate.
    pub not_shown: Vec<String>,
    pub measures: Vec<CardMeasure>,
}

/// A quantity of the model's behaviour, which a function of `card.lua` measures.
pub struct CardMeasure {
    /// The function's name.
    pub name: String,
    pub text: String,
    pub unit: String,
    /// Value according to the data sheet, in `unit`.
    pub expected: f64,
    pub source: String,
    /// Maximum absolute deviation from `expected`, in `unit`.
    pub allowed: f64,
    /// Value measured when the card was last written, in `unit`.
    pub measured: Option<f64>,
    /// Parameters of the model and settings of the scene, for the world in which the quantity is measured.
    pub params: Table,
    pub scene: Table,
    /// Simulation time by which the function must have returned, s.
    pub seconds: f64,
}

impl CardMeasure {
    /// Returns whether a value is within the tolerance.
    pub fn is_within_tolerance(&self, value: f64) -> bool {
        (value - self.expected).abs() <= self.allowed
    }

    /// Returns whether the card's recorded value agrees with a new one, within a quarter of the tolerance.
    pub fn is_recorded(&self, value: f64) -> bool {
        self.measured.is_some_and(|m| (m - value).abs() <= 0.25 * self.allowed)
    }
}

/// Reads the card beside a model's file, if there is one.
pub fn read(model: &Path) -> Result<Option<Card>, Error> {
    let file = model.with_file_name("card.toml");
    if !file.exists() {
        return Ok(None);
    }
    let text = read_plain_text(&file, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("{} cannot be read: {e}", file.display())))?;
    let reader = CardReader { file: &file, text: &text };
    reader.card().map(Some)
}

/// Writes measured values into the card's file, in the order of its measures; `None` leaves a recorded value unchanged.
pub fn write(card: &Card, values: &[Option<f64>]) -> Result<(), Error> {
    let fail = |why: String| Error::new("E105", format!("{} cannot be written: {why}", card.file.display()));
    let text = read_plain_text(&card.file, MAX_FILE_BYTES).map_err(|e| fail(e.to_string()))?;
    let mut doc: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
        let reader = CardReader { file: &card.file, text: &text };
        reader.fail("E105", format!("{} cannot be written: {}", card.file.display(), e.message()), e.span())
    })?;
    let tables = doc.get_mut("measure").and_then(Item::as_array_of_tables_mut);
    for (table, measured) in tables.into_iter().flat_map(|t| t.iter_mut()).zip(values) {
        if let Some(x) = measured {
            table["measured"] = value(rounded(*x));
        }
    }
    tatu_core::state::write_atomically(&card.file, doc.to_string().as_bytes()).map_err(|e| fail(e.to_string()))
}

/// Rounds to five significant digits.
pub fn rounded(x: f64) -> f64 {
    format!("{x:.4e}").parse().unwrap_or(x)
}

struct CardReader<'a> {
    file: &'a Path,
    text: &'a str,
}

impl CardReader<'_> {
    fn card(&self) -> Result<Card, Error> {
        let doc = Document::parse(self.text)
            .map_err(|e| self.fail("E100", format!("not a TOML file: {}", e.message()), e.span()))?;
        self.reject_unknown_keys(doc.as_table(), CARD_KEYS, "a card")?;
        if doc.get("format").and_then(Item::as_integer) != Some(1) {
            let error = self.fail("E102", "`format` is not 1".into(), doc.get("format").and_then(Item::span));
            return Err(error.help("write `format = 1` in the first line of the card"));
        }
        let (params, scene) = (self.table(doc.as_table(), "params")?, self.table(doc.as_table(), "scene")?);
        let mut measures = Vec::new();
        match doc.get("measure").map(|m| (m.as_array_of_tables(), m.span())) {
            None => {}
            Some((Some(all), _)) => {
                for table in all {
                    measures.push(self.measure(table, &params, &scene)?);
                }
            }
            Some((None, span)) => {
                return Err(self.fail(
                    "E102",
                    "`measure` is not an array of tables: write [[measure]] above each measure".into(),
                    span,
                ));
            }
        }
        if measures.is_empty() {
            return Err(self.fail("E104", "the card has no [[measure]]".into(), None));
        }
        let not_shown = match doc.get("not_shown") {
            None => Vec::new(),
            Some(item) => {
                let all = item.as_array().and_then(|a| a.iter().map(|v| v.as_str().map(str::to_owned)).collect());
                all.ok_or_else(|| self.fail("E102", "`not_shown` is not a list of strings".into(), item.span()))?
            }
        };
        Ok(Card { file: self.file.to_owned(), not_shown, measures })
    }

    fn measure(&self, table: &Table, params: &Table, scene: &Table) -> Result<CardMeasure, Error> {
        self.reject_unknown_keys(table, MEASURE_KEYS, "a measure")?;
        let lacks = |key: &str| self.fail("E104", format!("this measure has no `{key}`"), table.span());
        let text = |key: &str| -> Result<String, Error> {
            let item = table.get(key).ok_or_else(|| lacks(key))?;
            let text =
                item.as_str().ok_or_else(|| self.fail("E102", format!("`{key}` is not a string"), item.span()))?;
            Ok(text.to_owned())
        };
        let number = |key: &str| -> Result<Option<f64>, Error> {
            let Some(item) = table.get(key) else { return Ok(None) };
            let number = item.as_float().or_else(|| item.as_integer().map(|i| i as f64)).filter(|x| x.is_finite());
            let wrong = || self.fail("E102", format!("`{key}` is not a finite number"), item.span());
            number.map(Some).ok_or_else(wrong)
        };
        for key in ["tolerance", "within", "seconds"] {
            if number(key)?.is_some_and(|x| x <= 0.0) {
                let span = table.get(key).and_then(Item::span);
                return Err(self.fail("E102", format!("`{key}` is not greater than 0"), span));
            }
        }
        let name = text("name")?;
        let is_name = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if !is_name {
            let span = table.get("name").and_then(Item::span);
            let error = self.fail("E102", format!("`name`: `{name}` is not a valid function name"), span);
            return Err(error.expected("letters, digits and `_`, not beginning with a digit"));
        }
        let expected = number("expected")?.ok_or_else(|| lacks("expected"))?;
        let relative = number("tolerance")?.unwrap_or(DEFAULT_TOLERANCE) * expected.abs();
        let allowed = number("within")?.unwrap_or(relative);
        if allowed == 0.0 {
            let text = format!("the tolerance of `{name}` is 0");
            let error = self.fail("E104", text, table.span());
            return Err(error.help("if `expected` is 0, set `within`, the maximum absolute deviation"));
        }
        let or = |key: &str, all: &Table| -> Result<Table, Error> {
            if table.contains_key(key) { self.table(table, key) } else { Ok(all.clone()) }
        };
        Ok(CardMeasure {
            text: text("text")?,
            unit: text("unit")?,
            source: text("source")?,
            measured: number("measured")?,
            params: or("params", params)?,
            scene: or("scene", scene)?,
            seconds: number("seconds")?.unwrap_or(600.0),
            name,
            expected,
            allowed,
        })
    }

    /// Returns the table with this key, or an empty table if the key is missing.
    fn table(&self, of: &Table, key: &str) -> Result<Table, Error> {
        let Some(item) = of.get(key) else { return Ok(Table::new()) };
        let table = item.clone().into_table();
        table.map_err(|item| self.fail("E102", format!("`{key}` is not a table"), item.span()))
    }

    fn reject_unknown_keys(&self, table: &Table, known: &[&str], what: &str) -> Result<(), Error> {
        let Some((key, _)) = table.iter().find(|(key, _)| !known.contains(key)) else { return Ok(()) };
        let span = table.key(key).and_then(toml_edit::Key::span);
        let error = self.fail("E101", format!("unknown key `{key}` of {what}"), span);
        Err(error.expected(known.join(", ")).nearest(key, known.iter().copied()))
    }

    fn fail(&self, code: &'static str, text: String, span: Option<Range<usize>>) -> Error {
        let error = Error::new(code, text);
        let Some(span) = span.filter(|s| s.end <= self.text.len()) else {
            return error.at(Some(SourceLocation { file: self.file.to_owned(), ..SourceLocation::default() }));
        };
        let before = &self.text.as_bytes()[..span.start];
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        let column = 1 + before.iter().rev().take_while(|b| **b != b'\n').count();
        error.at(Some(SourceLocation { file: self.file.to_owned(), line, column, span }))
    }
}
