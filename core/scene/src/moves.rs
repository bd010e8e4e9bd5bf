//! A list of the shapes that have moved, which saves its readers from visiting all shapes.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The shapes that have moved, in order; each is listed at most once between two reads.
#[derive(Debug, Default)]
pub struct MoveLog {
    list: Vec<u32>,
    /// Number of entries that were dropped before the first one of the current list.
    dropped: u64,
    /// For each slot, the number of entries up to and including its last one, or 0 if it has no entry.
    last_entry: Vec<u64>,
    /// The position up to which the list has been read. A shape that is listed after this position need not be listed
    /// again. Atomic, because documents, which contain a scene for their names, are shared by worlds on several
    /// threads.
    seen: AtomicU64,
}

impl Clone for MoveLog {
    fn clone(&self) -> Self {
        let MoveLog { list, dropped: gone, last_entry: noted, seen } = self;
        MoveLog { list: list.clone(), dropped: *gone, last_entry: noted.clone(), seen: seen.load(Relaxed).into() }
    }
}

impl MoveLog {
    /// Records that the shape in a slot has moved.
    pub fn record(&mut self, slot: u32) {
        let at = slot as usize;
        if self.last_entry.len() <= at {
            self.last_entry.resize(at + 1, 0);
        }
        if self.last_entry[at] > self.seen.load(Relaxed) {
            return;
        }
        // A reader that is this far behind must visit all objects instead.
        if self.list.len() >= MIN_LENGTH_TO_CLEAR.max(2 * self.last_entry.len()) {
            self.dropped += self.list.len() as u64;
            self.list.clear();
        }
        self.list.push(slot);
        self.last_entry[at] = self.dropped + self.list.len() as u64;
    }

    /// Returns the shapes that have moved since the position `last` of the list, or `None` if the list no longer goes
    /// back that far. `last` is set to the current position, and must only be used with the same scene.
    pub fn since(&self, last: &mut u64) -> Option<&[u32]> {
        let end = self.dropped + self.list.len() as u64;
        self.seen.store(end, Relaxed);
        let from = std::mem::replace(last, end);
        self.list.get(usize::try_from(from.checked_sub(self.dropped)?).ok()?..)
    }
}

/// Length below which the list is never cleared.
const MIN_LENGTH_TO_CLEAR: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_get_the_moves_since_their_last_read() {
        let (mut moves, mut a, mut b) = (MoveLog::default(), 0, 0);
        moves.record(3);
        moves.record(3);
        moves.record(5);
        assert_eq!(moves.since(&mut a), Some(&[3, 5][..]), "each once between two reads");
        moves.record(3);
        assert_eq!(moves.since(&mut a), Some(&[3][..]));
        assert_eq!(moves.since(&mut a), Some(&[][..]));
        assert_eq!(moves.since(&mut b), Some(&[3, 5, 3][..]), "readers do not affect each other");
    }

    #[test]
    fn slow_reader_must_visit_all_objects() {
        let (mut moves, mut awake, mut asleep) = (MoveLog::default(), 0, 0);
        moves.since(&mut asleep);
        for _ in 0..10 * MIN_LENGTH_TO_CLEAR {
            moves.record(1);
            assert_eq!(moves.since(&mut awake), Some(&[1][..]));
        }
        assert_eq!(moves.since(&mut asleep), None);
        moves.record(1);
        assert_eq!(moves.since(&mut asleep), Some(&[1][..]));
        assert!(moves.list.len() <= MIN_LENGTH_TO_CLEAR);
    }
}
