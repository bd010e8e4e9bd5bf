//! Who is there, what waits for its turn, and what waits for an answer.

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

/// How long a client is waited for before it is asked whether the run goes on.
const PATIENCE: Duration = Duration::from_millis(20);

/// What the service holds.
pub(crate) struct State {
    pub clients: Clients,
    pub requests: VecDeque<Waiting>,
    /// Requests whose commands run now, the outermost first: a function of a client may be called in any of them.
    pub running: Vec<Pending>,
    /// Functions of clients that have been called and have not returned.
    pub talks: u32,
    /// Requests whose commands wait, by token.
    pub waits: BTreeMap<u64, Pending>,
    pub next_token: u64,
    pub functions: Functions,
    /// The step that was last sent to listeners of the first protocol.
    pub told: Option<u64>,
    pub events: Receiver<Event>,
    /// Last, so that what waits is let go before connections end.
    pub _listener: Listener,
    pub counter: Option<Listener>,
}

/// A request that waits for its turn.
pub(crate) struct Waiting {
    pub connection: u64,
    pub answer: Answer,
    pub asked: Result<Request>,
}

/// A request that is not answered yet.
#[derive(Clone)]
pub(crate) struct Pending {
    pub connection: u64,
    /// Of its client.
    pub key: String,
    pub answer: Answer,
    /// What it calls.
    pub name: String,
    /// It is of the first protocol.
    pub first: bool,
}

impl Pending {
    /// Answers; who has gone needs none.
    pub fn reply(&self, result: Result<Vec<Cbor>>) {
        let bytes = match result {
            Ok(values) => cbor::results(values, self.first),
            Err(fail) => cbor::failed(&format!("{} (in function '{}')", fail.text(), self.name), self.first),
        };
        let _ = self.answer.send(bytes);
    }
}

/// Where the answer of a client's function goes: to a command that runs, or to one that waits.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    Running(usize),
    Waits(u64),
}

/// What becomes of a request.
pub(crate) enum Done {
    Now(Vec<Cbor>),
    /// It is answered later.
    Later,
    /// It is a command of the world, to be called.
    Command,
}

/// The client of a function, or of a request, is not there any more.
pub(crate) fn gone() -> Fail {
    Fail::with_code(TATU_ERR_GONE, "the function's client has disconnected")
}

impl State {
    /// What connections reported.
    pub fn hear(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            self.take(session, event);
        }
    }

    /// Waits briefly for what connections report.
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

    /// A client says that it goes.
    pub fn end(&mut self, key: &str) {
        self.clients.end(key);
        self.functions.gone(key);
    }

    /// The request of a client that a function of it can answer now: the innermost that runs, else the last that waits.
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

    /// Answers those whose steps are over. While time stands a step is over at once.
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
        // Their answers will not come: connections that wait for them end.
        self.requests.clear();
        self.waits.clear();
        self.clients = Clients::default();
    }
}
