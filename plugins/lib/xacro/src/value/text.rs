//! Values as text, as `str()` and `repr()` of Python write them.

use std::fmt::Write;

use super::{Value, number::float_text};
use crate::{
    error::{Result, fail},
    limits::Budget,
};

/// Returns a value as it appears in the expanded file.
pub(crate) fn to_text(value: &Value, budget: &mut Budget) -> Result<std::rc::Rc<str>> {
    if let Value::Text(text) = value {
        return Ok(text.clone());
    }
    repr(value, budget).map(Into::into)
}

/// Returns a value as it appears in a list: texts in quotes.
pub(crate) fn repr(value: &Value, budget: &mut Budget) -> Result<String> {
    let mut out = String::new();
    write_value(&mut out, value, budget)?;
    Ok(out)
}

fn write_value(out: &mut String, value: &Value, budget: &mut Budget) -> Result<()> {
    if out.len() > budget.limits.text_bytes {
        budget.text(out.len())?;
    }
    budget.spend(1)?;
    match value {
        Value::None => out.push_str("None"),
        Value::Bool(true) => out.push_str("True"),
        Value::Bool(false) => out.push_str("False"),
        // Writing to a String cannot fail.
        Value::Int(i) => write!(out, "{i}").unwrap_or_default(),
        Value::Float(f) => out.push_str(&float_text(*f)),
        Value::Text(text) => {
            budget.text(text.len())?;
            write_quoted(out, text);
        }
        Value::List(list) => write_items(out, "[", &list.items().items, "]", budget)?,
        Value::Tuple(items) => {
            let close = if items.items.len() == 1 { ",)" } else { ")" };
            write_items(out, "(", &items.items, close, budget)?;
        }
        Value::Dict(dict) => {
            out.push('{');
            for (i, (key, value)) in dict.entries().pairs().enumerate() {
                out.push_str(if i > 0 { ", " } else { "" });
                write_value(out, key, budget)?;
                out.push_str(": ");
                write_value(out, value, budget)?;
            }
            out.push('}');
        }
        Value::Range(range) if range.step == 1 => {
            write!(out, "range({}, {})", range.start, range.stop).unwrap_or_default();
        }
        Value::Range(range) => {
            write!(out, "range({}, {}, {})", range.start, range.stop, range.step).unwrap_or_default();
        }
        Value::View(view) if view.kind.starts_with("dict_") => {
            out.push_str(view.kind);
            write_items(out, "([", &view.items.items, "])", budget)?;
        }
        Value::View(view) => fail!("what `{0}` returns has no text: write list({0}(...))", view.kind),
        Value::Function(name) => fail!("`{name}` is a function: it has no text, and is called as {name}(...)"),
        Value::Namespace(_) => fail!("a namespace has no text: name what is in it after a dot"),
    }
    Ok(())
}

fn write_items(out: &mut String, open: &str, items: &[Value], close: &str, budget: &mut Budget) -> Result<()> {
    out.push_str(open);
    for (i, item) in items.iter().enumerate() {
        out.push_str(if i > 0 { ", " } else { "" });
        write_value(out, item, budget)?;
    }
    out.push_str(close);
    Ok(())
}

fn write_quoted(out: &mut String, text: &str) {
    let quote = if text.contains('\'') && !text.contains('"') { '"' } else { '\'' };
    out.push(quote);
    for c in text.chars() {
        let code = u32::from(c);
        match c {
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            _ if c == quote => out.extend(['\\', c]),
            _ if is_printable(c) => out.push(c),
            _ if code < 0x100 => write!(out, "\\x{code:02x}").unwrap_or_default(),
            _ if code < 0x1_0000 => write!(out, "\\u{code:04x}").unwrap_or_default(),
            _ => write!(out, "\\U{code:08x}").unwrap_or_default(),
        }
    }
    out.push(quote);
}

/// Whether Python writes a character as it is; unassigned ones are taken for printable here.
fn is_printable(c: char) -> bool {
    let is_invisible = matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{e000}'..='\u{f8ff}');
    c == ' ' || !(c.is_control() || c.is_whitespace() || is_invisible)
}
