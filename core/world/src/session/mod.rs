//! What outlives worlds: services, and the barrier at which they act.
//!
//! - `barrier`: what happens between two steps: waits that are over, replayed calls, services until all say go;
//! - `functions`: what clients give to commands, to be called back;
//! - [`mod@log`]: feeding what came from outside again; [`mod@file`]: the same as a file.
//!
//! A session and its worlds live on one thread; different sessions live on different threads. Only `wake` is called
//! from other threads.

mod barrier;
pub mod file;
pub(crate) mod functions;
mod json;
pub mod log;

pub(crate) use barrier::{before_step, last, rest, stopped};
pub(crate) use log::outside_request;
