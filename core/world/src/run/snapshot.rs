//! Writing the state of a world, and going on from it.

use tatu_errors::{Error, Result};

use super::World;
use crate::state::{self, Snapshot};

impl World {
    /// Everything that decides the future, at the boundary between two steps; what could not be captured is named in
    /// the head. The run, which continues, is not affected.
    pub fn snapshot(&self) -> Result<Snapshot> {
        state::take(self.cell())
    }

    /// Makes a world that has just been made of the snapshot's document go on from the snapshot's step.
    ///
    /// An incomplete snapshot is refused, unless `allow_partial`: then what it lacks is as at the start of a run. After
    /// a failure the world is half one and half the other: drop it.
    pub fn restore(&self, snapshot: &Snapshot, allow_partial: bool) -> Result {
        let cell = self.cell();
        state::restore::check(cell, snapshot, allow_partial)?;
        self.start_silently();
        state::restore::go_on(cell, snapshot)
    }

    /// Runs a world that has just been made to the snapshot's step, without repeating what it reported the first time,
    /// and compares the state hash.
    pub fn replay(&self, snapshot: &Snapshot) -> Result {
        let cell = self.cell();
        snapshot.check(&cell.model.document, &cell.model.registry)?;
        self.feed(state::restore::records(snapshot)?.into());
        self.start();
        while self.steps() < snapshot.head.step && !self.stop_requested() && self.step() {
            self.take_lines();
        }
        self.take_lines();
        let hash = self.hash().total;
        if hash == snapshot.head.hash {
            // From here on the run is its own.
            cell.run.outside.replay.take();
            return Ok(());
        }
        let text = format!(
            "the replay reached another state at step {}: hash {hash:016x}, then {:016x}",
            snapshot.head.step, snapshot.head.hash
        );
        Err(Error::new("E504", text)
            .help("something in the run depends on more than scene and seed: files that scripts read, or a plugin"))
    }
}
