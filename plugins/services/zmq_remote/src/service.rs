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

use crate::{
    catalogue,
    cbor::{self, Request},
    clients::Clients,
    functions::Functions,
    state::{Done, Pending, Place, State, Waiting, gone},
    zmtp::{Event, Kind, Listener},
};

/// The plugin, which offers the service `zmq_remote`.
pub struct ZmqRemote;

/// Maximum number of requests that are executed at a barrier.
const AT_ONCE: usize = 2000;
/// Name of the function in a request by which a client returns the results of a called function of its own.
const EXECUTED: &str = "_*executed*_";
/// The port to which clients connect by default.
const PORT: i64 = 23000;

/// The service `zmq_remote`.
pub struct Remote {
    session: Session,
    state: RefCell<State>,
}

impl Service for Remote {
    type Plugin = ZmqRemote;
    const ID: &'static str = "zmq_remote";
    const TEXT: &'static str =
        "The ZeroMQ remote API: clients written for CoppeliaSim call commands, with or without stepping.";

    fn params() -> Vec<Param> {
        vec![Param::int("port").range(0.0, 65534.0).default(PORT).text(
            "port on 127.0.0.1 to listen on; 0: any free port. The next port notifies clients that use the first \
                 version of the protocol of steps",
        )]
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
        let state = State {
            clients: Clients::default(),
            requests: VecDeque::new(),
            running: Vec::new(),
            talks: 0,
            waits: BTreeMap::new(),
            next_token: 1,
            functions: Functions::default(),
            told: None,
            events,
            _listener: listener,
            counter,
        };
        Ok(Remote { session, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<safe::Answer> {
        // Only the first world of the session is served.
        if turn.worlds().0 != 0 {
            return Ok(safe::Answer::Go);
        }
        {
            let state = &mut *self.state()?;
            if state.told.replace(step) != Some(step)
                && let Some(counter) = &state.counter
            {
                counter.publish(&(step as u32).to_le_bytes());
            }
            state.hear(&self.session);
            state.stepped(turn, step);
        }
        for _ in 0..AT_ONCE {
            let Some(waiting) = self.state()?.requests.pop_front() else { break };
            self.handle(turn, step, waiting)?;
        }
        let state = &mut *self.state()?;
        if !state.requests.is_empty() {
            self.session.wake();
        }
        state.stepped(turn, step);
        let hold = turn.state() == TATU_RUNNING && state.clients.iter_mut().any(|c| c.holds());
        Ok(if hold { safe::Answer::Hold } else { safe::Answer::Go })
    }

    fn event(&self, turn: &Turn<'_>, name: &str, _: ValueRef<'_>) {
        if name == "stopped"
            && let Ok(mut state) = self.state()
        {
            state.stepped(turn, u64::MAX);
        }
    }

    fn resume(&self, _: &Turn<'_>, token: u64, result: Result<&[ValueRef<'_>]>) {
        let Ok(mut state) = self.state() else { return };
        let Some(pending) = state.waits.remove(&token) else { return };
        pending.reply(result.and_then(|all| all.iter().map(|v| Ok(cbor::write(v.to_value()?))).collect()));
    }

    fn call_func(&self, turn: &Turn<'_>, local: u32, args: &[ValueRef<'_>]) -> Result<Vec<Value>> {
        let args = args.iter().map(|v| v.to_value()).collect::<Result<Vec<_>>>()?;
        let function = self.state()?.functions.get(local).cloned().ok_or_else(gone)?;
        let place = self.state()?.place_of(&function.client);
        match place {
            Some(place) => self.call_back(turn, place, &function.name, &args),
            None => {
                self.state()?.functions.put_off(function, args);
                Ok(Vec::new())
            }
        }
    }
}

impl Remote {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }

    /// Executes a request. The state is not borrowed while a command runs, because the command may call a client's
    /// function.
    fn handle(&self, turn: &Turn<'_>, step: u64, waiting: Waiting) -> Result<()> {
        let Waiting { connection, answer, asked } = waiting;
        let asked = asked.map(|r| {
            let key = r.uuid.clone().unwrap_or_else(|| format!("connection {connection}"));
            (Pending { connection, key, answer: answer.clone(), name: r.func.clone(), first: r.uuid.is_none() }, r)
        });
        let (pending, mut request) = match asked {
            Ok(asked) => asked,
            Err(fail) => {
                let nobody = Pending { connection, key: String::new(), answer, name: String::new(), first: false };
                nobody.reply(Err(fail));
                return Ok(());
            }
        };
        let key = pending.key.clone();
        let (at, later) = {
            let state = &mut *self.state()?;
            turn.client(state.clients.of(&key, connection).number);
            state.running.push(pending);
            (state.running.len() - 1, state.functions.take_later(&key))
        };
        for (name, args) in later {
            // The results of a deferred call are not used, and an error only means that the client has disconnected.
            let _ = self.call_back(turn, Place::Running(at), &name, &args);
        }
        let bound = {
            let functions = &mut self.state()?.functions;
            let mut args = request.args.iter_mut().filter(|_| request.uuid.is_some());
            args.try_for_each(|arg| functions.bind(&key, arg, &|number| turn.function(number)))
        };
        let done = bound.and_then(|()| self.act(turn, step, at, &request)).and_then(|done| match done {
            Done::Command => self.call(turn, at, &request),
            done => Ok(done),
        });
        // If functions of the client were called, the answer belongs to the request in which the last of them returned.
        let state = &mut *self.state()?;
        let pending = state.running.pop();
        match (done, pending) {
            (Ok(Done::Now(values)), Some(pending)) => pending.reply(Ok(values)),
            (Err(fail), Some(pending)) => pending.reply(Err(fail)),
            _ => {}
        }
        Ok(())
    }

