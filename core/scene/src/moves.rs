//! A list of the shapes that have moved, which saves its readers from visiting all shapes.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The shapes that have moved, in order; each is listed at most once between two reads.
#[derive(Debug, Default)]
pub struct Moves {
    list: Vec<u32>,
    /// Number of entries that were dropped before the first one of the current list.
    gone: u64,
    /// For each slot, the number of entries up to and including its last one, or 0 if it has no entry.
    noted: Vec<u64>,
    /// The position up to which the list has been read. A shape that is listed after this position need not be listed
    /// again. Atomic, because documents, which contain a scene for their names, are shared by worlds on several
    /// threads.
    seen: AtomicU64,
}

impl Clone for Moves {
    fn clone(&self) -> Self {
        let Moves { list, gone, noted, seen } = self;
        Moves { list: list.clone(), gone: *gone, noted: noted.clone(), seen: seen.load(Relaxed).into() }
    }
}

impl Moves {
    /// Records that the shape in a slot has moved.
    pub fn note(&mut self, slot: u32) {
        let at = slot as usize;
        if self.noted.len() <= at {
            self.noted.resize(at + 1, 0);
        }
        if self.noted[at] > self.seen.load(Relaxed) {
            return;
        }
        // A reader that is this far behind must visit all objects instead.
        if self.list.len() >= FEWEST.max(2 * self.noted.len()) {
            self.gone += self.list.len() as u64;
            self.list.clear();
        }
        self.list.push(slot);
        self.noted[at] = self.gone + self.list.len() as u64;
    }

    /// Returns the shapes that have moved since the position `last` of the list, or `None` if the list no longer goes
    /// back that far. `last` is set to the current position, and must only be used with the same scene.
    pub fn since(&self, last: &mut u64) -> Option<&[u32]> {
        let end = self.gone + self.list.len() as u64;
        self.seen.store(end, Relaxed);
        let from = std::mem::replace(last, end);
        self.list.get(usize::try_from(from.checked_sub(self.gone)?).ok()?..)
    }
}

/// Length below which the list is never cleared.
const FEWEST: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_follower_finds_what_moved_since_its_look() {
        let (mut moves, mut a, mut b) = (Moves::default(), 0, 0);
        moves.note(3);
        moves.note(3);
        moves.note(5);
        assert_eq!(moves.since(&mut a), Some(&[3, 5][..]), "each once between two reads");
        moves.note(3);
        assert_eq!(moves.since(&mut a), Some(&[3][..]));
        assert_eq!(moves.since(&mut a), Some(&[][..]));
        assert_eq!(moves.since(&mut b), Some(&[3, 5, 3][..]), "readers do not affect each other");
    }

    #[test]
    fn a_follower_that_slept_is_told_to_look_at_all() {
        let (mut moves, mut awake, mut asleep) = (Moves::default(), 0, 0);
        moves.since(&mut asleep);
        for _ in 0..10 * FEWEST {
            moves.note(1);
            assert_eq!(moves.since(&mut awake), Some(&[1][..]));
        }
        assert_eq!(moves.since(&mut asleep), None);
        moves.note(1);
        assert_eq!(moves.since(&mut asleep), Some(&[1][..]));
        assert!(moves.list.len() <= FEWEST);
    }
}
