//! Lines for the log.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use tatu_plugins::watchdog::peek;

/// A line of the log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LogLine {
    /// `TATU_LOG_*`
    pub level: u32,
    /// Of a fault: its stable code.
    pub code: Option<&'static str>,
    /// The text.
    pub text: String,
}

/// Lines that are stored until they are taken. Only the thread of the world adds to them.
#[derive(Debug, Clone, Default)]
pub struct Lines(Arc<Mutex<Vec<LogLine>>>);

impl Lines {
    pub(crate) fn hold(&self) -> MutexGuard<'_, Vec<LogLine>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// Takes all there are.
    pub(crate) fn take(&self) -> Vec<LogLine> {
        std::mem::take(&mut *self.hold())
    }
    /// The same from another thread, when that of the world may never go on; none while it holds them.
    pub fn take_from_outside(&self) -> Vec<LogLine> {
        peek(&self.0).map(|mut lines| std::mem::take(&mut *lines)).unwrap_or_default()
    }
}

/// Lines that are kept between two looks at them: a script that prints in an endless loop must not fill the memory.
pub(crate) const MAX_LINES: usize = 10_000;
