//! A local port that serves files and WebSockets.
//!
//! The `Host` of a request must be the address of the listener, the `Origin` of a page must be this server or an
//! allowed origin, and a WebSocket must present a token if one is required. Sizes, counts and waiting times are
//! limited, so a misbehaving client harms only itself. Each connection has a separate thread, which never accesses a
//! world: received messages are queued in an inbox.

use std::{
    collections::{BTreeMap, VecDeque},
    io,
    net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use serde_json::json;
use tungstenite::{
    Message as Frame, WebSocket,
    handshake::derive_accept_key,
    protocol::{Role, WebSocketConfig},
};

use crate::{
    http::{HttpRequest, write_response},
    outbox::{Outbox, OutgoingMessage},
    port::end_threads,
    state::PrivateFolder,
    tokens::{self, TokenPair},
};

/// The path at which any client can query a description of the service without a token.
const ABOUT_PATH: &str = "/tatu";

/// Maximum number of simultaneous connections.
const MAX_CONNECTIONS: usize = 256;
/// Maximum number of queued messages from a client; a client that sends more is disconnected.
const MAX_INBOX_MESSAGES: usize = 10_000;
/// Read timeout of a connection, after which its thread sends queued messages. Also the pause after a failed `accept`.
const READ_TIMEOUT: Duration = Duration::from_millis(8);

/// Timeout of the connection that a listener makes to itself in order to end its thread.
const WAKE_TIMEOUT: Duration = Duration::from_secs(1);
/// Size of the read buffer, bytes.
const READ_BUFFER_BYTES: usize = 4 << 10;

/// The rights of a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rights {
    /// Full rights: the client may control the world.
    Control,
    /// Read-only rights: the client may view the world, but not control it.
    View,
}

/// The response for a path: content type, content, and additional headers. Unless these state otherwise, a browser asks
/// again before it uses a cached file.
pub type FileResponse = (&'static str, Vec<u8>, Vec<(&'static str, String)>);

/// Settings with which a listener is opened.
pub struct ListenerSettings {
    /// Id of the service, which any client can query.
    pub service: &'static str,
    /// Port on 127.0.0.1; 0: any free port.
    pub port: u16,
    /// Path of the WebSocket.
    pub path: &'static str,
    /// Whether a WebSocket must present a token, which some standard protocols do not allow. The tokens of a fixed port
    /// remain the same in later runs.
    pub token: bool,
    /// Allowed origins of pages besides this server, in the form that browsers send, such as `http://localhost:8080`.
    pub origins: Vec<String>,
    /// Maximum size of a message from a client, bytes.
    pub max_message_bytes: usize,
    /// Returns the file at a path, or `None` if it does not exist.
    pub files: fn(&str) -> Option<FileResponse>,
    /// Called after a client has connected, disconnected, or sent a message.
    pub wake: Box<dyn Fn() + Send + Sync>,
    /// Called, on the thread of its connection, with each message of a client that has full rights.
    pub on_message: Box<dyn Fn(&str) + Send + Sync>,
}

/// A client that is connected by a WebSocket.
pub struct WebSocketClient {
    /// Number of the client in order of connection, from 1.
    pub number: u64,
    /// The rights that the token of the client grants; full rights if no token is required.
    pub rights: Rights,
    /// Messages to be sent to the client.
    pub out: Arc<Outbox>,
    inbox: Arc<Mutex<VecDeque<String>>>,
    gone: Arc<AtomicBool>,
}

impl WebSocketClient {
    /// Removes and returns the next message from the client, or returns `None` if there is none.
    pub fn next(&self) -> Option<String> {
        lock(&self.inbox).pop_front()
    }
    /// Returns whether the client has disconnected.
    pub fn is_gone(&self) -> bool {
        self.gone.load(Ordering::Acquire)
    }
}

