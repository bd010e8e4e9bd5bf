//! Jobs that the threads of a frame take one after the other.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// How often a thread looks whether another is done, some tenths of a millisecond in all.
const LOOKS: usize = 4000;

/// Bits of a count, and the lower one.
const HALF: u32 = 32;
const FRONT: u64 = (1 << HALF) - 1;

/// Jobs, and what was made of them.
pub(super) struct Jobs<J, T> {
    all: Vec<(J, OnceLock<T>)>,
    /// How many have been taken from the front; in the upper half, from the back.
    taken: AtomicU64,
}

impl<J, T> Jobs<J, T> {
    pub fn new(all: impl IntoIterator<Item = J>) -> Self {
        Self { all: all.into_iter().map(|job| (job, OnceLock::new())).collect(), taken: AtomicU64::new(0) }
    }

    /// Does the first or the last that nobody has taken; `false`: there is none. Who takes the same ones in each frame has
    /// still in its cache what they need.
    pub fn take(&self, last: bool, make: impl Fn(&J) -> T) -> bool {
        let mut taken = self.taken.load(Ordering::Relaxed);
        loop {
            let (front, back) = ((taken & FRONT) as usize, (taken >> HALF) as usize);
            let Some(rest) = (self.all.len() - back).checked_sub(front + 1) else { return false };
            let (at, next) = if last { (front + rest, taken + (1 << HALF)) } else { (front, taken + 1) };
            match self.taken.compare_exchange_weak(taken, next, Ordering::Relaxed, Ordering::Relaxed) {
                Ok(_) => {
                    let (job, made) = &self.all[at];
                    let _ = made.set(make(job));
                    return true;
                }
                Err(now) => taken = now,
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_job_is_taken_once_from_either_end() {
        for count in [0, 1, 2, 7, 500] {
            let jobs = Jobs::<usize, usize>::new(0..count);
            let done: Vec<AtomicU64> = (0..count).map(|_| AtomicU64::new(0)).collect();
            let make = |job: &usize| {
                done[*job].fetch_add(1, Ordering::Relaxed);
                2 * job
            };
            let from_ends: Vec<usize> = std::thread::scope(|scope| {
                let (jobs, make) = (&jobs, &make);
                let threads = [false, true, true].map(|last| {
                    scope.spawn(move || {
                        std::iter::repeat_with(|| jobs.take(last, make)).take_while(|took| *took).count()
                    })
                });
                threads.into_iter().map(|thread| thread.join().unwrap()).collect()
            });
            assert_eq!(from_ends.iter().sum::<usize>(), count);
            assert!(done.iter().all(|n| n.load(Ordering::Relaxed) == 1));
            assert!(jobs.made(&make).all(|(job, made)| *made == 2 * job));
        }
    }
}
