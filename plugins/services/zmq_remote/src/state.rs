//! Clients, requests that wait for their turn, and requests that wait for an answer.

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

/// How long to wait for a client before checking whether the run continues.
const PATIENCE: Duration = Duration::from_millis(20);

/// The state of the service.
pub(crate) struct State {
    pub clients: Clients,
    pub requests: VecDeque<Waiting>,
    /// Requests whose commands are running, outermost first: each may call functions of clients.
    pub running: Vec<Pending>,
    /// Number of client functions that have been called and have not returned.
    pub talks: u32,
    /// Requests whose commands wait, by token.
    pub waits: BTreeMap<u64, Pending>,
    pub next_token: u64,
    pub functions: Functions,
    /// The step last sent to subscribers of the first protocol.
    pub told: Option<u64>,
    pub events: Receiver<Event>,
    /// Must come after the fields with pending requests, which must be dropped before connections end.
    pub _listener: Listener,
    pub counter: Option<Listener>,
}

/// A request that waits for its turn.
pub(crate) struct Waiting {
    pub connection: u64,
    pub answer: Answer,
    pub asked: Result<Request>,
}

/// A request that has not been answered yet.
#[derive(Clone)]
pub(crate) struct Pending {
    pub connection: u64,
    /// Key of its client.
    pub key: String,
    pub answer: Answer,
    /// The name of the called function.
    pub name: String,
    /// Whether it uses the first protocol.
    pub first: bool,
}

impl Pending {
    /// Sends the answer; does nothing if the client has disconnected.
    pub fn reply(&self, result: Result<Vec<Cbor>>) {
        let bytes = match result {
            Ok(values) => cbor::results(values, self.first),
            Err(fail) => cbor::failed(&format!("{} (in function '{}')", fail.text(), self.name), self.first),
        };
        let _ = self.answer.send(bytes);
    }
}

/// The request whose answer a client's function provides: a running one, or a waiting one.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    Running(usize),
    Waits(u64),
}

/// The outcome of a request.
pub(crate) enum Done {
    Now(Vec<Cbor>),
    /// The request will be answered later.
    Later,
    /// The request names a command of the world, which must be called.
    Command,
}

/// Builds the error for a client that has disconnected.
pub(crate) fn gone() -> Fail {
    Fail::with_code(TATU_ERR_GONE, "the function's client has disconnected")
}

impl State {
    /// Processes the events of connections.
    pub fn hear(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            self.take(session, event);
        }
    }

    /// Waits briefly for an event of a connection.
    pub fn wait(&mut self, session: &Session) {
        if let Ok(event) = self.events.recv_timeout(PATIENCE) {
            self.take(session, event);
        }
    }

    pub fn take(&mut self, session: &Session, event: Event) {
        match event {
            Event::Request { connection, body, answer } => {
                self.requests.push_back(Waiting { connection, answer, asked: cbor::read(&body) });
            }
            Event::Gone(connection) => {
                self.requests.retain(|r| r.connection != connection);
                for key in self.clients.gone(connection) {
                    self.functions.gone(&key);
                }
            }
            Event::Refused(text) => session.log(TATU_LOG_WARNING, &format!("zmq_remote: {text}")),
        }
    }

    /// Removes a client that announces its end.
    pub fn end(&mut self, key: &str) {
        self.clients.end(key);
        self.functions.gone(key);
    }

    /// Returns the request of a client that carries a call of its function: the innermost running one, otherwise the
    /// last waiting one.
    pub fn place_of(&self, client: &str) -> Option<Place> {
        let running = self.running.iter().rposition(|p| p.key == client).map(Place::Running);
        running.or_else(|| self.waits.iter().rfind(|(_, p)| p.key == client).map(|(token, _)| Place::Waits(*token)))
    }

    pub fn pending(&mut self, place: Place) -> Option<&mut Pending> {
        match place {
            Place::Running(at) => self.running.get_mut(at),
            Place::Waits(token) => self.waits.get_mut(&token),
        }
    }

    /// Answers the clients that wait for steps which have passed. While the simulation is not running, steps pass at
    /// once.
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
        // Pending requests will not be answered: the connections waiting for them end.
        self.requests.clear();
        self.waits.clear();
        self.clients = Clients::default();
    }
}
