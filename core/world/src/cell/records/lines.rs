//! Log lines that are stored until they are taken.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use tatu_plugin_api::abi::*;
use tatu_plugins::watchdog::lock_with_timeout;

/// A line of the log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LogLine {
    /// Level of the line: `TATU_LOG_*`.
    pub level: u32,
    /// The stable code, if the line reports a fault.
    pub code: Option<&'static str>,
    /// Text of the line, without level and code.
    pub text: String,
}

impl LogLine {
    /// Returns the line as programs print it, such as `error[F205]: ...`, or `None` if it is a debug message or is
    /// meant for a console window of a script.
    pub fn formatted(&self) -> Option<String> {
        match self.level {
            TATU_LOG_ERROR => {
                Some(format!("error{}: {}", self.code.map_or(String::new(), |c| format!("[{c}]")), self.text))
            }
            TATU_LOG_WARNING => Some(format!("warning: {}", self.text)),
            TATU_LOG_DEBUG | TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => None,
            _ => Some(self.text.clone()),
        }
    }
}

/// Lines that are stored until they are taken. Only the world's thread adds lines.
#[derive(Debug, Clone, Default)]
pub struct LogBuffer(Arc<Mutex<Vec<LogLine>>>);

impl LogBuffer {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Vec<LogLine>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    pub(crate) fn has_lines(&self) -> bool {
        !self.lock().is_empty()
    }
    /// Takes all lines.
    pub(crate) fn take(&self) -> Vec<LogLine> {
        std::mem::take(&mut *self.lock())
    }
    /// Takes all lines from another thread, because the world's thread may be stuck. Returns no lines if that thread
    /// holds the lock.
    pub fn take_from_outside(&self) -> Vec<LogLine> {
        lock_with_timeout(&self.0).map(|mut lines| std::mem::take(&mut *lines)).unwrap_or_default()
    }
}

/// Maximum number of lines that are stored until they are taken. It limits memory if a script prints in an endless
/// loop.
pub(crate) const MAX_LINES: usize = 10_000;
