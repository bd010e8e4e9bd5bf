//! Executes requests at the barrier: clients in order of connection, and the lines of each client in order of arrival.

use std::{
    cell::{Cell, RefCell, RefMut},
    collections::BTreeMap,
    thread::JoinHandle,
};

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Answer, Called, Fail, Host, Param, Params, Prop, Result, Service, Session, Turn, ValueRef},
};

use tatu_services_common::{
    hold_limit::{self, HoldLimit, HoldTimer},
    json,
};

use crate::{
    clients::{LineConnection, LineListener},
    message::{JsonlRequest, RequestLine, error},
};

/// The plugin, which offers the service `jsonl`.
pub struct JsonLines {
    /// Interned key of the property `scene.time`.
    pub(crate) time: Prop,
}

/// Maximum number of lines per client that are processed at a barrier, so that a client cannot starve the others.
const MAX_LINES_PER_BARRIER: usize = 1000;

/// The service `jsonl`, which executes commands that clients send as lines of JSON.
pub struct JsonlService {
    state: RefCell<JsonlState>,
    session: Session,
    time: Prop,
    /// Number of clients that must have sent a `stepping` message before the first step.
    wait_for: i64,
    /// Number of clients that have sent a `stepping` message.
    greeted: Cell<i64>,
    /// Token for the next command that does not return immediately.
    next_token: Cell<u64>,
    hold_limit: HoldLimit,
}

struct JsonlState {
    clients: Vec<LineClient>,
    /// Writing threads of clients that have disconnected.
    threads: Vec<JoinHandle<()>>,
    /// The number of the client and the id of the line for each command that has not returned yet, by token.
    pending_commands: BTreeMap<u64, (u64, Json)>,
    /// The open port, which is closed after all clients.
    listener: LineListener,
}

/// A client and its settings.
struct LineClient {
    client: LineConnection,
    /// Whether steps require the permission of the client.
    stepping: bool,
    /// Measures how long the client has held the world in silence.
    hold: HoldTimer,
    /// Whether the client has sent a `stepping` message.
    greeted: bool,
    /// Whether the client receives events.
    events: bool,
    /// Index of the world that the client has selected.
    world: usize,
    /// The pending `step` request of the client: the id of its line, and the step at which it ends.
    until: Option<(Json, u64)>,
    /// A line that was taken from the queue but must be processed later.
    next: Option<RequestLine>,
    /// Whether all lines of the client have been processed, and the client can send no more.
    finished: bool,
}

impl Service for JsonlService {
    type Plugin = JsonLines;
    const ID: &'static str = "jsonl";
    const TEXT: &'static str = "Accepts commands as lines of JSON on a local socket. Clients may control the stepping.";

