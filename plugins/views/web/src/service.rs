//! What is done at the barrier: what clients sent is done, and what they are to see is put into their outboxes.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
    io::Write,
    time::{Duration, Instant},
};

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Answer, Fail, Host, Param, Params, Result, Service, Session, Turn, ValueRef},
};
use tatu_services_common::{
    json,
    listener::{Client, Listener, Rights, Settings},
    outbox::Message,
};

use crate::{
    WebPage, acts,
    drop::Dropped,
    files,
    frames::{Now, object},
    pace::{Pace, SPEEDS},
    readings,
    scene::{self, Whole},
    windows::{self, Windows},
};

/// Version of what is sent.
const VERSION: u32 = 1;
/// How often frames are sent, and readings.
const FRAMES: Duration = Duration::from_millis(50);
const READINGS: Duration = Duration::from_millis(100);
/// Bytes of a message from a client.
const MOST_MESSAGE: usize = 4 << 20;
/// Messages of one client in one turn.
const AT_ONCE: usize = 500;
/// Lines that a client which comes late still reads.
const MOST_LINES: usize = 500;

/// The service.
pub struct Web {
    p: crate::Props,
    state: RefCell<State>,
}

struct State {
    guests: Vec<Guest>,
    whole: Whole,
    /// The world that the scene was read of.
    world: usize,
    /// The newest lines of the status bar and the consoles.
    lines: Vec<String>,
    windows: Windows,
    pace: Pace,
    /// Time stands between two steps; after so many it stands again.
    held: bool,
    singles: u64,
    last_frame: Instant,
    last_readings: Instant,
    told: String,
    drawn: String,
    sent: readings::Sent,
    listener: Listener,
}

/// A client.
struct Guest {
    client: Client,
    known: BTreeMap<u32, [u8; 20]>,
    /// Whether it has the scene as it is now.
    whole: bool,
    /// The sensor whose image it sees, and the graph.
    eye: u64,
    graph: u64,
    /// A file that comes in parts.
    dropped: Option<Dropped>,
}

