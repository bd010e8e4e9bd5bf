//! State of the clients: pending and repeated commands, and synchronous operation.

use std::{collections::BTreeMap, sync::Arc};

use tatu_plugin_api::safe::{Fail, Result};

use crate::{
    connections::Outbox,
    message::{Command, mode},
};

/// Maximum number of streams of a client, of its partial commands, and of its stored errors.
const MOST_STREAMS: usize = 5000;
const MOST_PARTS: usize = 64;
const MOST_ERRORS: usize = 50;

/// A client.
pub struct Client {
    /// Answers to be sent to the client.
    pub out: Arc<Outbox>,
    /// The id of the client's newest message.
    pub id: i32,
    /// Commands that have not been executed yet.
    pub pending: Vec<Command>,
    /// Repeated commands, each with the world time in ms at which it is due.
    pub streams: BTreeMap<(u16, Vec<u8>), (Command, f64)>,
    /// Commands that arrive in parts.
    parts: BTreeMap<(u16, Vec<u8>), Vec<u8>>,
    /// Whether each step waits for the client.
    pub synchronous: bool,
    /// The step at which the client's permission to step ends.
    pub until: Option<u64>,
    /// Errors, oldest first.
    pub errors: Vec<String>,
}

impl Client {
    /// Creates the state of a new client.
    pub fn new(out: Arc<Outbox>) -> Client {
        Client {
            out,
            id: 0,
            pending: Vec::new(),
            streams: BTreeMap::new(),
            parts: BTreeMap::new(),
            synchronous: false,
            until: None,
            errors: Vec::new(),
        }
    }
    /// Returns whether the world must wait until the client permits a step.
    pub fn holds(&self, step: u64) -> bool {
        self.synchronous && self.until.is_none_or(|until| step >= until)
    }
    /// Stores an error.
    pub fn went_wrong(&mut self, text: String) {
        self.errors.push(text);
        let over = self.errors.len().saturating_sub(MOST_ERRORS);
        self.errors.drain(..over);
    }
    /// Adds a command that may be one part of a split command; returns the complete command once all parts have
    /// arrived.
    pub fn whole(&mut self, command: Command) -> Result<Option<Command>> {
        let split = matches!(command.mode(), mode::ONESHOT_SPLIT | mode::STREAMING_SPLIT);
        let (at, full) = command.part;
        if !split || at == 0 && command.data.len() >= full {
            return Ok(Some(command));
        }
        let key = (command.raw(), command.of.clone());
        if full > crate::packet::MOST {
            return Err(Fail::argument(format!("a command has {full} bytes; the limit is {}", crate::packet::MOST)));
        }
        if at == 0 {
            if self.parts.len() >= MOST_PARTS {
                return Err(Fail::argument("too many commands are being sent in parts at once"));
            }
            self.parts.insert(key.clone(), Vec::new());
        }
        let data = self.parts.get_mut(&key).filter(|d| d.len() == at);
        let data = data.ok_or_else(|| Fail::argument("received part of a command without its first part"))?;
        data.extend_from_slice(&command.data);
        if data.len() > crate::packet::MOST {
            self.parts.remove(&key);
            return Err(Fail::argument("a command is too large"));
        }
        if data.len() < full {
            return Ok(None);
        }
        let data = self.parts.remove(&key).unwrap_or_default();
        Ok(Some(Command { data, ..command }))
    }
    /// Adds a command to be repeated.
    pub fn stream(&mut self, command: &Command) -> Result {
        if self.streams.len() >= MOST_STREAMS {
            return Err(Fail::argument(format!("a client can have at most {MOST_STREAMS} streams")));
        }
        self.streams.insert((command.raw(), command.of.clone()), (command.clone(), f64::NEG_INFINITY));
        Ok(())
    }
}
