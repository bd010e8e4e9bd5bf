//! Numbered sockets, built on the standard library. Blocking calls check regularly whether the run is about to end.

use std::{
    collections::BTreeMap,
    io::{self, ErrorKind, Read, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream, ToSocketAddrs, UdpSocket},
    sync::mpsc,
    time::{Duration, Instant},
};

/// Maximum time for which a call blocks before it checks whether the run is about to end.
const INTERRUPT_INTERVAL: Duration = Duration::from_millis(50);
/// Pause between two polls of a non-blocking socket.
const POLL_INTERVAL: Duration = Duration::from_millis(1);
/// Shortest timeout of a connection attempt; `connect_timeout` rejects zero.
const MIN_CONNECT_TIMEOUT: Duration = Duration::from_millis(20);
/// Longest timeout of a connection attempt, which also applies if the script sets no limit.
const MAX_CONNECT_TIMEOUT: Duration = Duration::from_secs(120);
/// Number of bytes per read from the operating system, as in LuaSocket.
const BUFFER_BYTES: usize = 8192;

/// A connection, with a buffer of received bytes that no call has read yet.
pub struct BufferedStream {
    stream: TcpStream,
    buffer: Vec<u8>,
}

/// An open socket of the operating system.
pub enum Socket {
    /// A TCP connection.
    Stream(BufferedStream),
    /// A TCP listener, and a connection that `select` has accepted but `accept` has not returned yet.
    Listener(TcpListener, Option<TcpStream>),
    /// A UDP socket.
    Datagram(UdpSocket),
}

/// The sockets of a world.
#[derive(Default)]
pub struct Sockets {
    all: BTreeMap<i64, Socket>,
    /// The last number that was assigned. Numbers are not reused, so a number that a script stored before the world was
    /// restored never refers to a different socket.
    pub last: i64,
}

/// The deadline of a blocking call, and a callback that can end the call earlier.
pub struct CallDeadline<'a> {
    end: Option<Instant>,
    is_run_ending: &'a dyn Fn() -> bool,
}

impl<'a> CallDeadline<'a> {
    /// Creates a deadline `seconds` from now; a negative number means no deadline. `ends` returns whether the run is
    /// about to end.
    pub fn new(seconds: f64, ends: &'a dyn Fn() -> bool) -> Self {
        let end = (seconds >= 0.0).then(|| Instant::now() + Duration::from_secs_f64(seconds.min(1e6)));
        CallDeadline { end, is_run_ending: ends }
    }
    fn time_left(&self) -> Option<Duration> {
        self.end.map(|end| end.saturating_duration_since(Instant::now()))
    }
    /// Sleeps for at most `most`; returns an error once the deadline has passed or the run is about to end.
    pub fn sleep(&self, most: Duration) -> io::Result<()> {
        if (self.is_run_ending)() {
            return Err(ErrorKind::ConnectionAborted.into());
        }
        match self.time_left() {
            Some(Duration::ZERO) => return Err(ErrorKind::TimedOut.into()),
            Some(left) => std::thread::sleep(left.min(most)),
            None => std::thread::sleep(most),
        }
        Ok(())
    }
    /// Sleeps until the deadline, or until the run is about to end.
    pub fn wait(&self) {
        while self.sleep(INTERRUPT_INTERVAL).is_ok() {}
    }
    /// Calls `f` repeatedly until it succeeds or fails with an error other than `WouldBlock`, `TimedOut` and
    /// `Interrupted`. Returns an error once the deadline has passed or the run is about to end.
    fn retry<T>(&self, mut f: impl FnMut() -> io::Result<T>) -> io::Result<T> {
        loop {
            match f() {
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    self.sleep(POLL_INTERVAL)?
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                done => return done,
            }
        }
    }
}

/// What a call to `receive` reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReceivePattern {
    /// A line up to a line feed; the line feed and all carriage returns are removed.
    Line,
    /// All bytes until the peer closes the connection.
    All,
    /// A number of bytes.
    Count(usize),
}

