//! The service `web`: executes requests from clients, and queues messages to them, at each barrier.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
    io::Write,
    time::Instant,
};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Answer, Fail, Host, Param, Params, Result, Service, Session, Turn, ValueRef},
};
use tatu_services_common::{
    json,
    listener::{Client, Listener, Rights, Settings},
    outbox::{Message, Utf8Bytes},
};

use crate::{
    acts,
    changes::Changes,
    drop::{Dropped, Folder},
    edits::{self, Known},
    files, film_page,
    lists::{Allowance, Lists},
    opened::Opened,
    overlays::Wanted,
    pace::{Pace, SPEEDS},
    plugin::{Props, WebPage},
    protocol::{Action, FromPage, ToPage},
    readings,
    recent::Recent,
    recorder::{EVENTS, Recorder},
    scene::Whole,
    watch::Watch,
    windows::{self, Windows},
};

/// Version of the protocol between the page and the program.
const VERSION: u32 = 3;
/// Maximum size of a message from a client, bytes.
const MOST_MESSAGE: usize = 4 << 20;
/// Maximum number of messages from a client with control rights that are processed per barrier.
const AT_ONCE: usize = 500;
/// Maximum number of messages from a client with view rights only that are processed per barrier.
const LOOKS_AT_ONCE: usize = 20;
/// Maximum compressed size of a client's film, bytes; the film is sent in base64 as a single message.
const MOST_FILM: usize = 64 << 20;
/// Maximum number of sensors whose images a client may request at the same time, and of graphs.
const MOST_SHOWN: usize = 8;
/// Maximum number of output messages that are stored for new clients.
const MOST_LINES: usize = 500;

/// The service `web`.
pub struct Web {
    p: Props,
    state: RefCell<State>,
}

/// The state of the service `web`.
pub(crate) struct State {
    /// The connected clients.
    pub(crate) guests: Vec<Guest>,
    pub(crate) whole: Whole,
    pub(crate) changes: Changes,
    /// Start time of the last round of comparisons by `changes`; `None` if a round is due.
    pub(crate) last_round: Option<Instant>,
    /// Whether objects have changed since `whole` was read, so its messages must be built again for a new client.
    pub(crate) is_old: bool,
    /// Address of the world whose scene was read, which identifies the world.
    pub(crate) world: usize,
    /// Number of scenes opened so far.
    pub(crate) opened_before: u32,
    /// The newest messages with output of the simulation, for new clients.
    pub(crate) lines: Vec<Message>,
    pub(crate) windows: Windows,
    pub(crate) pace: Pace,
    /// Whether the simulation is held between two steps, as after a single step.
    pub(crate) held: bool,
    /// Number of single steps that remain to be run while the simulation is held.
    pub(crate) singles: u64,
    pub(crate) last_frame: Instant,
    pub(crate) last_readings: Instant,
    /// The last `state` message, as JSON.
    pub(crate) told: String,
    /// The last message with drawings, as JSON.
    pub(crate) drawn: String,
    /// Version of the drawings: the number of times that they have changed.
    pub(crate) drawings: u64,
    pub(crate) sent: readings::Sent,
    pub(crate) listener: Listener,
    pub(crate) lists: Lists,
    pub(crate) recent: Recent,
    pub(crate) edits: Known,
    /// The file that passes the address to the browser; removed when a client with control rights connects.
    pub(crate) opened: Option<Opened>,
}

/// The state of a client.
pub(crate) struct Guest {
    pub(crate) client: Client,
    /// The frame entries that were sent to the client last, by key.
    pub(crate) known: BTreeMap<u32, [u8; 20]>,
    /// Whether the client has received the current scene.
    pub(crate) whole: bool,
    /// Handles of the sensors whose images the client has requested.
    pub(crate) images: Vec<u32>,
    /// Handles of the graphs whose streams the client has requested.
    pub(crate) graphs: Vec<u32>,
    /// The values that the client watches.
    pub(crate) watch: Watch,
    /// The film that the client is recording.
    pub(crate) film: Option<Recorder>,
    /// The overlays that the client has requested.
    pub(crate) overlays: Wanted,
    /// Whether messages to the client were still queued when `show` started to queue new ones.
    pub(crate) waits: bool,
    /// Whether the client has missed readings that were sent to other clients.
    pub(crate) missed: bool,
    /// Version of the drawings that the client received last.
    pub(crate) drawings: u64,
    /// The dropped file that is being received.
    pub(crate) dropped: Option<Dropped>,
    /// The folder that the client created last for dropped files.
    pub(crate) folder: Option<Folder>,
    /// The requests that the client may still make; used only for clients with view rights only.
    pub(crate) allowance: Allowance,
}

