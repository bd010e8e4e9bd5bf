//! Reply and publish sockets for ZeroMQ clients, built on the frames of `tatu_services_common::zmtp`.
//!
//! Each connection has a thread, which reads a request, passes it on, waits for the answer and writes it. The
//! connection is closed if a frame is too large.

use std::{
    collections::BTreeMap,
    io::{self, Read, Write},
    net::{SocketAddr, TcpStream},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
        mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    },
    thread,
    time::Duration,
};

use tatu_services_common::{
    port::Port,
    zmtp::{
        FLAG_COMMAND, FLAG_MORE, MAX_MESSAGE_BYTES, SMALL_MESSAGE_BYTES, greet, invalid_message, pong, push_header,
        read_frame, write_after, write_frame,
    },
};

/// Maximum total size of all unanswered requests that are larger than `SMALL_MESSAGE_BYTES`, bytes. Smaller requests
/// are not counted.
const MAX_UNANSWERED_BYTES: usize = 512 << 20;
/// Maximum number of simultaneous connections.
const MAX_CONNECTIONS: usize = 256;
/// Time within which a peer must send its greeting, and for which sending to a peer may block.
const GREETING_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval at which a thread that waits for an answer checks whether its peer is still connected.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Events that the threads of connections report to the service.
pub enum ConnectionEvent {
    /// A peer has sent a request. The answer must be sent to `answer`.
    Request {
        /// The number of the connection.
        connection: u64,
        /// The content of the request.
        body: Vec<u8>,
        /// Channel to the thread that sends the answer to the peer.
        answer: Sender<Vec<u8>>,
    },
    /// The connection with this number has ended.
    Disconnected(u64),
    /// A connection was closed because of an invalid message. The text is for the log.
    Refused(String),
}

/// The type of a socket.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum SocketKind {
    /// A reply socket, which answers requests.
    Reply,
    /// A publish socket, which sends messages to all subscribers.
    Publish,
}

/// Data shared by all connections of a listener.
struct SocketState {
    events: Mutex<Sender<ConnectionEvent>>,
    wake: Box<dyn Fn() + Send + Sync>,
    /// Total size of all unanswered requests that are larger than `SMALL_MESSAGE_BYTES`, bytes.
    unanswered_bytes: AtomicUsize,
    /// The peers that receive published messages, by the number of the connection.
    subscribers: Mutex<BTreeMap<u64, TcpStream>>,
}

