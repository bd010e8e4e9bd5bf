//! Messages to and from the process of a script.

use std::{
    io,
    os::fd::{AsRawFd, OwnedFd},
    time::{Duration, Instant},
};

use crate::message::{MAX_BYTES, Message};

/// How often the host is asked whether the script must return.
const POLL: Duration = Duration::from_millis(20);
/// Bytes that are read at once.
const CHUNK: usize = 64 << 10;
/// How much of the last output of a process is kept for the message about its end.
const TAIL: usize = 4 << 10;

/// Why no message can be exchanged with the process any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lost {
    /// It has closed the socket, or has ended.
    Closed,
    /// It has not answered in time.
    Late,
    /// The host asks the script to return.
    Interrupted,
    /// It sent something that is not a message.
    Malformed,
}

/// How long the plugin waits for the process during one call of the host.
pub(crate) struct Patience<'a> {
    /// The time that the process may still take; `None`: any time.
    pub left: Option<Duration>,
    /// Returns whether the host asks the script to return.
    pub must_return: &'a dyn Fn() -> bool,
}

/// The socket to the process, and the pipe from its standard output and error.
pub(crate) struct Channel {
    socket: OwnedFd,
    output: OwnedFd,
    /// Whether the process has closed its end of the pipe.
    output_ended: bool,
    received: Vec<u8>,
    /// Start of the bytes in `received` that have not been taken.
    taken: usize,
    to_send: Vec<u8>,
    lines: Vec<u8>,
    tail: Vec<u8>,
}

impl Channel {
    pub fn new(socket: OwnedFd, output: OwnedFd) -> io::Result<Self> {
        for fd in [&socket, &output] {
            // SAFETY: the system calls take a descriptor that is open, and numbers.
            let result = unsafe {
                let flags = libc::fcntl(fd.as_raw_fd(), libc::F_GETFL);
                libc::fcntl(fd.as_raw_fd(), libc::F_SETFL, flags | libc::O_NONBLOCK)
            };
            if result < 0 {
                return Err(io::Error::last_os_error());
            }
        }
        let (received, to_send, lines, tail) = Default::default();
        Ok(Channel { socket, output, output_ended: false, received, taken: 0, to_send, lines, tail })
    }

    /// Adds a message that is sent with the next one; it must be complete.
    pub fn queue(&mut self, message: &[u8]) {
        self.to_send.extend_from_slice(message);
    }

    /// Sends what was queued, and returns the next message of the process.
    pub fn exchange(&mut self, patience: &mut Patience<'_>) -> Result<Message, Lost> {
        let mut begun = None;
        loop {
            self.send_some()?;
            if self.to_send.is_empty()
                && let Some(message) = self.take()?
            {
                return Ok(message);
            }
            self.wait(patience, begun.get_or_insert_with(Instant::now))?;
        }
    }

    /// Takes what the process has written to its standard output and error since the last call, line by line.
    pub fn output_lines(&mut self) -> Vec<String> {
        let Some(end) = self.lines.iter().rposition(|b| *b == b'\n') else { return Vec::new() };
        let whole: Vec<u8> = self.lines.drain(..=end).collect();
        String::from_utf8_lossy(&whole).lines().map(str::to_owned).collect()
    }

    /// Returns the last lines that the process has written to its standard output and error.
    pub fn last_output(&mut self) -> String {
        self.read_output();
        String::from_utf8_lossy(&self.tail).trim().to_owned()
    }

    fn send_some(&mut self) -> Result<(), Lost> {
        while !self.to_send.is_empty() {
            let (ptr, len) = (self.to_send.as_ptr().cast(), self.to_send.len());
            // SAFETY: the pointer and the length are those of `to_send`.
            let sent = unsafe { libc::send(self.socket.as_raw_fd(), ptr, len, NO_SIGNAL) };
            match usize::try_from(sent) {
                Ok(sent) => drop(self.to_send.drain(..sent)),
                Err(_) => match io::Error::last_os_error().kind() {
                    io::ErrorKind::Interrupted => {}
                    io::ErrorKind::WouldBlock => return Ok(()),
                    _ => return Err(Lost::Closed),
                },
            }
        }
        Ok(())
    }