    const EVENTS: &'static [&'static str] = &["started", "paused", "resumed", "stopped", "fault", "held"];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port")
                .range(0.0, 65535.0)
                .default(23300)
                .text("port on 127.0.0.1 to listen on; 0: any free port"),
            Param::int("wait_for")
                .range(0.0, 1000.0)
                .default(0)
                .text("number of clients that must have sent a `stepping` message before the first step"),
            Param::string("token")
                .default("")
                .text("token that each client must send first, as `{\"token\": \"...\"}`; empty: no token is required"),
            HoldLimit::param(),
        ]
    }

    fn start(plugin: &JsonLines, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let listener = LineListener::open(params.i64("port")? as u16, params.string("token")?, session.clone())?;
        let state =
            JsonlState { clients: Vec::new(), threads: Vec::new(), pending_commands: BTreeMap::new(), listener };
        Ok(JsonlService {
            state: RefCell::new(state),
            session,
            time: plugin.time,
            wait_for: params.i64("wait_for")?,
            greeted: Cell::new(0),
            next_token: Cell::new(1),
            hold_limit: HoldLimit::read(params)?,
        })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer> {
        let state = &mut *self.state()?;
        let new = state.listener.take_new().into_iter().map(|client| LineClient {
            client,
            stepping: false,
            hold: HoldTimer::default(),
            greeted: false,
            events: false,
            world: 0,
            until: None,
            next: None,
            finished: false,
        });
        state.clients.extend(new);
        let (here, worlds) = turn.worlds();
        let mut hold = false;
        for guest in &mut state.clients {
            if guest.world >= worlds {
                guest.world = 0;
            }
            // `stepping` and `world` messages do not access a world, so they are processed in the turn of any world.
            while guest.world != here && guest.until.is_none() {
                guest.next = guest.next.take().or_else(|| guest.client.next_line());
                match guest
                    .next
                    .take_if(|m| matches!(m.request, Ok(JsonlRequest::Stepping(_) | JsonlRequest::World(_))))
                {
                    Some(message) => self.handle(guest, &mut state.pending_commands, message, turn, step, worlds)?,
                    None => break,
                }
            }
            if guest.world == here {
                let holds = self.serve(guest, &mut state.pending_commands, turn, step, worlds)?;
                let over = guest.hold.is_over(holds && turn.state() == TATU_RUNNING, self.hold_limit);
                if over {
                    guest.stepping = false;
                    hold_limit::report(&self.session, Self::ID, guest.client.number, self.hold_limit);
                }
                hold |= holds && !over;
            }
        }
        state.remove_disconnected();
        Ok(if hold || self.greeted.get() < self.wait_for { Answer::Hold } else { Answer::Go })
    }

    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        let here = turn.worlds().0;
        let payload = payload.to_value().map_or(Json::Null, |v| json::write(&v));
        for guest in state.clients.iter_mut().filter(|g| g.world == here) {
            if guest.events {
                guest.client.send(&json!({ "event": name, "payload": payload }));
            }
            if name == "stopped"
                && let Some((id, _)) = guest.until.take()
            {
                let fail = Fail::with_code(
                    TATU_ERR_GONE,
                    "the simulation was stopped before the requested steps were completed",
                );
                guest.client.send(&error(&id, &fail));
            }
        }
    }

    fn resume(&self, _: &Turn<'_>, token: u64, result: Result<&[ValueRef<'_>]>) {
        let Ok(mut state) = self.state() else { return };
        let Some((number, id)) = state.pending_commands.remove(&token) else { return };
        let Some(guest) = state.clients.iter().find(|g| g.client.number == number) else { return };
        let values = result.and_then(|r| r.iter().map(|v| v.to_value()).collect::<Result<Vec<_>>>());
        guest.client.send(&match values {
            Ok(values) => json!({ "id": id, "result": values.iter().map(json::write).collect::<Json>() }),
            Err(fail) => error(&id, &fail),
        });
    }
}

impl JsonlService {
    fn state(&self) -> Result<RefMut<'_, JsonlState>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }

    /// Processes lines of a client, at most `MAX_LINES_PER_BARRIER`. Returns whether the client holds the world.
    fn serve(
        &self,
        guest: &mut LineClient,
        waits: &mut BTreeMap<u64, (u64, Json)>,
        turn: &Turn<'_>,
        step: u64,
        worlds: usize,
    ) -> Result<bool> {
        turn.client(guest.client.number);
        let here = guest.world;
        for _ in 0..MAX_LINES_PER_BARRIER {
            match &guest.until {
                // The client waits for its steps, but during a pause, its next line may resume the simulation.
                Some((_, until)) if step < *until && turn.state() == TATU_PAUSED => {
                    guest.next = guest.next.take().or_else(|| guest.client.next_line());
                    match guest
                        .next
                        .take_if(|m| matches!(m.request, Ok(JsonlRequest::Request(_) | JsonlRequest::State)))
                    {
                        Some(message) => self.handle(guest, waits, message, turn, step, worlds)?,
                        None => return Ok(false),
                    }
                    continue;
                }
                Some((_, until)) if step < *until => return Ok(false),
                Some((id, _)) => {
                    guest.client.send(&json!({ "id": id, "time": turn.f64(0, self.time)?, "step": step }));
                    guest.until = None;
                }
                None => {}
            }
            // The flag must be read before the queue, because it is set after the last line has been queued.
            let ended = guest.client.has_ended();
            let Some(message) = guest.next.take().or_else(|| guest.client.next_line()) else {
                guest.finished = ended;
                return Ok(guest.stepping && !ended);
            };
            // Steps are counted from the start of a run, so this line and later ones must wait for the start.
            if matches!(message.request, Ok(JsonlRequest::Step(_))) && turn.state() == TATU_STOPPED {
                guest.next = Some(message);
                guest.finished = ended;
                return Ok(guest.stepping && !ended);
            }
            self.handle(guest, waits, message, turn, step, worlds)?;
            if guest.world != here {
                return Ok(false);
            }
        }
        // There may be further lines, so another turn is requested immediately.
        self.session.wake();
        Ok(guest.stepping && !guest.client.has_ended())
    }

