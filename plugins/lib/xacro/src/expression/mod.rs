//! Expressions: a part of Python's.
//!
//! - `lexer`: text to tokens;
//! - `syntax`: the tree of an expression;
//! - `parser`: tokens to the tree;
//! - `context`: what an expression needs from the file that it is in;
//! - `operators`: arithmetic, comparison, indexing;
//! - `format`: `format()` and `%`;
//! - `math`: the functions of `math`;
//! - `methods`: methods of texts, lists and dictionaries;
//! - `builtins`: functions of Python that need only their arguments;
//! - `functions`: the other functions, and the names of all;
//! - `evaluation`: the value of a tree.

mod builtins;
pub(crate) mod context;
pub(crate) mod evaluation;
mod format;
mod functions;
pub(crate) mod lexer;
mod math;
mod methods;
mod operators;
mod parser;
mod syntax;
#[cfg(test)]
mod tests;

pub(crate) use functions::is_global;
