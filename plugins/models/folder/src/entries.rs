//! The tables of a model's file, and the texts from which it is built.

use std::ops::Range;

use tatu_plugin_api::safe::Params;
use toml_edit::{Document, Item, Table};

use crate::{
    expression::{Names, Value, evaluate},
    fill::filled,
    model::Model,
    wrong::{Result, Wrong},
};

/// Most repetitions of an entry.
const MOST_REPEATS: f64 = 10_000.0;

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

/// Returns the texts in the scene format of a model with these parameters: first that of its base alone, then those of
/// everything below it, in the order of the file.
pub fn texts(model: &Model, params: &Params<'_>) -> Result<Vec<String>> {
    let mut names = Names::new();
    for key in &model.params {
        let given = params.get(key).and_then(|v| v.to_value()).map_err(|e| Wrong::new(e.text()))?;
        names.extend(Value::of_host(&given).map(|v| (key.clone(), v)));
    }
    for (name, value, span) in &model.numbers {
        let value = value_of(value, &names).map_err(|e| e.at(Some(span.clone())))?;
        names.insert(name.clone(), value);
    }
    let mut runs: Vec<(Vec<usize>, Option<f64>)> = vec![(vec![model.base], None)];
    for (i, entry) in model.entries.iter().enumerate() {
        let wanted = condition(entry, &names)?;
        if i == model.base {
            if !wanted || entry.repeat.is_some() {
                return Err(Wrong::new("the base of a model can be neither left out nor repeated").at(Some(at(entry))));
            }
            continue;
        }
        if !wanted {
            continue;
        }
        match repeats(entry, &names)? {
            Some(n) => runs.extend((0..n).map(|index| (vec![i], Some(index as f64)))),
            None => match runs.last_mut().filter(|(run, index)| index.is_none() && run[0] != model.base) {
                Some((run, _)) => run.push(i),
                None => runs.push((vec![i], None)),
            },
        }
    }
    let last = model.sections.iter().any(|s| s.root == "set").then_some((Vec::new(), None));
    runs.extend(last);
    let text = |(i, (run, index)): (usize, &(Vec<usize>, Option<f64>))| {
        let mut names = names.clone();
        names.extend(index.map(|x| ("index".to_owned(), Value::Number(x))));
        // Settings come before objects, and what `[set]` changes after them.
        let of_file = |root: &str| match root {
            "set" => run.is_empty(),
            "model" | "object" | "import" => false,
            _ => i == 0,
        };
        let kept = |s: &&Section| s.entry.map_or_else(|| of_file(&s.root), |e| run.contains(&e));
        let head = model.sections.first().map_or(model.text.len(), |s| s.span.start);
        let kept: Vec<_> = std::iter::once(0..head)
            .chain(model.sections.iter().filter(kept).map(|s| s.span.clone()))
            .collect();
        let own: Vec<_> = run.iter().flat_map(|e| model.entries[*e].own.clone()).collect();
        filled(&model.doc, &kept, &own, &names)
    };
    runs.iter().enumerate().map(text).collect()
}

fn at(entry: &Entry) -> Range<usize> {
    let written = entry.condition.as_ref().or(entry.repeat.as_ref());
    written.map_or(entry.start..entry.start, |(_, span)| span.clone())
}

/// Returns a value, or what its expression yields.
fn value_of(value: &Value, names: &Names) -> Result<Value> {
    match value {
        Value::Text(t) if t.starts_with('=') => evaluate(&t[1..], names),
        Value::List(all) => all.iter().map(|v| value_of(v, names)).collect::<Result<_>>().map(Value::List),
        value => Ok(value.clone()),
    }
}

fn condition(entry: &Entry, names: &Names) -> Result<bool> {
    let Some((value, span)) = &entry.condition else { return Ok(true) };
    match value_of(value, names).map_err(|e| e.at(Some(span.clone())))? {
        Value::Bool(b) => Ok(b),
        other => Err(Wrong::new(format!("`if`: expected true or false, found {}", other.describe()))
            .help("such as \"=with_arm\" or \"=preset == 'wide'\"")
            .at(Some(span.clone()))),
    }
}

fn repeats(entry: &Entry, names: &Names) -> Result<Option<usize>> {
    let Some((value, span)) = &entry.repeat else { return Ok(None) };
    match value_of(value, names).map_err(|e| e.at(Some(span.clone())))? {
        Value::Number(n) if (0.0..=MOST_REPEATS).contains(&n) && n == libm::floor(n) => Ok(Some(n as usize)),
        other => {
            let text = format!("`repeat`: expected a whole number from 0 to {MOST_REPEATS}, found {}", other.describe());
            Err(Wrong::new(text).help("`index` counts from 0").at(Some(span.clone())))
        }
    }
}
