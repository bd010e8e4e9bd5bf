//! Messages between the plugin and the interpreter's process: a length of 4 bytes, a kind of 1 byte, and the contents.
//!
//! One side asks, and serves the questions of the other side until its own is answered; so both sides may call each
//! other to any depth, and at most one of them works at a time. `runtime/link.py` is the other side.

/// Kinds of messages to the process.
pub(crate) mod to {
    /// Text, name, dialect and preludes of the script; answered.
    pub const LOAD: u8 = 1;
    /// Whether the script defines a callback or function; answered.
    pub const FIND: u8 = 2;
    /// Calls a callback or function by name; answered.
    pub const CALL: u8 = 3;
    /// Calls a function by its number; answered.
    pub const CALL_FUNCTION: u8 = 4;
    /// Ends a wait of a thread; answered.
    pub const RESUME: u8 = 5;
    /// Saves what the script saves of its state; answered.
    pub const SAVE: u8 = 6;
    /// Passes saved state to the script; answered.
    pub const RESTORE: u8 = 7;
    /// The position of the script; answered.
    pub const PLACE: u8 = 8;
    /// Retains a function under a new number.
    pub const KEEP: u8 = 9;
    /// Releases a function.
    pub const DROP: u8 = 10;
    /// Names of commands have changed.
    pub const REFRESH: u8 = 11;
    /// Results of the process's question.
    pub const RESULT: u8 = 20;
    /// The process's question has failed.
    pub const ERROR: u8 = 21;
    /// The command waits; its results follow later, under this token.
    pub const WAIT: u8 = 22;
}

/// Kinds of messages from the process.
pub(crate) mod from {
    /// Calls a command.
    pub const COMMAND: u8 = 1;
    /// Calls a function of another script.
    pub const FUNCTION: u8 = 2;
    /// What a name stands for.
    pub const LOOKUP: u8 = 3;
    /// The text of a module that a plugin provides.
    pub const MODULE: u8 = 4;
    /// The command whose name is nearest to an unknown one.
    pub const NEAREST: u8 = 5;
    /// The declaration of a command, as text.
    pub const DESCRIBE: u8 = 6;
    /// A line for the log; not answered.
    pub const LOG: u8 = 10;
    /// The results of the plugin's question.
    pub const DONE: u8 = 20;
    /// The plugin's question has failed.
    pub const FAILED: u8 = 21;
    /// The function waits in a command.
    pub const WAITING: u8 = 22;
}

/// The largest message, bytes.
pub(crate) const MAX_BYTES: usize = 256 << 20;

/// A message of the process.
pub(crate) struct Message {
    pub kind: u8,
    pub body: Vec<u8>,
}

/// Begins a message to the process.
pub(crate) fn begin(kind: u8) -> Vec<u8> {
    vec![0, 0, 0, 0, kind]
}

/// Completes a message with its length.
pub(crate) fn complete(message: &mut [u8]) {
    let length = (message.len() - 4) as u32;
    message[..4].copy_from_slice(&length.to_le_bytes());
}
