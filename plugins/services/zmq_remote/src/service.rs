//! What is done at the barrier: requests in the order in which they came.

use std::{
    cell::{RefCell, RefMut},
    collections::{BTreeMap, VecDeque},
    sync::mpsc::Receiver,
};

use ciborium::Value as Cbor;
use tatu_plugin_api::{
    abi::*,
    safe::{self, Called, Fail, Host, Param, Params, Result, Service, Session, Turn, Value, ValueRef},
};

use crate::{
    ZmqRemote, catalogue,
    cbor::{self, Request},
    clients::{Answer, Clients},
    zmtp::{Event, Kind, Listener},
};

/// Requests that are handled in one turn.
const AT_ONCE: usize = 2000;
/// The port that clients ask when they are told none.
const PORT: i64 = 23000;

/// The service.
pub struct Remote {
    session: Session,
    state: RefCell<State>,
}

struct State {
    clients: Clients,
    requests: VecDeque<Waiting>,
    /// Commands that wait, by token.
    waits: BTreeMap<u64, (Answer, bool, String)>,
    next_token: u64,
    /// The step that listeners of the first protocol were told last.
    told: Option<u64>,
    events: Receiver<Event>,
    /// Last, so that what waits is let go before connections end.
    _listener: Listener,
    counter: Option<Listener>,
}

/// A request that waits for its turn.
struct Waiting {
    connection: u64,
    answer: Answer,
    asked: Result<Request>,
}

/// What becomes of a request.
enum Done {
    Now(Vec<Cbor>),
    /// It is answered later.
    Later,
}

impl Service for Remote {
    type Plugin = ZmqRemote;
    const ID: &'static str = "zmq_remote";
    const TEXT: &'static str =
        "The ZeroMQ remote API: clients written for CoppeliaSim call commands, with or without stepping.";

    fn params() -> Vec<Param> {
        vec![
            Param::int("port").range(0.0, 65534.0).default(PORT).text(
                "of 127.0.0.1 to listen on; 0: any that is free. The next port tells clients of the first protocol of steps",
            ),
        ]
    }

    fn start(_: &ZmqRemote, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let port = params.i64("port")? as u16;
        let wake = move || session.wake();
        let (listener, events) = Listener::open(Kind::Reply, port, Box::new(wake)).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}")).help("choose another `port`; 0 takes any")
        })?;
        let address = listener.address();
        let counter = match Listener::open(Kind::Publish, address.port().wrapping_add(1), Box::new(|| ())) {
            Ok((counter, _)) => Some(counter),
            Err(e) => {
                let next = address.port().wrapping_add(1);
                let text = format!("zmq_remote: port {next} is taken ({e}): clients of 2022 and before cannot step");
                session.log(TATU_LOG_WARNING, &text);
                None
            }
        };
        session.log(TATU_LOG_INFO, &format!("zmq_remote: listening on {address}"));
        let state = State {
            clients: Clients::default(),
            requests: VecDeque::new(),
            waits: BTreeMap::new(),
            next_token: 1,
            told: None,
            events,
            _listener: listener,
            counter,
        };
        Ok(Remote { session, state: RefCell::new(state) })
    }

    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<safe::Answer> {
        // One world is served: the first one of its session.
        if turn.worlds().0 != 0 {
            return Ok(safe::Answer::Go);
        }
        let state = &mut *self.state()?;
        if state.told.replace(step) != Some(step)
            && let Some(counter) = &state.counter
        {
            counter.publish(&(step as u32).to_le_bytes());
        }
        state.hear(&self.session);
        state.stepped(turn, step);
        for _ in 0..AT_ONCE {
            let Some(waiting) = state.requests.pop_front() else { break };
            state.handle(turn, step, waiting);
        }
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
        let Some((answer, first, name)) = state.waits.remove(&token) else { return };
        let values = result.and_then(|all| all.iter().map(|v| Ok(cbor::write(&v.to_value()?))).collect());
        reply(&answer, &name, values, first);
    }
}

