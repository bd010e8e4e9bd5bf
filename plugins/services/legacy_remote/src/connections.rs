//! Sockets: each connection has a thread that answers every message at once, with what the world did since, or with nothing
//! but a head. What comes in waits for the barrier.

use std::{
    collections::BTreeMap,
    io,
    net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use tatu_plugin_api::safe::Session;

use crate::{
    message::{self, Command, Head, World},
    packet,
};

/// Connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// How long a message with commands waits for what the world does, before it is answered without.
const PATIENCE: Duration = Duration::from_millis(20);
/// A client that takes nothing for so long has gone. One that says nothing keeps its connection.
const WRITING: Duration = Duration::from_secs(5);

/// What connections tell.
pub enum Event {
    /// A client has come.
    Come(u64, Arc<Outbox>),
    /// It sent commands.
    Commands(u64, Head, Vec<Command>),
    /// It has gone; with why, if it did something wrong.
    Gone(u64, Option<String>),
}

/// What a client is to be told.
#[derive(Default)]
pub struct Outbox {
    state: Mutex<Waiting>,
    filled: Condvar,
}

/// What an answer is of: the command's code, and what the command is of.
pub type Key = (u32, Vec<u8>);

#[derive(Default)]
struct Waiting {
    /// Answers by command and what it is of: of a stream only the newest.
    answers: BTreeMap<Key, Vec<u8>>,
    /// The message that they answer.
    id: i32,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Outbox {
    /// Adds answers to what waits.
    pub fn put(&self, id: i32, answers: Vec<(Key, Vec<u8>)>) {
        let mut state = lock(&self.state);
        state.id = id;
        state.answers.extend(answers);
        self.filled.notify_all();
    }
    /// Whether all that was put was sent.
    pub fn is_empty(&self) -> bool {
        lock(&self.state).answers.is_empty()
    }
    /// What waits; after a time nothing.
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

/// What all ports of a service have in common.
#[derive(Clone)]
pub struct Ports {
    session: Session,
    events: Sender<Event>,
    world: Arc<Mutex<World>>,
    numbers: Arc<AtomicU64>,
}

impl Ports {
    /// Ports of which nobody listens to any yet, and what their connections tell.
    pub fn new(session: Session) -> (Ports, Receiver<Event>) {
        let (events, told) = channel();
        (Ports { session, events, world: Arc::default(), numbers: Arc::default() }, told)
    }
    /// How the world stands now.
    pub fn tell(&self, world: World) {
        *lock(&self.world) = world;
    }
}

struct Shared {
    ports: Mutex<Ports>,
    open: Mutex<BTreeMap<u64, TcpStream>>,
    end: AtomicBool,
}

/// A port that is listened to; dropping it ends its threads.
pub struct Listener {
    /// Where it listens.
    pub address: SocketAddr,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens on 127.0.0.1.
    pub fn open(port: u16, ports: &Ports) -> io::Result<Listener> {
        let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = socket.local_addr()?;
        let ports = Mutex::new(ports.clone());
        let shared = Arc::new(Shared { ports, open: Mutex::default(), end: AtomicBool::new(false) });
        let own = shared.clone();
        let thread = thread::Builder::new().name("legacy remote".into()).spawn(move || accept(&socket, &own))?;
        Ok(Listener { address, shared, thread: Some(thread) })
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.shared.end.store(true, Ordering::Release);
        // Nothing more is read; answers that are on their way are written.
        for stream in lock(&self.shared.open).values() {
            let _ = stream.shutdown(Shutdown::Read);
        }
        // The thread sits in `accept`: a connection of our own gets it out.
        let _ = TcpStream::connect_timeout(&self.address, WRITING);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn accept(socket: &TcpListener, shared: &Arc<Shared>) {
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    let ports = lock(&shared.ports).clone();
    loop {
        let accepted = socket.accept();
        if shared.end.load(Ordering::Acquire) {
            break;
        }
        threads.retain(|t| !t.is_finished());
        let Ok((stream, _)) = accepted else {
            // Out of file handles, for instance: others may be given back.
            thread::sleep(PATIENCE);
            continue;
        };
        // One too many is closed.
        if threads.len() >= MOST_CONNECTIONS {
            continue;
        }
        let number = ports.numbers.fetch_add(1, Ordering::Relaxed) + 1;
        let (own, ports) = (shared.clone(), ports.clone());
        let serve = move || {
            let done = serve(stream, number, &own, &ports);
            lock(&own.open).remove(&number);
            let why = done.err().filter(|e| e.kind() == io::ErrorKind::InvalidData).map(|e| e.to_string());
            let _ = ports.events.send(Event::Gone(number, why));
            ports.session.wake();
        };
        threads.extend(thread::Builder::new().name("legacy client".into()).spawn(serve));
    }
    for stream in lock(&shared.open).values() {
        let _ = stream.shutdown(Shutdown::Read);
    }
    for thread in threads {
        let _ = thread.join();
    }
}

fn serve(mut stream: TcpStream, number: u64, shared: &Shared, ports: &Ports) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITING))?;
    lock(&shared.open).insert(number, stream.try_clone()?);
    let out = Arc::new(Outbox::default());
    let mut told = false;
    while !shared.end.load(Ordering::Acquire) {
        let (head, commands) = message::read(&packet::read(&mut stream)?)?;
        // Who has said nothing that can be read is no client.
        if !std::mem::replace(&mut told, true) {
            let _ = ports.events.send(Event::Come(number, out.clone()));
        }
        let mut patience = Duration::ZERO;
        if !commands.is_empty() {
            let _ = ports.events.send(Event::Commands(number, head, commands));
            ports.session.wake();
            patience = PATIENCE;
        }
        let waits = out.take(patience);
        let world = *lock(&ports.world);
        let (id, answers) = waits.unwrap_or((-1, Vec::new()));
        let mut answer = message::head(id, head.time, world);
        answers.iter().for_each(|a| answer.extend_from_slice(a));
        packet::write(&mut stream, &answer)?;
    }
    Ok(())
}
