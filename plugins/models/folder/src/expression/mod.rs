//! Arithmetic over parameters: `=height / 2`, `=if(preset == 'wide', 0.4, 0.3)`, `=color[0]`.
//!
//! - `value`: values of expressions; `parse`: converts source text to a tree; `eval`: evaluates a tree; `functions`:
//!   the functions that expressions can call; `budget`: limits the size of results.

mod budget;
mod eval;
mod functions;
mod parse;
mod value;

pub use budget::SizeBudget;
pub use eval::NamedValues;
pub use functions::RESERVED;
pub use value::ExpressionValue;

use crate::error::Result;

/// Evaluates the expressions in a value, and returns all other values unchanged.
pub fn value_of(value: &ExpressionValue, names: &NamedValues, room: &SizeBudget) -> Result<ExpressionValue> {
    match value {
        ExpressionValue::Text(t) if t.starts_with('=') => evaluate(&t[1..], names, room),
        ExpressionValue::List(all) => {
            all.iter().map(|v| value_of(v, names, room)).collect::<Result<_>>().map(ExpressionValue::List)
        }
        value => Ok(value.clone()),
    }
}

/// Evaluates an expression. `text` does not include the leading `=`.
pub fn evaluate(text: &str, names: &NamedValues, room: &SizeBudget) -> Result<ExpressionValue> {
    eval::evaluate_tree(&parse::parse(text)?, names, room)
}

#[cfg(test)]
mod tests;