impl Service for Web {
    type Plugin = WebPage;
    const ID: &'static str = "web";
    const TEXT: &'static str = "A page in the browser that shows the world and steers it.";
    const EVENTS: &'static [&'static str] = &["*"];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65535.0).default(0).text("of 127.0.0.1 to listen on; 0: any that is free"),
            Param::bool("browser").default(false).text("whether a browser is started"),
            Param::float("speed")
                .range(0.0, SPEEDS.1)
                .default(1.0)
                .text("how many times as fast as the clock time passes at first; 0: as fast as it goes"),
        ]
    }

    fn start(plugin: &WebPage, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let settings = Settings {
            port: params.i64("port")? as u16,
            path: "/ws",
            most_message: MOST_MESSAGE,
            files: files::page,
            wake: Box::new(move || session.wake()),
        };
        let listener = Listener::open(settings)
            .map_err(|e| Fail::new(format!("cannot listen on 127.0.0.1:{}: {e}", params.i64("port").unwrap_or(0))))?;
        let url = format!("http://{}/?token={}", listener.address, listener.token);
        // Alone on its line, for programs; the token stays out of logs.
        let mut out = std::io::stdout();
        let _ = writeln!(out, "{url}").and_then(|()| out.flush());
        if params.bool("browser")? && std::process::Command::new("xdg-open").arg(&url).spawn().is_err() {
            session.log(TATU_LOG_INFO, "no browser could be started: open the address above in one");
        }
        let now = Instant::now();
        let state = State {
            guests: Vec::new(),
            whole: Whole::default(),
            world: 0,
            lines: Vec::new(),
            windows: Windows::default(),
            pace: Pace::new(params.f64("speed")?, session),
            held: false,
            singles: 0,
            last_frame: now,
            last_readings: now,
            told: String::new(),
            drawn: String::new(),
            sent: readings::Sent::default(),
            listener,
        };
        Ok(Web { p: plugin.p, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer> {
        let state = &mut *self.state()?;
        let running = turn.state() == TATU_RUNNING;
        state.come(turn)?;
        state.hear(turn, step)?;
        state.attend(turn);
        state.show(turn, &self.p, step)?;
        // A world that stands is not held: its own passes go on.
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

    fn event(&self, _: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
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
        let text = json!({ "event": name, "payload": payload }).to_string();
        if matches!(name, "message" | "console" | "script_error" | "started") {
            if name == "started" {
                state.lines.clear();
            }
            state.lines.push(text.clone());
            let over = state.lines.len().saturating_sub(MOST_LINES);
            state.lines.drain(..over);
        }
        state.guests.iter().for_each(|g| g.client.out.send(Message::Text(text.clone())));
    }
}

impl Web {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

impl State {
    /// Who has come and who has gone.
    fn come(&mut self, _: &Turn<'_>) -> Result {
        for client in self.listener.take_new() {
            let acts = client.role == Rights::Act;
            // A link to look only is for whoever may act to pass on.
            let look = acts.then(|| format!("http://{}/?token={}", self.listener.address, self.listener.look_token));
            let hello =
                json!({ "hello": { "version": VERSION, "acts": acts, "look": look, "speed": self.pace.speed } });
            client.out.send(Message::Text(hello.to_string()));
            self.lines.iter().cloned().chain(self.windows.messages()).for_each(|l| client.out.send(Message::Text(l)));
            self.told.clear();
            self.drawn.clear();
            self.sent = readings::Sent::default();
            self.guests.push(Guest { client, known: BTreeMap::new(), whole: false, eye: 0, graph: 0, dropped: None });
        }
        self.guests.retain(|g| !g.client.is_gone());
        Ok(())
    }

    /// Where somebody is there who can answer, dialogs wait for it.
    fn attend(&mut self, turn: &Turn<'_>) {
        if !self.guests.iter().any(|g| g.client.role == Rights::Act) {
            return;
        }
        for (act, window) in self.windows.asking() {
            // One that is gone again needs nobody.
            let _ = acts::call(turn, &act, &[json!(window), json!(0), json!("attend")]);
        }
    }

    /// Does what clients sent.
    fn hear(&mut self, turn: &Turn<'_>, step: u64) -> Result {
        let mut guests = std::mem::take(&mut self.guests);
        for guest in &mut guests {
            turn.client(guest.client.number);
            for _ in 0..AT_ONCE {
                let Some(line) = guest.client.next() else { break };
                let asked: Json = serde_json::from_str(&line).unwrap_or(Json::Null);
                let answer = match self.act(turn, guest, &asked, step) {
                    Ok(Some(answer)) => answer,
                    Ok(None) => continue,
                    Err(fail) => json!({ "error": fail.text(), "help": fail.help_text(), "of": asked.get("id") }),
                };
                guest.client.out.send(Message::Text(answer.to_string()));
            }
        }
        self.guests = guests;
        Ok(())
    }

    fn act(&mut self, turn: &Turn<'_>, guest: &mut Guest, asked: &Json, _: u64) -> Result<Option<Json>> {
        let number = |key: &str| asked.get(key).and_then(Json::as_u64);
        let text = |key: &str| asked.get(key).and_then(Json::as_str);
        let id = asked.get("id").cloned().unwrap_or_default();
        if let Some(n) = number("details") {
            return acts::details(turn, n).map(Some);
        }
        if let Some(n) = number("script") {
            return acts::script(turn, n).map(Some);
        }
        if let Some(n) = number("eye") {
            guest.eye = n;
            return Ok(None);
        }
        if let Some(n) = number("graph") {
            guest.graph = n;
            return Ok(None);
        }
        if asked.get("commands").is_some() {
            return Ok(Some(json!({ "commands": acts::commands(turn) })));
        }
        if asked.get("files").is_some() {
            return Ok(Some(json!({ "files": acts::files() })));
        }
        if guest.client.role != Rights::Act {
            return Err(Fail::unsupported("this page may look only"));
        }
        if let Some(what) = text("do") {
            self.request(turn, what)?;
            return Ok(None);
        }
        if let Some(speed) = asked.get("speed").and_then(Json::as_f64) {
            self.pace.speed = if speed <= 0.0 { 0.0 } else { speed.clamp(SPEEDS.0, SPEEDS.1) };
            self.pace.again();
            return Ok(None);
        }
        if let Some(key) = text("key") {
            acts::call(turn, "tatu.press", &[json!(key)])?;
            return Ok(None);
        }
        if let (Some(name), Some(part)) = (text("drop"), text("part")) {
            let mut file = match guest.dropped.take() {
                Some(file) => file,
                None => Dropped::new(name)?,
            };
            file.take(part)?;
            if asked.get("last") != Some(&Json::Bool(true)) {
                guest.dropped = Some(file);
                return Ok(None);
            }
            return Ok(Some(json!({ "result": [file.write(turn)?], "of": id })));
        }
        if let Some(name) = text("call") {
            let args = asked.get("args").and_then(Json::as_array).map_or(&[][..], Vec::as_slice);
            return Ok(Some(json!({ "result": acts::call(turn, name, args)?, "of": id })));
        }
        Err(Fail::argument("a message that asks for nothing known"))
    }

    fn request(&mut self, turn: &Turn<'_>, what: &str) -> Result {
        self.pace.again();
        match what {
            // Between two steps nothing has to be lifted.
            "start" if self.held && turn.state() == TATU_RUNNING => {
                self.held = false;
                Ok(())
            }
            "step" => {
                // What lifts a pause is a step already.
                let more = u64::from(turn.state() != TATU_PAUSED);
                if turn.state() != TATU_RUNNING {
                    turn.request(TATU_REQUEST_START)?;
                }
                (self.held, self.singles) = (true, self.singles + more);
                Ok(())
            }
            what => turn.request(acts::request(what)?),
        }
    }

    /// Puts into the outboxes what there is to see.
    fn show(&mut self, turn: &Turn<'_>, p: &crate::Props, step: u64) -> Result {
        if self.guests.is_empty() {
            return Ok(());
        }
        let now = Instant::now();
        let fresh = self.guests.iter().any(|g| !g.whole);
        if !fresh && now - self.last_frame < FRAMES {
            return Ok(());
        }
        self.last_frame = now;
        let ids = turn.list(0, 0, 0)?;
        if self.world != turn.raw().addr() || self.whole.ids != ids {
            self.whole = scene::read(turn, p)?;
            self.world = turn.raw().addr();
            self.guests.iter_mut().for_each(|g| g.whole = false);
            self.sent = readings::Sent::default();
        }
        for guest in self.guests.iter_mut().filter(|g| !g.whole) {
            self.whole.messages.iter().for_each(|m| guest.client.out.send(m.clone()));
            guest.known.clear();
            guest.whole = true;
        }
        self.tell(turn, p)?;
        if self.guests.iter().any(|g| g.client.out.wants_frame()) {
            let (all, time) = (Now::read(turn, p, &self.whole)?, turn.f64(0, p.time)?);
            for guest in self.guests.iter_mut().filter(|g| g.client.out.wants_frame()) {
                guest.client.out.frame(all.since(&mut guest.known, step, time));
            }
        }
        if now - self.last_readings >= READINGS {
            self.last_readings = now;
            self.show_readings(turn, p)?;
        }
        Ok(())
    }

    /// What the world does, if that has changed.
    fn tell(&mut self, turn: &Turn<'_>, p: &crate::Props) -> Result {
        let state = match turn.state() {
            TATU_STOPPED => "stopped",
            TATU_PAUSED => "paused",
            _ if self.held => "paused",
            _ => "running",
        };
        let text = json!({ "state": state, "speed": self.pace.speed, "dt": turn.f64(0, p.dt)? }).to_string();
        if text != self.told {
            self.guests.iter().for_each(|g| g.client.out.send(Message::Text(text.clone())));
            self.told = text;
        }
        Ok(())
    }

    fn show_readings(&mut self, turn: &Turn<'_>, p: &crate::Props) -> Result {
        let new = readings::new(turn, p, &self.whole, &mut self.sent);
        let any = new.as_object().is_some_and(|m| !m.is_empty());
        let readings = json!({ "readings": new }).to_string();
        let drawn = json!({ "drawings": readings::drawings(turn)? }).to_string();
        let redrawn = drawn != self.drawn;
        for guest in &self.guests {
            let out = &guest.client.out;
            // Who has not read the last ones yet gets the next ones.
            if out.waits() {
                continue;
            }
            if any {
                out.send(Message::Text(readings.clone()));
            }
            if redrawn {
                out.send(Message::Text(drawn.clone()));
            }
            let image = (guest.eye != 0).then(|| readings::image(turn, p, object(guest.eye))).flatten();
            image.into_iter().for_each(|m| out.send(m));
            if guest.graph != 0
                && let Ok(graph) = readings::graph(turn, object(guest.graph))
            {
                out.send(Message::Text(graph.to_string()));
            }
        }
        self.drawn = drawn;
        Ok(())
    }
}

impl Drop for State {
    fn drop(&mut self) {
        self.guests.iter().for_each(|g| g.client.out.cut());
    }
}
