//! Work that the calling thread shares with those of a pool.

use std::sync::{Mutex, PoisonError};

/// Does all jobs: the calling thread begins at once, and the threads of a pool join as they wake up. Which thread does
/// which job is left to chance, so jobs must not depend on one another.
///
/// Handing all to the pool instead, as `install` does, costs a sleep and a wake-up of the caller.
pub(super) fn share<T: Send>(
    pool: &rayon::ThreadPool,
    jobs: impl Iterator<Item = T> + Send,
    work: impl Fn(T) + Send + Sync,
) {
    let jobs = Mutex::new(jobs);
    let help = || {
        // No job runs while the lock is held: a panic in one leaves the rest as it was.
        while let Some(job) = { jobs.lock().unwrap_or_else(PoisonError::into_inner).next() } {
            work(job);
        }
    };
    pool.in_place_scope(|scope| {
        for _ in 1..pool.current_num_threads() {
            scope.spawn(|_| help());
        }
        help();
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn each_job_is_done_once() {
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let done: Vec<AtomicUsize> = (0..100).map(|_| AtomicUsize::new(0)).collect();
            let count = |i: usize| {
                done[i].fetch_add(1, Ordering::Relaxed);
            };
            share(&pool, 0..100, count);
            assert!(done.iter().all(|n| n.load(Ordering::Relaxed) == 1));
        }
    }
}
