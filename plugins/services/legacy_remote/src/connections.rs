//! Connections of clients. The thread of each connection answers every message with the results that are available, of
//! which there may be none. Received commands are queued until the barrier.

use std::{
    collections::BTreeMap,
    io,
    net::TcpStream,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, AtomicUsize, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    time::Duration,
};

use tatu_plugin_api::safe::Session;
use tatu_services_common::port::Port;

use crate::{
    message::{self, MessageHead, RemoteCommand, WorldStatus},
    packet,
};

/// Maximum number of simultaneous connections.
const MAX_CONNECTIONS: usize = 64;
/// Maximum total size of the messages of a client that have not been processed, bytes.
const MAX_UNPROCESSED_BYTES: usize = 128 << 20;
/// Time for which a connection waits for results before it answers a message with commands.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(20);
/// Time for which sending to a client may block before the client is disconnected. Clients that send nothing remain
/// connected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// Events that the threads of connections report to the service.
pub enum ConnectionEvent {
    /// The client with this number has connected.
    Connected(u64, Arc<AnswerQueue>),
    /// A client has sent commands. The last field is the size of the message, bytes.
    Commands(u64, MessageHead, Vec<RemoteCommand>, usize),
    /// A client has disconnected. The last field is the reason if its messages were invalid.
    Disconnected(u64, Option<String>),
}

/// The queue of answers to a client.
#[derive(Default)]
pub struct AnswerQueue {
    state: Mutex<PendingAnswers>,
    /// Notified when answers are queued.
    filled: Condvar,
    /// Total size of the client's messages that have not been processed, bytes.
    unprocessed_bytes: AtomicUsize,
}

/// Identifies an answer: the code and the subject of the command.
pub type CommandKey = (u32, Vec<u8>);

#[derive(Default)]
struct PendingAnswers {
    /// The answers, by code and subject of the command. A newer answer to the same command replaces an older one.
    answers: BTreeMap<CommandKey, Vec<u8>>,
    /// The id of the newest message that was executed.
    id: i32,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl AnswerQueue {
    /// Queues answers; `id` is that of the newest message that was executed.
    pub fn queue_answers(&self, id: i32, answers: Vec<(CommandKey, Vec<u8>)>) {
        let mut state = lock(&self.state);
        state.id = id;
        state.answers.extend(answers);
        self.filled.notify_all();
    }
    /// Records that a message of `size` bytes has been processed.
    pub fn mark_processed(&self, size: usize) {
        self.unprocessed_bytes.fetch_sub(size, Ordering::AcqRel);
    }
    /// Returns whether all queued answers have been sent.
    pub fn is_empty(&self) -> bool {
        lock(&self.state).answers.is_empty()
    }
    /// Waits at most `patience` for answers. Removes and returns all of them, with the id of the newest message that
    /// was executed, or returns `None` if there are none.
    fn wait_for_answers(&self, patience: Duration) -> Option<(i32, Vec<Vec<u8>>)> {
        let state = lock(&self.state);
        let (mut state, _) = self
            .filled
            .wait_timeout_while(state, patience, |s| s.answers.is_empty())
            .unwrap_or_else(PoisonError::into_inner);
        let answers: Vec<Vec<u8>> = std::mem::take(&mut state.answers).into_values().collect();
        (!answers.is_empty()).then_some((state.id, answers))
    }
}

/// Data shared by all ports of a service.
#[derive(Clone)]
pub struct PortOpener(Arc<PortsState>);

struct PortsState {
    session: Session,
    events: Mutex<Sender<ConnectionEvent>>,
    world: Mutex<WorldStatus>,
    numbers: AtomicU64,
}

impl PortOpener {
    /// Creates the shared data without opening a port. Also returns the receiver of events.
    pub fn new(session: Session) -> (PortOpener, Receiver<ConnectionEvent>) {
        let (events, told) = channel();
        let (events, world, numbers) = (Mutex::new(events), Mutex::default(), AtomicU64::new(1));
        (PortOpener(Arc::new(PortsState { session, events, world, numbers })), told)
    }
    /// Sets the state of the world that the heads of answers report.
    pub fn set_world_status(&self, world: WorldStatus) {
        *lock(&self.0.world) = world;
    }
    /// Opens a port on 127.0.0.1; if `port` is 0, any free port. Each connection is served by a separate thread.
    pub fn open(&self, port: u16) -> io::Result<Port> {
        let shared = self.0.clone();
        let serve = move |stream: TcpStream, _| {
            let number = shared.numbers.fetch_add(1, Ordering::Relaxed);
            let events = lock(&shared.events).clone();
            let done = serve(stream, number, &shared, &events);
            let why = done.err().filter(|e| e.kind() == io::ErrorKind::InvalidData).map(|e| e.to_string());
            let _ = events.send(ConnectionEvent::Disconnected(number, why));
            shared.session.wake();
        };
        Port::open(port, "legacy remote", MAX_CONNECTIONS, serve)
    }
}

/// Reads and answers messages until the connection is closed or a message is invalid.
fn serve(mut stream: TcpStream, number: u64, shared: &PortsState, events: &Sender<ConnectionEvent>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    let out = Arc::new(AnswerQueue::default());
    let mut told = false;
    loop {
        let bytes = packet::read(&mut stream)?;
        let (head, commands) = message::read(&bytes)?;
        // A connection is reported as a client after its first valid message.
        if !std::mem::replace(&mut told, true) {
            let _ = events.send(ConnectionEvent::Connected(number, out.clone()));
        }
        let mut patience = Duration::ZERO;
        if !commands.is_empty() {
            let size = bytes.len();
            // A client that sends commands faster than the world executes them is disconnected.
            if out.unprocessed_bytes.fetch_add(size, Ordering::AcqRel) + size > MAX_UNPROCESSED_BYTES {
                return Err(packet::invalid_message(&format!(
                    "more than {MAX_UNPROCESSED_BYTES} bytes of commands are waiting for execution"
                )));
            }
            let _ = events.send(ConnectionEvent::Commands(number, head, commands, size));
            shared.session.wake();
            patience = ANSWER_TIMEOUT;
        }
        let (id, answers) = out.wait_for_answers(patience).unwrap_or((-1, Vec::new()));
        let mut answer = message::head(id, head.time, *lock(&shared.world));
        answers.iter().for_each(|a| answer.extend_from_slice(a));
        packet::write(&mut stream, &answer)?;
    }
}
