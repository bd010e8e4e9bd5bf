//! Snapshots of a run: `--snapshot-at T FILE` and `--from FILE`.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use tatu_core::{
    World,
    document::Document,
    errors::{Error, Result},
    plugins::Registry,
    state::{Snapshot, UnsavedInstance},
};
use tatu_terminal::report;

/// The requested snapshots of a run.
pub struct SnapshotRequests {
    /// Simulation time, s, and file, ordered by time.
    pending: Vec<(f64, PathBuf)>,
}

impl SnapshotRequests {
    /// Parses the values of all `--snapshot-at` options, two per option.
    pub fn parse(values: &[String]) -> Result<Self> {
        let mut pending = Vec::new();
        for pair in values.chunks(2) {
            let [time, file] = pair else { continue };
            let number = time.parse::<f64>().ok().filter(|t| t.is_finite() && *t >= 0.0);
            let time = number.ok_or_else(|| {
                Error::new("E102", format!("--snapshot-at: `{time}` is not a time"))
                    .expected("seconds of simulated time, at least 0, then a file")
            })?;
            pending.push((time, PathBuf::from(file)));
        }
        pending.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(SnapshotRequests { pending })
    }

    /// Writes the snapshots that are due. Must be called between two steps. Prints a note about state that could not be
    /// captured; returns errors about files that could not be written.
    pub fn write(&mut self, world: &World) -> Vec<Error> {
        let mut failed = Vec::new();
        while self.pending.first().is_some_and(|(time, _)| world.time() >= time - 1e-9) {
            let (_, path) = self.pending.remove(0);
            match world.snapshot().and_then(|s| s.write(&path).map(|()| s)) {
                Ok(s) if s.is_complete() => {}
                Ok(s) => {
                    report::note(&format!("{} will be restored by replay: {}", path.display(), reasons(&s.head.missed)))
                }
                Err(e) => failed.push(e),
            }
        }
        failed
    }

    /// Returns an error for each snapshot whose time was not reached.
    pub fn unwritten(&self, world: &World) -> Vec<Error> {
        let tell = |(time, path): &(f64, PathBuf)| {
            let text = format!("{} was not written: the run ended at {} s", path.display(), world.time());
            Error::new("E505", text)
                .expected(format!("a run of at least {time} s"))
                .help("run longer, with `--seconds`")
        };
        self.pending.iter().map(tell).collect()
    }
}

/// Calls `run`, which continues from a snapshot. The parts of a forged snapshot can be inconsistent in ways that are
/// detected only when they are used, so a panic is reported as an error of the file.
pub fn catch_panic<T>(path: &Path, run: impl FnOnce() -> Result<T>) -> Result<T> {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
    std::panic::set_hook(usual);
    done.unwrap_or_else(|payload| {
        let why = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
        let text = format!(
            "{}: the snapshot cannot be resumed: its parts are inconsistent ({})",
            path.display(),
            why.unwrap_or("no details are known")
        );
        Err(Error::new("E501", text)
            .help("write the snapshot again; if that does not help, this is a bug in the program"))
    })
}

/// Creates a world that continues from a snapshot. The state is restored or, if the snapshot is incomplete, recreated
/// by a replay.
pub fn resume(path: &Path, document: Arc<Document>, registry: Arc<Registry>, threads: usize) -> Result<World> {
    let snapshot = Snapshot::read(path)?;
    snapshot.check(&document, &registry)?;
    let new = || World::with_threads(document.clone(), registry.clone(), threads);
    let why = if snapshot.is_complete() {
        let world = new()?;
        match world.restore(&snapshot, false) {
            Ok(()) => return Ok(world),
            Err(e) => e.text,
        }
    } else {
        reasons(&snapshot.head.missed)
    };
    let world = new()?;
    world.replay(&snapshot)?;
    report::note(&format!("restored by replay: {why}"));
    Ok(world)
}

/// Returns the first reason, and the number of further reasons.
fn reasons(missed: &[UnsavedInstance]) -> String {
    match missed {
        [] => String::new(),
        [one] => one.to_string(),
        [first, rest @ ..] => format!("{first} (and {} more)", rest.len()),
    }
}
