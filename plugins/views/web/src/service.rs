//! The service `web`: executes requests from clients, and queues messages to them, at each barrier.

use std::{
    cell::{RefCell, RefMut},
    collections::VecDeque,
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
    listener::{ListenerSettings, Rights, WebSocketClient, WebSocketListener},
    outbox::{OutgoingMessage, Utf8Bytes},
};

use crate::{
    browser::BrowserRedirect,
    changes::ChangeDetector,
    drop::{DropFolder, DroppedFile},
    edits::{self, EditTracker},
    files, film_page,
    frames::SentFrame,
    gallery,
    lists::{ListCache, RequestAllowance},
    overlays::OverlayRequest,
    pace::{RealTimePacer, SPEED_RANGE},
    plugin::{Props, WebPage},
    protocol::{FromPage, OutputLine, RunAction, ToPage},
    readings,
    recent::RecentScenes,
    recorder::{FilmRecorder, RECORDED_EVENTS},
    requests,
    scene::PageScene,
    sent::{SentMessages, Subject},
    watch::ValueWatch,
    windows::{self, ScriptWindows},
};

/// Version of the protocol between the page and the program.
const PROTOCOL_VERSION: u32 = 4;
/// Maximum size of a message from a client, bytes.
const MAX_MESSAGE_BYTES: usize = 4 << 20;
/// Maximum number of messages from a client with control rights that are processed per barrier.
const MAX_REQUESTS_PER_BARRIER: usize = 500;
/// Maximum number of messages from a client with view rights only that are processed per barrier.
const MAX_VIEWER_REQUESTS_PER_BARRIER: usize = 20;
/// Maximum compressed size of a client's film, bytes; the film is sent in base64 as a single message.
const MAX_FILM_BYTES: usize = 64 << 20;
/// Maximum number of sensors whose images a client may request at the same time, and of graphs.
const MAX_REQUESTED_OBJECTS: usize = 8;
/// Maximum number of output lines that are stored for new clients.
const MAX_OUTPUT_LINES: usize = 500;

/// The service `web`, which serves the page and exchanges messages with it.
pub struct WebService {
    p: Props,
    state: RefCell<WebState>,
}

/// The state of the service `web`, which changes at each barrier.
pub(crate) struct WebState {
    /// The connected clients.
    pub(crate) clients: Vec<PageClient>,
    pub(crate) view: SceneView,
    /// The newest lines of output of the simulation, for new clients.
    pub(crate) output: VecDeque<OutputLine>,
    /// The lines of output that are sent with the next frame.
    pub(crate) unsent_output: Vec<OutputLine>,
    pub(crate) windows: ScriptWindows,
    pub(crate) pacing: RunPacing,
    /// The last `state` message, as JSON.
    pub(crate) last_state: String,
    pub(crate) drawings: DrawingRecord,
    pub(crate) sent_readings: readings::SentReadings,
    pub(crate) listener: WebSocketListener,
    pub(crate) lists: ListCache,
    pub(crate) recent: RecentScenes,
    pub(crate) edits: EditTracker,
    /// The file that passes the address to the browser; removed when a client with control rights connects.
    pub(crate) browser_redirect: Option<BrowserRedirect>,
}

/// The scene as it was sent to clients.
pub(crate) struct SceneView {
    pub(crate) scene: PageScene,
    pub(crate) changes: ChangeDetector,
    /// Start time of the last round of comparisons by `changes`; `None` if a round is due.
    pub(crate) last_round: Option<Instant>,
    /// Whether objects have changed since `whole` was read, so its messages must be built again for a new client.
    pub(crate) scene_outdated: bool,
    /// Address of the world whose scene was read, which identifies the world.
    pub(crate) world: usize,
    /// Number of scenes opened so far.
    pub(crate) scenes_opened: u32,
}

/// The pace of the run, and of the messages.
pub(crate) struct RunPacing {
    pub(crate) pace: RealTimePacer,
    /// Whether the simulation is held between two steps, as after a single step.
    pub(crate) held: bool,
    /// Number of single steps that remain to be run while the simulation is held.
    pub(crate) pending_steps: u64,
    pub(crate) last_frame: Instant,
    /// When a client last requested something, or something was last seen to change.
    pub(crate) last_activity: Instant,
    pub(crate) last_readings: Instant,
    pub(crate) last_details: Instant,
}

