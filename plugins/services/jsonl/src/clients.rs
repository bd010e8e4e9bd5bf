//! Connections of clients. Each has a reading and a writing thread, which never access a world: received lines are
//! queued until the barrier.

use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader, Read, Write},
    net::{Shutdown, TcpStream},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
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
use tatu_services_common::port::{Port, end_threads};

use crate::message::{JsonlRequest, RequestLine};

/// Maximum number of simultaneous clients; further ones are disconnected.
const MAX_CLIENTS: usize = 256;
/// Maximum length of a line, bytes.
pub const MAX_LINE_BYTES: usize = 16 << 20;
/// Maximum number of lines per client that are queued for the barrier. While the queue is full, the client's reader
/// blocks, so that eventually the client blocks, too.
const MAX_QUEUED_LINES: usize = 256;
/// Maximum total size of the lines queued for a client, bytes. If more accumulate, the client is disconnected.
const MAX_UNREAD_BYTES: usize = 64 << 20;
/// Time for which sending to a client may block before the client is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);

/// The port, and the clients that have connected to it recently.
pub struct LineListener {
    new_clients: Arc<Mutex<NewClients>>,
    writers: Arc<WriterMap>,
    /// The open port; `None` only while the listener is being dropped.
    port: Option<Port>,
}

/// Clients that have connected since the last call of `take_new`, in order of connection.
#[derive(Default)]
struct NewClients {
    clients: Vec<LineConnection>,
    /// Whether the listener is being dropped, so that new clients are rejected.
    closed: bool,
}

/// A connected client. Its reader is a thread of the port.
pub struct LineConnection {
    /// Number of the client in order of connection, from 1.
    pub number: u64,
    /// The received lines that have not been processed.
    lines: Receiver<RequestLine>,
    link: Arc<ConnectionState>,
    /// Queues lines for the writer; `None` ends it.
    replies: Sender<Option<Vec<u8>>>,
    writer: JoinHandle<()>,
}

/// State of a client that is shared with its threads.
#[derive(Default)]
struct ConnectionState {
    /// Whether the reader has ended, so that no further lines will be queued.
    ended: AtomicBool,
    /// Whether lines can no longer be sent to the client, because sending has failed or too many lines are queued.
    broken: AtomicBool,
    /// Whether nothing is sent to the client any more, although its lines are processed.
    silent: AtomicBool,
    /// Total size of the lines that are queued for the client, bytes.
    unread: AtomicUsize,
}

/// The writers of all clients, by number of the client. A client that has sent its last line remains in the list until
/// all its answers have been sent.
#[derive(Default)]
struct WriterMap(Mutex<BTreeMap<u64, ConnectionWriter>>);

struct ConnectionWriter {
    link: Arc<ConnectionState>,
    replies: Sender<Option<Vec<u8>>>,
    stream: Arc<TcpStream>,
}

impl WriterMap {
    fn all(&self) -> MutexGuard<'_, BTreeMap<u64, ConnectionWriter>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds the writer of a new client. If there are too many clients, the first one that has sent its last line is no
    /// longer answered: it may have left, which cannot be distinguished from a client that only waits. Returns `false`
    /// if there are too many clients that may still send lines.
    fn add(&self, number: u64, writer: ConnectionWriter) -> bool {
        let mut all = self.all();
        if all.len() >= MAX_CLIENTS {
            let ended = all.iter().find(|(_, w)| w.link.ended.load(Ordering::Acquire)).map(|(number, _)| *number);
            let Some(ended) = ended.and_then(|number| all.remove(&number)) else { return false };
            ended.end();
        }
        all.insert(number, writer);
        true
    }
}

impl ConnectionWriter {
    /// Ends the writer, even if it is blocked because its client does not read.
    fn end(&self) {
        self.link.silent.store(true, Ordering::Release);
        let _ = self.stream.shutdown(Shutdown::Both);
        let _ = self.replies.send(None);
    }
}

impl LineListener {
    /// Opens a port on 127.0.0.1; if `port` is 0, any free port. Unless `token` is empty, each client must send it in
    /// its first line.
    pub fn open(port: u16, token: String, session: Session) -> Result<Self> {
        let arrivals = Arc::<Mutex<NewClients>>::default();
        let inside = arrivals.clone();
        let of_clients = session.clone();
        let writers = Arc::<WriterMap>::default();
        let of_listener = writers.clone();
        let serve = move |stream: TcpStream, number: u64| match LineConnection::new(
            number,
            stream,
            of_clients.clone(),
            &writers,
        ) {
            Ok(None) => {}
            Ok(Some((client, queue, stream))) => {
                let link = client.link.clone();
                let mut arrivals = inside.lock().unwrap_or_else(PoisonError::into_inner);
                if !arrivals.closed {
                    arrivals.clients.push(client);
                    drop(arrivals);
                    of_clients.wake();
                    read(&stream, &queue, &link, &of_clients, &token);
                } else {
                    drop(client.finish_sending());
                }
            }
            Err(e) => of_clients.log(TATU_LOG_WARNING, &format!("jsonl: client {number}: {e}")),
        };
        let port = Port::open(port, "jsonl", MAX_CLIENTS, serve).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}"))
                .help("choose another `port`, or 0 for any free port")
        })?;
        session.log(TATU_LOG_INFO, &format!("jsonl: listening on {}", port.address));
        Ok(LineListener { new_clients: arrivals, writers: of_listener, port: Some(port) })
    }
    /// Closes the connections of clients after waiting, at most half a second, until the queued lines have been sent.
    pub fn close(&self, clients: impl IntoIterator<Item = LineConnection>, others: Vec<JoinHandle<()>>) {
        let threads = clients.into_iter().map(LineConnection::finish_sending).chain(others).collect();
        end_threads(threads, || self.writers.all().values().for_each(ConnectionWriter::end));
    }
    /// Returns the clients that have connected since the last call.
    pub fn take_new(&self) -> Vec<LineConnection> {
        std::mem::take(&mut self.new_clients.lock().unwrap_or_else(PoisonError::into_inner).clients)
    }
}

