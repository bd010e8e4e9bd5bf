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

/// What begins each line of the child.
pub const PREFIX: &str = "tatu-check ";

/// Sends a line to the parent at once, so that it is there if the next call crashes.
pub fn send(line: &Line) {
    let Ok(json) = serde_json::to_string(line) else { return };
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{PREFIX}{json}").and_then(|()| out.flush());
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
