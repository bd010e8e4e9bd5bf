//! Connections of clients. Each has a reading and a writing thread, which never access a world: received lines are
//! queued until the barrier.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{Shutdown, TcpStream},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc::{Receiver, Sender, SyncSender, channel, sync_channel},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use serde_json::Value as Json;
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Session},
};
use tatu_services_common::port::Port;

use crate::message::Message;

/// Maximum number of simultaneous clients; further ones are disconnected.
const MOST_CLIENTS: usize = 256;
/// Maximum length of a line, bytes.
pub const LINE_LIMIT: usize = 16 << 20;
/// Maximum number of lines per client that are queued for the barrier. While the queue is full, the client's reader
/// blocks, so that eventually the client blocks, too.
const QUEUE: usize = 256;
/// Maximum total size of the lines queued for a client, bytes. If more accumulate, the client is disconnected.
const UNREAD_LIMIT: usize = 64 << 20;
/// Time for which sending to a client may block before the client is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);

/// The port, and the clients that have connected to it recently.
pub struct Listener {
    arrivals: Arc<Mutex<Arrivals>>,
    /// The open port; `None` only while the listener is being dropped.
    port: Option<Port>,
}

/// Clients that have connected since the last call of `take_new`, in order of connection.
#[derive(Default)]
struct Arrivals {
    clients: Vec<Client>,
    /// Whether the listener is being dropped, so that new clients are rejected.
    closed: bool,
}

/// A connected client. Its reader is a thread of the port.
pub struct Client {
    /// Number of the client in order of connection, from 1.
    pub number: u64,
    /// The received lines that have not been processed.
    lines: Receiver<Message>,
    link: Arc<Link>,
    /// Queues lines for the writer.
    replies: Sender<Vec<u8>>,
    writer: JoinHandle<()>,
}

/// State of a client that is shared with its threads.
#[derive(Default)]
struct Link {
    /// Whether the reader has ended, so that no further lines will be queued.
    ended: AtomicBool,
    /// Whether lines can no longer be sent to the client, because sending has failed or too many lines are queued.
    broken: AtomicBool,
    /// Total size of the lines that are queued for the client, bytes.
    unread: AtomicUsize,
}

impl Listener {
    /// Opens a port on 127.0.0.1; if `port` is 0, any free port. Unless `token` is empty, each client must send it in
    /// its first line.
    pub fn open(port: u16, token: String, session: Session) -> Result<Self> {
        let arrivals = Arc::<Mutex<Arrivals>>::default();
        let inside = arrivals.clone();
        let of_clients = session.clone();
        let serve = move |stream: TcpStream, number: u64| match Client::new(number, &stream, of_clients.clone()) {
            Ok((client, queue)) => {
                let link = client.link.clone();
                let mut arrivals = inside.lock().unwrap_or_else(PoisonError::into_inner);
                if !arrivals.closed {
                    arrivals.clients.push(client);
                    drop(arrivals);
                    of_clients.wake();
                    read(stream, &queue, &link, &of_clients, &token);
                }
            }
            Err(e) => of_clients.log(TATU_LOG_WARNING, &format!("jsonl: client {number}: {e}")),
        };
        let port = Port::open(port, "jsonl", MOST_CLIENTS, serve).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("jsonl: listening on {}", port.address));
        Ok(Listener { arrivals, port: Some(port) })
    }
    /// Returns the clients that have connected since the last call.
    pub fn take_new(&self) -> Vec<Client> {
        std::mem::take(&mut self.arrivals.lock().unwrap_or_else(PoisonError::into_inner).clients)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.arrivals.lock().unwrap_or_else(PoisonError::into_inner).closed = true;
        // The port waits for the readers, but a reader with a full queue blocks until its client is closed.
        self.take_new().into_iter().for_each(Client::close);
        self.port.take();
    }
}

