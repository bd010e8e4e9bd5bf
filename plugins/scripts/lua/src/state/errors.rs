//! The most recent errors of a script.

use std::collections::VecDeque;

use tatu_plugin_api::safe::*;

/// The most recent errors of a script.
#[derive(Default)]
pub(crate) struct Errors {
    /// The last error of a command, and its text as the script sees it.
    pub raised: Option<(Fail, Vec<u8>)>,
    /// The error that the message handler saw last.
    pub caught: Option<Caught>,
    /// The last unresolved names, with their prefixes.
    pub unresolved: VecDeque<Vec<u8>>,
}

/// A Lua error.
pub(crate) struct Caught {
    pub text: Vec<u8>,
    pub traceback: Vec<u8>,
    /// Running functions, innermost first: short source, full source, line.
    pub places: Vec<(Vec<u8>, Vec<u8>, i64)>,
}
