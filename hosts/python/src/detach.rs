//! Calls functions without the interpreter's lock, even while the interpreter is exiting.
//!
//! Before version 3.14, CPython ends a daemon thread that requests the lock during finalization with `pthread_exit`.
//! PyO3 stops the unwinding that this starts and suspends the thread, but this works only with the unwinder of the C
//! library. The module of the wheel contains LLVM's unwinder, in which the process crashes. Therefore the package
//! registers [`finish`] with Python's `atexit`; once it has been called, a thread that would request the lock is
//! suspended until the process ends, as in CPython 3.14.

use std::{
    process,
    sync::{
        OnceLock,
        atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering::SeqCst},
    },
    thread::{self, ThreadId},
    time::{Duration, Instant},
};

use pyo3::prelude::*;

/// Number of threads that have released the lock and will request it again.
static DETACHED_THREADS: AtomicUsize = AtomicUsize::new(0);
/// Whether the interpreter is exiting.
static EXITING: AtomicBool = AtomicBool::new(false);
/// The thread that finalizes the interpreter; it is never suspended.
static FINALIZING_THREAD: OnceLock<ThreadId> = OnceLock::new();
/// The process that loaded the module.
static LOADING_PROCESS: AtomicU32 = AtomicU32::new(0);

/// Maximum time for which the exit of the interpreter waits for calls that are still running.
const EXIT_TIMEOUT: Duration = Duration::from_secs(10);

/// Calls `f` without the interpreter's lock. Does not return if the interpreter is exiting, except on the thread that
/// finalizes it.
pub fn run_detached<T: Send>(py: Python<'_>, f: impl FnOnce() -> T + Send) -> T {
    // The thread is counted until it holds the lock again.
    let _counted = DetachedGuard::new();
    py.detach(|| {
        suspend_if_exiting();
        let result = f();
        suspend_if_exiting();
        result
    })
}

struct DetachedGuard;

impl DetachedGuard {
    fn new() -> Self {
        DETACHED_THREADS.fetch_add(1, SeqCst);
        DetachedGuard
    }
}

impl Drop for DetachedGuard {
    fn drop(&mut self) {
        DETACHED_THREADS.fetch_sub(1, SeqCst);
    }
}

fn suspend_if_exiting() {
    if !EXITING.load(SeqCst) || FINALIZING_THREAD.get() == Some(&thread::current().id()) {
        return;
    }
    // The thread never returns, so its `DetachedGuard` is never dropped.
    DETACHED_THREADS.fetch_sub(1, SeqCst);
    loop {
        thread::park();
    }
}

/// Records the process that loads the module.
pub fn record_process() {
    LOADING_PROCESS.store(process::id(), SeqCst);
}

/// Waits until no other thread will request the interpreter's lock. Must be called as the interpreter exits, by the
/// thread that finalizes it.
#[pyfunction]
pub fn finish(py: Python<'_>) {
    if LOADING_PROCESS.load(SeqCst) != process::id() {
        // In a forked child process, the threads that were counted do not exist.
        return;
    }
    let _ = FINALIZING_THREAD.set(thread::current().id());
    EXITING.store(true, SeqCst);
    py.detach(|| {
        let since = Instant::now();
        while DETACHED_THREADS.load(SeqCst) > 0 && since.elapsed() < EXIT_TIMEOUT {
            thread::sleep(Duration::from_millis(1));
        }
    });
}