/// An open port. Dropping it closes the port and all connections.
pub struct ZmtpListener {
    port: Port,
    shared: Arc<SocketState>,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ZmtpListener {
    /// Opens a port on 127.0.0.1; if `port` is 0, any free port. Events are sent to the returned receiver, and `wake`
    /// is called after events have been sent.
    pub fn open(
        kind: SocketKind,
        port: u16,
        wake: Box<dyn Fn() + Send + Sync>,
    ) -> io::Result<(ZmtpListener, Receiver<ConnectionEvent>)> {
        let (events, told) = channel();
        let (waiting, audience) = (AtomicUsize::new(0), Mutex::default());
        let shared = Arc::new(SocketState {
            events: Mutex::new(events),
            wake,
            unanswered_bytes: waiting,
            subscribers: audience,
        });
        let own = shared.clone();
        let serve = move |stream: TcpStream, number: u64| {
            let shared = &own;
            let events = lock(&shared.events).clone();
            // An error ends only the connection of this peer.
            let done = serve(stream, kind, number, shared, &events);
            lock(&shared.subscribers).remove(&number);
            if let Some(e) = done.err().filter(|e| e.kind() == io::ErrorKind::InvalidData) {
                let _ = events.send(ConnectionEvent::Refused(format!("connection {number} was closed: {e}")));
            }
            let _ = events.send(ConnectionEvent::Disconnected(number));
            (shared.wake)();
        };
        Ok((ZmtpListener { port: Port::open(port, "zmtp", MAX_CONNECTIONS, serve)?, shared }, told))
    }

    /// Returns the address on which the listener accepts connections.
    pub fn address(&self) -> SocketAddr {
        self.port.address
    }

    /// Sends a message of at most 255 bytes to all subscribers. Subscribers that cannot receive it immediately miss it.
    pub fn publish(&self, body: &[u8]) {
        let mut frame = vec![0, body.len() as u8];
        frame.extend_from_slice(body);
        for mut stream in lock(&self.shared.subscribers).values() {
            // The thread of a subscriber only discards data after the greeting, so the socket may remain non-blocking.
            let _ = stream.set_nonblocking(true).and_then(|()| stream.write(&frame).map(drop));
        }
    }
}

/// Exchanges greetings, then answers requests or registers a subscriber until the peer disconnects.
fn serve(
    mut stream: TcpStream,
    kind: SocketKind,
    number: u64,
    shared: &SocketState,
    events: &Sender<ConnectionEvent>,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(GREETING_TIMEOUT))?;
    stream.set_write_timeout(Some(GREETING_TIMEOUT))?;
    greet(&mut stream, if kind == SocketKind::Reply { "ROUTER" } else { "PUB" }, b"")?;
    stream.set_read_timeout(None)?;
    if kind == SocketKind::Publish {
        lock(&shared.subscribers).insert(number, stream.try_clone()?);
        return discard_input(&mut stream);
    }
    loop {
        let body = read_request(&mut stream)?;
        let size = body.len();
        if size > SMALL_MESSAGE_BYTES
            && shared.unanswered_bytes.fetch_add(size, Ordering::AcqRel) + size > MAX_UNANSWERED_BYTES
        {
            shared.unanswered_bytes.fetch_sub(size, Ordering::AcqRel);
            return Err(invalid_message("the unanswered requests of all connections exceed 512 MiB"));
        }
        let (answer, answered) = channel();
        let sent = events.send(ConnectionEvent::Request { connection: number, body, answer });
        (shared.wake)();
        let body = if sent.is_ok() { wait_for_answer(&stream, &answered) } else { None };
        if size > SMALL_MESSAGE_BYTES {
            shared.unanswered_bytes.fetch_sub(size, Ordering::AcqRel);
        }
        let Some(body) = body else { return Ok(()) };
        let mut headers = Vec::new();
        push_header(&mut headers, FLAG_MORE, 0);
        push_header(&mut headers, 0, body.len());
        write_after(&mut stream, headers, &body)?;
    }
}

/// Waits for the answer to a request. Returns `None` if the peer has disconnected or the request will not be answered.
fn wait_for_answer(stream: &TcpStream, answered: &Receiver<Vec<u8>>) -> Option<Vec<u8>> {
    loop {
        match answered.recv_timeout(POLL_INTERVAL) {
            Ok(body) => return Some(body),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) => {
                let _ = stream.set_nonblocking(true);
                let here = stream.peek(&mut [0]);
                let _ = stream.set_nonblocking(false);
                match here {
                    Ok(0) => return None,
                    Err(e) if e.kind() != io::ErrorKind::WouldBlock => return None,
                    _ => {}
                }
            }
        }
    }
}

/// Reads the next request, which consists of an empty frame and a body, and answers PING commands before it.
fn read_request(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let mut delimited = false;
    loop {
        let (flags, body) = read_frame(stream, MAX_MESSAGE_BYTES)?;
        if flags & FLAG_COMMAND != 0 {
            if let Some(pong) = pong(&body)? {
                write_frame(stream, FLAG_COMMAND, &pong)?;
            }
            continue;
        }
        match (delimited, flags & FLAG_MORE != 0) {
            (false, true) if body.is_empty() => delimited = true,
            (true, false) => return Ok(body),
            _ => return Err(invalid_message("a request must consist of an empty frame and a single body frame")),
        }
    }
}

/// Reads and discards data until a subscriber disconnects.
fn discard_input(stream: &mut TcpStream) -> io::Result<()> {
    let mut bytes = [0; 256];
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(_) => {}
            // The socket is non-blocking after the first published message.
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => thread::sleep(POLL_INTERVAL),
            Err(e) => return Err(e),
        }
    }
}
