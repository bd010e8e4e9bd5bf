//! Executes commands at the barrier: clients in order of connection, and for each client first its new commands in
//! order of arrival, then its streamed commands.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
    sync::mpsc::Receiver,
    time::Instant,
};

use tatu_plugin_api::{
    abi::*,
    safe::{self, Fail, Host, Param, Params, Result, Service, Session, Turn, ValueRef},
};

use tatu_services_common::port::Port;

use crate::{
    calls,
    clients::Client,
    connections::{Event, Key, Ports},
    files::Files,
    message::{self, Command, World, mode},
    values::Out,
};

/// The plugin, which offers the service `legacy_remote`.
pub struct LegacyRemote;

/// The default port of V-REP.
const PORT: i64 = 19997;
/// Number of the command that starts synchronous operation.
const SYNCHRONOUS: u16 = 1;
/// Number of the command that ends synchronous operation.
const FREE: u16 = 2;
/// Number of the command that permits a step in synchronous operation.
const TRIGGER: u16 = 3;
/// Number of the command that returns and clears the client's errors.
const ERRORS: u16 = 4;
/// Number of the command that announces the end of the connection.
const GOODBYE: u16 = 0xA;
/// Number of the command that reads and clears a string signal.
const GET_AND_CLEAR: u16 = 0x3017;
/// Numbers of the commands that transfer, load and erase files.
const FILES: std::ops::RangeInclusive<u16> = 0x3002..=0x3006;

/// The service `legacy_remote`.
pub struct Remote {
    session: Session,
    state: RefCell<State>,
}

struct State {
    clients: BTreeMap<u64, Client>,
    /// The start of the service.
    began: Instant,
    events: Receiver<Event>,
    ports: Ports,
    /// Ports that scripts have opened. They are closed when the simulation stops.
    of_scripts: BTreeMap<u16, Port>,
    listener: Port,
    files: Files,
}

/// Name of the event by which a script opens a port.
const OPEN: &str = "remote_api.open";
/// Name of the event by which a script closes a port.
const CLOSE: &str = "remote_api.close";

impl Service for Remote {
    type Plugin = LegacyRemote;
    const ID: &'static str = "legacy_remote";
    const TEXT: &'static str =
        "The legacy remote API: clients written for V-REP call commands, with or without synchronous operation.";

