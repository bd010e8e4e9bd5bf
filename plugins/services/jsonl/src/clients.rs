//! Connections: each client has a reading and a writing thread. They never access a world: lines wait in a queue until
//! the barrier.

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
/// Maximum number of lines per client queued for the barrier. When the queue is full, the client's reader blocks, and
/// finally the client itself.
const QUEUE: usize = 256;
/// Maximum size of the lines queued for a client, bytes; a client that lets more accumulate is disconnected.
const UNREAD_LIMIT: usize = 64 << 20;
/// A client that accepts no data for this time is considered gone.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);

/// The port, and the clients that have connected to it.
pub struct Listener {
    arrivals: Arc<Mutex<Arrivals>>,
    /// The open port, or `None` after it was closed.
    port: Option<Port>,
}

/// Clients that have connected since the last call of `take_new`, in order.
#[derive(Default)]
struct Arrivals {
    clients: Vec<Client>,
    closed: bool,
}

/// A connection. Its reader is a thread of the port.
pub struct Client {
    /// Number in order of connection, from 1.
    pub number: u64,
    lines: Receiver<Message>,
    link: Arc<Link>,
    replies: Sender<Vec<u8>>,
    writer: JoinHandle<()>,
}

/// Data shared by a client's threads.
#[derive(Default)]
struct Link {
    /// Whether the client has sent its last line.
    ended: AtomicBool,
    /// Whether the client accepts no more data.
    broken: AtomicBool,
    /// Size of the lines that have not been sent to the client yet, bytes.
    unread: AtomicUsize,
}

impl Listener {
    /// Opens a local port; if `port` is 0, any free one. Each client must send `token` first, unless it is empty.
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
                .help("choose another `port`; 0 means any free port")
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
        // A reader may block on its full queue until its client is closed, and the port waits for readers.
        self.take_new().into_iter().for_each(Client::close);
        self.port.take();
    }
}

impl Client {
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
    /// Returns the next line, if one is queued.
    pub fn next_line(&self) -> Option<Message> {
        self.lines.try_recv().ok()
    }
    /// Returns whether the client has sent its last line or has disconnected, so that it cannot hold the world any
    /// more.
    pub fn ended(&self) -> bool {
        self.link.ended.load(Ordering::Acquire) || self.broken()
    }
    /// Returns whether the client accepts no more data.
    pub fn broken(&self) -> bool {
        self.link.broken.load(Ordering::Acquire)
    }
    /// Queues a line to the client.
    pub fn send(&self, line: &Json) {
        let mut bytes = line.to_string().into_bytes();
        bytes.push(b'\n');
        let unread = self.link.unread.fetch_add(bytes.len(), Ordering::AcqRel);
        if unread > UNREAD_LIMIT || self.replies.send(bytes).is_err() {
            self.link.broken.store(true, Ordering::Release);
        }
    }
    /// Closes the connection after the queued lines have been sent; its threads end by themselves.
    pub fn leave(self) -> JoinHandle<()> {
        self.writer
    }
    /// Closes the connection, and waits until the queued lines have been sent.
    pub fn close(self) {
        let _ = self.leave().join();
    }
}

/// Sends queued lines; at the end, or when the client accepts no more data, it closes both directions, which also ends
/// the reader.
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

/// Queues lines until the client ends. A client whose first line is not a message is refused: a web page can make a
/// browser send data to any port, but only after the head of an HTTP request.
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
                Message::wrong(Fail::argument(format!("the line is longer than {LINE_LIMIT} bytes")))
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

/// Skips to the end of the line; returns `false` if the client ended before.
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
