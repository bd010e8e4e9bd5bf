//! Executes requests at the barrier, in order of arrival.

use std::{
    cell::{RefCell, RefMut},
    collections::{BTreeMap, VecDeque},
    io,
    sync::mpsc::Receiver,
};

use ciborium::Value as Cbor;
use tatu_plugin_api::{
    abi::*,
    safe::{self, Called, Fail, Host, Param, Params, Result, Service, Session, Turn, Value, ValueRef},
};

use tatu_services_common::hold_limit::{self, HoldLimit};

use crate::{
    catalogue,
    cbor::{self, RemoteRequest},
    clients::ZmqClients,
    functions::FunctionTable,
    state::{PendingId, PendingRequest, QueuedRequest, RequestOutcome, ZmqState, disconnected_error},
    zmtp::{ConnectionEvent, SocketKind, ZmtpListener},
};

/// The plugin, which offers the service `zmq_remote`.
pub struct ZmqRemote;

/// Maximum number of requests that are executed at a barrier.
const MAX_REQUESTS_PER_BARRIER: usize = 2000;
/// Name of the function in a request by which a client returns the results of a called function of its own.
const EXECUTED: &str = "_*executed*_";
/// The port to which clients connect by default.
const DEFAULT_PORT: i64 = 23000;

/// The service `zmq_remote`, which executes requests of clients of CoppeliaSim's ZeroMQ remote API.
pub struct ZmqRemoteService {
    session: Session,
    state: RefCell<ZmqState>,
    hold_limit: HoldLimit,
}

impl Service for ZmqRemoteService {
    type Plugin = ZmqRemote;
    const ID: &'static str = "zmq_remote";
    const TEXT: &'static str =
        "The ZeroMQ remote API: clients written for CoppeliaSim call commands, with or without stepping.";

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65534.0).default(DEFAULT_PORT).text(
                "port on 127.0.0.1 to listen on; 0: any free port. The next port notifies clients that use the first \
                 version of the protocol of steps",
            ),
            HoldLimit::param(),
        ]
    }

    fn start(_: &ZmqRemote, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let port = params.i64("port")? as u16;
        let ((listener, events), counter) = listen(&session, port)?;
        let address = listener.address();
        let counter = match counter {
            Ok((counter, _)) => Some(counter),
            Err(e) => {
                let next = address.port().wrapping_add(1);
                let text = format!(
                    "zmq_remote: port {next} cannot be opened ({e}), so clients of 2022 and earlier cannot step"
                );
                session.log(TATU_LOG_WARNING, &text);
                None
            }
        };
        session.log(TATU_LOG_INFO, &format!("zmq_remote: listening on {address}"));
        let state = ZmqState {
            clients: ZmqClients::default(),
            requests: VecDeque::new(),
            running: Vec::new(),
            active_calls: 0,
            pending_commands: BTreeMap::new(),
            next_token: 1,
            functions: FunctionTable::default(),
            published_step: None,
            events,
            _listener: listener,
            counter,
        };
        Ok(ZmqRemoteService { session, state: RefCell::new(state), hold_limit: HoldLimit::read(params)? })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<safe::Answer> {
        // Only the first world of the session is served.
        if turn.worlds().0 != 0 {
            return Ok(safe::Answer::Go);
        }
        {
            let state = &mut *self.state()?;
            if state.published_step.replace(step) != Some(step)
                && let Some(counter) = &state.counter
            {
                counter.publish(&(step as u32).to_le_bytes());
            }
            state.handle_events(&self.session);
            state.finish_steps(turn, step);
        }
        for _ in 0..MAX_REQUESTS_PER_BARRIER {
            let Some(waiting) = self.state()?.requests.pop_front() else { break };
            self.handle(turn, step, waiting)?;
        }
        let state = &mut *self.state()?;
        if !state.requests.is_empty() {
            self.session.wake();
        }
        state.finish_steps(turn, step);
        let running = turn.state() == TATU_RUNNING;
        for client in state.clients.iter_mut() {
            if client.release_if_silent(running, self.hold_limit) {
                hold_limit::report(&self.session, Self::ID, client.number, self.hold_limit);
            }
        }
        let hold = running && state.clients.iter_mut().any(|c| c.holds_simulation());
        Ok(if hold { safe::Answer::Hold } else { safe::Answer::Go })
    }

    fn event(&self, turn: &Turn<'_>, name: &str, _: ValueRef<'_>) {
        if name == "stopped"
            && let Ok(mut state) = self.state()
        {
            state.finish_steps(turn, u64::MAX);
        }
    }

    fn resume(&self, _: &Turn<'_>, token: u64, result: Result<&[ValueRef<'_>]>) {
        let Ok(mut state) = self.state() else { return };
        let Some(pending) = state.pending_commands.remove(&token) else { return };
        pending.reply(result.and_then(|all| all.iter().map(|v| Ok(cbor::write(v.to_value()?))).collect()));
    }

    fn call_func(&self, turn: &Turn<'_>, local: u32, args: &[ValueRef<'_>]) -> Result<Vec<Value>> {
        let args = args.iter().map(|v| v.to_value()).collect::<Result<Vec<_>>>()?;
        let function = self.state()?.functions.get(local).cloned().ok_or_else(disconnected_error)?;
        let place = self.state()?.pending_of_client(&function.client);
        match place {
            Some(place) => self.call_client_function(turn, place, &function.name, &args),
            None => {
                self.state()?.functions.defer_call(function, args);
                Ok(Vec::new())
            }
        }
    }
}

