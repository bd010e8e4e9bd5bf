//! The tables of a model's file: where each begins and ends, and what decides whether it is built.

use std::ops::Range;

use toml_edit::{Document, Item, Table};

use crate::{
    expression::Value,
    wrong::{Result, Wrong},
};

/// A part of the text that belongs to one table: its header, and what follows up to the next header.
#[derive(Debug, Clone)]
pub struct Section {
    pub span: Range<usize>,
    /// The key at the top of the file: "object".
    pub root: String,
    /// The number of the `[[object]]` or `[[import]]` that it belongs to, in the order of the file.
    pub entry: Option<usize>,
}

/// An `[[object]]` or `[[import]]`.
#[derive(Debug, Clone, Default)]
pub struct Entry {
    /// Its alias, if it is written as a text.
    pub alias: Option<String>,
    /// What decides whether it is built, and where that is written.
    pub condition: Option<(Value, Range<usize>)>,
    /// How often it is built, and where that is written.
    pub repeat: Option<(Value, Range<usize>)>,
    /// Keys with their values that only this plugin reads.
    pub own: Vec<Range<usize>>,
    /// Where it begins.
    pub start: usize,
    /// Whether it places something whose objects are not in this file.
    pub opaque: bool,
}

/// Divides a file into sections and entries.
pub fn divide(doc: &Document<String>) -> Result<(Vec<Section>, Vec<Entry>)> {
    let mut starts: Vec<(usize, &str, Option<usize>)> = Vec::new();
    let mut entries: Vec<Entry> = Vec::new();
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
    let sections = starts.iter().zip(ends).map(|((start, root, entry), end)| Section {
        span: *start..end,
        root: (*root).to_owned(),
        entry: *entry,
    });
    Ok((sections.collect(), entries))
}

/// Collects where the headers of a table and of those within it begin.
fn headers<'d>(table: &'d Table, of: (&'d str, Option<usize>), out: &mut Vec<(usize, &'d str, Option<usize>)>) {
    // Tables without a header of their own have no place.
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

fn entry(text: &str, kind: &str, table: &Table) -> Result<Entry> {
    let mut out = Entry { start: table.span().map_or(0, |s| s.start), ..Entry::default() };
    out.alias = table.get("alias").and_then(Item::as_str).map(str::to_owned);
    out.opaque = kind == "import" || table.contains_key("model") || table.contains_key("file");
    for key in ["if", "repeat"] {
        let Some(item) = table.get(key) else { continue };
        let span = item.span().unwrap_or_default();
        let value = item.as_value().and_then(Value::of_toml);
        let value = value.ok_or_else(|| Wrong::new(format!("`{key}` is not a value")).at(Some(span.clone())))?;
        let from = table.key(key).and_then(|k| k.span()).map_or(span.start, |k| k.start);
        if text[from..span.end].contains('\n') {
            return Err(Wrong::new(format!("`{key}` must stand on one line")).at(Some(span)));
        }
        out.own.push(from..span.end);
        let slot = if key == "if" { &mut out.condition } else { &mut out.repeat };
        *slot = Some((value, span));
    }
    Ok(out)
}
