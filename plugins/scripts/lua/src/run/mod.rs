//! What runs in a script, and what it may use.
//!
//! - `callbacks`, `threads`: what the host calls; `entry`: what each of its calls has in common;
//! - `commands`: what a script calls; `hidden`: names that it cannot reach;
//! - `functions`: functions that are passed out; `waits`: commands that take time; `frame`: a call to the host;
//! - `budget`, `time_slices`, `gc`: instructions and memory;
//! - `traits`: what the host asks about a script.

pub(crate) mod budget;
pub(crate) mod callbacks;
pub(crate) mod commands;
pub(crate) mod entry;
mod frame;
pub(crate) mod functions;
pub(crate) mod gc;
pub(crate) mod hidden;
pub(crate) mod threads;
pub(crate) mod time_slices;
pub(crate) mod traits;
mod waits;
