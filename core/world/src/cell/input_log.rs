//! The input log: everything that came from outside while a world ran.
//!
//! A world is a function of its document and of this log. Each [`Record`] says at which barrier (step) and at which
//! place within it something was done; [`World::feed`](crate::World::feed) does it again in another world of the same
//! document.
//!
//! Recorded are the calls of commands that services make, their requests, and what the program puts in, such as keys.
//! Whether a call succeeded is not: it will again or not. What a service changes by other tables than `commands` and
//! `session` is not recorded.

use std::sync::Arc;

use tatu_plugin_api::{abi::*, safe::Value};

/// The caller in a replay: no service of a session.
pub(crate) const REPLAY: u32 = u32::MAX;

/// Names of requests, by `TATU_REQUEST_*`.
pub(crate) const REQUESTS: [(&str, u32); 4] = [
    ("stop", TATU_REQUEST_STOP),
    ("pause", TATU_REQUEST_PAUSE),
    ("start", TATU_REQUEST_START),
    ("quit", TATU_REQUEST_QUIT),
];

/// What was done.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// A command was called.
    Call {
        /// By which of its names.
        name: String,
        /// With what, before any conversion. Numeric arrays are kept as f64 or i64.
        args: Vec<Value>,
        /// Whether the caller could wait.
        waits: bool,
    },
    /// A change of state was asked for: `TATU_REQUEST_*`.
    Request(u32),
    /// Something came in, such as a key.
    Event {
        /// What: "key".
        kind: String,
        /// Which.
        text: String,
    },
    /// Scripts had a pass while time stood.
    Pass,
    /// A plugin looked outside in the middle of a step: at a socket, for instance.
    Observed {
        /// What looked.
        kind: String,
        /// What it found.
        text: String,
    },
}

/// One thing that came from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Steps done before the barrier at which it happened.
    pub step: u64,
    /// Its place among what happened at that barrier, from 0.
    pub at: u64,
    /// Id of the service.
    pub service: String,
    /// For whom the service did it, by its own number.
    pub client: u64,
    /// What.
    pub input: Input,
}

/// What came from outside since the start, in order.
#[derive(Default)]
pub struct InputLog {
    records: Vec<Record>,
    /// Step and place of the next record.
    next: (u64, u64),
    /// Records are not kept.
    off: bool,
    sink: Option<Sink>,
}

/// Takes each record as it is made.
type Sink = Box<dyn FnMut(&Record)>;

impl InputLog {
    /// The records that were kept.
    pub fn records(&self) -> &[Record] {
        &self.records
    }
    /// Whether records are kept; a new log does. A long run that will not be replayed from memory need not grow.
    pub fn keep(&mut self, on: bool) {
        self.off = !on;
    }
    /// Passes each record on before it takes effect, so that not even a crash loses it.
    pub fn hand_to(&mut self, sink: impl FnMut(&Record) + 'static) {
        self.sink = Some(Box::new(sink));
    }
    /// Takes over what came from outside before a snapshot.
    pub(crate) fn restore(&mut self, records: Vec<Record>) {
        self.next = records.last().map_or((0, 0), |r| (r.step, r.at + 1));
        self.records = records;
    }
    pub(crate) fn is_idle(&self) -> bool {
        self.off && self.sink.is_none()
    }
    pub(crate) fn clear(&mut self) {
        self.records.clear();
        self.next = (0, 0);
    }
    pub(crate) fn push(&mut self, step: u64, service: String, client: u64, input: Input) {
        if self.is_idle() {
            return;
        }
        let at = if self.next.0 == step { self.next.1 } else { 0 };
        self.next = (step, at + 1);
        let record = Record { step, at, service, client, input };
        if let Some(sink) = &mut self.sink {
            sink(&record);
        }
        if !self.off {
            self.records.push(record);
        }
    }
}

/// A log that is being fed to a world.
#[derive(Debug)]
pub struct Replay {
    records: Arc<[Record]>,
    /// The next record to be done again,
    next: usize,
    /// and the next one of what plugins observed: they ask for it where they did then.
    observed: usize,
    /// and of what functions of clients gave.
    functions: usize,
}

impl Replay {
    /// From its first record.
    pub(crate) fn new(records: Arc<[Record]>) -> Self {
        Replay { records, next: 0, observed: 0, functions: 0 }
    }
    pub(crate) fn rewind(&mut self) {
        (self.next, self.observed, self.functions) = (0, 0, 0);
    }
    pub(crate) fn next_at(&mut self, step: u64) -> Option<Record> {
        loop {
            let record = self.records.get(self.next).filter(|r| r.step <= step)?;
            self.next += 1;
            if !matches!(record.input, Input::Observed { .. }) {
                return Some(record.clone());
            }
        }
    }
    /// The next record to be done again, if it stands before a place.
    pub(crate) fn next_before(&mut self, place: usize) -> Option<Record> {
        while self.next < place {
            self.next += 1;
            let record = self.records.get(self.next - 1)?;
            if !matches!(record.input, Input::Observed { .. }) {
                return Some(record.clone());
            }
        }
        None
    }
    /// Where the log has what the next function of a client gave, at a step: of a kind.
    pub(crate) fn place_of(&self, step: u64, kind: &str) -> Option<usize> {
        let is = |r: &Record| r.step >= step && matches!(&r.input, Input::Observed { kind: k, .. } if k == kind);
        self.records.get(self.functions..)?.iter().position(is).map(|i| self.functions + i)
    }
    /// What it gave.
    pub(crate) fn take_function(&mut self, place: usize) -> Option<String> {
        self.functions = place + 1;
        match &self.records.get(place)?.input {
            Input::Observed { text, .. } => Some(text.clone()),
            _ => None,
        }
    }
    /// What a plugin observed next, from a step on: of a kind.
    pub(crate) fn next_observed(&mut self, step: u64, kind: &str) -> Option<String> {
        let rest = self.records.get(self.observed..)?;
        let found = rest
            .iter()
            .position(|r| r.step >= step && matches!(&r.input, Input::Observed { kind: k, .. } if k == kind))?;
        self.observed += found + 1;
        match &rest[found].input {
            Input::Observed { text, .. } => Some(text.clone()),
            _ => None,
        }
    }
}
