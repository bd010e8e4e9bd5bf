//! Records a film: the messages that a client would receive, but with poses in full precision.

use std::{collections::BTreeMap, io::Write};

use flate2::{Compression, write::GzEncoder};
use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn, ValueRef},
};
use tatu_services_common::{json, outbox::OutgoingMessage};

use crate::{
    changes::{ChangeDetector, DetectedChange},
    frames,
    plugin::Props,
    protocol::ToPage,
    readings::{self, SentReadings},
    requests,
    scene::{self, PageScene},
};

/// Minimum simulation time between two records of readings, s.
const READINGS_INTERVAL_S: f64 = 0.1;
/// Minimum simulation time between two records of drawings, s.
const DRAWINGS_INTERVAL_S: f64 = 1.0;
/// Names of the events that are recorded.
pub const RECORDED_EVENTS: &[&str] = &["message", "console", "script_error", "started", "stopped"];

/// A recorder, and the recording that it is making.
#[derive(Default)]
pub struct FilmRecorder {
    /// The records, compressed; `None` before the start and after the end of the recording.
    records: Option<GzEncoder<Vec<u8>>>,
    scene: PageScene,
    changes: ChangeDetector,
    /// The frame entries that were recorded last, by key.
    last_entries: BTreeMap<u32, Vec<f64>>,
    /// The readings that were recorded last.
    sent: SentReadings,
    /// The last recorded drawings, as a JSON message.
    last_drawings: String,
    /// Simulation times of the last recorded readings and drawings, s.
    last_times: [f64; 2],
    /// Number of the step that was recorded last.
    step: Option<u64>,
    /// Simulation time of the current step or event, s.
    time: f64,
    /// Maximum compressed size, bytes. Once it is exceeded, further messages are dropped.
    max_bytes: usize,
    /// Simulation time at which the maximum size was exceeded, s.
    full_time: Option<f64>,
}

impl FilmRecorder {
    /// Creates a recorder with a maximum compressed size of `max_bytes` bytes.
    pub fn new(max_bytes: usize) -> Self {
        FilmRecorder { max_bytes, ..FilmRecorder::default() }
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
        self.full_time
    }

    /// Starts an empty recording.
    fn begin(&mut self) {
        let records = Some(GzEncoder::new(Vec::new(), Compression::default()));
        *self = FilmRecorder { records, ..FilmRecorder::new(self.max_bytes) };
        self.last_times = [f64::NEG_INFINITY; 2];
    }

    /// Appends a record: the length of the message as u32, the simulation time in s as f64, a byte (0: text, 1:
    /// binary), and the message.
    fn record(&mut self, message: &OutgoingMessage) {
        let Some(records) = self.records.as_mut().filter(|_| self.full_time.is_none()) else { return };
        let (kind, bytes): (u8, &[u8]) = match message {
            OutgoingMessage::Text(t) => (0, t.as_bytes()),
            OutgoingMessage::Binary(b) => (1, b),
        };
        let head = [&(bytes.len() as u32).to_le_bytes()[..], &self.time.to_le_bytes(), &[kind]].concat();
        // Writing into memory cannot fail.
        let _ = records.write_all(&head).and_then(|()| records.write_all(bytes));
        if records.get_ref().len() > self.max_bytes {
            self.full_time = Some(self.time);
        }
    }

    /// Appends a frame of the step, and the changed objects, readings and drawings that are due. Starts the recording
    /// if necessary. Does nothing if `step` is already recorded.
    pub fn record_step(&mut self, turn: &Turn<'_>, p: &Props, step: u64) -> Result {
        if self.step == Some(step) {
            return Ok(());
        }
        if self.records.is_none() {
            self.begin();
        }
        self.step = Some(step);
        self.time = turn.f64(0, p.time)?;
        if self.scene.ids != turn.list(0, 0, 0)? {
            self.record_scene(turn, p)?;
        } else {
            match self.changes.compare_next(turn, p, &mut self.scene)? {
                DetectedChange::Unchanged => {}
                DetectedChange::Scene => self.record_scene(turn, p)?,
                DetectedChange::Objects(messages) => messages.iter().for_each(|m| self.record(m)),
            }
        }
        let frame = frames::exact_frame(turn, p, &self.scene, &mut self.last_entries, (step, self.time));
        self.record(&frame);
        // The tolerance covers rounding errors in the simulation time.
        if self.time - self.last_times[0] > READINGS_INTERVAL_S - 1e-9 {
            self.last_times[0] = self.time;
            let new = readings::changed_readings(turn, p, &self.scene, &mut self.sent);
            if !new.is_empty() {
                self.record(&ToPage::Readings { readings: new }.message());
            }
        }
        if self.time - self.last_times[1] > DRAWINGS_INTERVAL_S - 1e-9 {
            self.last_times[1] = self.time;
            let drawn = readings::drawings(turn)?.text();
            if drawn != self.last_drawings {
                self.record(&OutgoingMessage::Text(drawn.clone().into()));
                self.last_drawings = drawn;
            }
        }
        Ok(())
    }

    /// Reads the current scene, and appends it and the sources of its scripts.
    fn record_scene(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        self.scene = scene::read(turn, p, 0)?;
        self.changes.begin(turn, p, &self.scene)?;
        self.sent = SentReadings::default();
        self.last_entries.clear();
        for script in turn.scripts(0)? {
            if let Ok(text) = requests::script(turn, tatu_slot(script)) {
                self.record(&text.message());
            }
        }
        for message in std::mem::take(&mut self.scene.messages) {
            self.record(&message);
        }
        Ok(())
    }
}
