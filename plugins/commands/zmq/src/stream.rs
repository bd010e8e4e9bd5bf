//! Connections and listeners, by TCP or by a file.

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

/// Longest time in which a connection is established. All peers are on this machine.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(1);

/// A connection.
pub enum Stream {
    Tcp(TcpStream),
    Ipc(UnixStream),
}

impl Stream {
    /// Connects to an endpoint.
    pub fn connect(to: &Endpoint) -> io::Result<Stream> {
        Ok(match to {
            Endpoint::Tcp(at) => {
                let stream = TcpStream::connect_timeout(at, CONNECT_TIMEOUT)?;
                // The system may connect a port to itself if nothing listens on it.
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
    /// Closes the connection, which ends reading and writing in other threads.
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

/// An open port or file.
pub enum Listener {
    Tcp(TcpListener),
    /// With the path of the file and its inode.
    Ipc(UnixListener, PathBuf, u64),
}

impl Listener {
    /// Opens an endpoint. Returns the listener, and the endpoint with the number of its port.
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
    /// Accepts a connection; fails if there is none.
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
        // Another program may have replaced the file by its own.
        if let Listener::Ipc(_, path, number) = self
            && inode(path) == Some(*number)
        {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Returns the inode of a file.
fn inode(path: &Path) -> Option<u64> {
    std::fs::symlink_metadata(path).ok().map(|m| m.ino())
}

/// Removes the file of a socket on which no program listens any more. Other files are never removed.
fn remove_stale(path: &Path) {
    let is_socket = std::fs::symlink_metadata(path).is_ok_and(|m| m.file_type().is_socket());
    let refused = |e: io::Error| e.kind() == io::ErrorKind::ConnectionRefused;
    if is_socket && UnixStream::connect(path).is_err_and(refused) {
        let _ = std::fs::remove_file(path);
    }
}