impl ZmqRemoteService {
    fn state(&self) -> Result<RefMut<'_, ZmqState>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }

    /// Executes a request. The state is not borrowed while a command runs, because the command may call a client's
    /// function.
    fn handle(&self, turn: &Turn<'_>, step: u64, waiting: QueuedRequest) -> Result<()> {
        let QueuedRequest { connection, answer, request: asked } = waiting;
        let asked = asked.map(|r| {
            let key = r.uuid.clone().unwrap_or_else(|| format!("connection {connection}"));
            (
                PendingRequest {
                    connection,
                    key,
                    answer: answer.clone(),
                    name: r.func.clone(),
                    first_version: r.uuid.is_none(),
                },
                r,
            )
        });
        let (pending, mut request) = match asked {
            Ok(asked) => asked,
            Err(fail) => {
                let nobody = PendingRequest {
                    connection,
                    key: String::new(),
                    answer,
                    name: String::new(),
                    first_version: false,
                };
                nobody.reply(Err(fail));
                return Ok(());
            }
        };
        let key = pending.key.clone();
        let (at, later) = {
            let state = &mut *self.state()?;
            let client = state.clients.get_or_create(&key, connection);
            client.hold.restart();
            turn.client(client.number);
            state.running.push(pending);
            (state.running.len() - 1, state.functions.take_deferred(&key))
        };
        for (name, args) in later {
            // The results of a deferred call are not used, and an error only means that the client has disconnected.
            let _ = self.call_client_function(turn, PendingId::Running(at), &name, &args);
        }
        let bound = {
            let functions = &mut self.state()?.functions;
            let mut args = request.args.iter_mut().filter(|_| request.uuid.is_some());
            args.try_for_each(|arg| functions.bind(&key, arg, &|number| turn.function(number)))
        };
        let done =
            bound.and_then(|()| self.execute_own_function(turn, step, at, &request)).and_then(|done| match done {
                RequestOutcome::Command => self.call_command(turn, at, &request),
                done => Ok(done),
            });
        // If functions of the client were called, the answer belongs to the request in which the last of them returned.
        let state = &mut *self.state()?;
        let pending = state.running.pop();
        match (done, pending) {
            (Ok(RequestOutcome::Results(values)), Some(pending)) => pending.reply(Ok(values)),
            (Err(fail), Some(pending)) => pending.reply(Err(fail)),
            _ => {}
        }
        Ok(())
    }

    /// Executes a request for a function that the service itself provides. Returns `RequestOutcome::Command` for other
    /// functions.
    fn execute_own_function(
        &self,
        turn: &Turn<'_>,
        step: u64,
        at: usize,
        request: &RemoteRequest,
    ) -> Result<RequestOutcome> {
        let RemoteRequest { func, args, .. } = request;
        let none = || Ok(RequestOutcome::Results(Vec::new()));
        let text = || match args.first() {
            Some(Value::Text(t)) => Ok(String::from_utf8_lossy(t).into_owned()),
            _ => Err(Fail::argument("argument 1: expected the name of a module")),
        };
        let mut state = self.state()?;
        let state = &mut *state;
        let pending = state.running.get(at).cloned().ok_or_else(disconnected_error)?;
        let client = state.clients.get_or_create(&pending.key, pending.connection);
        let running = turn.state() == TATU_RUNNING;
        match func.as_str() {
            EXECUTED => none(),
            "_*end*_" => {
                state.remove_client(&pending.key);
                none()
            }
            "zmqRemoteApi.require" => {
                catalogue::require(turn, &text()?)?;
                none()
            }
            "zmqRemoteApi.info" => Ok(RequestOutcome::Results(vec![catalogue::info(turn, &text()?)?])),
            "sim.setStepping" | "setStepping" => {
                let before = client.stepping_level;
                let on = matches!(args.first(), Some(Value::Bool(true)))
                    || matches!(args.first(), Some(Value::Int(i)) if *i != 0);
                client.stepping_level = if on { before + 1 } else { (before - 1).max(0) };
                Ok(RequestOutcome::Results(vec![Cbor::Integer(before.into())]))
            }
            "sim.step" | "sim.switchThread" | "sim.yield" | "step" if running && state.active_calls > 0 => {
                Err(Fail::with_code(
                    TATU_ERR_BUSY,
                    "a callback cannot request a step, because the simulation does not advance before the callback returns",
                ))
            }
            "sim.step" | "sim.switchThread" | "sim.yield" if running => {
                client.until.push((step + 1, Some(pending.answer)));
                Ok(RequestOutcome::Deferred)
            }
            // In the first version of the protocol, the client is notified of the step through the next port.
            "step" if running => {
                client.until.push((step + 1, None));
                none()
            }
            "sim.step" | "sim.switchThread" | "sim.yield" | "step" => none(),
            "sim.acquireLock" => {
                client.lock_count += 1;
                none()
            }
            "sim.releaseLock" => {
                client.lock_count = (client.lock_count - 1).max(0);
                none()
            }
            _ => Ok(RequestOutcome::Command),
        }
    }

