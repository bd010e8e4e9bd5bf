//! The input log: all external inputs of a world while it ran.
//!
//! A world is a function of its document and of this log. Each [`InputRecord`] contains the barrier (step), and the
//! position within it, at which an input happened; [`World::feed`](crate::World::feed) repeats it in a different world
//! with the same document.
//!
//! The log contains the commands that services call, their requests, and inputs of the program, such as key presses. It
//! does not contain the results of calls, since a replay reproduces them. Changes that a service makes through tables
//! other than `commands` and `session` are not recorded.

use std::sync::Arc;

use tatu_plugin_api::{abi::*, safe::Value};

/// Service number of the caller in a replay, which differs from that of any service of a session.
pub(crate) const REPLAY_SERVICE: u32 = u32::MAX;

/// Names of requests in the log, with the values of `TATU_REQUEST_*`.
pub(crate) const REQUEST_NAMES: [(&str, u32); 4] = [
    ("stop", TATU_REQUEST_STOP),
    ("pause", TATU_REQUEST_PAUSE),
    ("start", TATU_REQUEST_START),
    ("quit", TATU_REQUEST_QUIT),
];

/// One external input.
#[derive(Debug, Clone, PartialEq)]
pub enum ExternalInput {
    /// A command was called.
    Call {
        /// The name by which the command was called.
        name: String,
        /// The arguments before any conversion. Numeric arrays are stored as f64 or i64.
        args: Vec<Value>,
        /// Whether the caller could wait.
        waits: bool,
    },
    /// A change of phase was requested: `TATU_REQUEST_*`.
    Request(u32),
    /// An input such as a key press.
    Event {
        /// Kind of input, such as "key".
        kind: String,
        /// Content of the input, such as the name of the key.
        text: String,
    },
    /// Scripts were called while the simulation was paused or, in the log of a session, stopped.
    Pass,
    /// A plugin read data from outside the world during a step, for example from a socket.
    Observed {
        /// The kind of observation.
        kind: String,
        /// The data that was read.
        text: String,
    },
}

/// An input with its time and origin.
#[derive(Debug, Clone, PartialEq)]
pub struct InputRecord {
    /// Number of steps completed before the barrier at which it happened.
    pub step: u64,
    /// Index of the input among those at that barrier, from 0.
    pub at: u64,
    /// Id of the service from which the input came; empty if it came from the program itself.
    pub service: String,
    /// The client on whose behalf the service acted, as numbered by the service.
    pub client: u64,
    /// The input itself.
    pub input: ExternalInput,
}

/// All inputs since the start or, if `session` is set, since the session began, in order.
#[derive(Default)]
pub struct InputLog {
    records: Vec<InputRecord>,
    /// Step and position of the next record.
    next: (u64, u64),
    /// Whether records are not stored in memory. They are still passed to `sink`.
    off: bool,
    /// Whether records from before the start are part of the log.
    session: bool,
    sink: Option<RecordSink>,
}

/// A function that receives each record as it is made.
type RecordSink = Box<dyn FnMut(&InputRecord)>;

impl InputLog {
    /// Returns the stored records.
    pub fn records(&self) -> &[InputRecord] {
        &self.records
    }
    /// Sets whether records are stored in memory, which is the default. A long run that is not replayed from memory
    /// does not need them.
    pub fn store_records(&mut self, on: bool) {
        self.off = !on;
    }
    /// Passes each record to `sink` before it takes effect, so that it is not lost even if the program crashes.
    pub fn set_sink(&mut self, sink: impl FnMut(&InputRecord) + 'static) {
        self.sink = Some(Box::new(sink));
    }
    /// Makes records from before the start part of the log.
    pub fn include_session(&mut self) {
        self.session = true;
    }
    /// Returns whether inputs from before the start must be recorded.
    pub(crate) fn is_session(&self) -> bool {
        self.session && !self.is_idle()
    }
    /// Restores the records made before a snapshot.
    pub(crate) fn restore(&mut self, records: Vec<InputRecord>) {
        self.next = records.last().map_or((0, 0), |r| (r.step, r.at + 1));
        self.records = records;
    }
    pub(crate) fn is_idle(&self) -> bool {
        self.off && self.sink.is_none()
    }
    pub(crate) fn clear(&mut self) {
        if !self.session {
            self.records.clear();
            self.next = (0, 0);
        }
    }
    pub(crate) fn push(&mut self, step: u64, service: String, client: u64, input: ExternalInput) {
        if self.is_idle() {
            return;
        }
        let at = if self.next.0 == step { self.next.1 } else { 0 };
        self.next = (step, at + 1);
        let record = InputRecord { step, at, service, client, input };
        if let Some(sink) = &mut self.sink {
            sink(&record);
        }
        if !self.off {
            self.records.push(record);
        }
    }
}

