//! The tables of a model's file: their ranges, conditions and repetitions.

use std::ops::Range;

use toml_edit::{Document, Item, Table};

use crate::{
    error::{ModelError, Result},
    expression::ExpressionValue,
};

/// A part of the text that belongs to one table: from its header up to the next header.
#[derive(Debug, Clone)]
pub struct TextSection {
    pub span: Range<usize>,
    /// The top-level key, such as "object".
    pub root: String,
    /// The index of the `[[object]]` or `[[import]]` that contains the table, in the order of the file.
    pub entry: Option<usize>,
}

/// An `[[object]]` or `[[import]]`.
#[derive(Debug, Clone, Default)]
pub struct ModelEntry {
    /// The alias, if it is a string.
    pub alias: Option<String>,
    /// The value of `if`, the condition under which the entry is built, and the range of the value in the text.
    pub condition: Option<(ExpressionValue, Range<usize>)>,
    /// The value of `repeat`, the number of repetitions, and the range of the value in the text.
    pub repeat: Option<(ExpressionValue, Range<usize>)>,
    /// Ranges of the keys `if` and `repeat` with their values, which only this plugin reads.
    pub own_keys: Vec<Range<usize>>,
    /// Byte offset of the entry's header.
    pub start: usize,
    /// Whether the entry places a model or import, whose objects are not in this file.
    pub opaque: bool,
}

/// Divides a file into sections and entries.
pub fn divide(doc: &Document<String>) -> Result<(Vec<TextSection>, Vec<ModelEntry>)> {
    let mut starts: Vec<(usize, &str, Option<usize>)> = Vec::new();
    let mut entries: Vec<ModelEntry> = Vec::new();
    for key in ["object", "import"] {
        for table in doc.get(key).and_then(Item::as_array_of_tables).into_iter().flatten() {
            entries.push(entry(doc.raw(), key, table)?);
        }
    }
    entries.sort_by_key(|e| e.start);
    for (key, item) in doc.iter() {
        match item {
            Item::Table(table) => headers(table, (key, None), &mut starts),
            Item::ArrayOfTables(all) => {
                for table in all {
                    let at = table.span().map_or(0, |s| s.start);
                    let entry = entries.iter().position(|e| e.start == at);
                    headers(table, (key, entry.filter(|_| key == "object" || key == "import")), &mut starts);
                }
            }
            _ => {}
        }
    }
    starts.sort_unstable();
    let text = doc.raw();
    let ends = starts.iter().skip(1).map(|(at, ..)| *at).chain([text.len()]);
    let sections = starts.iter().zip(ends).map(|((start, root, entry), end)| TextSection {
        span: *start..end,
        root: (*root).to_owned(),
        entry: *entry,
    });
    Ok((sections.collect(), entries))
}

/// Collects the offsets of the headers of a table and of the tables within it.
fn headers<'d>(table: &'d Table, of: (&'d str, Option<usize>), out: &mut Vec<(usize, &'d str, Option<usize>)>) {
    // Implicit and dotted tables have no header, so they do not start a section.
    if !table.is_implicit() && !table.is_dotted() {
        out.extend(table.span().map(|span| (span.start, of.0, of.1)));
    }
    for (_, item) in table.iter() {
        match item {
            Item::Table(inner) => headers(inner, of, out),
            Item::ArrayOfTables(all) => all.iter().for_each(|inner| headers(inner, of, out)),
            _ => {}
        }
    }
}

fn entry(text: &str, kind: &str, table: &Table) -> Result<ModelEntry> {
    let mut out = ModelEntry { start: table.span().map_or(0, |s| s.start), ..ModelEntry::default() };
    out.alias = table.get("alias").and_then(Item::as_str).map(str::to_owned);
    out.opaque = kind == "import" || table.contains_key("model") || table.contains_key("file");
    for key in ["if", "repeat"] {
        let Some(item) = table.get(key) else { continue };
        let span = item.span().unwrap_or_default();
        let value = item.as_value().and_then(ExpressionValue::from_toml);
        let value = value.ok_or_else(|| {
            ModelError::new(format!("`{key}`: expected a value or an expression, not a table or a date"))
                .at(Some(span.clone()))
        })?;
        let from = table.key(key).and_then(|k| k.span()).map_or(span.start, |k| k.start);
        if text[from..span.end].contains('\n') {
            return Err(ModelError::new(format!("`{key}` must be on one line")).at(Some(span)));
        }
        out.own_keys.push(from..span.end);
        let slot = if key == "if" { &mut out.condition } else { &mut out.repeat };
        *slot = Some((value, span));
    }
    Ok(out)
}
