//! Services, and what enters a world from outside.
//!
//! - `session_cell`, `connections`, `wake_flag`: the session and its services; `service`, `service_calls`: a single
//!   service;
//! - `input_log`, `inputs`: external inputs.

pub(in crate::cell) mod connections;
pub(in crate::cell) mod input_log;
pub(in crate::cell) mod inputs;
pub(in crate::cell) mod service;
pub(in crate::cell) mod service_calls;
pub(in crate::cell) mod session_cell;
pub(in crate::cell) mod wake_flag;
