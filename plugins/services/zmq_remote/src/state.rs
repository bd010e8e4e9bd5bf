//! The state of the service: clients, queued requests, and requests that have not been answered.

use std::{
    collections::{BTreeMap, VecDeque},
    sync::mpsc::Receiver,
    time::Duration,
};

use ciborium::Value as Cbor;
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Session, Turn},
};

use crate::{
    cbor::{self, Request},
    clients::{Answer, Clients},
    functions::Functions,
    zmtp::{Event, Listener},
};

/// Time to wait for an event of a client before checking whether the run has ended.
const PATIENCE: Duration = Duration::from_millis(20);

/// The state of the service.
pub(crate) struct State {
    pub clients: Clients,
    /// Received requests that have not been executed, in order of arrival.
    pub requests: VecDeque<Waiting>,
    /// Requests that are being executed, outermost first. A request is nested if a client sends it while one of its
    /// functions is being called.
    pub running: Vec<Pending>,
    /// Number of functions of clients that have been called and have not returned.
    pub talks: u32,
    /// Requests for commands that have not returned yet, by token.
    pub waits: BTreeMap<u64, Pending>,
    /// Token for the next command that does not return immediately.
    pub next_token: u64,
    pub functions: Functions,
    /// The step that was published last, for clients that use the first version of the protocol.
    pub told: Option<u64>,
    pub events: Receiver<Event>,
    /// Must be declared after the fields with pending requests. Fields are dropped in order, and the threads of
    /// connections end only when the requests have been dropped.
    pub _listener: Listener,
    /// The port that publishes the step, if it could be opened.
    pub counter: Option<Listener>,
}

/// A received request that has not been executed.
pub(crate) struct Waiting {
    pub connection: u64,
    pub answer: Answer,
    /// The request, or the reason why it is invalid.
    pub asked: Result<Request>,
}

/// A request that has been accepted for execution and has not been answered.
#[derive(Clone)]
pub(crate) struct Pending {
    pub connection: u64,
    /// Key of the client.
    pub key: String,
    pub answer: Answer,
    /// The name of the called function.
    pub name: String,
    /// Whether the client uses the first version of the protocol.
    pub first: bool,
}

impl Pending {
    /// Sends the answer. Does nothing if the client has disconnected.
    pub fn reply(&self, result: Result<Vec<Cbor>>) {
        let bytes = match result {
            Ok(values) => cbor::results(values, self.first),
            Err(fail) => cbor::failed(&format!("{} (in function '{}')", fail.text(), self.name), self.first),
        };
        let _ = self.answer.send(bytes);
    }
}

/// Identifies an unanswered request in `State`.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    /// A request that is being executed, by its index in `running`.
    Running(usize),
    /// A request for a command that has not returned yet, by its token in `waits`.
    Waits(u64),
}

/// The outcome of a request.
pub(crate) enum Done {
    /// The request was executed, with these results.
    Now(Vec<Cbor>),
    /// The request is not executed completely, and will be answered later.
    Later,
    /// The request is for a command of the world, which must be called.
    Command,
}

/// Builds the error for a function of a client that has disconnected.
pub(crate) fn gone() -> Fail {
    Fail::with_code(TATU_ERR_GONE, "the client that provides the function has disconnected")
}

impl State {
    /// Handles the queued events of connections.
    pub fn hear(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            self.take(session, event);
        }
    }

    /// Waits at most `PATIENCE` for an event of a connection, and handles it.
    pub fn wait(&mut self, session: &Session) {
        if let Ok(event) = self.events.recv_timeout(PATIENCE) {
            self.take(session, event);
        }
    }

    /// Handles an event of a connection.
    pub fn take(&mut self, session: &Session, event: Event) {
        match event {
            Event::Request { connection, body, answer } => {
                self.requests.push_back(Waiting { connection, answer, asked: cbor::read(&body) });
            }
            Event::Gone(connection) => {
                self.requests.retain(|r| r.connection != connection);
                // Nobody would receive the answers of commands that have not returned yet.
                self.waits.retain(|_, pending| pending.connection != connection);
                for key in self.clients.gone(connection) {
                    self.functions.gone(&key);
                }
            }
            Event::Refused(text) => session.log(TATU_LOG_WARNING, &format!("zmq_remote: {text}")),
        }
    }

    /// Removes a client that has announced that it will disconnect.
    pub fn end(&mut self, key: &str) {
        self.clients.end(key);
        self.functions.gone(key);
    }

    /// Returns the unanswered request by whose answer a function of the client can be called: the innermost one that is
    /// being executed, otherwise the last one whose command has not returned yet.
    pub fn place_of(&self, client: &str) -> Option<Place> {
        let running = self.running.iter().rposition(|p| p.key == client).map(Place::Running);
        running.or_else(|| self.waits.iter().rfind(|(_, p)| p.key == client).map(|(token, _)| Place::Waits(*token)))
    }

    /// Returns an unanswered request.
    pub fn pending(&mut self, place: Place) -> Option<&mut Pending> {
        match place {
            Place::Running(at) => self.running.get_mut(at),
            Place::Waits(token) => self.waits.get_mut(&token),
        }
    }

    /// Removes step requests that have ended by this step, and answers those whose clients wait for an answer. While
    /// the simulation is not running, all step requests end immediately.
    pub fn stepped(&mut self, turn: &Turn<'_>, step: u64) {
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
}

impl Drop for State {
    fn drop(&mut self) {
        // Dropping the requests ends the threads of connections that wait for answers.
        self.requests.clear();
        self.waits.clear();
        self.clients = Clients::default();
    }
}
