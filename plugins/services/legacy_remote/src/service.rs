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

use tatu_services_common::{
    hold_limit::{self, HoldLimit},
    port::Port,
};

use crate::{
    calls,
    clients::LegacyClient,
    connections::{CommandKey, ConnectionEvent, PortOpener},
    files::TransferredFiles,
    message::{self, RemoteCommand, WorldStatus, mode},
    values::LittleEndianWriter,
};

/// The plugin, which offers the service `legacy_remote`.
pub struct LegacyRemote;

/// The default port of V-REP.
const DEFAULT_PORT: i64 = 19997;
/// Number of the command that starts synchronous operation.
const START_SYNCHRONOUS: u16 = 1;
/// Number of the command that ends synchronous operation.
const END_SYNCHRONOUS: u16 = 2;
/// Number of the command that permits a step in synchronous operation.
const TRIGGER_STEP: u16 = 3;
/// Number of the command that starts, pauses or stops the simulation, and its subject for a start.
const CHANGE_STATE: u16 = 0x1007;
const START: [u8; 4] = [0; 4];
/// Number of the command that returns and clears the client's errors.
const FETCH_ERRORS: u16 = 4;
/// Number of the command that announces the end of the connection.
const DISCONNECT: u16 = 0xA;
/// Number of the command that reads and clears a string signal.
const GET_AND_CLEAR_SIGNAL: u16 = 0x3017;
/// Numbers of the commands that transfer, load and erase files.
const FILE_COMMANDS: std::ops::RangeInclusive<u16> = 0x3002..=0x3006;

/// The service `legacy_remote`, which executes commands of clients of V-REP's legacy remote API.
pub struct LegacyRemoteService {
    session: Session,
    state: RefCell<LegacyState>,
    hold_limit: HoldLimit,
}

struct LegacyState {
    clients: BTreeMap<u64, LegacyClient>,
    /// The time at which the service was started. Answers contain the time since then.
    started: Instant,
    events: Receiver<ConnectionEvent>,
    ports: PortOpener,
    /// Ports that scripts have opened. They are closed when the simulation stops.
    script_ports: BTreeMap<u16, Port>,
    listener: Port,
    files: TransferredFiles,
}

/// Name of the event by which a script opens a port.
const OPEN_EVENT: &str = "remote_api.open";
/// Name of the event by which a script closes a port.
const CLOSE_EVENT: &str = "remote_api.close";

impl Service for LegacyRemoteService {
    type Plugin = LegacyRemote;
    const ID: &'static str = "legacy_remote";
    const TEXT: &'static str =
        "The legacy remote API: clients written for V-REP call commands, with or without synchronous operation.";

    const EVENTS: &'static [&'static str] = &["stopped", OPEN_EVENT, CLOSE_EVENT];

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65535.0).default(DEFAULT_PORT).text(
                "port on 127.0.0.1 to listen on; 0: any free port. Scripts may open further ports with `simRemoteApi.start`",
            ),
            HoldLimit::param(),
        ]
    }

    fn start(_: &LegacyRemote, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let port = params.i64("port")? as u16;
        let (ports, events) = PortOpener::new(session.clone());
        let listener = ports.open(port).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("legacy_remote: listening on {}", listener.address));
        let (clients, of_scripts) = (BTreeMap::new(), BTreeMap::new());
        let state = LegacyState {
            clients,
            started: Instant::now(),
            events,
            ports,
            script_ports: of_scripts,
            listener,
            files: TransferredFiles::default(),
        };
        Ok(LegacyRemoteService { session, state: RefCell::new(state), hold_limit: HoldLimit::read(params)? })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<safe::Answer> {
        // Only the first world of the session is served.
        if turn.worlds().0 != 0 {
            return Ok(safe::Answer::Go);
        }
        let state = &mut *self.state()?;
        state.handle_events(&self.session);
        let time = turn.f64(0, turn.host().prop("scene.time"))? * 1e3;
        state.ports.set_world_status(WorldStatus {
            time: state.started.elapsed().as_millis() as i32,
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
            client.update_permission(running, step);
            if !client.pending.is_empty() {
                client.hold.restart();
            }
            serve((turn, &self.session), client, &mut state.files, step, time);
            if client.hold.is_over(running && client.holds_world(step), self.hold_limit) {
                client.synchronous = false;
                hold_limit::report(&self.session, Self::ID, *number, self.hold_limit);
            }
        }
        let hold = running && state.clients.values().any(|c| c.holds_world(step));
        Ok(if hold { safe::Answer::Hold } else { safe::Answer::Go })
    }

    fn event(&self, _: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let Ok(mut state) = self.state() else { return };
        let port = payload.get("port").and_then(|p| p.as_i64()).and_then(|p| u16::try_from(p).ok());
        match (name, port) {
            ("stopped", _) => {
                state.clients.values_mut().for_each(LegacyClient::withdraw_permission);
                state.script_ports.clear();
            }
            (OPEN_EVENT, Some(port))
                if !state.script_ports.contains_key(&port) && state.listener.address.port() != port =>
            {
                match state.ports.open(port) {
                    Ok(listener) => {
                        state.script_ports.insert(port, listener);
                    }
                    Err(e) => {
                        let text =
                            format!("legacy_remote: port {port}, which a script requested, could not be opened: {e}");
                        self.session.log(TATU_LOG_WARNING, &text);
                    }
                }
            }
            (CLOSE_EVENT, Some(port)) => drop(state.script_ports.remove(&port)),
            _ => {}
        }
    }
}