    /// Executes a request for a function that the service itself provides. Returns `Done::Command` for other functions.
    fn act(&self, turn: &Turn<'_>, step: u64, at: usize, request: &Request) -> Result<Done> {
        let Request { func, args, .. } = request;
        let none = || Ok(Done::Now(Vec::new()));
        let text = || match args.first() {
            Some(Value::Text(t)) => Ok(String::from_utf8_lossy(t).into_owned()),
            _ => Err(Fail::argument("argument 1: expected the name of a module")),
        };
        let mut state = self.state()?;
        let state = &mut *state;
        let pending = state.running.get(at).cloned().ok_or_else(gone)?;
        let client = state.clients.of(&pending.key, pending.connection);
        let running = turn.state() == TATU_RUNNING;
        match func.as_str() {
            EXECUTED => none(),
            "_*end*_" => {
                state.end(&pending.key);
                none()
            }
            "zmqRemoteApi.require" => {
                catalogue::require(turn, &text()?)?;
                none()
            }
            "zmqRemoteApi.info" => Ok(Done::Now(vec![catalogue::info(turn, &text()?)?])),
            "sim.setStepping" | "setStepping" => {
                let before = client.level;
                let on = matches!(args.first(), Some(Value::Bool(true)))
                    || matches!(args.first(), Some(Value::Int(i)) if *i != 0);
                client.level = if on { before + 1 } else { (before - 1).max(0) };
                Ok(Done::Now(vec![Cbor::Integer(before.into())]))
            }
            "sim.step" | "sim.switchThread" | "sim.yield" | "step" if running && state.talks > 0 => {
                Err(Fail::with_code(
                    TATU_ERR_BUSY,
                    "a callback cannot request a step, because the simulation does not advance before the callback returns",
                ))
            }
            "sim.step" | "sim.switchThread" | "sim.yield" if running => {
                client.until.push((step + 1, Some(pending.answer)));
                Ok(Done::Later)
            }
            // In the first version of the protocol, the client is notified of the step through the next port.
            "step" if running => {
                client.until.push((step + 1, None));
                none()
            }
            "sim.step" | "sim.switchThread" | "sim.yield" | "step" => none(),
            "sim.acquireLock" => {
                client.holds += 1;
                none()
            }
            "sim.releaseLock" => {
                client.holds = (client.holds - 1).max(0);
                none()
            }
            _ => Ok(Done::Command),
        }
    }

    /// Calls the command of the world that a request names.
    fn call(&self, turn: &Turn<'_>, at: usize, request: &Request) -> Result<Done> {
        let token = {
            let state = &mut *self.state()?;
            // A stop must not be delayed by a client that holds the simulation.
            if request.func == "sim.stopSimulation" {
                state.clients.iter_mut().for_each(|c| c.release());
            }
            // While a client's function is being called, commands must not wait, which the token 0 enforces.
            if state.talks > 0 { 0 } else { state.next_token }
        };
        match turn.call(&request.func, &request.args, token)? {
            Called::Done(values) => Ok(Done::Now(values.into_iter().map(cbor::write).collect())),
            Called::Waits => {
                let state = &mut *self.state()?;
                state.next_token += 1;
                let pending = state.running.get(at).cloned().ok_or_else(gone)?;
                state.waits.insert(token, pending);
                Ok(Done::Later)
            }
        }
    }

    /// Calls a function of a client as the answer to the client's request, and executes further requests from the
    /// client until the function returns. Returns the results of the function.
    fn call_back(&self, turn: &Turn<'_>, place: Place, name: &str, args: &[Value]) -> Result<Vec<Value>> {
        self.state()?.talks += 1;
        let results = self.talk(turn, place, name, args);
        self.state()?.talks -= 1;
        results
    }

    /// Implements `call_back`, except for counting the calls in progress.
    fn talk(&self, turn: &Turn<'_>, place: Place, name: &str, args: &[Value]) -> Result<Vec<Value>> {
        let connection = {
            let state = &mut *self.state()?;
            let pending = state.pending(place).ok_or_else(gone)?;
            let _ = pending.answer.send(cbor::call(name, args));
            let connection = pending.connection;
            turn.client(state.clients.of_connection(connection).ok_or_else(gone)?);
            connection
        };
        loop {
            let next = {
                let state = &mut *self.state()?;
                if turn.is_interrupted() {
                    return Err(Fail::with_code(TATU_ERR_GONE, "the run ended before a function of a client returned"));
                }
                state.wait(&self.session);
                state.clients.of_connection(connection).ok_or_else(gone)?;
                let at = state.requests.iter().position(|r| r.connection == connection);
                at.and_then(|at| state.requests.remove(at))
            };
            match next {
                Some(Waiting { answer, asked: Ok(request), .. }) if request.func == EXECUTED => {
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

/// A port, and the receiver of the events of its connections.
type Opened = (Listener, Receiver<Event>);

/// Maximum number of attempts to find two consecutive free ports.
const ATTEMPTS: usize = 16;

/// Opens the port for requests, and the next port for the step counter, which may fail. If `port` is 0, chooses two
/// consecutive free ports if possible.
fn listen(session: &Session, port: u16) -> Result<(Opened, io::Result<Opened>)> {
    let mut attempt = 1;
    loop {
        let woken = session.clone();
        let opened = Listener::open(Kind::Reply, port, Box::new(move || woken.wake())).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        let next = opened.0.address().port().wrapping_add(1);
        let counter = Listener::open(Kind::Publish, next, Box::new(|| ()));
        if counter.is_ok() || port != 0 || attempt == ATTEMPTS {
            return Ok((opened, counter));
        }
        attempt += 1;
    }
}
