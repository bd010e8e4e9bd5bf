//! Calls that may have to wait.

use std::time::Instant;

/// A call that may have to wait.
pub struct Operation {
    /// The name of the command.
    pub name: &'static str,
    pub what: What,
    /// When the call ends without a result; `None` before the first attempt and without a limit.
    pub end: Option<Instant>,
    /// Whether the call has been attempted.
    pub begun: bool,
}

/// What a call does.
pub enum What {
    /// Receives a part of a message, which is stored in the message `message` or returned up to the size `most`.
    Receive { socket: String, wait: bool, most: usize, message: Option<String> },
    /// Sends a part of a message.
    Send { socket: String, wait: bool, data: Vec<u8>, more: bool },
    /// Finds out which sockets are ready for the given events; the timeout is in ms.
    Poll { sockets: Vec<(String, i64)>, timeout: i64 },
}

impl Operation {
    pub fn new(name: &'static str, what: What) -> Self {
        Operation { name, what, end: None, begun: false }
    }
}
