//! Sessions: services, which outlive worlds, and the barrier at which they act.
//!
//! - `barrier`: the barrier between two steps: waits that have ended, replayed calls, turns of services;
//! - `functions`: functions of clients, passed to commands to be called back;
//! - [`mod@log`]: requests, and the replay of external inputs; [`mod@file`]: the input log as a file.
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
