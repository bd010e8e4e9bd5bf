//! Connections: each client has a thread that reads and one that writes. None of them touches a world: lines wait in a queue
//! until the barrier.

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

/// Clients at a time; one more is cut off.
const MOST_CLIENTS: usize = 256;
/// Bytes of the longest line.
pub const LINE_LIMIT: usize = 16 << 20;
/// Lines of a client that wait for the barrier; then its reader waits, and in the end the client.
const QUEUE: usize = 256;
/// Bytes that wait to be read by a client; one that lets more pile up is cut off.
const UNREAD_LIMIT: usize = 64 << 20;
/// A client that takes nothing for so long has gone.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);

/// The port, and who has come to it.
pub struct Listener {
    arrivals: Arc<Mutex<Arrivals>>,
    /// None: it is closed.
    port: Option<Port>,
}

/// Clients that have connected since the last look, in order.
#[derive(Default)]
struct Arrivals {
    clients: Vec<Client>,
    closed: bool,
}

/// One connection. Its reader is a thread of the port.
pub struct Client {
    /// From 1, in order of connection.
    pub number: u64,
    lines: Receiver<Message>,
    link: Arc<Link>,
    replies: Sender<Vec<u8>>,
    writer: JoinHandle<()>,
}

/// What a client's threads share.
#[derive(Default)]
struct Link {
    /// It has sent its last line.
    ended: AtomicBool,
    /// It takes nothing any more.
    broken: AtomicBool,
    /// Bytes that it has not taken yet.
    unread: AtomicUsize,
}

impl Listener {
    /// Listens on a port of this machine; 0: any. `token`: what each client says first; empty: nothing.
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
    /// Clients that have connected since the last look.
    pub fn take_new(&self) -> Vec<Client> {
        std::mem::take(&mut self.arrivals.lock().unwrap_or_else(PoisonError::into_inner).clients)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.arrivals.lock().unwrap_or_else(PoisonError::into_inner).closed = true;
        // A reader whose lines nobody takes waits until its client is closed; the port waits for readers.
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
    /// The next line, if one waits.
    pub fn next_line(&self) -> Option<Message> {
        self.lines.try_recv().ok()
    }
    /// Whether it has sent its last line, or has gone: it holds nothing any more.
    pub fn ended(&self) -> bool {
        self.link.ended.load(Ordering::Acquire) || self.broken()
    }
    /// Whether it takes nothing any more.
    pub fn broken(&self) -> bool {
        self.link.broken.load(Ordering::Acquire)
    }
    /// Sends a line.
    pub fn send(&self, line: &Json) {
        let mut bytes = line.to_string().into_bytes();
        bytes.push(b'\n');
        let unread = self.link.unread.fetch_add(bytes.len(), Ordering::AcqRel);
        if unread > UNREAD_LIMIT || self.replies.send(bytes).is_err() {
            self.link.broken.store(true, Ordering::Release);
        }
    }
    /// Ends the connection once what was sent has been taken; its threads end by themselves.
    pub fn leave(self) -> JoinHandle<()> {
        self.writer
    }
    /// Ends the connection, and waits until what was sent has been taken.
    pub fn close(self) {
        let _ = self.leave().join();
    }
}

/// Sends what waits; when nothing more will come, or the client takes nothing, both directions are closed, which ends
/// the reader too.
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

/// Puts lines into the queue until the client ends. One whose first line is no message is refused: a web page can make a
/// browser send its own lines to any port, but not without the head of a request before them.
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
                Message::wrong(Fail::argument(format!("a line is longer than {LINE_LIMIT} bytes")))
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

/// Reads to the end of the line; `false`: the client ended before.
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
