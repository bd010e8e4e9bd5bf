//! Calls into plugins, and the commands that they run.
//!
//! - `stack`: the call stack, with `arena`, `errors` and `result_buffers`; `wait_list`: commands that wait and resume;
//!   `thread_results`, `thread_result_intake`: results of plugins' threads; `cost`: the cost of commands;
//! - `monitor`: state that is monitored while plugins run; `plugin_calls`: calls into plugins; `scope`: the host
//!   functions that are allowed during each plugin call.

pub(in crate::cell) mod arena;
pub(crate) mod cost;
pub(crate) mod errors;
pub(in crate::cell) mod monitor;
pub(in crate::cell) mod plugin_calls;
pub(in crate::cell) mod result_buffers;
pub(in crate::cell) mod scope;
pub(in crate::cell) mod stack;
pub(crate) mod thread_result_intake;
pub(in crate::cell) mod thread_results;
pub(in crate::cell) mod wait_list;
