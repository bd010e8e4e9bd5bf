//! Sockets and the threads that serve their connections: one thread per listener, and two per connection, of which one
//! reads and one writes.
//!
//! The threads only transfer messages between the network and the queues of [`SocketState`]. Which message a script
//! receives is determined when the script calls a command.

use std::{
    collections::BTreeMap,
    io,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use tatu_services_common::zmtp::{self, FLAG_COMMAND, FLAG_MORE};

use crate::{
    endpoint::Endpoint,
    errors::Errno,
    kinds::Kind,
    queue::{Message, QueuedBytes},
    routing::{MAX_MESSAGE_BYTES, MAX_PARTS, SocketState},
    stream::{Listener, Stream},
};

/// Maximum number of connections and listeners of a world.
const MAX_LINKS: usize = 256;
/// Time within which a peer must complete the handshake.
const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(5);
/// Maximum time for which a closed socket continues to send queued messages, regardless of its option `LINGER`.
const MAX_LINGER: Duration = Duration::from_millis(500);
/// Interval at which threads check whether their socket has been closed.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);
/// Delay before the first attempt to reconnect. It doubles with each attempt, up to the option `RECONNECT_IVL`. It is
/// short because scripts of a scene often connect before their peer has bound its socket.
const FIRST_RECONNECT_DELAY: Duration = Duration::from_millis(2);
/// Maximum delay between attempts to reconnect, ms.
const MAX_RECONNECT_MS: u64 = 10_000;
/// Interval at which a listener checks for new connections.
const ACCEPT_INTERVAL: Duration = Duration::from_millis(5);

/// Counters that all sockets of a world share, and that limit their memory and their number of connections.
#[derive(Clone, Default)]
pub struct Limits {
    pub queued: QueuedBytes,
    links: Arc<AtomicUsize>,
}

/// Counts a connection or listener against `MAX_LINKS` while the value is alive.
struct Link(Arc<AtomicUsize>);

impl Link {
    fn new(limits: &Limits) -> Result<Link, Errno> {
        let link = Link(limits.links.clone());
        if limits.links.fetch_add(1, Ordering::AcqRel) >= MAX_LINKS { Err(Errno::TOO_MANY) } else { Ok(link) }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// The part of a socket that is shared with its threads.
struct Shared {
    state: Mutex<SocketState>,
    changed: Condvar,
    /// The open connections, which are closed with the socket.
    streams: Mutex<BTreeMap<u64, Stream>>,
    last_stream: AtomicUsize,
    threads: Mutex<Vec<JoinHandle<()>>>,
    limits: Limits,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An endpoint to which the socket is bound, and the thread that accepts its connections.
struct Bound {
    endpoint: Endpoint,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// A socket. Dropping it closes the socket, and waits for queued messages until the linger time is over.
pub struct Socket {
    shared: Arc<Shared>,
    bound: Vec<Bound>,
    /// The endpoints to which the socket connects, each with the number of its peer.
    connected: Vec<(Endpoint, u64)>,
}

impl Socket {
    pub fn new(kind: Kind, limits: &Limits) -> Socket {
        let shared = Shared {
            state: Mutex::new(SocketState::new(kind, &limits.queued)),
            changed: Condvar::new(),
            streams: Mutex::default(),
            last_stream: AtomicUsize::new(0),
            threads: Mutex::default(),
            limits: limits.clone(),
        };
        Socket { shared: Arc::new(shared), bound: Vec::new(), connected: Vec::new() }
    }

    /// Calls `f` with the state of the socket, and then wakes the threads of the socket.
    pub fn with<T>(&self, f: impl FnOnce(&mut SocketState) -> T) -> T {
        let done = f(&mut lock(&self.shared.state));
        self.shared.changed.notify_all();
        done
    }

    /// Calls `f` repeatedly until it returns a result other than `WOULD_BLOCK`, but at most for the time `most`.
    pub fn wait<T>(&self, most: Duration, mut f: impl FnMut(&mut SocketState) -> Result<T, Errno>) -> Result<T, Errno> {
        let end = Instant::now() + most;
        let mut state = lock(&self.shared.state);
        loop {
            let done = f(&mut state);
            let left = end.saturating_duration_since(Instant::now());
            if !matches!(done, Err(Errno::WOULD_BLOCK)) || left.is_zero() {
                drop(state);
                self.shared.changed.notify_all();
                return done;
            }
            state = self.shared.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Binds the socket to an endpoint, and starts to accept connections.
    pub fn bind(&mut self, at: &Endpoint) -> Result<(), Errno> {
        let link = Link::new(&self.shared.limits)?;
        let (listener, endpoint) = Listener::open(at)?;
        let stop = Arc::new(AtomicBool::new(false));
        let (shared, own) = (self.shared.clone(), stop.clone());
        let thread = thread::Builder::new().name("zmq listener".into()).spawn(move || {
            accept(&shared, &listener, &own);
            drop(link);
        })?;
        self.with(|state| state.last_endpoint = endpoint.to_string());
        self.bound.push(Bound { endpoint, stop, thread: Some(thread) });
        Ok(())
    }

    /// Stops listening on an endpoint. Existing connections remain open.
    pub fn unbind(&mut self, endpoint: &Endpoint) -> Result<(), Errno> {
        let at = self.bound.iter().position(|b| b.endpoint == *endpoint).ok_or(Errno::ABSENT)?;
        self.bound.remove(at);
        Ok(())
    }

    /// Starts to connect to an endpoint, which need not be available yet.
    pub fn connect(&mut self, to: &Endpoint) -> Result<(), Errno> {
        let link = Link::new(&self.shared.limits)?;
        let number = self.with(SocketState::add_peer);
        let (shared, endpoint) = (self.shared.clone(), to.clone());
        let run = move || {
            reconnect(&shared, number, &endpoint);
            drop(link);
        };
        match thread::Builder::new().name("zmq connection".into()).spawn(run) {
            Ok(thread) => lock(&self.shared.threads).push(thread),
            Err(e) => {
                self.with(|state| state.peers.remove(&number));
                return Err(e.into());
            }
        }
        self.connected.push((to.clone(), number));
        self.with(|state| state.last_endpoint = to.to_string());
        Ok(())
    }

    /// Ends the connection to an endpoint after all messages queued for it have been sent.
    pub fn disconnect(&mut self, endpoint: &Endpoint) -> Result<(), Errno> {
        let at = self.connected.iter().position(|(e, _)| e == endpoint).ok_or(Errno::ABSENT)?;
        let (_, number) = self.connected.remove(at);
        self.with(|state| {
            if let Some(peer) = state.peers.get_mut(&number) {
                peer.leaving = true;
            }
        });
        Ok(())
    }

    /// Closes the socket without waiting: stops listening, but continues to send queued messages for the time set by
    /// the option `LINGER`, at most `MAX_LINGER`.
    pub fn close(&mut self) {
        self.bound.clear();
        self.with(|state| {
            let linger = u64::try_from(state.options.linger).map_or(MAX_LINGER, Duration::from_millis);
            state.closed.get_or_insert(Instant::now() + linger.min(MAX_LINGER));
        });
    }

    /// Returns whether the socket has been closed and all its connections have ended.
    pub fn is_over(&self) -> bool {
        lock(&self.shared.threads).iter().all(JoinHandle::is_finished)
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        self.close();
        let end = lock(&self.shared.state).closed.unwrap_or_else(Instant::now);
        while !self.is_over() && Instant::now() < end {
            thread::sleep(Duration::from_millis(1));
        }
        // A thread that has just connected registers its stream before it checks that the socket is closed.
        while !self.is_over() {
            lock(&self.shared.streams).values().for_each(Stream::close);
            self.shared.changed.notify_all();
            thread::sleep(Duration::from_millis(1));
        }
        for thread in lock(&self.shared.threads).drain(..) {
            let _ = thread.join();
        }
    }
}

impl Drop for Bound {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Accepts the connections of a listener until `stop` is set, and serves each of them in a new thread.
fn accept(shared: &Arc<Shared>, listener: &Listener, stop: &AtomicBool) {
    loop {
        if stop.load(Ordering::Acquire) {
            return;
        }
        // The listener is non-blocking. A thread that blocks in `accept` could be ended only by a connection of this
        // process, which might reach another program if that program has replaced the file of the socket.
        let Ok(stream) = listener.accept() else {
            thread::sleep(ACCEPT_INTERVAL);
            continue;
        };
        let Ok(link) = Link::new(&shared.limits) else { continue };
        let own = shared.clone();
        let run = move || {
            // An error ends this connection only.
            let _ = converse(&own, None, stream);
            drop(link);
        };
        let mut threads = lock(&shared.threads);
        threads.retain(|t| !t.is_finished());
        if let Ok(thread) = thread::Builder::new().name("zmq connection".into()).spawn(run) {
            threads.push(thread);
        }
    }
}

/// Connects to an endpoint, and reconnects whenever the connection ends, until the socket is closed or disconnected.
fn reconnect(shared: &Shared, number: u64, endpoint: &Endpoint) {
    let mut delay = FIRST_RECONNECT_DELAY;
    loop {
        if let Ok(stream) = Stream::connect(endpoint) {
            delay = FIRST_RECONNECT_DELAY;
            let _ = converse(shared, Some(number), stream);
        }
        let mut state = lock(&shared.state);
        state.peer_is_lost(number);
        let pause = u64::try_from(state.options.reconnect_interval).unwrap_or(100).clamp(1, MAX_RECONNECT_MS);
        let end = Instant::now() + delay.min(Duration::from_millis(pause));
        delay = (delay * 2).min(Duration::from_millis(MAX_RECONNECT_MS));
        while !is_over(&state, number) && Instant::now() < end {
            let left = end.saturating_duration_since(Instant::now()).min(CHECK_INTERVAL);
            state = shared.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        if is_over(&state, number) {
            state.peers.remove(&number);
            return;
        }
    }
}

/// Returns whether the connection to a peer must end: the socket is closed or disconnected, and all messages have been
/// sent or the linger time is over.
fn is_over(state: &SocketState, number: u64) -> bool {
    let Some(peer) = state.peers.get(&number) else { return true };
    match state.closed {
        Some(end) => peer.outgoing.is_empty() || Instant::now() >= end,
        None => peer.leaving && peer.outgoing.is_empty(),
    }
}

/// Removes a connection from the list of open connections when the value is dropped.
struct OpenStream<'a>(&'a Shared, u64);

impl Drop for OpenStream<'_> {
    fn drop(&mut self) {
        lock(&self.0.streams).remove(&self.1);
    }
}

/// Exchanges messages with a peer until the connection ends. `number` is the number of the peer, or `None` for an
/// accepted connection, which becomes a peer after the handshake.
fn converse(shared: &Shared, number: Option<u64>, mut stream: Stream) -> io::Result<()> {
    let id = shared.last_stream.fetch_add(1, Ordering::AcqRel) as u64;
    lock(&shared.streams).insert(id, stream.try_clone()?);
    let _open = OpenStream(shared, id);
    let (kind, identity) = {
        let state = lock(&shared.state);
        (state.kind, state.options.identity.clone())
    };
    stream.set_timeout(Some(HANDSHAKE_TIMEOUT))?;
    let peer = zmtp::greet(&mut stream, kind.names().0, &identity)?;
    stream.set_timeout(None)?;
    if !kind.accepts(&peer.kind) {
        return Err(zmtp::invalid_message("the type of the peer's socket is incompatible with that of this socket"));
    }
    let accepted = number.is_none();
    let number = {
        let mut state = lock(&shared.state);
        let number = number.unwrap_or_else(|| state.add_peer());
        if !state.peer_is_ready(number, peer.identity) {
            if accepted {
                state.peers.remove(&number);
            }
            return Err(zmtp::invalid_message("another peer already has the identity of this peer"));
        }
        number
    };
    shared.changed.notify_all();
    let (broken, pongs) = (&AtomicBool::new(false), &Mutex::new(Vec::new()));
    let mut input = stream.try_clone()?;
    let done = thread::scope(|scope| {
        let read = move || {
            let _ = read_messages(shared, number, &mut input, broken, pongs);
            // The lock ensures that the writing thread cannot read the flag before it is set and then miss the
            // notification.
            let _state = lock(&shared.state);
            broken.store(true, Ordering::Release);
            shared.changed.notify_all();
        };
        let reader = thread::Builder::new().name("zmq reader".into()).spawn_scoped(scope, read);
        let done = reader.map(drop).and_then(|()| write_messages(shared, number, &mut stream, broken, pongs));
        broken.store(true, Ordering::Release);
        stream.close();
        shared.changed.notify_all();
        done
    });
    if accepted {
        remove_accepted(shared, number);
    }
    done
}

/// Removes a peer whose accepted connection has ended, after the script has received all its messages.
fn remove_accepted(shared: &Shared, number: u64) {
    let mut state = lock(&shared.state);
    state.peer_is_lost(number);
    if let Some(peer) = state.peers.get_mut(&number) {
        peer.leaving = true;
        peer.outgoing.clear();
    }
    while state.closed.is_none() && state.peers.get(&number).is_some_and(|p| !p.incoming.is_empty()) {
        state = shared.changed.wait_timeout(state, CHECK_INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
    }
    state.peers.remove(&number);
}

/// Writes queued messages until the connection ends.
fn write_messages(
    shared: &Shared,
    number: u64,
    stream: &mut Stream,
    broken: &AtomicBool,
    pongs: &Mutex<Vec<Vec<u8>>>,
) -> io::Result<()> {
    loop {
        let message = {
            let mut state = lock(&shared.state);
            loop {
                if broken.load(Ordering::Acquire) || is_over(&state, number) {
                    return Ok(());
                }
                if !lock(pongs).is_empty() {
                    break None;
                }
                if let Some(message) = state.peers.get_mut(&number).and_then(|p| p.outgoing.pop()) {
                    break Some(message);
                }
                state = shared.changed.wait_timeout(state, CHECK_INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
            }
        };
        shared.changed.notify_all();
        for pong in lock(pongs).drain(..) {
            zmtp::write_frame(stream, FLAG_COMMAND, &pong)?;
        }
        let Some(message) = message else { continue };
        let last = message.len().saturating_sub(1);
        let mut bytes = Vec::new();
        for (i, part) in message.iter().enumerate() {
            zmtp::push_header(&mut bytes, if i < last { FLAG_MORE } else { 0 }, part.len());
            if i == last || part.len() > zmtp::SMALL_MESSAGE_BYTES {
                zmtp::write_after(stream, std::mem::take(&mut bytes), part)?;
            } else {
                bytes.extend_from_slice(part);
            }
        }
    }
}

/// Reads messages into the queue until the connection ends. While the queue is full, nothing is read, so that the peer
/// must stop sending.
fn read_messages(
    shared: &Shared,
    number: u64,
    stream: &mut Stream,
    broken: &AtomicBool,
    pongs: &Mutex<Vec<Vec<u8>>>,
) -> io::Result<()> {
    loop {
        let most = {
            let mut state = lock(&shared.state);
            while !state.has_room(number) {
                if broken.load(Ordering::Acquire) || state.closed.is_some() {
                    return Ok(());
                }
                state = shared.changed.wait_timeout(state, CHECK_INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
            }
            usize::try_from(state.options.max_message).unwrap_or(MAX_MESSAGE_BYTES).min(MAX_MESSAGE_BYTES)
        };
        let Some(message) = read_message(stream, most, |pong| {
            // The number of pending answers is limited, so that a peer cannot exhaust the memory with PING commands.
            let mut pongs = lock(pongs);
            if pongs.len() < MAX_PARTS {
                pongs.push(pong);
            }
        })?
        else {
            shared.changed.notify_all();
            continue;
        };
        lock(&shared.state).deposit(number, message);
        shared.changed.notify_all();
    }
}

/// Reads the parts of the next message, at most `most` bytes in total. Returns `None` if it was a command.
fn read_message(stream: &mut Stream, most: usize, mut answer: impl FnMut(Vec<u8>)) -> io::Result<Option<Message>> {
    let (mut message, mut size) = (Message::new(), 0);
    loop {
        let (flags, body) = zmtp::read_frame(stream, (most - size) as u64)?;
        if flags & FLAG_COMMAND != 0 {
            zmtp::pong(&body)?.into_iter().for_each(&mut answer);
            if message.is_empty() {
                return Ok(None);
            }
            continue;
        }
        size += body.len();
        message.push(body);
        if flags & FLAG_MORE == 0 {
            return Ok(Some(message));
        }
        if message.len() >= MAX_PARTS {
            return Err(zmtp::invalid_message(&format!("a message has more than {MAX_PARTS} parts")));
        }
    }
}

#[cfg(test)]
mod tests;
