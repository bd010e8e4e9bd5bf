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
    cbor::{self, RemoteRequest},
    clients::{AnswerSender, ZmqClients},
    functions::FunctionTable,
    zmtp::{ConnectionEvent, ZmtpListener},
};

/// Time to wait for an event of a client before checking whether the run has ended.
const EVENT_TIMEOUT: Duration = Duration::from_millis(20);

/// The clients of the service, their requests, and its ports.
pub(crate) struct ZmqState {
    pub clients: ZmqClients,
    /// Received requests that have not been executed, in order of arrival.
    pub requests: VecDeque<QueuedRequest>,
    /// Requests that are being executed, outermost first. A request is nested if a client sends it while one of its
    /// functions is being called.
    pub running: Vec<PendingRequest>,
    /// Number of functions of clients that have been called and have not returned.
    pub active_calls: u32,
    /// Requests for commands that have not returned yet, by token.
    pub pending_commands: BTreeMap<u64, PendingRequest>,
    /// Token for the next command that does not return immediately.
    pub next_token: u64,
    pub functions: FunctionTable,
    /// The step that was published last, for clients that use the first version of the protocol.
    pub published_step: Option<u64>,
    pub events: Receiver<ConnectionEvent>,
    /// Must be declared after the fields with pending requests. Fields are dropped in order, and the threads of
    /// connections end only when the requests have been dropped.
    pub _listener: ZmtpListener,
    /// The port that publishes the step, if it could be opened.
    pub counter: Option<ZmtpListener>,
}

/// A received request that has not been executed.
pub(crate) struct QueuedRequest {
    pub connection: u64,
    pub answer: AnswerSender,
    /// The request, or the reason why it is invalid.
    pub request: Result<RemoteRequest>,
}

/// A request that has been accepted for execution and has not been answered.
#[derive(Clone)]
pub(crate) struct PendingRequest {
    pub connection: u64,
    /// Key of the client.
    pub key: String,
    pub answer: AnswerSender,
    /// The name of the called function.
    pub name: String,
    /// Whether the client uses the first version of the protocol.
    pub first_version: bool,
}

impl PendingRequest {
    /// Sends the answer. Does nothing if the client has disconnected.
    pub fn reply(&self, result: Result<Vec<Cbor>>) {
        let bytes = match result {
            Ok(values) => cbor::encode_results(values, self.first_version),
            Err(fail) => {
                cbor::encode_error(&format!("{} (in function '{}')", fail.text(), self.name), self.first_version)
            }
        };
        let _ = self.answer.send(bytes);
    }
}

/// Identifies an unanswered request in `ZmqState`.
#[derive(Clone, Copy)]
pub(crate) enum PendingId {
    /// A request that is being executed, by its index in `running`.
    Running(usize),
    /// A request for a command that has not returned yet, by its token in `pending_commands`.
    Waiting(u64),
}

/// What remains to be done for a request after its execution has started.
pub(crate) enum RequestOutcome {
    /// The request was executed, with these results.
    Results(Vec<Cbor>),
    /// The request is not executed completely, and will be answered later.
    Deferred,
    /// The request is for a command of the world, which must be called.
    Command,
}

/// Builds the error for a function of a client that has disconnected.
pub(crate) fn disconnected_error() -> Fail {
    Fail::with_code(TATU_ERR_GONE, "the client that provides the function has disconnected")
}

impl ZmqState {
    /// Handles the queued events of connections.
    pub fn handle_events(&mut self, session: &Session) {
        while let Ok(event) = self.events.try_recv() {
            self.handle_event(session, event);
        }
    }

    /// Waits at most `EVENT_TIMEOUT` for an event of a connection, and handles it.
    pub fn wait_for_event(&mut self, session: &Session) {
        if let Ok(event) = self.events.recv_timeout(EVENT_TIMEOUT) {
            self.handle_event(session, event);
        }
    }

    /// Handles an event of a connection: queues a request, removes what belongs to a closed connection, or logs an
    /// error.
    pub fn handle_event(&mut self, session: &Session, event: ConnectionEvent) {
        match event {
            ConnectionEvent::Request { connection, body, answer } => {
                self.requests.push_back(QueuedRequest { connection, answer, request: cbor::read(&body) });
            }
            ConnectionEvent::Disconnected(connection) => {
                self.requests.retain(|r| r.connection != connection);
                // The answers of commands that have not returned yet can no longer be delivered.
                self.pending_commands.retain(|_, pending| pending.connection != connection);
                for key in self.clients.remove_connection(connection) {
                    self.functions.remove_client(&key);
                }
            }
            ConnectionEvent::Refused(text) => session.log(TATU_LOG_WARNING, &format!("zmq_remote: {text}")),
        }
    }

    /// Removes a client that has announced that it will disconnect.
    pub fn remove_client(&mut self, key: &str) {
        self.clients.remove(key);
        self.functions.remove_client(key);
    }

    /// Returns the unanswered request by whose answer a function of the client can be called: the innermost one that is
    /// being executed, otherwise the last one whose command has not returned yet.
    pub fn pending_of_client(&self, client: &str) -> Option<PendingId> {
        let running = self.running.iter().rposition(|p| p.key == client).map(PendingId::Running);
        running.or_else(|| {
            self.pending_commands.iter().rfind(|(_, p)| p.key == client).map(|(token, _)| PendingId::Waiting(*token))
        })
    }

    /// Returns an unanswered request.
    pub fn pending(&mut self, place: PendingId) -> Option<&mut PendingRequest> {
        match place {
            PendingId::Running(at) => self.running.get_mut(at),
            PendingId::Waiting(token) => self.pending_commands.get_mut(&token),
        }
    }

    /// Removes step requests that have ended by this step, and answers those whose clients wait for an answer. While
    /// the simulation is not running, all step requests end immediately.
    pub fn finish_steps(&mut self, turn: &Turn<'_>, step: u64) {
        let stands = turn.state() != TATU_RUNNING;
        for client in self.clients.iter_mut() {
            client.until.retain(|(until, answer)| {
                let over = stands || *until <= step;
                if let (true, Some(answer)) = (over, answer) {
                    let _ = answer.send(cbor::encode_results(Vec::new(), false));
                }
                !over
            });
        }
    }
}

impl Drop for ZmqState {
    fn drop(&mut self) {
        // Dropping the requests ends the threads of connections that wait for answers.
        self.requests.clear();
        self.pending_commands.clear();
        self.clients = ZmqClients::default();
    }
}
