//! Calls of commands that may wait for the network.

use std::time::Instant;

/// A call of a command that may wait for the network.
pub struct Operation {
    /// The name of the command.
    pub name: &'static str,
    pub what: What,
    /// Time at which the call fails if it still has no result; `None` before the first attempt, or if there is no
    /// limit.
    pub end: Option<Instant>,
    /// Whether the call has been attempted.
    pub begun: bool,
}

/// The action of a call.
pub enum What {
    /// Receives a part of a message. The part is stored in the message object `message`; without one, its first `most`
    /// bytes are returned.
    Receive { socket: String, wait: bool, most: usize, message: Option<String> },
    /// Sends a part of a message.
    Send { socket: String, wait: bool, data: Vec<u8>, more: bool },
    /// Determines which sockets are ready for the given events; the timeout is in ms.
    Poll { sockets: Vec<(String, i64)>, timeout: i64 },
}

impl Operation {
    pub fn new(name: &'static str, what: What) -> Self {
        Operation { name, what, end: None, begun: false }
    }
}
