//! The threads that a world computes with.

use std::{cell::RefCell, sync::Arc};

use rayon::{ThreadPool, ThreadPoolBuilder};
use tatu_errors::{Error, Result};

thread_local! {
    /// The pool that this thread is one of, once it was needed.
    static OWN: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// A pool of `threads` threads for a world of the calling thread, which is one of them: nothing is handed from thread to
/// thread that it could do itself, and what it has in its caches stays of use.
///
/// A world never computes in a pool of several threads that another thread uses: the engine waits there for tasks that
/// it gave to the pool, and two worlds that wait in one pool of two would wait for ever. Worlds of one thread never
/// compute at once, and share its pool. A thread belongs to one pool for ever: where it is one of another, a pool of
/// other threads is made.
pub(crate) fn of(threads: usize) -> Result<Arc<ThreadPool>> {
    let threads = threads.max(1);
    OWN.with_borrow_mut(|own| {
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
