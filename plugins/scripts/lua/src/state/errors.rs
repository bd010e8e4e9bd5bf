//! The most recent errors of a script.

use std::collections::VecDeque;

use tatu_plugin_api::safe::*;

/// The most recent errors of a script.
#[derive(Default)]
pub(crate) struct RecentErrors {
    /// The last error of a command, and its text for the script.
    pub raised: Option<(Fail, Vec<u8>)>,
    /// The last error recorded by the message handler.
    pub caught: Option<CaughtError>,
    /// The last unresolved names, with their prefixes.
    pub unresolved: VecDeque<Vec<u8>>,
}

/// A Lua error, as recorded by the message handler.
pub(crate) struct CaughtError {
    pub text: Vec<u8>,
    pub traceback: Vec<u8>,
    /// Running functions, innermost first: short source, full source, line.
    pub places: Vec<(Vec<u8>, Vec<u8>, i64)>,
}