impl Drop for LineListener {
    fn drop(&mut self) {
        self.new_clients.lock().unwrap_or_else(PoisonError::into_inner).closed = true;
        // The port waits for the readers, but a reader with a full queue blocks until its client is closed.
        self.close(self.take_new(), Vec::new());
        self.port.take();
    }
}

/// A new client, the sender of its queue of received lines, and its connection.
type StartedConnection = (LineConnection, SyncSender<RequestLine>, Arc<TcpStream>);

impl LineConnection {
    /// Starts the writer of a new client. Also returns the sender of its queue of received lines and its connection,
    /// for the reader. Returns `None` if there are too many clients.
    fn new(
        number: u64,
        stream: TcpStream,
        session: Session,
        writers: &Arc<WriterMap>,
    ) -> std::io::Result<Option<StartedConnection>> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        let (queue, lines) = sync_channel(MAX_QUEUED_LINES);
        let (replies, waiting) = channel();
        let link = Arc::<ConnectionState>::default();
        let stream = Arc::new(stream);
        let known = ConnectionWriter { link: link.clone(), replies: replies.clone(), stream: stream.clone() };
        if !writers.add(number, known) {
            return Ok(None);
        }
        let (writing, inside, of_all) = (stream.clone(), link.clone(), writers.clone());
        let writer = thread::Builder::new().name(format!("jsonl writer {number}"));
        let writer = writer.spawn(move || {
            write(&writing, &waiting, &inside, &session);
            of_all.all().remove(&number);
        });
        let writer = writer.inspect_err(|_| drop(writers.all().remove(&number)))?;
        Ok(Some((LineConnection { number, lines, link, replies, writer }, queue, stream)))
    }

    /// Removes and returns the next received line, or returns `None` if there is none.
    pub fn next_line(&self) -> Option<RequestLine> {
        self.lines.try_recv().ok()
    }
    /// Returns whether the client has sent its last line or has disconnected, so that it can no longer hold the world.
    pub fn has_ended(&self) -> bool {
        self.link.ended.load(Ordering::Acquire) || self.is_broken()
    }
    /// Returns whether lines can no longer be sent to the client, because sending has failed or too many are queued.
    pub fn is_broken(&self) -> bool {
        self.link.broken.load(Ordering::Acquire)
    }
    /// Returns whether the client is no longer answered, because it has sent its last line and others have connected.
    pub fn is_silent(&self) -> bool {
        self.link.silent.load(Ordering::Acquire)
    }
    /// Queues a line for the client. If too many bytes are already queued, discards the line and marks the client as
    /// broken.
    pub fn send(&self, line: &Json) {
        let mut bytes = line.to_string().into_bytes();
        bytes.push(b'\n');
        let unread = self.link.unread.fetch_add(bytes.len(), Ordering::AcqRel);
        if unread > MAX_UNREAD_BYTES || self.replies.send(Some(bytes)).is_err() {
            self.link.broken.store(true, Ordering::Release);
        }
    }
    /// Lets the writer send the queued lines and then close the connection. Returns the thread of the writer.
    pub fn finish_sending(self) -> JoinHandle<()> {
        let _ = self.replies.send(None);
        self.writer
    }
}

/// Sends queued lines until the client is closed or sending fails. Then closes both directions of the connection, which
/// also ends the reader.
fn write(mut stream: &TcpStream, waiting: &Receiver<Option<Vec<u8>>>, link: &ConnectionState, session: &Session) {
    while let Ok(Some(bytes)) = waiting.recv() {
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
fn read(stream: &TcpStream, queue: &SyncSender<RequestLine>, link: &ConnectionState, session: &Session, token: &str) {
    let mut first = true;
    let mut stream = BufReader::with_capacity(64 << 10, stream);
    let mut line = Vec::new();
    loop {
        line.clear();
        let n = (&mut stream).take(MAX_LINE_BYTES as u64 + 1).read_until(b'\n', &mut line);
        let message = match n {
            Ok(0) | Err(_) => break,
            Ok(_) if line.len() > MAX_LINE_BYTES && line.last() != Some(&b'\n') => {
                if !skip_line(&mut stream) {
                    break;
                }
                let fail = Fail::argument(format!("the line is longer than {MAX_LINE_BYTES} bytes"));
                RequestLine { no_json: true, ..RequestLine::invalid(fail) }
            }
            Ok(_) if line.trim_ascii().is_empty() => continue,
            Ok(_) => RequestLine::parse(line.trim_ascii()),
        };
        let refused = std::mem::take(&mut first).then(|| message.refusal(token)).flatten();
        let over = refused.is_some();
        if !over && matches!(message.request, Ok(JsonlRequest::Request(TATU_REQUEST_STOP | TATU_REQUEST_QUIT))) {
            session.stop();
        }
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