/// Returns LuaSocket's message for an error.
pub fn error_message(e: &io::Error) -> String {
    match e.kind() {
        ErrorKind::WouldBlock | ErrorKind::TimedOut => "timeout".into(),
        ErrorKind::UnexpectedEof
        | ErrorKind::ConnectionReset
        | ErrorKind::BrokenPipe
        | ErrorKind::ConnectionAborted
        | ErrorKind::NotConnected => "closed".into(),
        ErrorKind::ConnectionRefused => "connection refused".into(),
        ErrorKind::AddrInUse => "address already in use".into(),
        ErrorKind::PermissionDenied => "permission denied".into(),
        _ => {
            let text = e.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_owned()
        }
    }
}

/// Resolves a host to all its IPv4 addresses; `*` is any address of this machine.
pub fn addresses(host: &str, port: u16) -> io::Result<Vec<SocketAddr>> {
    let host = if host == "*" { "0.0.0.0" } else { host };
    let unknown = || io::Error::other("host or service not provided, or not known");
    let all: Vec<SocketAddr> =
        (host, port).to_socket_addrs().map_err(|_| unknown())?.filter(SocketAddr::is_ipv4).collect();
    if all.is_empty() { Err(unknown()) } else { Ok(all) }
}

fn closed() -> io::Error {
    ErrorKind::NotConnected.into()
}

/// Opens a TCP connection, in a separate thread because the system call cannot be interrupted.
pub fn connect(to: SocketAddr, deadline: &CallDeadline<'_>) -> io::Result<Socket> {
    let most = deadline.time_left().unwrap_or(MAX_CONNECT_TIMEOUT).clamp(MIN_CONNECT_TIMEOUT, MAX_CONNECT_TIMEOUT);
    let (done, wait) = mpsc::channel();
    std::thread::spawn(move || done.send(TcpStream::connect_timeout(&to, most)));
    loop {
        match wait.recv_timeout(INTERRUPT_INTERVAL) {
            Ok(stream) => return Socket::connected(stream?),
            Err(_) if (deadline.is_run_ending)() => return Err(ErrorKind::ConnectionAborted.into()),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => return Err(ErrorKind::TimedOut.into()),
        }
    }
}

/// Opens a TCP listener.
pub fn listen(at: SocketAddr) -> io::Result<Socket> {
    let listener = TcpListener::bind(at)?;
    listener.set_nonblocking(true)?;
    Ok(Socket::Listener(listener, None))
}

/// Opens a UDP socket.
pub fn datagrams(at: SocketAddr) -> io::Result<Socket> {
    let socket = UdpSocket::bind(at)?;
    socket.set_nonblocking(true)?;
    Ok(Socket::Datagram(socket))
}

impl Socket {
    fn connected(stream: TcpStream) -> io::Result<Socket> {
        stream.set_nonblocking(true)?;
        Ok(Socket::Stream(BufferedStream { stream, buffer: Vec::new() }))
    }

    /// Returns whether the socket can be written, if `write` is true, or read without blocking.
    fn is_ready(&mut self, write: bool) -> bool {
        let would_block = |r: io::Result<usize>| matches!(r, Err(e) if e.kind() == ErrorKind::WouldBlock);
        match self {
            Socket::Stream(s) if write => s.stream.peer_addr().is_ok(),
            Socket::Stream(s) => !s.buffer.is_empty() || !would_block(s.stream.peek(&mut [0])),
            Socket::Listener(listener, seen) => {
                if !write && seen.is_none() {
                    *seen = listener.accept().ok().map(|(stream, _)| stream);
                }
                !write && seen.is_some()
            }
            Socket::Datagram(socket) => write || !would_block(socket.peek(&mut [0])),
        }
    }
}

