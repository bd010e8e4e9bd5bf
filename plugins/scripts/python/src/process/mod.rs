//! The interpreter's process.
//!
//! - `interpreter`: which program runs scripts;
//! - `child`: starts it, with limits, and ends it;
//! - `channel`: messages, with a time limit, and what the process writes to its standard output and error.

mod channel;
mod child;
mod interpreter;

pub(crate) use channel::{Channel, Lost, Patience};
pub(crate) use child::{Child, MAX_MEMORY_MB, Settings};