/// An open port. Dropping it closes the port and all connections.
pub struct WebSocketListener {
    /// The address on which the listener accepts connections.
    pub address: SocketAddr,
    /// The token that gives a client full rights.
    pub token: String,
    /// The token that gives a client read-only rights.
    pub view_token: String,
    /// The error because of which the tokens of a fixed port could not be stored for later runs, if any.
    pub token_error: Option<io::Error>,
    new_clients: Arc<Mutex<Vec<WebSocketClient>>>,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Data shared by all connections of a listener.
struct ListenerState {
    settings: ListenerSettings,
    address: SocketAddr,
    tokens: TokenPair,
    /// Random id that distinguishes this listener from earlier ones on the same port.
    instance: String,
    new_clients: Arc<Mutex<Vec<WebSocketClient>>>,
    end: Arc<AtomicBool>,
    count: AtomicUsize,
    numbers: AtomicU64,
    /// The open connections, by number.
    streams: Mutex<BTreeMap<u64, TcpStream>>,
}

impl WebSocketListener {
    /// Opens a port on 127.0.0.1.
    pub fn open(settings: ListenerSettings) -> io::Result<WebSocketListener> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, settings.port))?;
        let address = listener.local_addr()?;
        // Only the process that has opened a port uses its stored tokens, so they are read after the port is open.
        let (tokens, unkept) = match settings.token && settings.port != 0 {
            true => tokens::load_or_create(PrivateFolder::of_user(), settings.port)?,
            false => (tokens::new()?, None),
        };
        let new = Arc::new(Mutex::new(Vec::new()));
        let end = Arc::new(AtomicBool::new(false));
        let shared = Arc::new(ListenerState {
            settings,
            address,
            tokens: tokens.clone(),
            instance: tokens::random_token()?,
            new_clients: new.clone(),
            end: end.clone(),
            count: AtomicUsize::new(0),
            numbers: AtomicU64::new(1),
            streams: Mutex::default(),
        });
        let thread = std::thread::Builder::new().name("listener".into()).spawn(move || accept(&listener, &shared))?;
        let [token, look_token] = tokens;
        Ok(WebSocketListener {
            address,
            token,
            view_token: look_token,
            token_error: unkept,
            new_clients: new,
            end,
            thread: Some(thread),
        })
    }
    /// Returns the clients that have connected since the last call.
    pub fn take_new(&self) -> Vec<WebSocketClient> {
        std::mem::take(&mut *lock(&self.new_clients))
    }
}

impl Drop for WebSocketListener {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Release);
        // The thread blocks until a client connects. If this connection fails, the thread is left running until the
        // process exits.
        let woken = TcpStream::connect_timeout(&self.address, WAKE_TIMEOUT).is_ok();
        if let Some(thread) = self.thread.take().filter(|_| woken) {
            let _ = thread.join();
        }
    }
}

/// Accepts connections, each in a new thread, until the listener is dropped.
fn accept(listener: &TcpListener, shared: &Arc<ListenerState>) {
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    while !shared.end.load(Ordering::Acquire) {
        match listener.accept() {
            _ if shared.end.load(Ordering::Acquire) => break,
            Ok((stream, _)) if shared.count.load(Ordering::Relaxed) < MAX_CONNECTIONS => {
                let own = shared.clone();
                own.count.fetch_add(1, Ordering::Relaxed);
                let serve = move || {
                    let number = own.numbers.fetch_add(1, Ordering::Relaxed);
                    if let Ok(kept) = stream.try_clone() {
                        lock(&own.streams).insert(number, kept);
                        // An error ends only the connection of this client.
                        let _ = serve(stream, number, &own);
                        lock(&own.streams).remove(&number);
                    }
                    own.count.fetch_sub(1, Ordering::Relaxed);
                };
                match std::thread::Builder::new().name("client".into()).spawn(serve) {
                    Ok(thread) => threads.push(thread),
                    Err(_) => {
                        shared.count.fetch_sub(1, Ordering::Relaxed);
                    }
                }
            }
            // The maximum number of connections is reached, so this one is closed.
            Ok(_) => {}
            Err(_) => std::thread::sleep(READ_TIMEOUT),
        }
        threads.retain(|t| !t.is_finished());
    }
    // A client that does not read, or sends its request slowly, must not delay the end.
    end_threads(threads, || {
        for stream in lock(&shared.streams).values() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    });
}

/// Returns whether a `Host`, or the host of an `Origin`, is the address of this listener.
fn is_own_host(name: &str, address: SocketAddr) -> bool {
    let port = address.port();
    [format!("127.0.0.1:{port}"), format!("localhost:{port}")].iter().any(|here| here == name)
}

