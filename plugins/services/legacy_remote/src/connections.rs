//! Connections. The thread of each connection answers every message at once, with the results since the last message,
//! or with only a head. Commands wait for the barrier.

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
/// Maximum size of a client's commands that wait for the barrier, bytes.
const MOST_UNHEARD: usize = 128 << 20;
/// How long a message with commands waits for results before it is answered without them.
const PATIENCE: Duration = Duration::from_millis(20);
/// A client that accepts no data for this time is considered gone. A silent client keeps its connection.
const WRITING: Duration = Duration::from_secs(5);

/// Events reported by connections.
pub enum Event {
    /// A client has connected.
    Come(u64, Arc<Outbox>),
    /// A client has sent commands, in a message of this many bytes.
    Commands(u64, Head, Vec<Command>, usize),
    /// A client has disconnected, with the error that caused this, if any.
    Gone(u64, Option<String>),
}

/// Outgoing answers to a client.
#[derive(Default)]
pub struct Outbox {
    state: Mutex<Waiting>,
    filled: Condvar,
    /// Bytes that the client sent and that have not been processed yet.
    unheard: AtomicUsize,
}

/// Identifies an answer: the command's code, and its subject.
pub type Key = (u32, Vec<u8>);

#[derive(Default)]
struct Waiting {
    /// Answers by command and subject; only the newest answer of a stream is kept.
    answers: BTreeMap<Key, Vec<u8>>,
    /// The id of the message that the answers are for.
    id: i32,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Outbox {
    /// Queues answers.
    pub fn put(&self, id: i32, answers: Vec<(Key, Vec<u8>)>) {
        let mut state = lock(&self.state);
        state.id = id;
        state.answers.extend(answers);
        self.filled.notify_all();
    }
    /// Records that this many received bytes were processed.
    pub fn heard(&self, size: usize) {
        self.unheard.fetch_sub(size, Ordering::AcqRel);
    }
    /// Returns whether all queued answers have been sent.
    pub fn is_empty(&self) -> bool {
        lock(&self.state).answers.is_empty()
    }
    /// Removes and returns the queued answers, or returns `None` if there are none within `patience`.
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
    /// Creates the shared data, without an open port; also returns the receiver of events.
    pub fn new(session: Session) -> (Ports, Receiver<Event>) {
        let (events, told) = channel();
        let (events, world, numbers) = (Mutex::new(events), Mutex::default(), AtomicU64::new(1));
        (Ports(Arc::new(Shared { session, events, world, numbers })), told)
    }
    /// Sets the state of the world for heads of answers.
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

fn serve(mut stream: TcpStream, number: u64, shared: &Shared, events: &Sender<Event>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITING))?;
    let out = Arc::new(Outbox::default());
    let mut told = false;
    loop {
        let bytes = packet::read(&mut stream)?;
        let (head, commands) = message::read(&bytes)?;
        // A connection counts as a client once it has sent a valid packet.
        if !std::mem::replace(&mut told, true) {
            let _ = events.send(Event::Come(number, out.clone()));
        }
        let mut patience = Duration::ZERO;
        if !commands.is_empty() {
            let size = bytes.len();
            // A client that sends faster than the world processes loses its connection.
            if out.unheard.fetch_add(size, Ordering::AcqRel) + size > MOST_UNHEARD {
                return Err(packet::wrong(&format!("more than {MOST_UNHEARD} bytes of commands wait")));
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
