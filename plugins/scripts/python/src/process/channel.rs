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
    /// It has closed the pipe, or has ended.
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

/// Pipes to and from the process: of messages in both directions, and of its standard output and error.
///
/// Pipes take half the time of a pair of sockets.
pub(crate) struct Channel {
    /// `None` once it has been closed, which asks the process to end.
    input: Option<OwnedFd>,
    messages: OwnedFd,
    output: OwnedFd,
    /// Whether the process has closed its end of `output`.
    output_ended: bool,
    /// Whether a write to a process that has ended would end this program.
    signals: bool,
    received: Vec<u8>,
    /// Start of the bytes in `received` that have not been taken.
    taken: usize,
    to_send: Vec<u8>,
    /// Number of bytes of `to_send` that have been sent.
    sent: usize,
    lines: Vec<u8>,
    tail: Vec<u8>,
}

impl Channel {
    pub fn new(input: OwnedFd, messages: OwnedFd, output: OwnedFd) -> io::Result<Self> {
        for fd in [&input, &messages, &output] {
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
        let (taken, sent) = (0, 0);
        let signals = pipe_signal_is_fatal();
        let input = Some(input);
        Ok(Channel {
            input,
            messages,
            output,
            output_ended: false,
            signals,
            received,
            taken,
            to_send,
            sent,
            lines,
            tail,
        })
    }

    /// Asks the process to end, after it has finished what it does.
    pub fn close(&mut self) {
        self.input = None;
        self.read_output();
    }

    /// Adds a message that is sent with the next one; it must be complete.
    pub fn queue(&mut self, message: &[u8]) {
        self.to_send.extend_from_slice(message);
    }

    /// Sends what was queued, and returns the next message of the process.
    pub fn exchange(&mut self, patience: &mut Patience<'_>) -> Result<Message, Lost> {
        let begun = Instant::now();
        let limit = patience.left;
        let result = loop {
            if let Err(lost) = self.send_some() {
                break Err(lost);
            }
            if self.to_send.is_empty() {
                match self.take() {
                    Ok(Some(message)) => break Ok(message),
                    Ok(None) => {}
                    Err(lost) => break Err(lost),
                }
            }
            let idle = match self.wait() {
                Ok(idle) => idle,
                Err(lost) => break Err(lost),
            };
            if limit.is_some_and(|limit| begun.elapsed() >= limit) {
                break Err(Lost::Late);
            }
            if idle && (patience.must_return)() {
                break Err(Lost::Interrupted);
            }
        };
        patience.left = limit.map(|limit| limit.saturating_sub(begun.elapsed()));
        result
    }

    /// Takes what the process has written to its standard output and error since the last call, line by line.
    pub fn output_lines(&mut self) -> Vec<String> {
        self.read_output();
        let Some(end) = self.lines.iter().rposition(|b| *b == b'\n') else { return Vec::new() };
        let whole: Vec<u8> = self.lines.drain(..=end).collect();
        String::from_utf8_lossy(&whole).lines().map(str::to_owned).collect()
    }

    /// Returns the last lines that the process has written to its standard output and error.
    pub fn last_output(&mut self) -> String {
        self.read_output();
        String::from_utf8_lossy(&self.tail).trim().to_owned()
    }

    /// Sends what the process can receive now.
    fn send_some(&mut self) -> Result<(), Lost> {
        while !self.to_send.is_empty() {
            let Some(input) = &self.input else { return Err(Lost::Closed) };
            match write(input, &self.to_send[self.sent..], self.signals) {
                Ok(n) if self.sent + n == self.to_send.len() => {
                    self.to_send.clear();
                    self.to_send.shrink_to(CHUNK);
                    self.sent = 0;
                }
                Ok(n) => self.sent += n,
                Err(e) => match e.kind() {
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
            self.received.shrink_to(CHUNK);
            self.taken = 0;
        }
        Ok(Some(message))
    }

    /// Waits until something can be sent or has been received, and receives it. Returns whether nothing happened for a
    /// while, or only output was written, which an endless loop may do.
    fn wait(&mut self) -> Result<bool, Lost> {
        let entry = |fd: i32, events| libc::pollfd { fd, events, revents: 0 };
        let input = self.input.as_ref().filter(|_| !self.to_send.is_empty());
        let mut fds = [
            entry(self.messages.as_raw_fd(), libc::POLLIN),
            entry(if self.output_ended { -1 } else { self.output.as_raw_fd() }, libc::POLLIN),
            entry(input.map_or(-1, AsRawFd::as_raw_fd), libc::POLLOUT),
        ];
        // SAFETY: the pointer and the count are those of `fds`.
        unsafe { libc::poll(fds.as_mut_ptr(), fds.len() as libc::nfds_t, POLL.as_millis() as i32) };
        if fds[1].revents != 0 {
            self.read_output();
        }
        if fds[0].revents == 0 {
            return Ok(fds[2].revents == 0);
        }
        if self.taken > 0 {
            self.received.drain(..self.taken);
            self.taken = 0;
        }
        if self.received.len() > MAX_BYTES + 4 {
            return Err(Lost::Malformed);
        }
        match read(&self.messages, &mut self.received) {
            Some(0) => Err(Lost::Closed),
            _ => Ok(false),
        }
    }

    /// Reads the pipe, and forgets all but the last lines.
    fn read_output(&mut self) {
        // The process may write faster than the pipe is read.
        for _ in 0..MAX_LINES_BYTES / CHUNK {
            if self.output_ended || !self.read_some_output() {
                return;
            }
        }
    }

    /// Returns whether there may be more to read.
    fn read_some_output(&mut self) -> bool {
        let before = self.lines.len();
        let Some(n) = read(&self.output, &mut self.lines) else { return false };
        self.output_ended |= n == 0;
        self.tail.extend_from_slice(&self.lines[before..before + n]);
        self.tail.drain(..self.tail.len().saturating_sub(TAIL));
        // Lines are taken after each call of the host. Until then, only the last ones are kept.
        self.lines.drain(..self.lines.len().saturating_sub(MAX_LINES_BYTES));
        n > 0
    }
}

const MAX_LINES_BYTES: usize = 1 << 20;

/// Returns whether this program has not chosen to ignore or handle the signal of broken pipes.
fn pipe_signal_is_fatal() -> bool {
    // SAFETY: zero bytes are a valid `sigaction`, which the system call overwrites.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        libc::sigaction(libc::SIGPIPE, std::ptr::null(), &raw mut action) == 0 && action.sa_sigaction == libc::SIG_DFL
    }
}

/// Writes to a pipe. With `signals`, keeps the signal of a broken pipe from ending the program.
fn write(fd: &OwnedFd, bytes: &[u8], signals: bool) -> io::Result<usize> {
    // SAFETY: the pointer and the length are those of `bytes`; the sets of signals are initialized before use.
    unsafe {
        let mut outer: libc::sigset_t = std::mem::zeroed();
        let mut pipe: libc::sigset_t = std::mem::zeroed();
        if signals {
            libc::sigemptyset(&raw mut pipe);
            libc::sigaddset(&raw mut pipe, libc::SIGPIPE);
            libc::pthread_sigmask(libc::SIG_BLOCK, &raw const pipe, &raw mut outer);
        }
        let n = libc::write(fd.as_raw_fd(), bytes.as_ptr().cast(), bytes.len());
        let result = usize::try_from(n).map_err(|_| io::Error::last_os_error());
        if signals {
            if result.as_ref().is_err_and(|e| e.kind() == io::ErrorKind::BrokenPipe) {
                // The signal is pending for this thread; it is taken before it is allowed again.
                let mut number = 0;
                libc::sigwait(&raw const pipe, &raw mut number);
            }
            libc::pthread_sigmask(libc::SIG_SETMASK, &raw const outer, std::ptr::null_mut());
        }
        result
    }
}

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