    /// Calls the command of the world that a request names.
    fn call_command(&self, turn: &Turn<'_>, at: usize, request: &RemoteRequest) -> Result<RequestOutcome> {
        let token = {
            let state = &mut *self.state()?;
            // A stop must not be delayed by a client that holds the simulation.
            if request.func == "sim.stopSimulation" {
                state.clients.iter_mut().for_each(|c| c.release());
            }
            // While a client's function is being called, commands must not wait, which the token 0 enforces.
            if state.active_calls > 0 { 0 } else { state.next_token }
        };
        match turn.call(&request.func, &request.args, token)? {
            Called::Done(values) => Ok(RequestOutcome::Results(values.into_iter().map(cbor::write).collect())),
            Called::Waits => {
                let state = &mut *self.state()?;
                state.next_token += 1;
                let pending = state.running.get(at).cloned().ok_or_else(disconnected_error)?;
                state.pending_commands.insert(token, pending);
                Ok(RequestOutcome::Deferred)
            }
        }
    }

    /// Calls a function of a client as the answer to the client's request, and executes further requests from the
    /// client until the function returns. Returns the results of the function.
    fn call_client_function(
        &self,
        turn: &Turn<'_>,
        place: PendingId,
        name: &str,
        args: &[Value],
    ) -> Result<Vec<Value>> {
        self.state()?.active_calls += 1;
        let results = self.serve_until_return(turn, place, name, args);
        self.state()?.active_calls -= 1;
        results
    }

    /// Implements `call_client_function`, except for counting the calls in progress.
    fn serve_until_return(&self, turn: &Turn<'_>, place: PendingId, name: &str, args: &[Value]) -> Result<Vec<Value>> {
        let connection = {
            let state = &mut *self.state()?;
            let pending = state.pending(place).ok_or_else(disconnected_error)?;
            let _ = pending.answer.send(cbor::encode_call(name, args));
            let connection = pending.connection;
            turn.client(state.clients.number_of_connection(connection).ok_or_else(disconnected_error)?);
            connection
        };
        loop {
            let next = {
                let state = &mut *self.state()?;
                if turn.is_interrupted() {
                    return Err(Fail::with_code(TATU_ERR_GONE, "the run ended before a function of a client returned"));
                }
                state.wait_for_event(&self.session);
                state.clients.number_of_connection(connection).ok_or_else(disconnected_error)?;
                let at = state.requests.iter().position(|r| r.connection == connection);
                at.and_then(|at| state.requests.remove(at))
            };
            match next {
                Some(QueuedRequest { answer, request: Ok(request), .. }) if request.func == EXECUTED => {
                    if let Some(pending) = self.state()?.pending(place) {
                        pending.answer = answer;
                    }
                    return Ok(request.args);
                }
                Some(request) => self.handle(turn, 0, request)?,
                None => {}
            }
        }
    }
}

/// An open port, and the channel on which its connections report events.
type OpenedPort = (ZmtpListener, Receiver<ConnectionEvent>);

/// Maximum number of attempts to find two consecutive free ports.
const MAX_PORT_ATTEMPTS: usize = 16;

/// Opens the port for requests, and the next port for the step counter, which may fail. If `port` is 0, chooses two
/// consecutive free ports if possible.
fn listen(session: &Session, port: u16) -> Result<(OpenedPort, io::Result<OpenedPort>)> {
    let mut attempt = 1;
    loop {
        let woken = session.clone();
        let opened = ZmtpListener::open(SocketKind::Reply, port, Box::new(move || woken.wake())).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        let next = opened.0.address().port().wrapping_add(1);
        let counter = ZmtpListener::open(SocketKind::Publish, next, Box::new(|| ()));
        if counter.is_ok() || port != 0 || attempt == MAX_PORT_ATTEMPTS {
            return Ok((opened, counter));
        }
        attempt += 1;
    }
}
