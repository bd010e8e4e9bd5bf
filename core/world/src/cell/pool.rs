//! The thread pool that a world uses.

use std::{cell::RefCell, sync::Arc};

use rayon::{ThreadPool, ThreadPoolBuilder};
use tatu_errors::{Error, Result};

thread_local! {
    /// The pool to which this thread belongs, created at the first use.
    static THREAD_POOL: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Returns a pool of `threads` threads for a world of the calling thread. The calling thread is one of them, so it does
/// its share of the work without a context switch, and with warm caches.
///
/// Worlds of different threads never share a pool of several threads, because the engine blocks until its tasks in the
/// pool are done: two worlds that block in one pool of two threads would deadlock. The worlds of one thread never
/// compute at the same time, so they share its pool. A thread can belong to only one pool during its lifetime. If it
/// already belongs to a pool of a different size, a new pool without the calling thread is created.
pub(crate) fn of(threads: usize) -> Result<Arc<ThreadPool>> {
    let threads = threads.max(1);
    THREAD_POOL.with_borrow_mut(|own| {
        if let Some(pool) = own.as_ref().filter(|pool| pool.current_num_threads() == threads) {
            return Ok(pool.clone());
        }
        let build = || ThreadPoolBuilder::new().num_threads(threads);
        if own.is_none()
            && let Ok(pool) = build().use_current_thread().build()
        {
            return Ok(own.insert(Arc::new(pool)).clone());
        }
        let failed = |e| Error::new("E401", format!("cannot start {threads} threads: {e}"));
        build().build().map(Arc::new).map_err(failed)
    })
}
