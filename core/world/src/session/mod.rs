//! Sessions: services, which outlive worlds, and the barrier at which they act.
//!
//! - `barrier`: the barrier between two steps, at which waiting commands are resumed, calls are replayed, and services
//!   have their turns;
//! - `functions`: functions of clients, which commands can call;
//! - [`mod@log`]: requests, and the replay of external inputs; [`mod@file`]: the input log as a file.
//!
//! A session and its worlds belong to one thread; different sessions can belong to different threads. Only `wake` may
//! be called from other threads.

mod barrier;
pub mod file;
pub(crate) mod functions;
mod json;
pub mod log;

pub(crate) use barrier::{before_step, cancel_service_waits, notify_world_end, wait_for_start};
pub(crate) use log::request_from_program;
