//! Passes jobs to a thread, and waits until they are done.
//!
//! A step of a world takes 10 to 200 us, and waking a thread about 10 us. A waiting thread therefore spins for a while
//! before it sleeps, provided that no more threads spin or work than there are processors.

use std::{
    cell::UnsafeCell,
    sync::{
        Mutex, OnceLock, PoisonError,
        atomic::{
            AtomicU32, AtomicUsize,
            Ordering::{Acquire, Relaxed, Release},
        },
    },
    thread::{self, Thread},
    time::{Duration, Instant},
};

/// No work has been posted.
const FREE: u32 = 0;
/// Work has been posted; the thread has not finished it yet.
const POSTED: u32 = 1;
/// The work is done, and the caller may continue.
const DONE: u32 = 2;

/// Longest time for which a thread spins for new work, or a caller for the completion of its work, before it sleeps.
const MAX_SPIN_TIME: Duration = Duration::from_micros(300);

/// Number of threads in this process that spin in [`spin_then_park`] or run a job of a [`JobQueue`].
static BUSY_THREADS: AtomicUsize = AtomicUsize::new(0);

fn processors() -> usize {
    static COUNT: OnceLock<usize> = OnceLock::new();
    *COUNT.get_or_init(|| thread::available_parallelism().map_or(1, usize::from))
}

/// Waits until `ready` returns true: spins for a while, then parks the thread.
fn spin_then_park(ready: impl Fn() -> bool) {
    if BUSY_THREADS.fetch_add(1, Relaxed) < processors() {
        let since = Instant::now();
        while BUSY_THREADS.load(Relaxed) <= processors() && since.elapsed() < MAX_SPIN_TIME {
            for _ in 0..64 {
                if ready() {
                    BUSY_THREADS.fetch_sub(1, Relaxed);
                    return;
                }
                std::hint::spin_loop();
            }
        }
    }
    BUSY_THREADS.fetch_sub(1, Relaxed);
    while !ready() {
        thread::park();
    }
}

/// A job for a thread that owns a `T`.
type ThreadJob<'a, T> = dyn FnMut(&mut T) + Send + 'a;

/// A posted job, and the thread that waits for it.
struct QueuedJob<T> {
    /// The job; `None` ends [`JobQueue::serve`].
    job: Option<*mut ThreadJob<'static, T>>,
    /// The thread that waits until the job is done.
    caller: Thread,
}

/// A channel through which callers hand jobs to one thread.
pub struct JobQueue<T> {
    state: AtomicU32,
    /// Written by the caller while `FREE`, read by the thread while `POSTED`.
    posted: UnsafeCell<Option<QueuedJob<T>>>,
    /// Held by the caller from the moment when it posts a job until the job is done.
    caller_lock: Mutex<()>,
}

// SAFETY: `posted` is used by one thread at a time, as its comment states; `state` transfers it between threads. The
// job is `Send`.
unsafe impl<T> Send for JobQueue<T> {}
// SAFETY: as for `Send`; in addition, the mutex `caller_lock` admits only one caller at a time.
unsafe impl<T> Sync for JobQueue<T> {}

impl<T> JobQueue<T> {
    /// Creates a queue without any posted work.
    pub fn new() -> Self {
        JobQueue { state: AtomicU32::new(FREE), posted: UnsafeCell::new(None), caller_lock: Mutex::new(()) }
    }

    /// Runs posted jobs on the calling thread until [`end`](Self::end) is called.
    pub fn serve(&self, owned: &mut T) {
        loop {
            spin_then_park(|| self.state.load(Acquire) == POSTED);
            // SAFETY: while `POSTED`, only this thread uses `posted`.
            let Some(QueuedJob { job, caller }) = (unsafe { (*self.posted.get()).take() }) else { continue };
            if let Some(job) = job {
                BUSY_THREADS.fetch_add(1, Relaxed);
                // SAFETY: the caller keeps the job alive until it sees `DONE`, and does not use it before then.
                unsafe { (*job)(owned) };
                BUSY_THREADS.fetch_sub(1, Relaxed);
            }
            self.state.store(DONE, Release);
            caller.unpark();
            if job.is_none() {
                return;
            }
        }
    }

    /// Runs a job on the thread, and waits until it is done. The job must not panic.
    pub fn call(&self, thread: &Thread, job: &mut ThreadJob<'_, T>) {
        self.post(thread, Some(job)).finish();
    }

    /// Makes the thread return from [`serve`](Self::serve), and waits for it.
    pub fn end(&self, thread: &Thread) {
        self.post(thread, None).finish();
    }

    /// Posts a job without waiting for it; `None` makes the thread return from [`serve`](Self::serve).
    pub fn post<'a>(&'a self, thread: &Thread, job: Option<&'a mut ThreadJob<'_, T>>) -> PostedJob<'a, T> {
        let guard = self.caller_lock.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: only the lifetime changes. `PostedJob` borrows the job, and dropping it waits until the thread is
        // done with the job.
        let job =
            job.map(|job| unsafe { std::mem::transmute::<*mut ThreadJob<'_, T>, *mut ThreadJob<'static, T>>(job) });
        // SAFETY: this caller holds `caller_lock` and the state is `FREE`, so no other thread uses `posted`.
        unsafe { *self.posted.get() = Some(QueuedJob { job, caller: thread::current() }) };
        self.state.store(POSTED, Release);
        thread.unpark();
        PostedJob { queue: self, _guard: guard }
    }
}

/// A posted job. Dropping it waits until the job is done.
#[must_use]
pub struct PostedJob<'a, T> {
    queue: &'a JobQueue<T>,
    _guard: std::sync::MutexGuard<'a, ()>,
}

impl<T> PostedJob<'_, T> {
    /// Waits until the work is done.
    pub fn finish(self) {}
}

impl<T> Drop for PostedJob<'_, T> {
    fn drop(&mut self) {
        spin_then_park(|| self.queue.state.load(Acquire) == DONE);
        self.queue.state.store(FREE, Release);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn concurrent_callers_are_serialized() {
        let line = Arc::new(JobQueue::<u64>::new());
        let served = line.clone();
        let thread = thread::spawn(move || {
            let mut sum = 0;
            served.serve(&mut sum);
            sum
        });
        thread::scope(|scope| {
            for part in 0..4 {
                let (line, thread) = (&line, thread.thread());
                scope.spawn(move || {
                    for n in 0..1000 {
                        let mut seen = 0;
                        line.call(thread, &mut |sum| {
                            *sum += part * 1000 + n;
                            seen = *sum;
                        });
                        assert!(seen >= part * 1000 + n);
                    }
                });
            }
        });
        line.end(thread.thread());
        assert_eq!(thread.join().unwrap(), (0..4000).sum::<u64>());
    }
}