    /// Takes a message that has been received completely.
    fn take(&mut self) -> Result<Option<Message>, Lost> {
        let waiting = &self.received[self.taken..];
        let Some((length, rest)) = waiting.split_first_chunk::<4>() else { return Ok(None) };
        let length = u32::from_le_bytes(*length) as usize;
        if length == 0 || length > MAX_BYTES {
            return Err(Lost::Malformed);
        }
        let Some(body) = rest.get(..length) else { return Ok(None) };
        let message = Message { kind: body[0], body: body[1..].to_vec() };
        self.taken += 4 + length;
        if self.taken == self.received.len() {
            self.received.clear();
            self.taken = 0;
        }
        Ok(Some(message))
    }

    /// Waits until something can be sent or has been received, and receives it.
    fn wait(&mut self, patience: &mut Patience<'_>, begun: &mut Instant) -> Result<(), Lost> {
        let events = if self.to_send.is_empty() { libc::POLLIN } else { libc::POLLIN | libc::POLLOUT };
        let mut fds = [
            libc::pollfd { fd: self.socket.as_raw_fd(), events, revents: 0 },
            libc::pollfd { fd: if self.output_ended { -1 } else { self.output.as_raw_fd() }, events: libc::POLLIN, revents: 0 },
        ];
        let pause = patience.left.map_or(POLL, |left| left.min(POLL));
        let ms = i32::try_from(pause.as_millis()).unwrap_or(1).max(1);
        // SAFETY: the pointer and the count are those of `fds`.
        let ready = unsafe { libc::poll(fds.as_mut_ptr(), fds.len() as libc::nfds_t, ms) };
        if fds[1].revents != 0 {
            self.read_output();
        }
        if fds[0].revents & !libc::POLLOUT != 0 {
            self.receive()?;
        }
        if let Some(left) = &mut patience.left {
            let now = Instant::now();
            *left = left.saturating_sub(now.duration_since(*begun));
            *begun = now;
            if left.is_zero() {
                return Err(Lost::Late);
            }
        }
        // A process that floods the pipe or the socket must not keep the host from being asked.
        if (ready <= 0 || fds[1].revents != 0) && (patience.must_return)() {
            return Err(Lost::Interrupted);
        }
        Ok(())
    }

    fn receive(&mut self) -> Result<(), Lost> {
        if self.taken > 0 {
            self.received.drain(..self.taken);
            self.taken = 0;
        }
        if self.received.len() > MAX_BYTES + 4 {
            return Err(Lost::Malformed);
        }
        match read(&self.socket, &mut self.received) {
            Some(0) => Err(Lost::Closed),
            _ => Ok(()),
        }
    }

    fn read_output(&mut self) {
        let before = self.lines.len();
        let Some(n) = read(&self.output, &mut self.lines) else { return };
        self.output_ended |= n == 0;
        self.tail.extend_from_slice(&self.lines[before..before + n]);
        self.tail.drain(..self.tail.len().saturating_sub(TAIL));
        // Lines are taken after each call of the host. Until then, only the last ones are kept.
        self.lines.drain(..self.lines.len().saturating_sub(MAX_LINES_BYTES));
    }
}

const MAX_LINES_BYTES: usize = 1 << 20;

#[cfg(any(target_os = "linux", target_os = "android", target_os = "freebsd"))]
const NO_SIGNAL: i32 = libc::MSG_NOSIGNAL;
#[cfg(not(any(target_os = "linux", target_os = "android", target_os = "freebsd")))]
const NO_SIGNAL: i32 = 0;

/// Appends what can be read at once. Returns the number of bytes, 0 at the end, or `None` if nothing can be read now.
fn read(fd: &OwnedFd, to: &mut Vec<u8>) -> Option<usize> {
    to.reserve(CHUNK);
    let place = to.spare_capacity_mut();
    // SAFETY: the pointer and the length are those of `place`.
    let n = unsafe { libc::read(fd.as_raw_fd(), place.as_mut_ptr().cast(), place.len()) };
    let failed = (n < 0).then(|| io::Error::last_os_error().kind());
    let n = usize::try_from(n).unwrap_or(0);
    // SAFETY: `read` has initialized the first `n` bytes after the end.
    unsafe { to.set_len(to.len() + n) };
    match failed {
        Some(io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => None,
        Some(_) => Some(0),
        None => Some(n),
    }
}
