//! Records the messages that a client would receive, in full precision, for a film.

use std::{collections::BTreeMap, io::Write};

use flate2::{Compression, write::GzEncoder};
use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn, ValueRef},
};
use tatu_services_common::{json, outbox::Message};

use crate::{
    acts,
    changes::{Changes, Found},
    frames,
    plugin::Props,
    protocol::ToPage,
    readings::{self, Sent},
    scene::{self, Whole},
};

/// Simulation time between recorded readings, and between drawings, s.
const READINGS: f64 = 0.1;
const DRAWINGS: f64 = 1.0;
/// Events that are recorded.
pub const EVENTS: &[&str] = &["message", "console", "script_error", "started", "stopped"];

/// A recording of a run.
#[derive(Default)]
pub struct Recorder {
    records: Option<GzEncoder<Vec<u8>>>,
    whole: Whole,
    changes: Changes,
    known: BTreeMap<u32, Vec<f64>>,
    sent: Sent,
    drawn: String,
    /// Times of the last recorded readings and drawings.
    at: [f64; 2],
    /// Number of steps at the last recorded frame.
    step: Option<u64>,
    time: f64,
    /// Maximum compressed size, bytes; later messages are dropped, and that is reported.
    most: usize,
    full: bool,
}

impl Recorder {
    /// Creates a recorder with a maximum compressed size of `most` bytes.
    pub fn new(most: usize) -> Self {
        Recorder { most, ..Recorder::default() }
    }

    /// Appends an event; the event `started` restarts the recording.
    pub fn event(&mut self, turn: &Turn<'_>, p: &Props, name: &str, payload: ValueRef<'_>) {
        if name == "started" {
            self.begin();
        }
        if self.records.is_none() {
            return;
        }
        // Events are delivered at the end of their stage, before the next frame.
        if let Ok(time) = turn.f64(0, p.time) {
            self.time = time;
        }
        let payload = payload.to_value().map_or(serde_json::Value::Null, |v| json::write(&v));
        self.record(&ToPage::Event { name: name.to_owned(), payload }.message());
    }

    /// Ends the recording. Returns its compressed bytes, or `None` if there is none.
    pub fn finish(&mut self) -> Option<std::io::Result<Vec<u8>>> {
        self.records.take().map(GzEncoder::finish)
    }

    /// Returns the time at which the recording became too large, if it did.
    pub fn full_at(&self) -> Option<f64> {
        self.full.then_some(self.time)
    }

    fn begin(&mut self) {
        let records = Some(GzEncoder::new(Vec::new(), Compression::default()));
        *self = Recorder { records, ..Recorder::new(self.most) };
        self.at = [f64::NEG_INFINITY; 2];
    }

    /// Appends a record: the length of its message as u32, the time as f64, 1 for bytes or 0 for text, the message.
    fn record(&mut self, message: &Message) {
        let Some(records) = self.records.as_mut().filter(|_| !self.full) else { return };
        let (kind, bytes): (u8, &[u8]) = match message {
            Message::Text(t) => (0, t.as_bytes()),
            Message::Binary(b) => (1, b),
        };
        let head = [&(bytes.len() as u32).to_le_bytes()[..], &self.time.to_le_bytes(), &[kind]].concat();
        // Writing into memory cannot fail.
        let _ = records.write_all(&head).and_then(|()| records.write_all(bytes));
        self.full = records.get_ref().len() > self.most;
    }

    /// Appends the changes of a step.
    pub fn look(&mut self, turn: &Turn<'_>, p: &Props, step: u64) -> Result {
        if self.step == Some(step) {
            return Ok(());
        }
        if self.records.is_none() {
            self.begin();
        }
        self.step = Some(step);
        self.time = turn.f64(0, p.time)?;
        if self.whole.ids != turn.list(0, 0, 0)? {
            self.scene(turn, p)?;
        } else {
            match self.changes.look(turn, p, &mut self.whole)? {
                Found::Nothing => {}
                Found::Scene => self.scene(turn, p)?,
                Found::Objects(messages) => messages.iter().for_each(|m| self.record(m)),
            }
        }
        let frame = frames::exact(turn, p, &self.whole, &mut self.known, (step, self.time));
        self.record(&frame);
        // The tolerance is for rounding errors of the step's time.
        if self.time - self.at[0] > READINGS - 1e-9 {
            self.at[0] = self.time;
            let new = readings::new(turn, p, &self.whole, &mut self.sent);
            if !new.is_empty() {
                self.record(&ToPage::Readings { readings: new }.message());
            }
        }
        if self.time - self.at[1] > DRAWINGS - 1e-9 {
            self.at[1] = self.time;
            let drawn = readings::drawings(turn)?.text();
            if drawn != self.drawn {
                self.record(&Message::Text(drawn.clone().into()));
                self.drawn = drawn;
            }
        }
        Ok(())
    }

    /// Reads the current scene and the sources of its scripts.
    fn scene(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        self.whole = scene::read(turn, p, 0)?;
        self.changes.begin(turn, p, &self.whole)?;
        self.sent = Sent::default();
        self.known.clear();
        for script in turn.scripts(0)? {
            if let Ok(text) = acts::script(turn, tatu_slot(script)) {
                self.record(&text.message());
            }
        }
        for message in std::mem::take(&mut self.whole.messages) {
            self.record(&message);
        }
        Ok(())
    }
}
