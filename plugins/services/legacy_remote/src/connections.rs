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
    message::{self, Command, Head, World},
    packet,
};

/// Maximum number of simultaneous connections.
const MOST_CONNECTIONS: usize = 64;
/// Maximum total size of the messages of a client that have not been processed, bytes.
const MOST_UNHEARD: usize = 128 << 20;
/// Time for which a connection waits for results before it answers a message with commands.
const PATIENCE: Duration = Duration::from_millis(20);
/// Time for which sending to a client may block before the client is disconnected. Clients that send nothing remain
/// connected.
const WRITING: Duration = Duration::from_secs(5);

/// Events reported by connections.
pub enum Event {
    /// The client with this number has connected.
    Come(u64, Arc<Outbox>),
    /// A client has sent commands. The last field is the size of the message, bytes.
    Commands(u64, Head, Vec<Command>, usize),
    /// A client has disconnected. The last field is the reason if its messages were invalid.
    Gone(u64, Option<String>),
}

/// The queue of answers to a client.
#[derive(Default)]
pub struct Outbox {
    state: Mutex<Waiting>,
    /// Notified when answers are queued.
    filled: Condvar,
    /// Total size of the client's messages that have not been processed, bytes.
    unheard: AtomicUsize,
}

/// Identifies an answer: the code and the subject of the command.
pub type Key = (u32, Vec<u8>);

#[derive(Default)]
struct Waiting {
    /// The answers, by code and subject of the command. A newer answer to the same command replaces an older one.
    answers: BTreeMap<Key, Vec<u8>>,
    /// The id of the newest message that was executed.
    id: i32,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Outbox {
    /// Queues answers; `id` is that of the newest message that was executed.
    pub fn put(&self, id: i32, answers: Vec<(Key, Vec<u8>)>) {
        let mut state = lock(&self.state);
        state.id = id;
        state.answers.extend(answers);
        self.filled.notify_all();
    }
    /// Records that a message of `size` bytes has been processed.
    pub fn heard(&self, size: usize) {
        self.unheard.fetch_sub(size, Ordering::AcqRel);
    }
    /// Returns whether all queued answers have been sent.
    pub fn is_empty(&self) -> bool {
        lock(&self.state).answers.is_empty()
    }
    /// Waits at most `patience` for answers. Removes and returns all of them, with the id of the newest message that
    /// was executed, or returns `None` if there are none.
    fn take(&self, patience: Duration) -> Option<(i32, Vec<Vec<u8>>)> {
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
pub struct Ports(Arc<Shared>);

struct Shared {
    session: Session,
    events: Mutex<Sender<Event>>,
    world: Mutex<World>,
    numbers: AtomicU64,
}

impl Ports {
    /// Creates the shared data without opening a port. Also returns the receiver of events.
    pub fn new(session: Session) -> (Ports, Receiver<Event>) {
        let (events, told) = channel();
        let (events, world, numbers) = (Mutex::new(events), Mutex::default(), AtomicU64::new(1));
        (Ports(Arc::new(Shared { session, events, world, numbers })), told)
    }
    /// Sets the state of the world that the heads of answers report.
    pub fn tell(&self, world: World) {
        *lock(&self.0.world) = world;
    }
    /// Opens a port on 127.0.0.1.
    pub fn open(&self, port: u16) -> io::Result<Port> {
        let shared = self.0.clone();
        let serve = move |stream: TcpStream, _| {
            let number = shared.numbers.fetch_add(1, Ordering::Relaxed);
            let events = lock(&shared.events).clone();
            let done = serve(stream, number, &shared, &events);
            let why = done.err().filter(|e| e.kind() == io::ErrorKind::InvalidData).map(|e| e.to_string());
            let _ = events.send(Event::Gone(number, why));
            shared.session.wake();
        };
        Port::open(port, "legacy remote", MOST_CONNECTIONS, serve)
    }
}

/// Reads and answers messages until the connection is closed or a message is invalid.
fn serve(mut stream: TcpStream, number: u64, shared: &Shared, events: &Sender<Event>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITING))?;
    let out = Arc::new(Outbox::default());
    let mut told = false;
    loop {
        let bytes = packet::read(&mut stream)?;
        let (head, commands) = message::read(&bytes)?;
        // A connection is reported as a client after its first valid message.
        if !std::mem::replace(&mut told, true) {
            let _ = events.send(Event::Come(number, out.clone()));
        }
        let mut patience = Duration::ZERO;
        if !commands.is_empty() {
            let size = bytes.len();
            // A client that sends commands faster than the world executes them is disconnected.
            if out.unheard.fetch_add(size, Ordering::AcqRel) + size > MOST_UNHEARD {
                return Err(packet::wrong(&format!(
                    "more than {MOST_UNHEARD} bytes of commands are waiting for execution"
                )));
            }
            let _ = events.send(Event::Commands(number, head, commands, size));
            shared.session.wake();
            patience = PATIENCE;
        }
        let (id, answers) = out.take(patience).unwrap_or((-1, Vec::new()));
        let mut answer = message::head(id, head.time, *lock(&shared.world));
        answers.iter().for_each(|a| answer.extend_from_slice(a));
        packet::write(&mut stream, &answer)?;
    }
}