impl Client {
    /// Starts the writer of a new client. Also returns the sender of its queue of received lines, for the reader.
    fn new(number: u64, stream: &TcpStream, session: Session) -> std::io::Result<(Self, SyncSender<Message>)> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        let (queue, lines) = sync_channel(QUEUE);
        let (replies, waiting) = channel();
        let link = Arc::<Link>::default();
        let (writing, inside) = (stream.try_clone()?, link.clone());
        let writer = thread::Builder::new().name(format!("jsonl writer {number}"));
        let writer = writer.spawn(move || write(writing, &waiting, &inside, session))?;
        Ok((Client { number, lines, link, replies, writer }, queue))
    }
    /// Removes and returns the next received line, or returns `None` if there is none.
    pub fn next_line(&self) -> Option<Message> {
        self.lines.try_recv().ok()
    }
    /// Returns whether the client has sent its last line or has disconnected, so that it can no longer hold the world.
    pub fn ended(&self) -> bool {
        self.link.ended.load(Ordering::Acquire) || self.broken()
    }
    /// Returns whether lines can no longer be sent to the client, because sending has failed or too many are queued.
    pub fn broken(&self) -> bool {
        self.link.broken.load(Ordering::Acquire)
    }
    /// Queues a line for the client. If too many bytes are already queued, discards the line and marks the client as
    /// broken.
    pub fn send(&self, line: &Json) {
        let mut bytes = line.to_string().into_bytes();
        bytes.push(b'\n');
        let unread = self.link.unread.fetch_add(bytes.len(), Ordering::AcqRel);
        if unread > UNREAD_LIMIT || self.replies.send(bytes).is_err() {
            self.link.broken.store(true, Ordering::Release);
        }
    }
    /// Lets the writer send the queued lines and then close the connection. Returns the thread of the writer.
    pub fn leave(self) -> JoinHandle<()> {
        self.writer
    }
    /// Closes the connection after waiting until the queued lines have been sent.
    pub fn close(self) {
        let _ = self.leave().join();
    }
}

/// Sends queued lines until the client is closed or sending fails. Then closes both directions of the connection, which
/// also ends the reader.
fn write(mut stream: TcpStream, waiting: &Receiver<Vec<u8>>, link: &Link, session: Session) {
    while let Ok(bytes) = waiting.recv() {
        if stream.write_all(&bytes).is_err() {
            link.broken.store(true, Ordering::Release);
            break;
        }
        link.unread.fetch_sub(bytes.len(), Ordering::AcqRel);
    }
    let _ = stream.shutdown(Shutdown::Both);
    session.wake();
}

/// Reads and queues lines until the client closes the connection. A client is rejected if its first line is not a JSON
/// object. This keeps out web pages, which can make a browser send data to any port, but only after the head of an HTTP
/// request.
fn read(stream: TcpStream, queue: &SyncSender<Message>, link: &Link, session: &Session, token: &str) {
    let mut first = true;
    let mut stream = BufReader::with_capacity(64 << 10, stream);
    let mut line = Vec::new();
    loop {
        line.clear();
        let n = (&mut stream).take(LINE_LIMIT as u64 + 1).read_until(b'\n', &mut line);
        let message = match n {
            Ok(0) | Err(_) => break,
            Ok(_) if line.len() > LINE_LIMIT && line.last() != Some(&b'\n') => {
                if !skip_line(&mut stream) {
                    break;
                }
                let fail = Fail::argument(format!("the line is longer than {LINE_LIMIT} bytes"));
                Message { no_json: true, ..Message::wrong(fail) }
            }
            Ok(_) if line.trim_ascii().is_empty() => continue,
            Ok(_) => Message::parse(line.trim_ascii()),
        };
        let refused = std::mem::take(&mut first).then(|| message.refusal(token)).flatten();
        let over = refused.is_some();
        if queue.send(refused.unwrap_or(message)).is_err() || over {
            break;
        }
        session.wake();
    }
    link.ended.store(true, Ordering::Release);
    session.wake();
}

/// Skips the rest of the line. Returns `false` if the connection is closed before the line ends.
fn skip_line(stream: &mut impl BufRead) -> bool {
    loop {
        let (used, end) = match stream.fill_buf() {
            Ok([]) | Err(_) => return false,
            Ok(buffer) => match buffer.iter().position(|b| *b == b'\n') {
                Some(at) => (at + 1, true),
                None => (buffer.len(), false),
            },
        };
        stream.consume(used);
        if end {
            return true;
        }
    }
}