    /// Executes a request, and sends the answer unless it must wait.
    fn handle(
        &self,
        guest: &mut LineClient,
        waits: &mut BTreeMap<u64, (u64, Json)>,
        message: RequestLine,
        turn: &Turn<'_>,
        step: u64,
        worlds: usize,
    ) -> Result {
        guest.hold.restart();
        let id = message.id;
        let done = |result: Json| json!({ "id": id, "result": result });
        let reply = match message.request {
            Err(fail) => error(&id, &fail),
            Ok(JsonlRequest::Call { name, args }) => {
                let token = self.next_token.get();
                match turn.call(&name, &args, token) {
                    Ok(Called::Done(values)) => done(values.iter().map(json::write).collect()),
                    Ok(Called::Waits) => {
                        self.next_token.set(token + 1);
                        waits.insert(token, (guest.client.number, id));
                        return Ok(());
                    }
                    Err(fail) => error(&id, &fail),
                }
            }
            Ok(JsonlRequest::Token(_)) => done(json!([])),
            Ok(JsonlRequest::Stepping(on)) => {
                guest.stepping = on;
                if !std::mem::replace(&mut guest.greeted, true) {
                    self.greeted.set(self.greeted.get() + 1);
                }
                done(json!([]))
            }
            Ok(JsonlRequest::Step(n)) => {
                guest.until = Some((id, step.saturating_add(n)));
                return Ok(());
            }
            Ok(JsonlRequest::Request(what)) => match turn.request(what) {
                Ok(()) => done(json!([])),
                Err(fail) => error(&id, &fail),
            },
            Ok(JsonlRequest::State) => {
                let state = match turn.state() {
                    TATU_STOPPED => "stopped",
                    TATU_PAUSED => "paused",
                    _ => "running",
                };
                json!({ "id": id, "state": state, "time": turn.f64(0, self.time)?, "step": step })
            }
            Ok(JsonlRequest::Events(on)) => {
                guest.events = on;
                done(json!([]))
            }
            Ok(JsonlRequest::World(n)) if n < worlds => {
                guest.world = n;
                done(json!([]))
            }
            Ok(JsonlRequest::World(n)) => error(
                &id,
                &Fail::argument(format!(
                    "world {n} does not exist: worlds are numbered from 0, and there are {worlds}"
                )),
            ),
        };
        guest.client.send(&reply);
        Ok(())
    }
}

impl JsonlState {
    /// Removes clients that have disconnected, except those that can still receive answers that are pending.
    fn remove_disconnected(&mut self) {
        let waits = &self.pending_commands;
        let is_over = |g: &mut LineClient| {
            let owed = waits.values().any(|(n, _)| *n == g.client.number);
            g.client.is_broken() || g.finished && (!owed || g.client.is_silent())
        };
        let gone: Vec<LineClient> = self.clients.extract_if(.., is_over).collect();
        for g in gone {
            // The commands continue to wait, but their results are discarded.
            self.pending_commands.retain(|_, (number, _)| *number != g.client.number);
            self.threads.push(g.client.finish_sending());
        }
        self.threads.retain(|t| !t.is_finished());
    }
}

impl Drop for JsonlState {
    fn drop(&mut self) {
        let threads = std::mem::take(&mut self.threads);
        self.listener.close(self.clients.drain(..).map(|guest| guest.client), threads);
    }
}
