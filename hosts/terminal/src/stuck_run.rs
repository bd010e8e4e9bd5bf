//! Ends a run in which a plugin call does not return: reports it, closes files, and exits. A crash is handled in the
//! same way.
//!
//! The stuck thread cannot be stopped, so another thread does this, with the data stored here.

use std::{
    fs::File,
    io::{BufWriter, Write},
    sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError},
    time::Duration,
};

use serde_json::json;
use tatu_core::{
    LogBuffer, LogLine, World,
    errors::{Fault, FaultKind},
    plugins::watchdog::{CallWatches, StuckCall, lock_with_timeout},
};
use tatu_plugin_api::abi::*;

use crate::report;

/// A file that two threads may close.
pub type SharedFile = Arc<Mutex<BufWriter<File>>>;

/// What is known about the run, for the output if a plugin call that does not return ends the program.
#[derive(Default)]
struct RunRecord {
    json: bool,
    /// Whether the run has started: the exit code is then 1 instead of 2.
    began: bool,
    /// Whether the summary has been printed.
    summary_printed: bool,
    steps: u64,
    time: f64,
    faults: Vec<Fault>,
    files: Vec<SharedFile>,
    /// Log lines of the running step.
    lines: Option<LogBuffer>,
    /// Whether status lines are printed on standard output.
    prints: bool,
}

/// Ends a run in which a plugin call does not return within the time limit.
#[derive(Clone, Default)]
pub struct Watchdog {
    /// The registry's record of running plugin calls.
    pub watches: CallWatches,
    record: Arc<Mutex<RunRecord>>,
}

/// The watchdog of this process.
static CURRENT: OnceLock<Watchdog> = OnceLock::new();

/// Returns the watchdog of this process, or `None` if it has not been started.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn current() -> Option<&'static Watchdog> {
    CURRENT.get()
}

impl Watchdog {
    /// Starts the watchdog with a time limit in s of real time; 0 disables the limit.
    pub fn start(limit: f64, json: bool) -> Self {
        let new = Watchdog::default();
        new.record().json = json;
        // A process runs only one command, so this succeeds.
        let _ = CURRENT.set(new.clone());
        if limit > 0.0 {
            let run = new.clone();
            let end = move |stuck: StuckCall| run.end(&stuck, limit);
            // If the thread cannot be started, the run continues without a watchdog.
            let _ = new.watches.start_watchdog(Duration::from_secs_f64(limit), end);
        }
        new
    }
    fn record(&self) -> MutexGuard<'_, RunRecord> {
        self.record.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// Sets the world whose log lines are printed. `prints` is set if status lines are printed on standard
    /// output.
    pub fn world(&self, world: &World, prints: bool) {
        let mut known = self.record();
        (known.lines, known.prints) = (Some(world.lines()), prints);
    }
    /// Marks the start of the run; `file` is flushed even if the run is ended by force.
    pub fn begin(&self, file: Option<SharedFile>) {
        let mut known = self.record();
        known.began = true;
        known.files.extend(file);
    }
    /// Records a step, and all faults of the run if there are new ones.
    pub fn step(&self, steps: u64, time: f64, faults: Option<Vec<Fault>>) {
        let mut known = self.record();
        (known.steps, known.time) = (steps, time);
        if let Some(faults) = faults {
            known.faults = faults;
        }
    }
    /// Records that the summary has been printed.
    pub fn set_summary_printed(&self) {
        self.record().summary_printed = true;
    }

    /// Reports the stuck call and ends the process.
    fn end(&self, stuck: &StuckCall, limit: f64) {
        let StuckCall { plugin, object, call, command, .. } = stuck;
        let what = command.as_ref().map_or(String::new(), |name| format!(" (`{name}`)"));
        let text = format!("plugin `{plugin}` has not returned from {call}{what} for {limit} s: the run ends here");
        let mut fault = Fault::new(FaultKind::Stuck, text);
        (fault.plugin, fault.object) = (Some(plugin.clone()), object.clone());
        fault.help = Some("if it is merely slow, raise the limit with `--watchdog S`; 0 means no limit".into());
        let place = object.as_ref().map_or(String::new(), |o| format!(" [{o}]"));
        report::err!("error[{}]: {}{place} ({})", fault.code, fault.message, fault.help.as_deref().unwrap_or_default());
        leave(self.close(&fault));
    }

    /// Writes all pending output, and the fault that ends the run; returns the exit code. It never waits for locks that
    /// a stuck thread may hold.
    pub fn close(&self, fault: &Fault) -> i32 {
        let Some(known) = lock_with_timeout(&self.record) else { return 1 };
        for file in &known.files {
            // A stuck thread is inside a plugin, so no line of the trace is incomplete. After a crash elsewhere, the
            // file may end with part of a line.
            if let Some(mut file) = lock_with_timeout(file) {
                let _ = file.flush();
            }
        }
        // A run with `--interactive` has changed the terminal's mode.
        if crossterm::terminal::is_raw_mode_enabled().unwrap_or(false) {
            let _ = crossterm::terminal::disable_raw_mode();
        }
        let lines = known.lines.as_ref().map(LogBuffer::take_from_outside).unwrap_or_default();
        lines.iter().for_each(|l| print_log_line(l, known.prints));
        if known.json && known.began && !known.summary_printed {
            let errors: Vec<&Fault> = known.faults.iter().chain([fault]).collect();
            let out = json!({ "steps": known.steps, "sim_time_s": known.time, "objects": {}, "errors": errors });
            report::out!("{}", serde_json::to_string_pretty(&out).unwrap_or_default());
        }
        let _ = std::io::stdout().flush();
        if known.began { 1 } else { 2 }
    }
}

/// Prints a log line in the same way as a run.
fn print_log_line(line: &LogLine, prints: bool) {
    match line.level {
        TATU_LOG_ERROR => report::err!("error{}: {}", line.code.map_or(String::new(), |c| format!("[{c}]")), line.text),
        TATU_LOG_WARNING => report::err!("warning: {}", line.text),
        TATU_LOG_DEBUG | TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => {}
        _ if prints => report::out!("{}", line.text),
        _ => report::err!("{}", line.text),
    }
}

/// Ends the process at once, without exit handlers, which could hang as well.
#[cfg(unix)]
pub fn leave(code: i32) {
    // SAFETY: `_exit` has no preconditions, and does not return.
    unsafe { libc::_exit(code) }
}
#[cfg(not(unix))]
pub fn leave(code: i32) {
    std::process::exit(code)
}
