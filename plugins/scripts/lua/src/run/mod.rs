//! Runs scripts: calls from the host, calls to the host, and their limits.
//!
//! - `callbacks`, `threads`: the functions that the host calls; `entry`: the common part of such calls;
//! - `commands`: functions of the host that scripts call; `shadowed_commands`: commands that scripts cannot call;
//! - `functions`: functions passed to the host; `waits`: commands that take time; `frame`: a call to the host;
//! - `budget`, `time_slices`, `gc`: limits on instructions and memory;
//! - `traits`: properties of a script that the host queries.

pub(crate) mod budget;
pub(crate) mod callbacks;
pub(crate) mod commands;
pub(crate) mod entry;
mod frame;
pub(crate) mod functions;
pub(crate) mod gc;
pub(crate) mod shadowed_commands;
pub(crate) mod threads;
pub(crate) mod time_slices;
pub(crate) mod traits;
mod waits;
