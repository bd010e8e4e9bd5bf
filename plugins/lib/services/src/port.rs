//! A local port with a thread for each connection, for custom protocols. Connections beyond the limit are closed.
//! Dropping the port waits until pending answers have been written, at most half a second, and all threads have ended.

use std::{
    collections::BTreeMap,
    io,
    net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

/// Pause after a failed `accept`.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(50);
/// Timeout of the connection that unblocks the accepting thread.
const UNBLOCK_TIMEOUT: Duration = Duration::from_secs(5);
/// Time within which the threads of connections can write pending answers before the connections are closed.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_millis(500);
/// Interval at which ending threads are checked.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// An open port. Dropping it closes the port after pending answers have been written.
pub struct Port {
    /// The address on which the port accepts connections.
    pub address: SocketAddr,
    connections: Arc<OpenConnections>,
    thread: Option<JoinHandle<()>>,
}

/// The open connections of a port, which are shared with its threads.
#[derive(Default)]
struct OpenConnections {
    /// The connections, by number.
    streams: Mutex<BTreeMap<u64, TcpStream>>,
    /// Whether the port is being closed.
    closing: AtomicBool,
}

impl OpenConnections {
    fn streams(&self) -> MutexGuard<'_, BTreeMap<u64, TcpStream>> {
        self.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }
    fn is_closing(&self) -> bool {
        self.closing.load(Ordering::Acquire)
    }
    /// Ends reading on all connections, which makes their threads return.
    fn stop_reading(&self) {
        for stream in self.streams().values() {
            let _ = stream.shutdown(Shutdown::Read);
        }
    }
    /// Closes all connections, which makes reading and writing fail.
    fn close(&self) {
        for stream in self.streams().values() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

impl Port {
    /// Opens a port on 127.0.0.1; if `port` is 0, any free port. `serve` is called in a separate thread for each
    /// connection, with the number of the connection, and must return when reading fails. At most `most` connections
    /// are open at the same time. `name` is the name of the accepting thread.
    pub fn open(
        port: u16,
        name: &str,
        most: usize,
        serve: impl Fn(TcpStream, u64) + Send + Sync + 'static,
    ) -> io::Result<Port> {
        let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = socket.local_addr()?;
        let open = Arc::new(OpenConnections::default());
        let (own, serve) = (open.clone(), Arc::new(serve));
        let thread = thread::Builder::new().name(name.into()).spawn(move || accept(&socket, &own, most, &serve))?;
        Ok(Port { address, connections: open, thread: Some(thread) })
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        self.connections.closing.store(true, Ordering::Release);
        // The thread blocks in `accept`; connecting to the port unblocks it.
        let _ = TcpStream::connect_timeout(&self.address, UNBLOCK_TIMEOUT);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Accepts connections, each in a new thread, until the port is dropped.
fn accept<F>(socket: &TcpListener, open: &Arc<OpenConnections>, most: usize, serve: &Arc<F>)
where
    F: Fn(TcpStream, u64) + Send + Sync + 'static,
{
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    let mut number = 0;
    loop {
        let accepted = socket.accept();
        if open.is_closing() {
            break;
        }
        threads.retain(|t| !t.is_finished());
        let Ok((stream, _)) = accepted else {
            // The error may be temporary, for example if the process has too many open files.
            thread::sleep(ACCEPT_RETRY_DELAY);
            continue;
        };
        let Some(kept) = stream.try_clone().ok().filter(|_| threads.len() < most) else { continue };
        number += 1;
        open.streams().insert(number, kept);
        let (own, serve) = (open.clone(), serve.clone());
        let run = move || {
            serve(stream, number);
            own.streams().remove(&number);
        };
        match thread::Builder::new().name("client".into()).spawn(run) {
            Ok(thread) => threads.push(thread),
            Err(_) => drop(open.streams().remove(&number)),
        }
    }
    // Ends reading only, so that the threads can write pending answers before they end.
    open.stop_reading();
    end_threads(threads, || open.close());
}

/// Waits until all threads have ended. If some of them have not after half a second, because their peers do not read,
/// calls `close`, which must make them end.
pub fn end_threads(threads: Vec<JoinHandle<()>>, close: impl FnOnce()) {
    let begun = Instant::now();
    while begun.elapsed() < SHUTDOWN_TIMEOUT && threads.iter().any(|t| !t.is_finished()) {
        thread::sleep(POLL_INTERVAL);
    }
    if threads.iter().any(|t| !t.is_finished()) {
        close();
    }
    for thread in threads {
        let _ = thread.join();
    }
}

#[cfg(test)]
mod tests {
    use std::{
        io::{Read, Write},
        sync::mpsc::channel,
    };

    use super::*;

    /// The port ends although a peer reads nothing of a large answer, and another one sends nothing.
    #[test]
    fn port_closes_despite_unresponsive_peers() {
        let (tell, told) = channel();
        let tell = Mutex::new(tell);
        let serve = move |mut stream: TcpStream, _| {
            let mut one = [0];
            let begins = stream.read_exact(&mut one).is_ok();
            let _ = tell.lock().unwrap().send(());
            let done = if begins { stream.write_all(&vec![0; 64 << 20]) } else { Ok(()) };
            assert!(!begins || done.is_err(), "the answer does not fit in the buffers of a connection");
        };
        let port = Port::open(0, "test", 8, serve).unwrap();
        let mut deaf = TcpStream::connect(port.address).unwrap();
        let silent = TcpStream::connect(port.address).unwrap();
        deaf.write_all(b"x").unwrap();
        told.recv().unwrap();
        // Without an end, the test would hang.
        drop(port);
        drop((deaf, silent));
    }

    #[test]
    fn pending_answers_are_written_before_the_end() {
        let serve = |mut stream: TcpStream, _| {
            let _ = stream.read(&mut [0]);
            let _ = stream.write_all(b"bye");
        };
        let port = Port::open(0, "test", 8, serve).unwrap();
        let mut peer = TcpStream::connect(port.address).unwrap();
        while port.connections.streams().is_empty() {
            thread::sleep(POLL_INTERVAL);
        }
        drop(port);
        let mut text = String::new();
        peer.read_to_string(&mut text).unwrap();
        assert_eq!(text, "bye");
    }
}
