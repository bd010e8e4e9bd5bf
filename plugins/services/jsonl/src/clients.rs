//! Connections: one thread listens, and each client has one that reads and one that writes. None of them touches a
//! world: lines wait in a queue until the barrier.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream},
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

use crate::message::Message;

/// Bytes of the longest line.
pub const LINE_LIMIT: usize = 16 << 20;
/// Lines of a client that wait for the barrier; then its reader waits, and in the end the client.
const QUEUE: usize = 256;
/// Bytes that wait to be read by a client; one that lets more pile up is cut off.
const UNREAD_LIMIT: usize = 64 << 20;
/// A client that takes nothing for so long has gone.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);

/// The socket and its thread.
pub struct Listener {
    address: SocketAddr,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    session: Session,
    /// Connected since the last look, in order.
    new: Mutex<Vec<Client>>,
    stopping: AtomicBool,
    /// What each client says first; empty: nothing.
    token: String,
}

/// One connection.
pub struct Client {
    /// From 1, in order of connection.
    pub number: u64,
    lines: Receiver<Message>,
    link: Arc<Link>,
    replies: Sender<Vec<u8>>,
    threads: [JoinHandle<()>; 2],
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
    /// Listens on a port of this machine; 0: any.
    pub fn open(port: u16, token: String, session: Session) -> Result<Self> {
        let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| {
            Fail::new(format!("cannot listen on 127.0.0.1:{port}: {e}")).help("choose another `port`; 0 takes any")
        })?;
        let address = socket.local_addr().map_err(|e| Fail::new(format!("the socket has no address: {e}")))?;
        session.log(TATU_LOG_INFO, &format!("jsonl: listening on {address}"));
        let shared = Arc::new(Shared { session, new: Mutex::default(), stopping: AtomicBool::new(false), token });
        let inside = shared.clone();
        let thread = thread::Builder::new().name("jsonl".into()).spawn(move || listen(&socket, &inside));
        let thread = thread.map_err(|e| Fail::new(format!("cannot start a thread: {e}")))?;
        Ok(Listener { address, shared, thread: Some(thread) })
    }
    /// Clients that have connected since the last look.
    pub fn take_new(&self) -> Vec<Client> {
        std::mem::take(&mut *self.shared.new.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.shared.stopping.store(true, Ordering::Release);
        // The thread sits in `accept`: a connection of our own gets it out.
        let _ = TcpStream::connect_timeout(&self.address, WRITE_TIMEOUT);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        self.take_new().into_iter().for_each(Client::close);
    }
}

fn listen(socket: &TcpListener, shared: &Shared) {
    let mut number = 0;
    loop {
        let stream = match socket.accept() {
            Ok((stream, _)) => stream,
            Err(_) if shared.stopping.load(Ordering::Acquire) => return,
            Err(e) => {
                // Out of file handles, for instance: others may be given back.
                shared.session.log(TATU_LOG_WARNING, &format!("jsonl: a connection failed: {e}"));
                thread::sleep(Duration::from_millis(100));
                continue;
            }
        };
        if shared.stopping.load(Ordering::Acquire) {
            return;
        }
        number += 1;
        match Client::new(number, stream, shared) {
            Ok(client) => shared.new.lock().unwrap_or_else(PoisonError::into_inner).push(client),
            Err(e) => shared.session.log(TATU_LOG_WARNING, &format!("jsonl: client {number}: {e}")),
        }
        shared.session.wake();
    }
}

impl Client {
    fn new(number: u64, stream: TcpStream, shared: &Shared) -> std::io::Result<Self> {
        let (session, token) = (shared.session, shared.token.clone());
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        let (queue, lines) = sync_channel(QUEUE);
        let (replies, waiting) = channel();
        let link = Arc::<Link>::default();
        let (reading, writing) = (stream.try_clone()?, stream);
        let named = |what: &str| thread::Builder::new().name(format!("jsonl {what} {number}"));
        let inside = link.clone();
        let writer = named("writer").spawn(move || write(writing, &waiting, &inside, session))?;
        let inside = link.clone();
        let reader = named("reader").spawn(move || read(reading, &queue, &inside, session, &token))?;
        Ok(Client { number, lines, link, replies, threads: [reader, writer] })
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
    pub fn leave(self) -> [JoinHandle<()>; 2] {
        self.threads
    }
    /// Ends the connection and waits for its threads.
    pub fn close(self) {
        let threads = self.leave();
        threads.into_iter().for_each(|t| drop(t.join()));
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
fn read(stream: TcpStream, queue: &SyncSender<Message>, link: &Link, session: Session, token: &str) {
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
