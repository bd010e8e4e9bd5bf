//! Connections and listeners on TCP ports and Unix domain sockets.

use std::{
    io::{self, Read, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    os::unix::{
        fs::{FileTypeExt, MetadataExt},
        net::{UnixListener, UnixStream},
    },
    path::{Path, PathBuf},
    time::Duration,
};

use crate::endpoint::Endpoint;

/// Timeout of a connection attempt. It is short because all peers are on this machine.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(1);

/// A connection to a peer.
pub enum Stream {
    Tcp(TcpStream),
    Ipc(UnixStream),
}

impl Stream {
    /// Connects to an endpoint. Fails if no program listens on it.
    pub fn connect(to: &Endpoint) -> io::Result<Stream> {
        Ok(match to {
            Endpoint::Tcp(at) => {
                let stream = TcpStream::connect_timeout(at, CONNECT_TIMEOUT)?;
                // If nothing listens on a port, the system may connect the socket to itself.
                if stream.local_addr()? == stream.peer_addr()? {
                    return Err(io::ErrorKind::ConnectionRefused.into());
                }
                stream.set_nodelay(true)?;
                Stream::Tcp(stream)
            }
            Endpoint::Ipc(path) => Stream::Ipc(UnixStream::connect(path)?),
        })
    }
    pub fn try_clone(&self) -> io::Result<Stream> {
        Ok(match self {
            Stream::Tcp(stream) => Stream::Tcp(stream.try_clone()?),
            Stream::Ipc(stream) => Stream::Ipc(stream.try_clone()?),
        })
    }
    /// Closes the connection, which ends pending reads and writes of other threads.
    pub fn close(&self) {
        let _ = match self {
            Stream::Tcp(stream) => stream.shutdown(Shutdown::Both),
            Stream::Ipc(stream) => stream.shutdown(Shutdown::Both),
        };
    }
    /// Limits the time for which reading and writing may block.
    pub fn set_timeout(&self, most: Option<Duration>) -> io::Result<()> {
        match self {
            Stream::Tcp(stream) => stream.set_read_timeout(most).and_then(|()| stream.set_write_timeout(most)),
            Stream::Ipc(stream) => stream.set_read_timeout(most).and_then(|()| stream.set_write_timeout(most)),
        }
    }
}

impl Read for Stream {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Stream::Tcp(stream) => stream.read(into),
            Stream::Ipc(stream) => stream.read(into),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, from: &[u8]) -> io::Result<usize> {
        match self {
            Stream::Tcp(stream) => stream.write(from),
            Stream::Ipc(stream) => stream.write(from),
        }
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A listener on a TCP port or Unix domain socket.
pub enum Listener {
    Tcp(TcpListener),
    /// The listener, the path of the socket's file, and the inode of that file.
    Ipc(UnixListener, PathBuf, u64),
}

impl Listener {
    /// Starts to listen on an endpoint. Returns the listener, and the endpoint with the actual port.
    pub fn open(at: &Endpoint) -> io::Result<(Listener, Endpoint)> {
        Ok(match at {
            Endpoint::Tcp(at) => {
                let listener = TcpListener::bind(at)?;
                listener.set_nonblocking(true)?;
                let at: SocketAddr = listener.local_addr()?;
                (Listener::Tcp(listener), Endpoint::Tcp(at))
            }
            Endpoint::Ipc(path) => {
                remove_stale(path);
                let listener = UnixListener::bind(path)?;
                listener.set_nonblocking(true)?;
                (Listener::Ipc(listener, path.clone(), inode(path).unwrap_or(0)), at.clone())
            }
        })
    }
    /// Accepts a pending connection. Fails if there is none.
    pub fn accept(&self) -> io::Result<Stream> {
        Ok(match self {
            Listener::Tcp(listener) => {
                let stream = listener.accept()?.0;
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                Stream::Tcp(stream)
            }
            Listener::Ipc(listener, ..) => {
                let stream = listener.accept()?.0;
                stream.set_nonblocking(false)?;
                Stream::Ipc(stream)
            }
        })
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // The file is removed only if it is still the same, because another program may have replaced it.
        if let Listener::Ipc(_, path, number) = self
            && inode(path) == Some(*number)
        {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Returns the inode of a file, which identifies it.
fn inode(path: &Path) -> Option<u64> {
    std::fs::symlink_metadata(path).ok().map(|m| m.ino())
}

/// Removes the file at a path if it is a socket on which no program listens. Other files are never removed.
fn remove_stale(path: &Path) {
    let is_socket = std::fs::symlink_metadata(path).is_ok_and(|m| m.file_type().is_socket());
    let refused = |e: io::Error| e.kind() == io::ErrorKind::ConnectionRefused;
    if is_socket && UnixStream::connect(path).is_err_and(refused) {
        let _ = std::fs::remove_file(path);
    }
}