impl BufferedStream {
    /// Waits until at least one more byte has been received into the buffer.
    fn fill(&mut self, deadline: &CallDeadline<'_>) -> io::Result<()> {
        let mut bytes = [0; BUFFER_BYTES];
        match deadline.retry(|| self.stream.read(&mut bytes))? {
            0 => Err(closed()),
            n => {
                self.buffer.extend_from_slice(&bytes[..n]);
                Ok(())
            }
        }
    }

    /// Appends received bytes to `out`, including those received before an error.
    fn receive(&mut self, want: ReceivePattern, out: &mut Vec<u8>, deadline: &CallDeadline<'_>) -> io::Result<()> {
        loop {
            match want {
                ReceivePattern::Line => {
                    let end = self.buffer.iter().position(|b| *b == b'\n');
                    let line = self.buffer.drain(..end.map_or(self.buffer.len(), |e| e + 1));
                    out.extend(line.filter(|b| !b"\r\n".contains(b)));
                    if end.is_some() {
                        return Ok(());
                    }
                }
                ReceivePattern::All => out.append(&mut self.buffer),
                ReceivePattern::Count(0) if !self.buffer.is_empty() => return Ok(()),
                ReceivePattern::Count(n) => {
                    let lacks = n.saturating_sub(out.len()).min(self.buffer.len());
                    out.extend(self.buffer.drain(..lacks));
                    if n > 0 && out.len() >= n {
                        return Ok(());
                    }
                }
            }
            match self.fill(deadline) {
                Err(e) if want == ReceivePattern::All && error_message(&e) == "closed" && !out.is_empty() => {
                    return Ok(());
                }
                done => done?,
            }
        }
    }
}

impl Sockets {
    /// Stores a socket and returns its new number.
    pub fn insert(&mut self, socket: Socket) -> i64 {
        self.last += 1;
        self.all.insert(self.last, socket);
        self.last
    }
    /// Replaces the socket stored under a number.
    pub fn replace(&mut self, n: i64, socket: Socket) {
        self.all.insert(n, socket);
    }
    /// Closes a socket; does nothing if it is closed already.
    pub fn close(&mut self, n: i64) {
        self.all.remove(&n);
    }
    fn stream(&mut self, n: i64) -> io::Result<&mut BufferedStream> {
        match self.all.get_mut(&n) {
            Some(Socket::Stream(stream)) => Ok(stream),
            _ => Err(closed()),
        }
    }
    /// Returns the UDP socket with this number.
    pub fn datagram(&self, n: i64) -> io::Result<&UdpSocket> {
        match self.all.get(&n) {
            Some(Socket::Datagram(socket)) => Ok(socket),
            _ => Err(closed()),
        }
    }

