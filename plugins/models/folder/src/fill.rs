//! Replaces the expressions in a model's source text with their results, without changing line numbers.

use std::ops::Range;

use toml_edit::{Document, Item, Value as Toml};

use crate::{
    error::{ModelError, Result},
    expression::{NamedValues, SizeBudget, evaluate},
};

/// Returns the source text of a document reduced to the ranges in `kept`, which must be in ascending order. Lines
/// before and between them become empty, which preserves line numbers. Expressions in these ranges are replaced with
/// their results. `dropped` contains the ranges of keys that only this plugin reads; they are removed.
pub fn fill_expressions(
    doc: &Document<String>,
    kept: &[Range<usize>],
    dropped: &[Range<usize>],
    names: &NamedValues,
) -> Result<String> {
    let text = doc.raw();
    let mut found: Vec<(Range<usize>, &str)> = Vec::new();
    doc.iter().for_each(|(_, item)| expressions(item, &mut found));
    let inside =
        |span: &Range<usize>, all: &[Range<usize>]| all.iter().any(|r| r.start <= span.start && span.end <= r.end);
    let mut changes: Vec<(Range<usize>, String)> = Vec::new();
    let room = SizeBudget::default();
    for (span, written) in found {
        if !inside(&span, kept) || inside(&span, dropped) {
            continue;
        }
        let value = value_toml(written, names, &room).map_err(|wrong| wrong.at(Some(span.clone())))?;
        if text[span.clone()].contains('\n') {
            return Err(ModelError::new("an expression must be on one line").at(Some(span)));
        }
        changes.push((span, value));
    }
    changes.extend(dropped.iter().map(|span| (span.clone(), String::new())));
    changes.sort_by_key(|(span, _)| span.start);
    let mut out = String::with_capacity(text.len());
    let mut changes = changes.into_iter().peekable();
    let mut at = 0;
    for part in kept {
        out.extend(text[at..part.start].matches('\n'));
        at = part.start;
        while let Some((span, value)) = changes.next_if(|(span, _)| span.end <= part.end) {
            if span.start >= at {
                out += &text[at..span.start];
                out += &value;
                at = span.end;
            }
        }
        out += &text[at..part.end];
        at = part.end;
    }
    Ok(out)
}

/// Evaluates an expression that starts with `=`, and formats the result as TOML. `==` stands for a literal `=`.
fn value_toml(written: &str, names: &NamedValues, room: &SizeBudget) -> Result<String> {
    match written.strip_prefix("==") {
        Some(rest) => crate::expression::ExpressionValue::Text(format!("={rest}")).to_toml(),
        None => evaluate(written.trim_start_matches('='), names, room)?.to_toml(),
    }
}

/// Collects the expressions, which are the strings that start with `=`, and their ranges.
fn expressions<'d>(item: &'d Item, out: &mut Vec<(Range<usize>, &'d str)>) {
    match item {
        Item::None => {}
        Item::Value(value) => value_expressions(value, out),
        Item::Table(table) => table.iter().for_each(|(_, item)| expressions(item, out)),
        Item::ArrayOfTables(all) => all.iter().flat_map(|t| t.iter()).for_each(|(_, item)| expressions(item, out)),
    }
}

fn value_expressions<'d>(value: &'d Toml, out: &mut Vec<(Range<usize>, &'d str)>) {
    match value {
        Toml::String(s) if s.value().starts_with('=') => {
            out.extend(value.span().map(|span| (span, s.value().as_str())))
        }
        Toml::Array(all) => all.iter().for_each(|v| value_expressions(v, out)),
        Toml::InlineTable(table) => table.iter().for_each(|(_, v)| value_expressions(v, out)),
        _ => {}
    }
}
