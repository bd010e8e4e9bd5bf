//! Tables on standard output.

use serde_json::Value;
use tatu_core::plugins::texts::label;

use crate::report;

/// Maximum length of a cell, in characters, because a long cell would widen its column in all rows. `--json` prints the
/// whole text.
const MAX_CELL_CHARS: usize = 400;

/// Prints rows with columns as wide as their widest cell.
pub fn table(rows: &[Value], columns: &[&str]) {
    let cell = |row: &Value, column: &str| cell(&row[column]);
    let widths: Vec<usize> = columns
        .iter()
        .map(|c| rows.iter().map(|r| cell(r, c).chars().count()).chain([c.len()]).max().unwrap_or(0))
        .collect();
    let line = |cells: Vec<String>| {
        let padded: Vec<_> = cells.iter().zip(&widths).map(|(c, w)| format!("{c:<w$}")).collect();
        report::out!("{}", padded.join("  ").trim_end());
    };
    line(columns.iter().map(|c| c.to_uppercase()).collect());
    rows.iter().for_each(|r| line(columns.iter().map(|c| cell(r, c)).collect()));
}

/// Returns a value as one line without control characters, because names and texts may come from untrusted files.
fn cell(value: &Value) -> String {
    let text = match value {
        Value::String(s) => s.clone(),
        Value::Array(a) => a.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(", "),
        Value::Null => String::new(),
        other => other.to_string(),
    };
    let line = label(text.as_bytes());
    match line.char_indices().nth(MAX_CELL_CHARS) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_cells_are_truncated_and_escaped() {
        assert_eq!(cell(&"a\u{1b}[31m\nb".into()), "a\\u{1b}[31m\\nb");
        assert_eq!(cell(&"\u{e4}".repeat(70_000).into()), "\u{e4}".repeat(MAX_CELL_CHARS) + "...");
        assert_eq!(cell(&"x".repeat(MAX_CELL_CHARS).into()), "x".repeat(MAX_CELL_CHARS));
    }
}
