//! What a test finds, and the lines by which a child process reports it.

use std::{
    io::Write,
    sync::{Mutex, PoisonError},
};

use serde::{Deserialize, Serialize};

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// A breach of a rule: the check fails.
    Error,
    /// Something that users will trip over, and no breach.
    Warning,
    /// For information.
    Note,
}

/// What a test found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    pub level: Level,
    /// What in the plugin: "command `hello.twice`", "sensor `lamp`"; empty: the plugin as a whole.
    pub place: String,
    /// What is wrong, one sentence.
    pub text: String,
}

/// A line from a child process to its parent. Lines without it are the plugin's own output.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Line {
    /// What is tried now: the place of a crash that follows.
    At {
        place: String,
        text: String,
    },
    Found(Finding),
    /// Text for the parent: see `commands::repeat`.
    Transcript(String),
    /// The test came to its end.
    Done,
}

/// What is tried in every test.
pub const LOADING: &str = "when it is loaded";

/// What begins each line of the child.
pub const PREFIX: &str = "tatu-check ";

/// Sends a line to the parent at once, so that it is there if the next call crashes.
pub fn send(line: &Line) {
    let Ok(json) = serde_json::to_string(line) else { return };
    let line = format!("{PREFIX}{json}\n");
    #[cfg(unix)]
    {
        use std::os::fd::FromRawFd;
        // SAFETY: a descriptor that stays open until the process ends; it is not closed here.
        let mut out = std::mem::ManuallyDrop::new(unsafe { std::fs::File::from_raw_fd(channel()) });
        let _ = out.write_all(line.as_bytes());
    }
    #[cfg(not(unix))]
    {
        let mut out = std::io::stdout().lock();
        let _ = out.write_all(line.as_bytes()).and_then(|()| out.flush());
    }
}

/// The descriptor to which lines for the parent are written: standard output, until `take_output` moves it away.
#[cfg(unix)]
static CHANNEL: std::sync::atomic::AtomicI32 = std::sync::atomic::AtomicI32::new(1);

/// Returns that descriptor.
#[cfg(unix)]
pub fn channel() -> i32 {
    CHANNEL.load(std::sync::atomic::Ordering::Relaxed)
}

/// Keeps standard output for lines to the parent; what the plugin prints goes to standard error from now on.
#[cfg(unix)]
pub fn take_output() {
    // SAFETY: calls with numbers only; the new descriptor is closed in programs that a plugin starts.
    unsafe {
        let own = libc::fcntl(1, libc::F_DUPFD_CLOEXEC, 64);
        if own >= 0 && libc::dup2(2, 1) == 1 {
            CHANNEL.store(own, std::sync::atomic::Ordering::Relaxed);
        }
    }
}

/// What is tried now.
static PLACE: Mutex<String> = Mutex::new(String::new());

/// The place that was named last.
pub fn here() -> String {
    PLACE.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Says what is tried now.
pub fn at(place: &str, text: impl Into<String>) {
    place.clone_into(&mut PLACE.lock().unwrap_or_else(PoisonError::into_inner));
    send(&Line::At { place: place.to_owned(), text: text.into() });
}

/// Reports a breach of a rule.
pub fn error(place: &str, text: impl Into<String>) {
    found(Level::Error, place, text);
}

/// Reports something that users will trip over.
pub fn warning(place: &str, text: impl Into<String>) {
    found(Level::Warning, place, text);
}

/// Reports for information.
pub fn note(place: &str, text: impl Into<String>) {
    found(Level::Note, place, text);
}

fn found(level: Level, place: &str, text: impl Into<String>) {
    send(&Line::Found(Finding { level, place: place.to_owned(), text: text.into() }));
}