/// Answers; who has gone needs none.
fn reply(answer: &Answer, name: &str, result: Result<Vec<Cbor>>, first: bool) {
    let bytes = match result {
        Ok(values) => cbor::results(values, first),
        Err(fail) => cbor::failed(&format!("{} (in function '{name}')", fail.text()), first),
    };
    let _ = answer.send(bytes);
}

impl Remote {
    fn state(&self) -> Result<RefMut<'_, State>> {
        self.state.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the service is in use"))
    }
}

impl State {
    /// What connections told.
    fn hear(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            match event {
                Event::Request { connection, body, answer } => {
                    self.requests.push_back(Waiting { connection, answer, asked: cbor::read(&body) });
                }
                Event::Gone(connection) => {
                    self.requests.retain(|r| r.connection != connection);
                    self.clients.gone(connection);
                }
                Event::Refused(text) => session.log(TATU_LOG_WARNING, &format!("zmq_remote: {text}")),
            }
        }
    }

    /// Answers those whose steps are over. While time stands a step is over at once.
    fn stepped(&mut self, turn: &Turn<'_>, step: u64) {
        let stands = turn.state() != TATU_RUNNING;
        for client in self.clients.iter_mut() {
            client.until.retain(|(until, answer)| {
                let over = stands || *until <= step;
                if let (true, Some(answer)) = (over, answer) {
                    let _ = answer.send(cbor::results(Vec::new(), false));
                }
                !over
            });
        }
    }

    fn handle(&mut self, turn: &Turn<'_>, step: u64, waiting: Waiting) {
        let Waiting { connection, answer, asked } = waiting;
        let request = match asked {
            Ok(request) => request,
            Err(fail) => return reply(&answer, "", Err(fail), false),
        };
        let first = request.uuid.is_none();
        let key = request.uuid.clone().unwrap_or_else(|| format!("connection {connection}"));
        let number = self.clients.of(&key, connection).number;
        turn.client(number);
        let name = request.func.clone();
        match self.act(turn, step, (&key, connection), request, &answer) {
            Ok(Done::Later) => {}
            Ok(Done::Now(values)) => reply(&answer, &name, Ok(values), first),
            Err(fail) => reply(&answer, &name, Err(fail), first),
        }
    }

    fn act(
        &mut self,
        turn: &Turn<'_>,
        step: u64,
        (key, connection): (&str, u64),
        request: Request,
        answer: &Answer,
    ) -> Result<Done> {
        let Request { func, args, uuid } = request;
        let first = uuid.is_none();
        let running = turn.state() == TATU_RUNNING;
        let none = || Ok(Done::Now(Vec::new()));
        let text = || match args.first() {
            Some(Value::Text(t)) => Ok(String::from_utf8_lossy(t).into_owned()),
            _ => Err(Fail::argument("the name of a module is expected")),
        };
        let client = self.clients.of(key, connection);
        match func.as_str() {
            "_*executed*_" => none(),
            "_*end*_" => {
                self.clients.end(key);
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
            "sim.step" | "sim.switchThread" | "sim.yield" if running => {
                client.until.push((step + 1, Some(answer.clone())));
                Ok(Done::Later)
            }
            // A client of the first protocol hears of the step by the next port.
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
            _ => {
                // A stop is held up by nobody.
                if func == "sim.stopSimulation" {
                    self.clients.iter_mut().for_each(|c| c.release());
                }
                self.call(turn, func, &args, answer, first)
            }
        }
    }

    fn call(&mut self, turn: &Turn<'_>, func: String, args: &[Value], answer: &Answer, first: bool) -> Result<Done> {
        let token = self.next_token;
        match turn.call(&func, args, token)? {
            Called::Done(values) => Ok(Done::Now(values.iter().map(cbor::write).collect())),
            Called::Waits => {
                self.next_token += 1;
                self.waits.insert(token, (answer.clone(), first, func));
                Ok(Done::Later)
            }
        }
    }
}

impl Drop for State {
    fn drop(&mut self) {
        // Their answers will not come: connections that wait for them end.
        self.requests.clear();
        self.waits.clear();
        self.clients = Clients::default();
    }
}
