//! Films: records the messages that clients would receive, in full precision, and writes them as a page that needs no
//! server.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
    fs::File,
    io::Write,
    path::PathBuf,
};

use flate2::{Compression, write::GzEncoder};
use serde_json::Value as Json;
use tatu_plugin_api::{
    abi::*,
    safe::{Answer, Fail, Host, Param, Params, Result, Service, Session, Turn, ValueRef},
};
use tatu_services_common::{json, outbox::Message};

use crate::{
    acts,
    changes::{Changes, Found},
    film_page, frames,
    plugin::{Props, WebPage},
    protocol::ToPage,
    readings::{self, Sent},
    scene::{self, Whole},
};

/// Simulation time between recorded readings, and between drawings, s.
const READINGS: f64 = 0.1;
const DRAWINGS: f64 = 1.0;
/// Most compressed bytes of a recording; later messages are dropped, and that is reported.
const MOST: usize = 500 << 20;
/// Events that are recorded.
const EVENTS: &[&str] = &["message", "console", "script_error", "started", "stopped"];

/// The service.
pub struct Film {
    p: Props,
    session: Session,
    file: PathBuf,
    state: RefCell<State>,
}

#[derive(Default)]
struct State {
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
    full: bool,
}

impl Service for Film {
    type Plugin = WebPage;
    const ID: &'static str = "film";
    const TEXT: &'static str = "Records a run and writes it as a page that shows it without a program.";
    const EVENTS: &'static [&'static str] = EVENTS;

    fn params() -> Vec<Param> {
        vec![Param::string("page").text("the page that is written when the run ends")]
    }

    fn start(plugin: &WebPage, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let file = PathBuf::from(params.string("page")?);
        film_page::check()?;
        // Report before the run starts if the file cannot be written.
        let made = File::options().append(true).create(true).open(&file);
        made.map_err(|e| Fail::new(format!("the file `{}` could not be created: {e}", file.display())))?;
        Ok(Film { p: plugin.p, session, file, state: RefCell::default() })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer> {
        if turn.state() != TATU_STOPPED {
            self.state()?.look(turn, &self.p, step)?;
        }
        Ok(Answer::Go)
    }

    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        if name == "started" {
            state.begin();
        }
        let payload = payload.to_value().map_or(Json::Null, |v| json::write(&v));
        // Events are delivered at the end of their stage, before the next frame.
        if let Ok(time) = turn.f64(0, self.p.time) {
            state.time = time;
        }
        state.record(&ToPage::Event { name: name.to_owned(), payload }.message());
        if name == "stopped" {
            self.write(&mut state);
        }
    }
}

/// A session that ends before its world was stopped leaves the film of what there was.
impl Drop for Film {
    fn drop(&mut self) {
        if let Ok(mut state) = self.state.try_borrow_mut() {
            self.write(&mut state);
        }
    }
}

impl Film {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the film is in use"))
    }

    fn write(&self, state: &mut State) {
        let Some(records) = state.records.take() else { return };
        let file = self.file.display();
        let done =
            records.finish().and_then(|bytes| File::create(&self.file)?.write_all(film_page::page(&bytes).as_bytes()));
        match done {
            Err(e) => self.session.log(TATU_LOG_ERROR, &format!("the film `{file}` could not be written: {e}")),
            Ok(()) if state.full => {
                let text =
                    format!("the film `{file}` ends at {:.1} s: no more than {MOST} bytes are recorded", state.time);
                self.session.log(TATU_LOG_WARNING, &text);
            }
            Ok(()) => {}
        }
    }
}

impl State {
    fn begin(&mut self) {
        *self = State { records: Some(GzEncoder::new(Vec::new(), Compression::default())), ..State::default() };
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
        self.full = records.get_ref().len() > MOST;
    }

    fn look(&mut self, turn: &Turn<'_>, p: &Props, step: u64) -> Result {
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
        self.whole = scene::read(turn, p)?;
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