/// Answers a request, or serves the WebSocket that it opens.
fn serve(mut stream: TcpStream, number: u64, shared: &Arc<ListenerState>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let request = HttpRequest::read(&mut stream)?;
    let refuse = |stream: &mut TcpStream, status: &str, why: &str| {
        write_response(stream, status, &[("Content-Type", "text/plain; charset=utf-8")], why.as_bytes())
    };
    if !request.header("host").is_some_and(|h| is_own_host(h, shared.address)) {
        return refuse(&mut stream, "421 Misdirected Request", "expected the address of this server in `Host`\n");
    }
    if request.method != "GET" {
        return refuse(&mut stream, "405 Method Not Allowed", "only GET is supported\n");
    }
    if request.path == ABOUT_PATH {
        let about = json!({
            "name": "tatu",
            "service": shared.settings.service,
            "version": env!("CARGO_PKG_VERSION"),
            "instance": shared.instance,
        });
        let headers = [("Content-Type", "application/json"), ("Cache-Control", "no-store")];
        return write_response(&mut stream, "200 OK", &headers, about.to_string().as_bytes());
    }
    if request.path != shared.settings.path {
        return match (shared.settings.files)(&request.path) {
            Some((kind, bytes, more)) => {
                let mut headers = vec![
                    ("Content-Type", kind),
                    ("X-Content-Type-Options", "nosniff"),
                    ("Referrer-Policy", "no-referrer"),
                ];
                if !more.iter().any(|(name, _)| *name == "Cache-Control") {
                    headers.push(("Cache-Control", "no-cache"));
                }
                headers.extend(more.iter().map(|(n, v)| (*n, v.as_str())));
                write_response(&mut stream, "200 OK", &headers, &bytes)
            }
            None => refuse(&mut stream, "404 Not Found", "there is no file at this path\n"),
        };
    }
    if let Some(origin) = request.header("origin") {
        let here = origin.strip_prefix("http://").is_some_and(|o| is_own_host(o, shared.address));
        if !here && !shared.settings.origins.iter().any(|o| o == origin) {
            return refuse(&mut stream, "403 Forbidden", "pages from this origin may not connect\n");
        }
    }
    let role = match request.query_value("token") {
        _ if !shared.settings.token => Rights::Control,
        Some(t) if equal_in_constant_time(t, &shared.tokens[0]) => Rights::Control,
        Some(t) if equal_in_constant_time(t, &shared.tokens[1]) => Rights::View,
        _ => return refuse(&mut stream, "401 Unauthorized", "the token in the address is missing or invalid\n"),
    };
    let Some(key) = request.header("sec-websocket-key") else {
        return refuse(&mut stream, "426 Upgrade Required", "expected a WebSocket handshake at this path\n");
    };
    let accept = derive_accept_key(key.as_bytes());
    let head = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"
    );
    io::Write::write_all(&mut stream, head.as_bytes())?;
    exchange_messages(stream, role, number, shared)
}

/// Compares two strings in a time that does not depend on the position of the first difference, so that the time does
/// not reveal how much of a guessed token is correct.
fn equal_in_constant_time(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (x, y)| sum | (x ^ y)) == 0
}

/// Passes messages between a WebSocket and the queues of its client until the WebSocket is closed.
fn exchange_messages(stream: TcpStream, role: Rights, number: u64, shared: &Arc<ListenerState>) -> io::Result<()> {
    stream.set_read_timeout(Some(READ_TIMEOUT))?;
    stream.set_write_timeout(Some(Duration::from_secs(5)))?;
    let most = shared.settings.max_message_bytes;
    // Each read clears the entire buffer, and most reads time out without data, so the buffer is small.
    let config = WebSocketConfig::default()
        .read_buffer_size(READ_BUFFER_BYTES)
        .max_message_size(Some(most))
        .max_frame_size(Some(most));
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    let out = Arc::new(Outbox::default());
    let inbox = Arc::new(Mutex::new(VecDeque::new()));
    let gone = Arc::new(AtomicBool::new(false));
    let client = WebSocketClient { number, rights: role, out: out.clone(), inbox: inbox.clone(), gone: gone.clone() };
    lock(&shared.new_clients).push(client);
    (shared.settings.wake)();
    while !shared.end.load(Ordering::Acquire) && !out.must_disconnect() {
        let mut wrote = false;
        while let Some(message) = if shared.end.load(Ordering::Acquire) { None } else { out.next() } {
            let frame = match message {
                OutgoingMessage::Text(text) => Frame::text(text),
                OutgoingMessage::Binary(bytes) => Frame::binary(bytes),
            };
            if socket.write(frame).is_err() {
                out.disconnect();
                break;
            }
            wrote = true;
        }
        if wrote && socket.flush().is_err() {
            break;
        }
        match socket.read() {
            Ok(Frame::Text(text)) => {
                if role == Rights::Control {
                    (shared.settings.on_message)(text.as_str());
                }
                let mut inbox = lock(&inbox);
                if inbox.len() >= MAX_INBOX_MESSAGES {
                    break;
                }
                inbox.push_back(text.to_string());
                drop(inbox);
                (shared.settings.wake)();
            }
            Ok(Frame::Close(_)) => break,
            Ok(_) => {}
            Err(tungstenite::Error::Io(e))
                if matches!(e.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(_) => break,
        }
    }
    let _ = socket.close(None);
    let _ = socket.flush();
    gone.store(true, Ordering::Release);
    (shared.settings.wake)();
    Ok(())
}