/// The drawings that were sent last.
pub(crate) struct DrawingRecord {
    /// The last message with drawings, as JSON.
    pub(crate) last_drawings: String,
    /// Version of the drawings: the number of times that they have changed.
    pub(crate) drawings_version: u64,
}

/// The handles of the objects of which a client receives what they measure or record.
#[derive(Default)]
pub(crate) struct RequestedStreams {
    /// Sensors whose images are sent.
    pub(crate) images: Vec<u32>,
    /// Sensors whose depths are sent.
    pub(crate) depths: Vec<u32>,
    /// Graphs whose curves are sent.
    pub(crate) graphs: Vec<u32>,
}

/// The state of a client.
pub(crate) struct PageClient {
    pub(crate) client: WebSocketClient,
    /// The last frame that was sent to the client.
    pub(crate) sent_frame: SentFrame,
    /// What the client has received last.
    pub(crate) sent: SentMessages,
    /// Whether the client has received the current scene.
    pub(crate) scene_sent: bool,
    pub(crate) streams: RequestedStreams,
    /// The handle of the object whose properties the client follows; 0: none.
    pub(crate) followed: u32,
    /// The values that the client watches.
    pub(crate) watch: ValueWatch,
    /// The film that the client is recording.
    pub(crate) film: Option<FilmRecorder>,
    /// The overlays that the client has requested.
    pub(crate) overlays: OverlayRequest,
    /// Whether messages to the client were still queued when `queue_messages` started to queue new ones.
    pub(crate) has_backlog: bool,
    /// Whether the client has missed readings that were sent to other clients.
    pub(crate) missed_readings: bool,
    /// Version of the drawings that the client received last.
    pub(crate) drawings_version: u64,
    /// The dropped file that is being received.
    pub(crate) incoming_file: Option<DroppedFile>,
    /// The folder that the client created last for dropped files.
    pub(crate) drop_folder: Option<DropFolder>,
    /// The requests that the client may still make; used only for clients with view rights only.
    pub(crate) allowance: RequestAllowance,
}

