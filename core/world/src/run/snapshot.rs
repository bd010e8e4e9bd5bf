//! Saves and restores the state of a world.

use tatu_errors::{Error, Result};

use super::World;
use crate::state::{self, Snapshot};

impl World {
    /// Captures all state that determines the future of the run, between two steps. The header lists the instances that
    /// could not be saved. The run is not affected.
    pub fn snapshot(&self) -> Result<Snapshot> {
        state::take_snapshot(self.cell())
    }

    /// Restores a snapshot in a new world of the snapshot's document.
    ///
    /// An incomplete snapshot is refused unless `allow_partial` is set, in which case the missing parts have their
    /// state at the start of a run. If restoring fails, the world is in an inconsistent state and must be dropped.
    pub fn restore(&self, snapshot: &Snapshot, allow_partial: bool) -> Result {
        let cell = self.cell();
        state::restore::check(cell, snapshot, allow_partial)?;
        self.start_silently();
        state::restore::restore_world(cell, snapshot)
    }

    /// Runs a new world up to the snapshot's step. Fails with E504 if the state hash then differs from the snapshot's.
    /// The log lines of these steps are discarded, because the original run has reported them.
    pub fn replay(&self, snapshot: &Snapshot) -> Result {
        let cell = self.cell();
        snapshot.check(&cell.model.document, &cell.model.registry)?;
        self.attach_log(state::restore::records(snapshot)?.into());
        self.start();
        while self.steps() < snapshot.head.step && !self.stop_requested() && self.step() {
            self.take_lines();
        }
        self.take_lines();
        let hash = self.hash().total;
        if hash == snapshot.head.hash {
            // From here on, the run no longer follows the log.
            cell.run.connections.record.replay.take();
            return Ok(());
        }
        let text = format!(
            "the replay reached a different state at step {}: its hash is {hash:016x}, but the snapshot has {:016x}",
            snapshot.head.step, snapshot.head.hash
        );
        Err(Error::new("E504", text).help(
            "the run depends on something besides the scene and the seed: a file that a script reads, or a plugin",
        ))
    }
}