    const EVENTS: &'static [&'static str] = &["stopped", OPEN, CLOSE];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65535.0).default(PORT).text(
                "port on 127.0.0.1 to listen on; 0: any free port. Scripts may open further ports with `simRemoteApi.start`",
            ),
        ]
    }

    fn start(_: &LegacyRemote, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let port = params.i64("port")? as u16;
        let (ports, events) = Ports::new(session.clone());
        let listener = ports.open(port).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("legacy_remote: listening on {}", listener.address));
        let (clients, of_scripts) = (BTreeMap::new(), BTreeMap::new());
        let state =
            State { clients, began: Instant::now(), events, ports, of_scripts, listener, files: Files::default() };
        Ok(Remote { session, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<safe::Answer> {
        // Only the first world of the session is served.
        if turn.worlds().0 != 0 {
            return Ok(safe::Answer::Go);
        }
        let state = &mut *self.state()?;
        state.hear(&self.session);
        let time = turn.f64(0, turn.host().prop("scene.time"))? * 1e3;
        state.ports.tell(World {
            time: state.began.elapsed().as_millis() as i32,
            scene: 1,
            state: match turn.state() {
                TATU_STOPPED => 0,
                TATU_PAUSED => 3,
                _ => 1,
            },
        });
        let running = turn.state() == TATU_RUNNING;
        for (number, client) in &mut state.clients {
            turn.client(*number);
            client.until = client.until.filter(|until| running && step < *until);
            serve(turn, client, &mut state.files, step, time);
        }
        let hold = running && state.clients.values().any(|c| c.holds(step));
        Ok(if hold { safe::Answer::Hold } else { safe::Answer::Go })
    }

    fn event(&self, _: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        let port = payload.get("port").and_then(|p| p.as_i64()).and_then(|p| u16::try_from(p).ok());
        match (name, port) {
            ("stopped", _) => {
                state.clients.values_mut().for_each(|c| c.until = None);
                state.of_scripts.clear();
            }
            (OPEN, Some(port)) if !state.of_scripts.contains_key(&port) && state.listener.address.port() != port => {
                match state.ports.open(port) {
                    Ok(listener) => {
                        state.of_scripts.insert(port, listener);
                    }
                    Err(e) => {
                        let text =
                            format!("legacy_remote: port {port}, which a script requested, could not be opened: {e}");
                        self.session.log(TATU_LOG_WARNING, &text);
                    }
                }
            }
            (CLOSE, Some(port)) => drop(state.of_scripts.remove(&port)),
            _ => {}
        }
    }
}

impl Remote {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

impl State {
    /// Handles the queued events of connections.
    fn hear(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            match event {
                Event::Come(number, out) => {
                    self.clients.insert(number, Client::new(out));
                }
                Event::Commands(number, head, commands, size) => {
                    if let Some(client) = self.clients.get_mut(&number) {
                        client.out.heard(size);
                        client.id = head.id;
                        client.pending.extend(commands);
                    }
                }
                Event::Gone(number, why) => {
                    self.clients.remove(&number);
                    if let Some(why) = why {
                        let text = format!("legacy_remote: connection {number} was closed: {why}");
                        session.log(TATU_LOG_WARNING, &text);
                    }
                }
            }
        }
    }
}

/// Executes the new and streamed commands of a client, and queues the answers.
fn serve(turn: &Turn<'_>, client: &mut Client, files: &mut Files, step: u64, time: f64) {
    let mut answers: Vec<(Key, Vec<u8>)> = Vec::new();
    for command in std::mem::take(&mut client.pending) {
        let (code, of) = (command.code, command.of.clone());
        let done = client.whole(command).and_then(|whole| match whole {
            Some(command) => act(turn, client, files, &command, step).map(Some),
            // Parts of an incomplete command are answered, too, because the client waits for each answer before it
            // sends the next part.
            None => Ok(Some(Vec::new())),
        });
        if let Err(fail) = &done {
            let help = fail.help_text().map(|h| format!("; {h}")).unwrap_or_default();
            client.went_wrong(format!("{:#06x}: {}{help}", code as u16, fail.text()));
        }
        let data = done.ok().flatten();
        answers.push(((code, of.clone()), message::answer(code, &of, data.as_deref(), time as i32)));
    }
    // Streamed commands are not executed again before their last answers have been sent.
    if client.out.is_empty() {
        let due: Vec<Command> = client
            .streams
            .values_mut()
            .filter(|(command, next)| {
                command.delay == 0 || command.mode() == mode::STREAMING_SPLIT || time >= *next || time < *next - 1e6
            })
            .map(|(command, next)| {
                *next = time + f64::from(command.delay);
                command.clone()
            })
            .collect();
        for command in due {
            let key = (command.code, command.of.clone());
            if answers.iter().any(|(k, _)| *k == key) {
                continue;
            }
            let done = calls::call(turn, files, command.raw(), &command.of, &command.data);
            let answer = message::answer(command.code, &command.of, done.ok().as_deref(), time as i32);
            answers.push((key, answer));
        }
    }
    if !answers.is_empty() {
        client.out.put(client.id, answers);
    }
}

/// Executes a command once and returns the data of the answer. Also starts or ends streaming.
fn act(turn: &Turn<'_>, client: &mut Client, files: &mut Files, command: &Command, step: u64) -> Result<Vec<u8>> {
    let key = (command.raw(), command.of.clone());
    match command.mode() {
        mode::DISCONTINUE => {
            client.streams.remove(&key);
            return Ok(Vec::new());
        }
        // Streaming such a command would, for example, load a file in each step.
        mode::STREAMING | mode::STREAMING_SPLIT if FILES.contains(&command.raw()) => {
            return Err(Fail::argument(
                "commands that transfer, load or erase files cannot be streamed: send them once",
            ));
        }
        mode::STREAMING | mode::STREAMING_SPLIT => client.stream(command)?,
        mode::ONESHOT | mode::BLOCKING | mode::ONESHOT_SPLIT => {}
        other => return Err(Fail::argument(format!("the command has the unknown mode {other}"))),
    }
    match command.raw() {
        SYNCHRONOUS | FREE => client.synchronous = command.raw() == SYNCHRONOUS,
        TRIGGER if !client.synchronous || turn.state() != TATU_RUNNING => {
            return Err(Fail::argument(
                "a step can be triggered only in synchronous operation while the simulation is running",
            ));
        }
        TRIGGER => client.until = Some(client.until.unwrap_or(step) + 1),
        ERRORS => {
            let mut out = Out::default();
            out.i32(client.errors.len() as i64);
            client.errors.drain(..).for_each(|e| {
                out.text(e.as_bytes());
            });
            return Ok(out.0);
        }
        GOODBYE => client.synchronous = false,
        raw => {
            let done = calls::call(turn, files, raw, &command.of, &command.data)?;
            if raw == GET_AND_CLEAR {
                client.streams.remove(&key);
            }
            return Ok(done);
        }
    }
    Ok(Vec::new())
}
