//! Records a film: the messages that a client would receive, but with poses in full precision.

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

/// Minimum simulation time between two records of readings, s.
const READINGS: f64 = 0.1;
/// Minimum simulation time between two records of drawings, s.
const DRAWINGS: f64 = 1.0;
/// Names of the events that are recorded.
pub const EVENTS: &[&str] = &["message", "console", "script_error", "started", "stopped"];

/// A recorder, and the recording that it is making.
#[derive(Default)]
pub struct Recorder {
    /// The records, compressed; `None` before the start and after the end of the recording.
    records: Option<GzEncoder<Vec<u8>>>,
    whole: Whole,
    changes: Changes,
    /// The frame entries that were recorded last, by key.
    known: BTreeMap<u32, Vec<f64>>,
    /// The last recorded readings.
    sent: Sent,
    /// The last recorded drawings, as a JSON message.
    drawn: String,
    /// Simulation times of the last recorded readings and drawings, s.
    at: [f64; 2],
    /// Number of the step that was recorded last.
    step: Option<u64>,
    /// Simulation time of the current step or event, s.
    time: f64,
    /// Maximum compressed size, bytes. Once it is exceeded, further messages are dropped.
    most: usize,
    /// Simulation time at which the maximum size was exceeded, s.
    full: Option<f64>,
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
        // Events are delivered before the frame of their step, so the time of the last frame would be too early.
        if let Ok(time) = turn.f64(0, p.time) {
            self.time = time;
        }
        let payload = payload.to_value().map_or(serde_json::Value::Null, |v| json::write(&v));
        self.record(&ToPage::Event { name: name.to_owned(), payload }.message());
    }

    /// Ends the recording and returns it in compressed form, or `None` if none was started.
    pub fn finish(&mut self) -> Option<std::io::Result<Vec<u8>>> {
        self.records.take().map(GzEncoder::finish)
    }

    /// Returns the simulation time at which the recording exceeded its maximum size, s, or `None` if it did not.
    pub fn full_at(&self) -> Option<f64> {
        self.full
    }

    /// Starts an empty recording.
    fn begin(&mut self) {
        let records = Some(GzEncoder::new(Vec::new(), Compression::default()));
        *self = Recorder { records, ..Recorder::new(self.most) };
        self.at = [f64::NEG_INFINITY; 2];
    }

    /// Appends a record: the length of the message as u32, the simulation time in s as f64, a byte (0: text, 1:
    /// binary), and the message.
    fn record(&mut self, message: &Message) {
        let Some(records) = self.records.as_mut().filter(|_| self.full.is_none()) else { return };
        let (kind, bytes): (u8, &[u8]) = match message {
            Message::Text(t) => (0, t.as_bytes()),
            Message::Binary(b) => (1, b),
        };
        let head = [&(bytes.len() as u32).to_le_bytes()[..], &self.time.to_le_bytes(), &[kind]].concat();
        // Writing into memory cannot fail.
        let _ = records.write_all(&head).and_then(|()| records.write_all(bytes));
        if records.get_ref().len() > self.most {
            self.full = Some(self.time);
        }
    }

    /// Appends a frame of the step, and the changed objects, readings and drawings that are due. Starts the recording
    /// if necessary. Does nothing if `step` is already recorded.
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
        // The tolerance covers rounding errors in the simulation time.
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

    /// Reads the current scene, and appends it and the sources of its scripts.
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
