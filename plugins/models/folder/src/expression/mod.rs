//! Arithmetic over parameters: `=height / 2`, `=if(preset == 'wide', 0.4, 0.3)`, `=color[0]`.
//!
//! - `value`: values of expressions; `parse`: converts source text to a tree; `eval`: evaluates a tree; `functions`:
//!   the functions that expressions can call; `room`: limits the size of results.

mod eval;
mod functions;
mod parse;
mod room;
mod value;

pub use eval::Names;
pub use functions::RESERVED;
pub use room::Room;
pub use value::Value;

use crate::wrong::Result;

/// Evaluates an expression. `text` does not include the leading `=`.
pub fn evaluate(text: &str, names: &Names, room: &Room) -> Result<Value> {
    eval::evaluated(&parse::parse(text)?, names, room)
}

#[cfg(test)]
mod tests;
