//! Threads that draw the segments of an image, two each.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::jobs::look_for;
use super::work::Work;

/// Work is waited for so many times as long as what another thread is about to do.
const PATIENCE: usize = 8;

/// Makes an image with the calling thread, which leads, and `helpers` others of rayon's current pool; which of them draws which
/// band does not change the image.
///
/// The others come at once: they `assist`, each by its number, as long as there is something to be made ready, and wait for
/// the `work` that `lead` gives.
pub(super) fn run<'a, const ID: bool>(
    helpers: usize,
    work: &OnceLock<Vec<Work<'a, ID>>>,
    assist: &(impl Fn(usize) -> bool + Sync),
    lead: impl FnOnce() -> &'a [Work<'a, ID>] + Send,
) {
    if helpers == 0 {
        return help(lead(), 0);
    }
    let busy = &AtomicUsize::new(helpers);
    rayon::in_place_scope(|scope| {
        for helper in 1..=helpers {
            scope.spawn(move |_| {
                come(work, assist, helper);
                busy.fetch_sub(1, Ordering::Release);
            });
        }
        let work = lead();
        // Who has waited for too long has gone.
        let gone = helpers - busy.load(Ordering::Acquire).min(helpers);
        busy.fetch_add(gone, Ordering::Relaxed);
        for helper in 1..=gone {
            scope.spawn(move |_| {
                help(work, helper);
                busy.fetch_sub(1, Ordering::Release);
            });
        }
        help(work, 0);
        look_for(|| busy.load(Ordering::Acquire) == 0);
    });
}

/// A thread that helps.
fn come<const ID: bool>(work: &OnceLock<Vec<Work<'_, ID>>>, assist: &impl Fn(usize) -> bool, helper: usize) {
    for _ in 0..PATIENCE {
        look_for(|| {
            while assist(helper) {}
            work.get().is_some()
        });
        if let Some(work) = work.get() {
            return help(work, helper);
        }
        std::thread::yield_now();
    }
    if let Some(work) = work.get() {
        help(work, helper);
    }
}

/// Draws wherever a thread is missing, beginning with the thread's own segment.
fn help<const ID: bool>(work: &[Work<'_, ID>], thread: usize) {
    for turn in thread..thread + work.len() {
        // As many threads as there are segments come from below, the next from above.
        work[turn % work.len()].help(turn / work.len() % 2 == 1);
    }
}
