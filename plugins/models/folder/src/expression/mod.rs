//! Arithmetic over parameters: `=height / 2`, `=if(preset == 'wide', 0.4, 0.3)`, `=color[0]`.
//!
//! - `value`: what an expression yields; `parse`: from text to a tree; `eval`: from a tree to a value; `functions`: the
//!   functions that expressions can call.

mod eval;
mod functions;
mod parse;
mod value;

pub use eval::Names;
pub use functions::RESERVED;
pub use value::Value;

use crate::wrong::Result;

/// Evaluates an expression, which is written without its `=`.
pub fn evaluate(text: &str, names: &Names) -> Result<Value> {
    eval::evaluated(&parse::parse(text)?, names)
}

#[cfg(test)]
mod tests;
