//! The state of clients: pending and streamed commands, errors, and synchronous operation.

use std::{collections::BTreeMap, sync::Arc};

use tatu_plugin_api::safe::{Fail, Result};
use tatu_services_common::hold_limit::HoldTimer;

use crate::{
    connections::AnswerQueue,
    message::{RemoteCommand, mode},
};

/// Maximum number of streamed commands per client.
const MAX_STREAMS: usize = 5000;
/// Maximum number of commands per client that are being received in parts.
const MAX_SPLIT_COMMANDS: usize = 64;
/// Maximum number of stored errors per client; older ones are discarded.
const MAX_ERRORS: usize = 50;

/// The state of a client.
pub struct LegacyClient {
    /// Answers to be sent to the client.
    pub out: Arc<AnswerQueue>,
    /// The id of the client's newest message with commands.
    pub id: i32,
    /// Received commands that have not been executed, in order of arrival.
    pub pending: Vec<RemoteCommand>,
    /// Streamed commands, by number and subject, each with the simulation time in ms at which it is due.
    pub streams: BTreeMap<(u16, Vec<u8>), (RemoteCommand, f64)>,
    /// The data received so far of commands that are sent in parts, by number and subject.
    parts: BTreeMap<(u16, Vec<u8>), Vec<u8>>,
    /// Whether each step requires the permission of the client.
    pub synchronous: bool,
    /// The step until which the client has permitted steps; `None` if it has not permitted any.
    pub until: Option<u64>,
    /// Whether the client has requested a start that has not taken effect yet.
    pub starting: bool,
    /// Number of steps that the client has permitted since it requested the start.
    pub permitted_early: u64,
    /// Error messages that the client has not fetched, the oldest first.
    pub errors: Vec<String>,
    /// Error messages that have been logged.
    logged: Vec<String>,
    /// Measures how long the client has held the world in silence.
    pub hold: HoldTimer,
}

impl LegacyClient {
    /// Creates the state of a new client.
    pub fn new(out: Arc<AnswerQueue>) -> LegacyClient {
        LegacyClient {
            out,
            id: 0,
            pending: Vec::new(),
            streams: BTreeMap::new(),
            parts: BTreeMap::new(),
            synchronous: false,
            until: None,
            starting: false,
            permitted_early: 0,
            errors: Vec::new(),
            logged: Vec::new(),
            hold: HoldTimer::default(),
        }
    }
    /// Updates the permission at the barrier before a step. Steps that were permitted between the request of a start and
    /// the start count from the first one.
    pub fn update_permission(&mut self, running: bool, step: u64) {
        self.until = self.until.filter(|until| running && step < *until);
        if running {
            self.starting = false;
            let early = std::mem::take(&mut self.permitted_early);
            if early > 0 {
                self.until = Some(self.until.unwrap_or(step) + early);
            }
        }
    }
    /// Permits another step. Returns whether the client may do so.
    pub fn permit_step(&mut self, running: bool, step: u64) -> bool {
        match (running, self.starting) {
            _ if !self.synchronous => return false,
            (true, _) => self.until = Some(self.until.unwrap_or(step) + 1),
            (false, true) => self.permitted_early += 1,
            (false, false) => return false,
        }
        true
    }
    /// Withdraws the permission, when the simulation has stopped.
    pub fn withdraw_permission(&mut self) {
        (self.until, self.starting, self.permitted_early) = (None, false, 0);
    }
    /// Returns whether the world must be held before this step until the client permits it.
    pub fn holds_world(&self, step: u64) -> bool {
        self.synchronous && self.until.is_none_or(|until| step >= until)
    }
    /// Returns whether an error message differs from all that have been logged for the client, of which the newest
    /// `MAX_ERRORS` are remembered.
    pub fn is_new_error(&mut self, text: &str) -> bool {
        if self.logged.iter().any(|t| t == text) {
            return false;
        }
        self.logged.push(text.to_owned());
        let over = self.logged.len().saturating_sub(MAX_ERRORS);
        self.logged.drain(..over);
        true
    }
    /// Stores an error message for the client. If there are too many, the oldest one is discarded.
    pub fn add_error(&mut self, text: String) {
        self.errors.push(text);
        let over = self.errors.len().saturating_sub(MAX_ERRORS);
        self.errors.drain(..over);
    }
    /// Adds a received command, which may be a part of a split command. Returns the complete command, or `None` if
    /// parts are still missing.
    pub fn join_parts(&mut self, command: RemoteCommand) -> Result<Option<RemoteCommand>> {
        let split = matches!(command.mode(), mode::ONESHOT_SPLIT | mode::STREAMING_SPLIT);
        let (at, full) = command.part;
        if !split || at == 0 && command.data.len() >= full {
            return Ok(Some(command));
        }
        let key = (command.number(), command.subject.clone());
        if full > crate::packet::MAX_MESSAGE_BYTES {
            return Err(Fail::argument(format!(
                "a command sent in parts has {full} bytes: expected at most {}",
                crate::packet::MAX_MESSAGE_BYTES
            )));
        }
        if at == 0 {
            if self.parts.len() >= MAX_SPLIT_COMMANDS {
                return Err(Fail::argument(
                    "too many commands are being sent in parts at the same time: expected at most 64",
                ));
            }
            self.parts.insert(key.clone(), Vec::new());
        }
        let data = self.parts.get_mut(&key).filter(|d| d.len() == at);
        let data = data.ok_or_else(|| Fail::argument("received a part of a command without the preceding part"))?;
        data.extend_from_slice(&command.data);
        if data.len() > crate::packet::MAX_MESSAGE_BYTES {
            self.parts.remove(&key);
            return Err(Fail::argument("the parts of a command exceed the maximum size of a command, 66 MiB"));
        }
        if data.len() < full {
            return Ok(None);
        }
        let data = self.parts.remove(&key).unwrap_or_default();
        Ok(Some(RemoteCommand { data, ..command }))
    }
    /// Starts to stream a command, which is due immediately. Fails if the client already has `MAX_STREAMS` streamed
    /// commands.
    pub fn start_stream(&mut self, command: &RemoteCommand) -> Result {
        let key = (command.number(), command.subject.clone());
        if self.streams.len() >= MAX_STREAMS && !self.streams.contains_key(&key) {
            return Err(Fail::argument(format!(
                "too many streamed commands: expected at most {MAX_STREAMS} per client"
            )));
        }
        self.streams.insert(key, (command.clone(), f64::NEG_INFINITY));
        Ok(())
    }
}
