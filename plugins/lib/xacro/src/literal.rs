//! Values of properties and parameters that are written without an expression.

use crate::{
    error::{Result, fail},
    limits::Budget,
    value::{
        Value,
        number::{float_from_text, int_from_text},
        text::to_text,
    },
};

/// Reads a text as a number or a truth value if it is one; quotes around it are removed. Other values stay.
pub(crate) fn literal(value: Value) -> Value {
    let Value::Text(text) = &value else { return value };
    if text.len() >= 2 && text.starts_with('\'') && text.ends_with('\'') {
        return Value::text(&text[1..text.len() - 1]);
    }
    if text.contains('_') {
        return value;
    }
    if let Some(int) = int_from_text(text) {
        return Value::Int(int);
    }
    let digits = text.trim();
    if digits.strip_prefix(['+', '-']).unwrap_or(digits).bytes().all(|b| b.is_ascii_digit()) {
        // More than 64 bits, such as a serial number: it stays as it is written.
        return value;
    }
    match &**text {
        "true" | "True" => Value::Bool(true),
        "false" | "False" => Value::Bool(false),
        text => float_from_text(text).map_or(value.clone(), Value::Float),
    }
}

/// Reads a condition: true, false, an integer, or a value that is no text. `condition` is the text that it came from.
pub(crate) fn condition(value: &Value, condition: &str, budget: &mut Budget) -> Result<bool> {
    let Value::Text(text) = value else { return Ok(value.is_true()) };
    match &**text {
        "true" | "True" => Ok(true),
        "false" | "False" => Ok(false),
        text => match int_from_text(text) {
            Some(int) => Ok(int != 0),
            None => {
                let value = crate::error::excerpt(&to_text(value, budget)?);
                fail!("the condition `{condition}` is `{value}`: expected true, false, 0, 1 or an expression ${{...}}")
            }
        },
    }
}