impl Service for WebService {
    type Plugin = WebPage;
    const ID: &'static str = "web";
    const TEXT: &'static str = "A page in the browser that shows and controls the world.";
    const EVENTS: &'static [&'static str] = &["*"];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65535.0).default(0).text("port on 127.0.0.1 to listen on; 0: any free port"),
            Param::bool("browser").default(false).text("whether to open the page in a browser"),
            Param::float("speed")
                .range(0.0, SPEED_RANGE.1)
                .default(1.0)
                .text("initial speed as a multiple of real time; 0: as fast as possible"),
        ]
    }

    fn start(plugin: &WebPage, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let settings = ListenerSettings {
            service: Self::ID,
            port: params.i64("port")? as u16,
            path: "/ws",
            token: true,
            origins: Vec::new(),
            max_message_bytes: MAX_MESSAGE_BYTES,
            files: files::embedded_file,
            wake: Box::new({
                let session = session.clone();
                move || session.wake()
            }),
            on_message: Box::new({
                let session = session.clone();
                move |text| {
                    if requests::requests_stop(text) {
                        session.stop();
                    }
                }
            }),
        };
        let listener = WebSocketListener::open(settings).map_err(|e| {
            let port = params.i64("port").unwrap_or(0);
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("end the program that uses the port, or choose another one; 0 selects a free port")
        })?;
        let url = format!("http://{}/?token={}", listener.address, listener.token);
        if let Some(e) = &listener.token_error {
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
            match BrowserRedirect::open_browser(&url) {
                Ok(file) => opened = Some(file),
                Err(e) => session.log(
                    TATU_LOG_INFO,
                    &format!("no browser could be started ({e}): open the address above in a browser"),
                ),
            }
        }
        let now = Instant::now();
        let state = WebState {
            clients: Vec::new(),
            view: SceneView {
                scene: PageScene::default(),
                changes: ChangeDetector::default(),
                last_round: None,
                scene_outdated: false,
                world: 0,
                scenes_opened: 0,
            },
            output: VecDeque::new(),
            unsent_output: Vec::new(),
            windows: ScriptWindows::default(),
            pacing: RunPacing {
                pace: RealTimePacer::new(params.f64("speed")?, session),
                held: false,
                pending_steps: 0,
                last_frame: now,
                last_activity: now,
                last_readings: now,
                last_details: now,
            },
            last_state: String::new(),
            drawings: DrawingRecord { last_drawings: String::new(), drawings_version: 0 },
            sent_readings: readings::SentReadings::default(),
            listener,
            lists: ListCache::default(),
            recent: RecentScenes::of_user(),
            edits: EditTracker::default(),
            browser_redirect: opened,
        };
        Ok(WebService { p: plugin.p, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer> {
        let state = &mut *self.state()?;
        let running = turn.state() == TATU_RUNNING;
        state.accept_clients(turn)?;
        state.handle_requests(turn, &self.p)?;
        state.defer_dialogs(turn);
        state.edits.write_backup(turn);
        state.record_step(turn, &self.p, step)?;
        state.queue_messages(turn, &self.p, step)?;
        // A world that is not running must not be held, because its scripts are still called.
        if !running {
            state.pacing.pace.reset();
            return Ok(Answer::Go);
        }
        if state.pacing.held {
            if state.pacing.pending_steps == 0 {
                state.pacing.pace.reset();
                return Ok(Answer::Hold);
            }
            state.pacing.pending_steps -= 1;
            return Ok(Answer::Go);
        }
        let time = turn.f64(0, self.p.time)?;
        Ok(if state.pacing.pace.is_due(time) { Answer::Go } else { Answer::Hold })
    }

    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        if RECORDED_EVENTS.contains(&name) {
            let films = state.clients.iter_mut().filter_map(|g| g.film.as_mut());
            films.for_each(|film| film.event(turn, &self.p, name, payload));
        }
        if matches!(name, edits::EDITED_EVENT | "stopped") {
            state.edits.mark_edited();
        }
        if name == "stopped" {
            (state.pacing.held, state.pacing.pending_steps) = (false, 0);
            state.windows.clear();
        }
        if matches!(name, "started" | "resumed") {
            state.pacing.pace.reset();
        }
        let payload = payload.to_value().map_or(Json::Null, |v| json::write(&v));
        if name == windows::WINDOW_EVENT {
            state.windows.apply_event(&payload);
        }
        if name == "started" {
            state.output.clear();
        }
        let line = OutputLine { name: name.to_owned(), payload };
        if matches!(name, "message" | "console" | "script_error" | "started") {
            state.output.push_back(line.clone());
            if state.output.len() > MAX_OUTPUT_LINES {
                state.output.pop_front();
            }
        }
        // Scripts may print many lines in each step, so lines are sent together. Other events follow the lines that
        // precede them immediately.
        if matches!(name, "message" | "console") {
            state.unsent_output.push(line);
            return;
        }
        state.queue_output();
        let message = ToPage::Event { name: line.name, payload: line.payload }.message();
        state.clients.iter().for_each(|g| g.client.out.send(message.clone()));
    }
}

impl WebService {
    fn state(&self) -> Result<RefMut<'_, WebState>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

/// Removes duplicates, and keeps at most `MAX_REQUESTED_OBJECTS` objects.
fn dedup_and_truncate(mut objects: Vec<u32>) -> Vec<u32> {
    objects.sort_unstable();
    objects.dedup();
    objects.truncate(MAX_REQUESTED_OBJECTS);
    objects
}

impl WebState {
    /// Records the current step in the films of clients, and samples the values that clients watch.
    fn record_step(&mut self, turn: &Turn<'_>, p: &Props, step: u64) -> Result {
        if turn.state() == TATU_STOPPED {
            return Ok(());
        }
        let time = turn.f64(0, p.time)?;
        for guest in &mut self.clients {
            guest.watch.sample(turn, time);
            if let Some(film) = &mut guest.film {
                film.record_step(turn, p, step)?;
            }
        }
        Ok(())
    }

    /// Adds clients that have connected and queues their first messages, and removes clients that have disconnected.
    fn accept_clients(&mut self, _: &Turn<'_>) -> Result {
        let new = self.listener.take_new();
        if !new.is_empty() {
            self.queue_output();
        }
        for client in new {
            let acts = client.rights == Rights::Control;
            if acts {
                self.browser_redirect = None;
            }
            // The view-only address is sent only to clients with control rights, which may share it.
            let look = acts.then(|| format!("http://{}/?token={}", self.listener.address, self.listener.view_token));
            let folder =
                std::env::current_dir().ok().filter(|_| acts).map(|folder| folder.to_string_lossy().into_owned());
            let hello = ToPage::Hello { version: PROTOCOL_VERSION, acts, look, folder, speed: self.pacing.pace.speed };
            client.out.send(hello.message());
            if !self.output.is_empty() {
                client.out.send(ToPage::Output { lines: self.output.iter().cloned().collect() }.message());
            }
            self.windows.messages().for_each(|m| client.out.send(m));
            self.last_state.clear();
            self.clients.push(PageClient {
                client,
                sent_frame: SentFrame::default(),
                sent: SentMessages::default(),
                followed: 0,
                scene_sent: false,
                streams: RequestedStreams::default(),
                watch: ValueWatch::default(),
                film: None,
                overlays: OverlayRequest::default(),
                has_backlog: false,
                missed_readings: true,
                drawings_version: 0,
                incoming_file: None,
                drop_folder: None,
                allowance: RequestAllowance::new(),
            });
        }
        self.clients.retain(|g| !g.client.is_gone());
        Ok(())
    }

    /// If a client with control rights is connected, makes new dialogs of scripts wait for its answer.
    fn defer_dialogs(&mut self, turn: &Turn<'_>) {
        if !self.clients.iter().any(|g| g.client.rights == Rights::Control) {
            return;
        }
        for (act, window) in self.windows.take_new_dialogs() {
            // Fails if the dialog has been closed in the meantime.
            let _ = requests::call_command(turn, &act, &[json!(window), json!(0), json!("attend")]);
        }
    }

    /// Executes queued requests of all clients, up to a limit per client, and queues the answers.
    fn handle_requests(&mut self, turn: &Turn<'_>, p: &Props) -> Result {
        let mut guests = std::mem::take(&mut self.clients);
        // Clients with control rights are processed first, so that viewers do not delay them.
        let (acting, looking): (Vec<_>, Vec<_>) = guests.iter_mut().partition(|g| g.client.rights == Rights::Control);
        for guest in acting.into_iter().chain(looking) {
            turn.client(guest.client.number);
            let acts = guest.client.rights == Rights::Control;
            for _ in 0..if acts { MAX_REQUESTS_PER_BARRIER } else { MAX_VIEWER_REQUESTS_PER_BARRIER } {
                if !acts && !guest.allowance.may_request() {
                    break;
                }
                let Some(line) = guest.client.next() else { break };
                self.pacing.last_activity = Instant::now();
                let asked = match FromPage::parse(&line) {
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
                    guest.client.out.send(OutgoingMessage::Text(list));
                    continue;
                }
                let of = asked.id();
                let answer = match self.execute_request(turn, p, guest, asked) {
                    Ok(Some(answer)) => answer,
                    Ok(None) => continue,
                    Err(fail) => {
                        ToPage::Error { error: fail.text().to_owned(), help: fail.help_text().map(str::to_owned), of }
                    }
                };
                guest.client.out.send(answer.message());
            }
        }
        self.clients = guests;
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
    fn execute_request(
        &mut self,
        turn: &Turn<'_>,
        p: &Props,
        guest: &mut PageClient,
        asked: FromPage,
    ) -> Result<Option<ToPage>> {
        let may_act = guest.client.rights == Rights::Control;
        match asked {
            FromPage::Details { object, follow } => {
                if follow {
                    guest.followed = object;
                    guest.sent.forget(Subject::Details);
                }
                return (object != 0 || !follow).then(|| requests::details(turn, object)).transpose();
            }
            FromPage::Script { script } => return requests::script(turn, script).map(Some),
            FromPage::Data { object } => return requests::data(turn, p, object).map(Some),
            FromPage::Images { objects, depths } => {
                guest.streams.images = dedup_and_truncate(objects);
                guest.streams.depths = dedup_and_truncate(depths);
                guest.sent.forget(Subject::Image);
                guest.sent.forget(Subject::Depth);
            }
            FromPage::Graphs { objects } => {
                guest.streams.graphs = dedup_and_truncate(objects);
                guest.sent.forget(Subject::Graph);
            }
            FromPage::Watch { of, values } => guest.watch = ValueWatch::new(turn, of, &values),
            FromPage::Overlays { contacts, bodies } => {
                guest.overlays = OverlayRequest { contacts, bodies };
                guest.sent.forget(Subject::Overlays);
            }
            FromPage::Commands {} | FromPage::Files {} => {}
            _ if !may_act => {
                return Err(Fail::unsupported(
                    "this page may only view the world: to control it, open the address that the program printed",
                ));
            }
            FromPage::Run { action } => self.execute_run_action(turn, action)?,
            FromPage::Speed { speed } => {
                self.pacing.pace.speed = if speed <= 0.0 { 0.0 } else { speed.clamp(SPEED_RANGE.0, SPEED_RANGE.1) };
                self.pacing.pace.reset();
            }
            FromPage::Key { key } => {
                requests::call_command(turn, "tatu.press", &[json!(key)])?;
            }
            FromPage::Folder { id, name } => {
                let folder = guest.drop_folder.insert(DropFolder::new(turn, &name)?);
                return Ok(Some(ToPage::Result { of: id, results: vec![json!(folder.name())] }));
            }
            FromPage::SaveScript { id, script, text, version } => {
                self.view.last_round = None;
                let result = requests::save_script(turn, p, script, &text, version)?;
                return Ok(Some(ToPage::Result { of: id, results: vec![result] }));
            }
            FromPage::Drop { id, file: name, part, last, folder } => {
                let mut file = match (guest.incoming_file.take(), folder) {
                    (Some(file), _) => file,
                    (None, None) => DroppedFile::new(&name)?,
                    (None, Some(folder)) => match &mut guest.drop_folder {
                        Some(own) if own.name() == folder => own.file(&name)?,
                        _ => {
                            return Err(Fail::argument(format!(
                                "`{folder}` is not the folder that the last `folder` request of this page created"
                            )));
                        }
                    },
                };
                file.append(&part)?;
                if last {
                    if let Some(folder) = &mut guest.drop_folder {
                        folder.add_size(&file)?;
                    }
                    return Ok(Some(ToPage::Result { of: id, results: vec![json!(file.write(turn)?)] }));
                }
                guest.incoming_file = Some(file);
            }
            FromPage::Open { id, file } => {
                requests::open_scene(turn, &self.recent, &file)?;
                return Ok(Some(ToPage::Result { of: id, results: Vec::new() }));
            }
            FromPage::Picture { scene, png } => requests::store_picture(&self.recent, &scene, &png)?,
            FromPage::ModelPicture { id, model } => {
                let picture = gallery::model_picture(&model).map(|png| STANDARD.encode(png));
                return Ok(Some(ToPage::Result { of: id, results: vec![json!(picture)] }));
            }
            FromPage::Film { id, on: true } => {
                film_page::require_libraries()?;
                guest.film.get_or_insert_with(|| FilmRecorder::new(MAX_FILM_BYTES));
                return Ok(Some(ToPage::Result { of: id, results: Vec::new() }));
            }
            FromPage::Film { id, on: false } => {
                let Some(mut film) = guest.film.take() else {
                    return Ok(Some(ToPage::Result { of: id, results: vec![Json::Null, Json::Null] }));
                };
                let recording = film.finish().transpose();
                let recording = recording.map_err(|e| Fail::new(format!("the film could not be created: {e}")))?;
                let page = recording.map(|bytes| STANDARD.encode(film_page::build_page(&bytes)));
                return Ok(Some(ToPage::Result { of: id, results: vec![json!(page), json!(film.full_at())] }));
            }
            FromPage::Call { id, name, args } => {
                self.view.last_round = None;
                self.edits.invalidate();
                return Ok(Some(ToPage::Result { of: id, results: requests::call_command(turn, &name, &args)? }));
            }
        }
        Ok(None)
    }

    /// Executes a `run` request.
    fn execute_run_action(&mut self, turn: &Turn<'_>, action: RunAction) -> Result {
        self.pacing.pace.reset();
        match action {
            // A held simulation is not paused, so it need not be resumed.
            RunAction::Start if self.pacing.held && turn.state() == TATU_RUNNING => {
                self.pacing.held = false;
                Ok(())
            }
            RunAction::Step => {
                // Resuming from a pause already runs one step.
                let more = u64::from(turn.state() != TATU_PAUSED);
                if turn.state() != TATU_RUNNING {
                    turn.request(requests::run_request(action))?;
                }
                (self.pacing.held, self.pacing.pending_steps) = (true, self.pacing.pending_steps + more);
                Ok(())
            }
            _ => turn.request(requests::run_request(action)),
        }
    }
}

impl Drop for WebState {
    fn drop(&mut self) {
        self.clients.iter().for_each(|g| g.client.out.disconnect());
    }
}