impl LegacyRemoteService {
    fn state(&self) -> Result<RefMut<'_, LegacyState>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

impl LegacyState {
    /// Handles the queued events of connections.
    fn handle_events(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            match event {
                ConnectionEvent::Connected(number, out) => {
                    self.clients.insert(number, LegacyClient::new(out));
                }
                ConnectionEvent::Commands(number, head, commands, size) => {
                    if let Some(client) = self.clients.get_mut(&number) {
                        client.out.mark_processed(size);
                        client.id = head.id;
                        client.pending.extend(commands);
                    }
                }
                ConnectionEvent::Disconnected(number, why) => {
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
fn serve(
    (turn, session): (&Turn<'_>, &Session),
    client: &mut LegacyClient,
    files: &mut TransferredFiles,
    step: u64,
    time: f64,
) {
    let mut answers: Vec<(CommandKey, Vec<u8>)> = Vec::new();
    for command in std::mem::take(&mut client.pending) {
        let (code, of, mode) = (command.code, command.subject.clone(), command.mode());
        let done = client.join_parts(command).and_then(|whole| match whole {
            Some(command) => execute_once(turn, client, files, &command, step).map(Some),
            // Parts of an incomplete command are answered, too, because the client waits for each answer before it
            // sends the next part.
            None => Ok(Some(Vec::new())),
        });
        if let Err(fail) = &done {
            let help = fail.help_text().map(|h| format!("; {h}")).unwrap_or_default();
            let text = format!("{:#06x}: {}{help}", code as u16, fail.text());
            // The client does not wait for the answer to such a command, so the error would go unnoticed unless it is
            // logged.
            if matches!(mode, mode::ONESHOT | mode::ONESHOT_SPLIT) && client.is_new_error(&text) {
                session.log(TATU_LOG_WARNING, &format!("legacy_remote: a command of a client failed: {text}"));
            }
            client.add_error(text);
        }
        let data = done.ok().flatten();
        answers.push(((code, of.clone()), message::answer(code, &of, data.as_deref(), time as i32)));
    }
    // Streamed commands are not executed again before their last answers have been sent.
    if client.out.is_empty() {
        let due: Vec<RemoteCommand> = client
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
            let key = (command.code, command.subject.clone());
            if answers.iter().any(|(k, _)| *k == key) {
                continue;
            }
            let done = calls::call(turn, files, command.number(), &command.subject, &command.data);
            let answer = message::answer(command.code, &command.subject, done.ok().as_deref(), time as i32);
            answers.push((key, answer));
        }
    }
    if !answers.is_empty() {
        client.out.queue_answers(client.id, answers);
    }
}

/// Executes a command once and returns the data of the answer. Also starts or ends streaming.
fn execute_once(
    turn: &Turn<'_>,
    client: &mut LegacyClient,
    files: &mut TransferredFiles,
    command: &RemoteCommand,
    step: u64,
) -> Result<Vec<u8>> {
    let key = (command.number(), command.subject.clone());
    match command.mode() {
        mode::DISCONTINUE => {
            client.streams.remove(&key);
            return Ok(Vec::new());
        }
        // Streaming such a command would, for example, load a file in each step.
        mode::STREAMING | mode::STREAMING_SPLIT if FILE_COMMANDS.contains(&command.number()) => {
            return Err(Fail::argument(
                "commands that transfer, load or erase files cannot be streamed; use a mode that executes the command \
                 once",
            ));
        }
        mode::STREAMING | mode::STREAMING_SPLIT => client.start_stream(command)?,
        mode::ONESHOT | mode::BLOCKING | mode::ONESHOT_SPLIT => {}
        other => return Err(Fail::argument(format!("the command has the unknown mode {other}"))),
    }
    match command.number() {
        START_SYNCHRONOUS | END_SYNCHRONOUS => client.synchronous = command.number() == START_SYNCHRONOUS,
        TRIGGER_STEP if !client.permit_step(turn.state() == TATU_RUNNING, step) => {
            return Err(Fail::argument(
                "a step can be triggered only in synchronous operation while the simulation is running or starting",
            ));
        }
        TRIGGER_STEP => {}
        FETCH_ERRORS => {
            let mut out = LittleEndianWriter::default();
            out.i32(client.errors.len() as i64);
            client.errors.drain(..).for_each(|e| {
                out.text(e.as_bytes());
            });
            return Ok(out.0);
        }
        DISCONNECT => client.synchronous = false,
        raw => {
            let done = calls::call(turn, files, raw, &command.subject, &command.data)?;
            if raw == CHANGE_STATE && command.subject.starts_with(&START) && turn.state() != TATU_RUNNING {
                client.starting = true;
            }
            if raw == GET_AND_CLEAR_SIGNAL {
                client.streams.remove(&key);
            }
            return Ok(done);
        }
    }
    Ok(Vec::new())
}
