//! Findings of tests, and the lines by which a child process sends them to its parent.

use std::{
    io::Write,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

use serde::{Deserialize, Serialize};

/// The severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FindingLevel {
    /// A violation of a rule: the check fails.
    Error,
    /// A likely problem for users that violates no rule.
    Warning,
    /// A remark that is not a problem.
    Note,
}

/// A problem or remark that a test reports.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    pub level: FindingLevel,
    /// The part of the plugin, such as "command `hello.twice`" or "sensor `lamp`". If empty, the whole plugin.
    pub place: String,
    /// Description of the problem: one sentence, which may refer to the part of the plugin as "it".
    pub text: String,
}

/// A message from a child process to its parent, sent as a line that starts with [`LINE_PREFIX`]. All other lines are
/// output of the plugin.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ChildMessage {
    /// The current activity, to which a later crash is attributed.
    At {
        place: String,
        text: String,
    },
    Found(Finding),
    /// The results of a run, each with the part of the plugin, for comparison by the parent: see `repeat`.
    Transcript(Vec<(String, String)>),
    /// The main part of the test is not possible for this plugin.
    Untested,
    /// The test has finished.
    Done,
}

/// Environment variable that is set in the two processes whose transcripts are compared, to 1 or 2.
pub const ONE_RUN: &str = "TATU_CHECK_ONE_RUN";

/// Returns whether this is the second of the processes whose transcripts are compared.
pub fn is_second_run() -> bool {
    std::env::var_os(ONE_RUN).is_some_and(|run| run == "2")
}

/// The first activity of every test.
pub const LOADING_ACTIVITY: &str = "when it is loaded";

/// The prefix of each line that the child sends.
pub const LINE_PREFIX: &str = "tatu-check ";

/// Whether findings are printed for people, because the test runs in the process of the program.
static FOR_PEOPLE: AtomicBool = AtomicBool::new(false);
static HAS_ERRORS: AtomicBool = AtomicBool::new(false);

/// From now on, prints findings for people instead of sending them to a parent.
pub fn print_for_people() {
    FOR_PEOPLE.store(true, Relaxed);
}

/// Returns whether an error was printed for people.
pub fn has_errors() -> bool {
    HAS_ERRORS.load(Relaxed)
}

/// Sends a line to the parent without buffering, so that it is not lost if the next call crashes.
pub fn send(line: &ChildMessage) {
    if FOR_PEOPLE.load(Relaxed) {
        match line {
            ChildMessage::Found(f) => {
                HAS_ERRORS.fetch_or(f.level == FindingLevel::Error, Relaxed);
                tatu_terminal::report::out!("{:?}: {}: {}", f.level, f.place, f.text);
            }
            ChildMessage::At { place, text } => tatu_terminal::report::out!("{place} {text}"),
            _ => {}
        }
        return;
    }
    let Ok(json) = serde_json::to_string(line) else { return };
    let line = format!("{LINE_PREFIX}{json}\n");
    #[cfg(unix)]
    {
        use std::os::fd::FromRawFd;
        // SAFETY: the descriptor remains open until the process exits, and `ManuallyDrop` prevents closing it here.
        let mut out = std::mem::ManuallyDrop::new(unsafe { std::fs::File::from_raw_fd(channel()) });
        let _ = out.write_all(line.as_bytes());
    }
    #[cfg(not(unix))]
    {
        let mut out = std::io::stdout().lock();
        let _ = out.write_all(line.as_bytes()).and_then(|()| out.flush());
    }
}

/// The file descriptor to which lines for the parent are written: standard output, until `redirect_output` redirects
/// it.
#[cfg(unix)]
static CHANNEL: std::sync::atomic::AtomicI32 = std::sync::atomic::AtomicI32::new(1);

/// Returns the file descriptor to which lines for the parent are written.
#[cfg(unix)]
pub fn channel() -> i32 {
    CHANNEL.load(std::sync::atomic::Ordering::Relaxed)
}

/// Reserves the current standard output for lines to the parent, and redirects the plugin's output to standard error.
#[cfg(unix)]
pub fn redirect_output() {
    // SAFETY: both functions take only integers; the new descriptor is closed in programs that a plugin starts.
    unsafe {
        let own = libc::fcntl(1, libc::F_DUPFD_CLOEXEC, 64);
        if own >= 0 && libc::dup2(2, 1) == 1 {
            CHANNEL.store(own, std::sync::atomic::Ordering::Relaxed);
        }
    }
}

/// The part of the plugin that is currently tested.
static CURRENT_PLACE: Mutex<String> = Mutex::new(String::new());

/// Returns the part of the plugin that is currently tested.
pub fn current_place() -> String {
    CURRENT_PLACE.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Reports the current activity to the parent: a part of the plugin, and a clause such as "when it is loaded".
pub fn report_activity(place: &str, text: impl Into<String>) {
    place.clone_into(&mut CURRENT_PLACE.lock().unwrap_or_else(PoisonError::into_inner));
    send(&ChildMessage::At { place: place.to_owned(), text: text.into() });
}

/// Reports a violation of a rule.
pub fn error(place: &str, text: impl Into<String>) {
    report_finding(FindingLevel::Error, place, text);
}

/// Reports a likely problem for users.
pub fn warning(place: &str, text: impl Into<String>) {
    report_finding(FindingLevel::Warning, place, text);
}

/// Reports that the main part of a test was not possible, and why. The test then counts as not applicable unless it
/// finds an error.
pub fn untested(place: &str, text: impl Into<String>) {
    send(&ChildMessage::Untested);
    note(place, text);
}

/// Reports a remark that is not a problem.
pub fn note(place: &str, text: impl Into<String>) {
    report_finding(FindingLevel::Note, place, text);
}

fn report_finding(level: FindingLevel, place: &str, text: impl Into<String>) {
    send(&ChildMessage::Found(Finding { level, place: place.to_owned(), text: text.into() }));
}