/// A log that is being replayed in a world.
#[derive(Debug)]
pub struct Replay {
    records: Arc<[InputRecord]>,
    /// Index of the next input to repeat.
    next: usize,
    /// Index from which to search for the next observation. Plugins request an observation at the same point of the run
    /// as when it was recorded.
    observed: usize,
    /// Index from which to search for the next result of a client function.
    functions: usize,
    /// Index of the first record of the run.
    run: usize,
}

impl Replay {
    /// Creates a replay that starts at the first record.
    pub(crate) fn new(records: Arc<[InputRecord]>) -> Self {
        Replay { records, next: 0, observed: 0, functions: 0, run: 0 }
    }
    pub(crate) fn rewind(&mut self) {
        (self.next, self.observed, self.functions) = (self.run, self.run, self.run);
    }
    /// Returns the next input, or `None` if that is the input that starts the simulation, which is skipped.
    pub(crate) fn next_before_start(&mut self) -> Option<InputRecord> {
        let record = self.records.get(self.next)?;
        self.next += 1;
        self.run = self.next;
        (record.input != ExternalInput::Request(TATU_REQUEST_START)).then(|| record.clone())
    }
    pub(crate) fn next_at(&mut self, step: u64) -> Option<InputRecord> {
        loop {
            let record = self.records.get(self.next).filter(|r| r.step <= step)?;
            self.next += 1;
            if !matches!(record.input, ExternalInput::Observed { .. }) {
                return Some(record.clone());
            }
        }
    }
    /// Returns the next input to repeat, if it is before index `place`.
    pub(crate) fn next_before(&mut self, place: usize) -> Option<InputRecord> {
        while self.next < place {
            self.next += 1;
            let record = self.records.get(self.next - 1)?;
            if !matches!(record.input, ExternalInput::Observed { .. }) {
                return Some(record.clone());
            }
        }
        None
    }
    /// Returns the index of the next result of a client function of this kind, from `step` on.
    pub(crate) fn find_function_result(&self, step: u64, kind: &str) -> Option<usize> {
        let is = |r: &InputRecord| {
            r.step >= step && matches!(&r.input, ExternalInput::Observed { kind: k, .. } if k == kind)
        };
        self.records.get(self.functions..)?.iter().position(is).map(|i| self.functions + i)
    }
    /// Returns the result at an index. The next search for a result begins after it.
    pub(crate) fn take_function_result(&mut self, place: usize) -> Option<String> {
        self.functions = place + 1;
        match &self.records.get(place)?.input {
            ExternalInput::Observed { text, .. } => Some(text.clone()),
            _ => None,
        }
    }
    /// Returns the next observation, if it was made at this step and is of this kind.
    pub(crate) fn observed_now(&mut self, step: u64, kind: &str) -> Option<String> {
        let rest = self.records.get(self.observed..)?;
        let at = rest.iter().position(|r| matches!(r.input, ExternalInput::Observed { .. }))?;
        match &rest[at].input {
            ExternalInput::Observed { kind: k, text } if k == kind && rest[at].step == step => {
                self.observed += at + 1;
                Some(text.clone())
            }
            _ => None,
        }
    }
    /// Returns the next observation of this kind, from `step` on.
    pub(crate) fn next_observed(&mut self, step: u64, kind: &str) -> Option<String> {
        let rest = self.records.get(self.observed..)?;
        let found = rest
            .iter()
            .position(|r| r.step >= step && matches!(&r.input, ExternalInput::Observed { kind: k, .. } if k == kind))?;
        self.observed += found + 1;
        match &rest[found].input {
            ExternalInput::Observed { text, .. } => Some(text.clone()),
            _ => None,
        }
    }
}