    /// Accepts the next connection of a listener and returns the number of the new socket.
    pub fn accept(&mut self, n: i64, deadline: &CallDeadline<'_>) -> io::Result<i64> {
        let Some(Socket::Listener(listener, seen)) = self.all.get_mut(&n) else { return Err(closed()) };
        let stream = match seen.take() {
            Some(stream) => stream,
            None => deadline.retry(|| listener.accept())?.0,
        };
        Ok(self.insert(Socket::connected(stream)?))
    }
    /// Appends the bytes received from a connection to `out`, including those received before an error.
    pub fn receive(
        &mut self,
        n: i64,
        want: ReceivePattern,
        out: &mut Vec<u8>,
        deadline: &CallDeadline<'_>,
    ) -> io::Result<()> {
        if matches!(want, ReceivePattern::Count(count) if count > 0 && out.len() >= count) {
            return Ok(());
        }
        self.stream(n)?.receive(want, out, deadline)
    }
    /// Receives a datagram; returns its bytes, truncated to `most`, and the address of its sender.
    pub fn receive_from(
        &mut self,
        n: i64,
        most: usize,
        deadline: &CallDeadline<'_>,
    ) -> io::Result<(Vec<u8>, Option<SocketAddr>)> {
        let socket = self.datagram(n)?;
        // A datagram has less than 64 KiB.
        let mut bytes = vec![0; most.min(1 << 16)];
        let (count, from) = match socket.peer_addr() {
            Ok(_) => (deadline.retry(|| socket.recv(&mut bytes))?, None),
            Err(_) => deadline.retry(|| socket.recv_from(&mut bytes)).map(|(n, from)| (n, Some(from)))?,
        };
        bytes.truncate(count);
        Ok((bytes, from))
    }
    /// Sends bytes. Returns the number of bytes sent, and the error that stopped the transfer, if any.
    pub fn send(&mut self, n: i64, bytes: &[u8], deadline: &CallDeadline<'_>) -> (usize, io::Result<()>) {
        if let Ok(socket) = self.datagram(n) {
            let done = deadline.retry(|| socket.send(bytes));
            return (*done.as_ref().unwrap_or(&0), done.map(drop));
        }
        let mut sent = 0;
        let done = self.stream(n).and_then(|s| {
            while sent < bytes.len() {
                match deadline.retry(|| s.stream.write(&bytes[sent..]))? {
                    0 => return Err(closed()),
                    more => sent += more,
                }
            }
            Ok(())
        });
        (sent, done)
    }
    /// Shuts down one or both directions of a connection.
    pub fn shutdown(&mut self, n: i64, how: Shutdown) {
        if let Ok(s) = self.stream(n) {
            let _ = s.stream.shutdown(how);
        }
    }
    /// Returns whether the receive buffer contains bytes that no call has returned yet.
    pub fn is_dirty(&mut self, n: i64) -> bool {
        self.stream(n).is_ok_and(|s| !s.buffer.is_empty())
    }
    /// Returns the local address of a socket, or the address of its peer if `peer` is true.
    pub fn name(&self, n: i64, peer: bool) -> io::Result<SocketAddr> {
        let unconnected = || io::Error::other("Transport endpoint is not connected");
        match self.all.get(&n) {
            Some(Socket::Stream(s)) if peer => s.stream.peer_addr().map_err(|_| unconnected()),
            Some(Socket::Stream(s)) => s.stream.local_addr(),
            Some(Socket::Datagram(s)) if peer => s.peer_addr().map_err(|_| unconnected()),
            Some(Socket::Datagram(s)) => s.local_addr(),
            Some(Socket::Listener(..)) if peer => Err(unconnected()),
            Some(Socket::Listener(s, _)) => s.local_addr(),
            None => Err(io::Error::other("Bad file descriptor")),
        }
    }
    /// Sets the option `tcp-nodelay` or `broadcast`; other options are ignored.
    pub fn option(&self, n: i64, name: &str, on: bool) -> io::Result<()> {
        match (name, self.all.get(&n)) {
            ("tcp-nodelay", Some(Socket::Stream(s))) => s.stream.set_nodelay(on),
            ("broadcast", Some(Socket::Datagram(s))) => s.set_broadcast(on),
            _ => Ok(()),
        }
    }
    /// Waits until at least one socket of `read` can be read or one of `write` can be written, and returns the ready
    /// sockets of both lists, or empty lists at the deadline or if the run is about to end. Sockets with buffered bytes
    /// come first.
    pub fn select(&mut self, read: &[i64], write: &[i64], deadline: &CallDeadline<'_>) -> [Vec<i64>; 2] {
        loop {
            let mut pick = |list: &[i64], write: bool| {
                let ready = |n: &i64| self.all.get_mut(n).is_some_and(|s| s.is_ready(write));
                let mut found: Vec<i64> = list.iter().copied().filter(ready).collect();
                found.sort_by_key(|n| (write || !self.is_dirty(*n), *n));
                found
            };
            let found = [pick(read, false), pick(write, true)];
            if found.iter().any(|f| !f.is_empty()) || deadline.sleep(POLL_INTERVAL).is_err() {
                return found;
            }
        }
    }
}