impl Service for Web {
    type Plugin = WebPage;
    const ID: &'static str = "web";
    const TEXT: &'static str = "A page in the browser that shows and controls the world.";
    const EVENTS: &'static [&'static str] = &["*"];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65535.0).default(0).text("port on 127.0.0.1 to listen on; 0: any free port"),
            Param::bool("browser").default(false).text("whether to open the page in a browser"),
            Param::float("speed")
                .range(0.0, SPEEDS.1)
                .default(1.0)
                .text("initial speed as a multiple of real time; 0: as fast as possible"),
        ]
    }

    fn start(plugin: &WebPage, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let settings = Settings {
            service: Self::ID,
            port: params.i64("port")? as u16,
            path: "/ws",
            token: true,
            origins: Vec::new(),
            most_message: MOST_MESSAGE,
            files: files::page,
            wake: Box::new({
                let session = session.clone();
                move || session.wake()
            }),
            heard: Box::new({
                let session = session.clone();
                move |text| {
                    if acts::ends_scripts(text) {
                        session.stop();
                    }
                }
            }),
        };
        let listener = Listener::open(settings).map_err(|e| {
            let port = params.i64("port").unwrap_or(0);
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("end the program that uses the port, or choose another one; 0 selects a free port")
        })?;
        let url = format!("http://{}/?token={}", listener.address, listener.token);
        if let Some(e) = &listener.unkept {
            let text = format!(
                "the page will have a different address in the next run, because its access token cannot be stored: {e}"
            );
            session.log(TATU_LOG_INFO, &text);
        }
        // The address is printed alone on a line of stdout, so that programs can read it. It is not logged, because
        // logs must not contain the token.
        let mut out = std::io::stdout();
        let _ = writeln!(out, "{url}").and_then(|()| out.flush());
        let mut opened = None;
        if params.bool("browser")? {
            match Opened::start(&url) {
                Ok(file) => opened = Some(file),
                Err(e) => session.log(
                    TATU_LOG_INFO,
                    &format!("no browser could be started ({e}): open the address above in a browser"),
                ),
            }
        }
        let now = Instant::now();
        let state = State {
            guests: Vec::new(),
            whole: Whole::default(),
            changes: Changes::default(),
            last_round: None,
            is_old: false,
            world: 0,
            opened_before: 0,
            lines: Vec::new(),
            windows: Windows::default(),
            pace: Pace::new(params.f64("speed")?, session),
            held: false,
            singles: 0,
            last_frame: now,
            last_readings: now,
            told: String::new(),
            drawn: String::new(),
            drawings: 0,
            sent: readings::Sent::default(),
            listener,
            lists: Lists::default(),
            recent: Recent::of_user(),
            edits: Known::default(),
            opened,
        };
        Ok(Web { p: plugin.p, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer> {
        let state = &mut *self.state()?;
        let running = turn.state() == TATU_RUNNING;
        state.come(turn)?;
        state.hear(turn, &self.p)?;
        state.attend(turn);
        state.edits.keep(turn);
        state.record(turn, &self.p, step)?;
        state.show(turn, &self.p, step)?;
        // A world that is not running must not be held, because its scripts are still called.
        if !running {
            state.pace.again();
            return Ok(Answer::Go);
        }
        if state.held {
            if state.singles == 0 {
                state.pace.again();
                return Ok(Answer::Hold);
            }
            state.singles -= 1;
            return Ok(Answer::Go);
        }
        let time = turn.f64(0, self.p.time)?;
        Ok(if state.pace.is_due(time) { Answer::Go } else { Answer::Hold })
    }

    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        if EVENTS.contains(&name) {
            let films = state.guests.iter_mut().filter_map(|g| g.film.as_mut());
            films.for_each(|film| film.event(turn, &self.p, name, payload));
        }
        if matches!(name, edits::EVENT | "stopped") {
            state.edits.changed();
        }
        if name == "stopped" {
            (state.held, state.singles) = (false, 0);
            state.windows.clear();
        }
        if matches!(name, "started" | "resumed") {
            state.pace.again();
        }
        let payload = payload.to_value().map_or(Json::Null, |v| json::write(&v));
        if name == windows::EVENT {
            state.windows.hear(&payload);
        }
        let message = ToPage::Event { name: name.to_owned(), payload }.message();
        if matches!(name, "message" | "console" | "script_error" | "started") {
            if name == "started" {
                state.lines.clear();
            }
            state.lines.push(message.clone());
            let over = state.lines.len().saturating_sub(MOST_LINES);
            state.lines.drain(..over);
        }
        state.guests.iter().for_each(|g| g.client.out.send(message.clone()));
    }
}

impl Web {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

/// Removes duplicates, and keeps at most `MOST_SHOWN` objects.
fn few(mut objects: Vec<u32>) -> Vec<u32> {
    objects.sort_unstable();
    objects.dedup();
    objects.truncate(MOST_SHOWN);
    objects
}

impl State {
    /// Records the current step in the films of clients, and samples the values that clients watch.
    fn record(&mut self, turn: &Turn<'_>, p: &Props, step: u64) -> Result {
        if turn.state() == TATU_STOPPED {
            return Ok(());
        }
        let time = turn.f64(0, p.time)?;
        for guest in &mut self.guests {
            guest.watch.look(turn, time);
            if let Some(film) = &mut guest.film {
                film.look(turn, p, step)?;
            }
        }
        Ok(())
    }

    /// Adds clients that have connected and queues their first messages, and removes clients that have disconnected.
    fn come(&mut self, _: &Turn<'_>) -> Result {
        for client in self.listener.take_new() {
            let acts = client.role == Rights::Act;
            if acts {
                self.opened = None;
            }
            // The view-only address is sent only to clients with control rights, which may share it.
            let look = acts.then(|| format!("http://{}/?token={}", self.listener.address, self.listener.look_token));
            let hello = ToPage::Hello { version: VERSION, acts, look, speed: self.pace.speed };
            client.out.send(hello.message());
            self.lines.iter().cloned().chain(self.windows.messages()).for_each(|m| client.out.send(m));
            self.told.clear();
            self.guests.push(Guest {
                client,
                known: BTreeMap::new(),
                whole: false,
                images: Vec::new(),
                graphs: Vec::new(),
                watch: Watch::default(),
                film: None,
                overlays: Wanted::default(),
                waits: false,
                missed: true,
                drawings: 0,
                dropped: None,
                folder: None,
                allowance: Allowance::new(),
            });
        }
        self.guests.retain(|g| !g.client.is_gone());
        Ok(())
    }

    /// If a client with control rights is connected, makes new dialogs of scripts wait for its answer.
    fn attend(&mut self, turn: &Turn<'_>) {
        if !self.guests.iter().any(|g| g.client.role == Rights::Act) {
            return;
        }
        for (act, window) in self.windows.asking() {
            // Fails if the dialog has been closed in the meantime.
            let _ = acts::call(turn, &act, &[json!(window), json!(0), json!("attend")]);
        }
    }

    /// Executes queued requests of all clients, up to a limit per client, and queues the answers.
    fn hear(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let mut guests = std::mem::take(&mut self.guests);
        // Clients with control rights are processed first, so that viewers do not delay them.
        let (acting, looking): (Vec<_>, Vec<_>) = guests.iter_mut().partition(|g| g.client.role == Rights::Act);
        for guest in acting.into_iter().chain(looking) {
            turn.client(guest.client.number);
            let acts = guest.client.role == Rights::Act;
            for _ in 0..if acts { AT_ONCE } else { LOOKS_AT_ONCE } {
                if !acts && !guest.allowance.may_ask() {
                    break;
                }
                let Some(line) = guest.client.next() else { break };
                let asked = match FromPage::read(&line) {
                    Ok(asked) => asked,
                    Err(refused) => {
                        guest.allowance.spend(false);
                        let error = ToPage::Error { error: refused.text, help: None, of: refused.of };
                        guest.client.out.send(error.message());
                        continue;
                    }
                };
                let list = self.list(turn, &asked, acts);
                guest.allowance.spend(list.is_some());
                if let Some(list) = list {
                    guest.client.out.send(Message::Text(list));
                    continue;
                }
                let of = asked.id();
                let answer = match self.act(turn, p, guest, asked) {
                    Ok(Some(answer)) => answer,
                    Ok(None) => continue,
                    Err(fail) => {
                        ToPage::Error { error: fail.text().to_owned(), help: fail.help_text().map(str::to_owned), of }
                    }
                };
                guest.client.out.send(answer.message());
            }
        }
        self.guests = guests;
        Ok(())
    }

    /// Returns the answer to a request for a list, or `None` for other requests. For clients with control rights, the
    /// list is built again, so that it includes files that were just saved.
    fn list(&mut self, turn: &Turn<'_>, asked: &FromPage, acts: bool) -> Option<Utf8Bytes> {
        match asked {
            FromPage::Commands {} => Some(self.lists.commands(turn, acts)),
            FromPage::Files {} => Some(self.lists.files(acts.then_some(&self.recent))),
            _ => None,
        }
    }

    /// Executes a request, and returns the answer if there is one.
    fn act(&mut self, turn: &Turn<'_>, p: &Props, guest: &mut Guest, asked: FromPage) -> Result<Option<ToPage>> {
        let may_act = guest.client.role == Rights::Act;
        match asked {
            FromPage::Details { object } => return acts::details(turn, object).map(Some),
            FromPage::Script { script } => return acts::script(turn, script).map(Some),
            FromPage::Data { object } => return acts::data(turn, p, object).map(Some),
            FromPage::Images { objects } => guest.images = few(objects),
            FromPage::Graphs { objects } => guest.graphs = few(objects),
            FromPage::Watch { of, values } => guest.watch = Watch::new(turn, of, &values),
            FromPage::Overlays { contacts, bodies } => guest.overlays = Wanted { contacts, bodies },
            FromPage::Commands {} | FromPage::Files {} => {}
            _ if !may_act => {
                return Err(Fail::unsupported(
                    "this page may only view the world: to control it, open the address that the program printed",
                ));
            }
            FromPage::Run { action } => self.request(turn, action)?,
            FromPage::Speed { speed } => {
                self.pace.speed = if speed <= 0.0 { 0.0 } else { speed.clamp(SPEEDS.0, SPEEDS.1) };
                self.pace.again();
            }
            FromPage::Key { key } => {
                acts::call(turn, "tatu.press", &[json!(key)])?;
            }
            FromPage::Folder { id, name } => {
                let folder = guest.folder.insert(Folder::new(turn, &name)?);
                return Ok(Some(ToPage::Result { of: id, results: vec![json!(folder.name())] }));
            }
            FromPage::SaveScript { id, script, text, version } => {
                self.last_round = None;
                let result = acts::save_script(turn, p, script, &text, version)?;
                return Ok(Some(ToPage::Result { of: id, results: vec![result] }));
            }
            FromPage::Drop { id, file: name, part, last, folder } => {
                let mut file = match (guest.dropped.take(), folder) {
                    (Some(file), _) => file,
                    (None, None) => Dropped::new(&name)?,
                    (None, Some(folder)) => match &mut guest.folder {
                        Some(own) if own.name() == folder => own.file(&name)?,
                        _ => {
                            return Err(Fail::argument(format!(
                                "`{folder}` is not the folder that the last `folder` request of this page created"
                            )));
                        }
                    },
                };
                file.take(&part)?;
                if last {
                    if let Some(folder) = &mut guest.folder {
                        folder.count(&file)?;
                    }
                    return Ok(Some(ToPage::Result { of: id, results: vec![json!(file.write(turn)?)] }));
                }
                guest.dropped = Some(file);
            }
            FromPage::Open { id, file } => {
                acts::open(turn, &self.recent, &file)?;
                return Ok(Some(ToPage::Result { of: id, results: Vec::new() }));
            }
            FromPage::Picture { scene, png } => acts::picture(&self.recent, &scene, &png)?,
            FromPage::Film { id, on: true } => {
                film_page::check()?;
                guest.film.get_or_insert_with(|| Recorder::new(MOST_FILM));
                return Ok(Some(ToPage::Result { of: id, results: Vec::new() }));
            }
            FromPage::Film { id, on: false } => {
                let Some(mut film) = guest.film.take() else {
                    return Ok(Some(ToPage::Result { of: id, results: vec![Json::Null, Json::Null] }));
                };
                let recording = film.finish().transpose();
                let recording = recording.map_err(|e| Fail::new(format!("the film could not be created: {e}")))?;
                let page = recording.map(|bytes| STANDARD.encode(film_page::page(&bytes)));
                return Ok(Some(ToPage::Result { of: id, results: vec![json!(page), json!(film.full_at())] }));
            }
            FromPage::Call { id, name, args } => {
                self.last_round = None;
                self.edits.look_again();
                return Ok(Some(ToPage::Result { of: id, results: acts::call(turn, &name, &args)? }));
            }
        }
        Ok(None)
    }

    /// Executes a `run` request.
    fn request(&mut self, turn: &Turn<'_>, action: Action) -> Result {
        self.pace.again();
        match action {
            // A held simulation is not paused, so it need not be resumed.
            Action::Start if self.held && turn.state() == TATU_RUNNING => {
                self.held = false;
                Ok(())
            }
            Action::Step => {
                // Resuming from a pause already runs one step.
                let more = u64::from(turn.state() != TATU_PAUSED);
                if turn.state() != TATU_RUNNING {
                    turn.request(acts::request(action))?;
                }
                (self.held, self.singles) = (true, self.singles + more);
                Ok(())
            }
            _ => turn.request(acts::request(action)),
        }
    }
}

impl Drop for State {
    fn drop(&mut self) {
        self.guests.iter().for_each(|g| g.client.out.cut());
    }
}
