//! Implements the part of ZMTP 3 without security (<https://rfc.zeromq.org/spec/23>) that reply and publish sockets
//! require.
//!
//! Each connection has a thread, which reads a request, passes it on, waits for the answer and writes it. Declared
//! sizes are not trusted: the connection is closed if a frame is too large, and memory is allocated only as bytes
//! arrive.

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

use tatu_services_common::port::Port;

/// Maximum size of a message, bytes.
pub const MAX_MESSAGE_BYTES: u64 = 64 << 20;
/// Maximum total size of all unanswered requests that are larger than `SMALL_MESSAGE_BYTES`, bytes.
const MAX_UNANSWERED_BYTES: usize = 512 << 20;
/// Maximum size of a message that is copied when it is sent, and of a request that does not count towards
/// `MAX_UNANSWERED_BYTES`, bytes.
const SMALL_MESSAGE_BYTES: usize = 64 << 10;
/// Maximum number of simultaneous connections.
const MAX_CONNECTIONS: usize = 256;
/// Time within which a peer must send its greeting, and for which sending to a peer may block.
const GREETING_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval at which a thread that waits for an answer checks whether its peer is still connected.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Flag of a frame: further frames of the message follow.
const FLAG_MORE: u8 = 1;
/// Flag of a frame: the size has eight bytes instead of one.
const FLAG_LONG: u8 = 2;
/// Flag of a frame: it is a command of the protocol.
const FLAG_COMMAND: u8 = 4;

/// Events reported by connections.
pub enum ConnectionEvent {
    /// A peer has sent a request. The answer must be sent to `answer`.
    Request {
        /// The number of the connection.
        connection: u64,
        /// The request.
        body: Vec<u8>,
        /// Receives the answer.
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

fn invalid_message(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why.to_owned())
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
    greet(&mut stream, kind)?;
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
        let mut bytes = vec![FLAG_MORE, 0];
        match u8::try_from(body.len()) {
            Ok(len) => bytes.extend_from_slice(&[0, len]),
            Err(_) => {
                bytes.push(FLAG_LONG);
                bytes.extend_from_slice(&(body.len() as u64).to_be_bytes());
            }
        }
        // A small answer is written together with its header. A large one, such as an image, is not copied.
        if body.len() <= SMALL_MESSAGE_BYTES {
            bytes.extend_from_slice(&body);
            stream.write_all(&bytes)?;
        } else {
            stream.write_all(&bytes)?;
            stream.write_all(&body)?;
        }
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

/// Exchanges greetings and READY commands.
fn greet(stream: &mut TcpStream, kind: SocketKind) -> io::Result<()> {
    let mut ours = [0_u8; 64];
    ours[0] = 0xFF;
    ours[8] = 1;
    ours[9] = 0x7F;
    ours[10] = 3;
    ours[12..16].copy_from_slice(b"NULL");
    stream.write_all(&ours)?;
    let mut theirs = [0_u8; 64];
    stream.read_exact(&mut theirs)?;
    if theirs[0] != 0xFF || theirs[9] & 1 == 0 || theirs[10] < 3 || theirs[12..32] != ours[12..32] {
        return Err(invalid_message("expected a greeting of ZMTP 3 without security"));
    }
    let kind: &[u8] = if kind == SocketKind::Reply { b"ROUTER" } else { b"PUB" };
    let mut ready = b"\x05READY\x0bSocket-Type\0\0\0".to_vec();
    ready.push(kind.len() as u8);
    ready.extend_from_slice(kind);
    stream.write_all(&[&[FLAG_COMMAND, ready.len() as u8][..], &ready].concat())?;
    let (flags, body) = read_frame(stream, u64::from(u16::MAX))?;
    if flags & FLAG_COMMAND == 0 || !body.starts_with(b"\x05READY") {
        return Err(invalid_message("expected the READY command as the first frame"));
    }
    Ok(())
}

/// Reads a frame of at most `most` bytes.
fn read_frame(stream: &mut impl Read, most: u64) -> io::Result<(u8, Vec<u8>)> {
    let mut head = [0_u8; 1];
    stream.read_exact(&mut head)?;
    let flags = head[0];
    if flags & !(FLAG_MORE | FLAG_LONG | FLAG_COMMAND) != 0 {
        return Err(invalid_message("a frame has unknown flags"));
    }
    let len = if flags & FLAG_LONG != 0 {
        let mut len = [0_u8; 8];
        stream.read_exact(&mut len)?;
        u64::from_be_bytes(len)
    } else {
        stream.read_exact(&mut head)?;
        u64::from(head[0])
    };
    if len > most {
        return Err(invalid_message(&format!("a frame claims to have {len} bytes: expected at most {most}")));
    }
    let mut body = Vec::new();
    if stream.take(len).read_to_end(&mut body)? as u64 != len {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok((flags, body))
}

/// Reads the next request, which consists of an empty frame and a body, and answers PING commands before it.
fn read_request(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let mut delimited = false;
    loop {
        let (flags, body) = read_frame(stream, MAX_MESSAGE_BYTES)?;
        if flags & FLAG_COMMAND != 0 {
            if body.starts_with(b"\x04PING") && body.len() >= 7 {
                let pong = [b"\x04PONG", &body[7..]].concat();
                let len = u8::try_from(pong.len()).map_err(|_| invalid_message("a PING is too long"))?;
                stream.write_all(&[&[FLAG_COMMAND, len][..], &pong].concat())?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claimed_frame_size_is_not_trusted() {
        let claim = [&[FLAG_LONG][..], &(MAX_MESSAGE_BYTES + 1).to_be_bytes()].concat();
        assert!(read_frame(&mut claim.as_slice(), MAX_MESSAGE_BYTES).unwrap_err().to_string().contains("claims"));
        let claim = [&[FLAG_LONG][..], &MAX_MESSAGE_BYTES.to_be_bytes(), b"short"].concat();
        assert_eq!(
            read_frame(&mut claim.as_slice(), MAX_MESSAGE_BYTES).unwrap_err().kind(),
            io::ErrorKind::UnexpectedEof
        );
        assert_eq!(read_frame(&mut &b"\x00\x02ab"[..], MAX_MESSAGE_BYTES).unwrap(), (0, b"ab".to_vec()));
        assert!(read_frame(&mut &b"\xF0\x02ab"[..], MAX_MESSAGE_BYTES).is_err());
    }
}
