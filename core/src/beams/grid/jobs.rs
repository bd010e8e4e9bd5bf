//! Jobs that the threads of a frame take one after the other.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How often a thread looks whether another is done, some tenths of a millisecond in all.
const LOOKS: usize = 4000;

/// Jobs, and what was made of them.
pub(super) struct Jobs<J, T> {
    all: Vec<(J, OnceLock<T>)>,
    /// The first that nobody has taken.
    next: AtomicUsize,
}

impl<J, T> Jobs<J, T> {
    pub fn new(all: impl IntoIterator<Item = J>) -> Self {
        Self { all: all.into_iter().map(|job| (job, OnceLock::new())).collect(), next: AtomicUsize::new(0) }
    }

    /// Does one that nobody has taken; `false`: there is none.
    pub fn take(&self, make: impl Fn(&J) -> T) -> bool {
        // Counting on would take the line from the others each time they look.
        if self.next.load(Ordering::Relaxed) >= self.all.len() {
            return false;
        }
        let Some((job, made)) = self.all.get(self.next.fetch_add(1, Ordering::Relaxed)) else { return false };
        let _ = made.set(make(job));
        true
    }

    /// All, with what was made of them, once all are taken. What another thread is about to be done with is waited for; if
    /// it takes long, it is done here once more.
    pub fn made(&self, make: impl Fn(&J) -> T) -> impl Iterator<Item = (&J, &T)> {
        self.all.iter().map(move |(job, made)| {
            look_for(|| made.get().is_some());
            (job, made.get_or_init(|| make(job)))
        })
    }
}

/// Waits for what another thread is about to do, for a while: to sleep and be woken would take longer.
pub(super) fn look_for(mut done: impl FnMut() -> bool) {
    for _ in 0..LOOKS {
        if done() {
            break;
        }
        std::hint::spin_loop();
    }
}
