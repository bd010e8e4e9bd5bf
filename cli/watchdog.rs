//! The end of a run in which a plugin call does not return: reported, files closed, exit code. A crash ends it likewise.
//!
//! The thread that is stuck cannot be taken back, so all is done by another one, with what was left here for it.

use std::{
    fs::File,
    io::{BufWriter, Write},
    sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError},
    time::Duration,
};

use serde_json::json;
use tatu_core::{
    Lines, LogLine, World,
    errors::{Fault, FaultKind},
    plugins::watchdog::{Stuck, Watches, peek},
};
use tatu_plugin_api::abi::*;

use crate::report;

/// A file that two threads may close.
pub type SharedFile = Arc<Mutex<BufWriter<File>>>;

/// What is known of the run, for the one who has to end it.
#[derive(Default)]
struct Known {
    json: bool,
    /// Something has been started: exit code 1 instead of 2.
    began: bool,
    /// The summary has been printed.
    told: bool,
    steps: u64,
    time: f64,
    faults: Vec<Fault>,
    files: Vec<SharedFile>,
    /// What the running step has logged so far.
    lines: Option<Lines>,
    /// Lines of the status bar go to standard output.
    prints: bool,
}

/// The watchdog of a run.
#[derive(Clone, Default)]
pub struct Watchdog {
    /// For the registry: where calls are noted.
    pub watches: Watches,
    known: Arc<Mutex<Known>>,
}

/// The watchdog of this process's command.
static CURRENT: OnceLock<Watchdog> = OnceLock::new();

/// The watchdog of the command that runs; `None`: it has none yet.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn current() -> Option<&'static Watchdog> {
    CURRENT.get()
}

impl Watchdog {
    /// Starts to watch; a limit of 0 watches nothing.
    pub fn start(limit: f64, json: bool) -> Self {
        let new = Watchdog::default();
        new.known().json = json;
        // A process runs one command; another one would only not be blamed for a crash.
        let _ = CURRENT.set(new.clone());
        if limit > 0.0 {
            let run = new.clone();
            let end = move |stuck: Stuck| run.end(&stuck, limit);
            // Without a thread for it there is only no watchdog.
            let _ = new.watches.guard(Duration::from_secs_f64(limit), end);
        }
        new
    }
    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// The world whose log lines are printed; `prints`: whether status bar lines go to standard output.
    pub fn world(&self, world: &World, prints: bool) {
        let mut known = self.known();
        (known.lines, known.prints) = (Some(world.lines()), prints);
    }
    /// The run begins; a file that it writes is to be whole whatever happens.
    pub fn begin(&self, file: Option<SharedFile>) {
        let mut known = self.known();
        known.began = true;
        known.files.extend(file);
    }
    /// Something is done; `faults` if there are new ones.
    pub fn step(&self, steps: u64, time: f64, faults: Option<Vec<Fault>>) {
        let mut known = self.known();
        (known.steps, known.time) = (steps, time);
        if let Some(faults) = faults {
            known.faults = faults;
        }
    }
    /// The summary has been printed.
    pub fn told(&self) {
        self.known().told = true;
    }

    /// Reports what there is and ends the process.
    fn end(&self, stuck: &Stuck, limit: f64) {
        let Stuck { plugin, object, call, command, .. } = stuck;
        let what = command.as_ref().map_or(String::new(), |name| format!(" (`{name}`)"));
        let text = format!("plugin `{plugin}` has not returned from {call}{what} for {limit} s: the run ends here");
        let mut fault = Fault::new(FaultKind::Stuck, text);
        (fault.plugin, fault.object) = (Some(plugin.clone()), object.clone());
        fault.help = Some("if it is merely slow, raise the limit with `--watchdog S`; 0 means no limit".into());
        let place = object.as_ref().map_or(String::new(), |o| format!(" [{o}]"));
        report::err!("error[{}]: {}{place} ({})", fault.code, fault.message, fault.help.as_deref().unwrap_or_default());
        leave(self.close(&fault));
    }

    /// Writes all that was held back, with the fault that ends the run; the exit code. Nothing is waited for that a thread
    /// which never goes on may hold.
    pub fn close(&self, fault: &Fault) -> i32 {
        let Some(known) = peek(&self.known) else { return 1 };
        for file in &known.files {
            // The stuck thread is in a plugin, so no line is half-written; if it is, the file ends there.
            if let Some(mut file) = peek(file) {
                let _ = file.flush();
            }
        }
        // A run that takes keys has changed the terminal.
        if crossterm::terminal::is_raw_mode_enabled().unwrap_or(false) {
            let _ = crossterm::terminal::disable_raw_mode();
        }
        let lines = known.lines.as_ref().map(Lines::take_from_outside).unwrap_or_default();
        lines.iter().for_each(|l| tell(l, known.prints));
        if known.json && known.began && !known.told {
            let errors: Vec<&Fault> = known.faults.iter().chain([fault]).collect();
            let out = json!({ "steps": known.steps, "sim_time_s": known.time, "objects": {}, "errors": errors });
            report::out!("{}", serde_json::to_string_pretty(&out).unwrap_or_default());
        }
        let _ = std::io::stdout().flush();
        if known.began { 1 } else { 2 }
    }
}

/// A line as runs print it.
fn tell(line: &LogLine, prints: bool) {
    match line.level {
        TATU_LOG_ERROR => report::err!("error{}: {}", line.code.map_or(String::new(), |c| format!("[{c}]")), line.text),
        TATU_LOG_WARNING => report::err!("warning: {}", line.text),
        TATU_LOG_DEBUG | TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => {}
        _ if prints => report::out!("{}", line.text),
        _ => report::err!("{}", line.text),
    }
}

/// Ends the process at once: what libraries want done at exit could hang just as well.
#[cfg(unix)]
pub fn leave(code: i32) {
    // SAFETY: does not return, and runs nothing of this process.
    unsafe { libc::_exit(code) }
}
#[cfg(not(unix))]
pub fn leave(code: i32) {
    std::process::exit(code)
}
