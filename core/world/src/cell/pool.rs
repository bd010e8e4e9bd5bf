//! The thread pool in which a world computes.

use std::{cell::RefCell, sync::Arc};

use rayon::{ThreadPool, ThreadPoolBuilder};
use tatu_errors::{Error, Result};

thread_local! {
    /// The pool that this thread belongs to, once it has been needed.
    static OWN: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Returns a pool of `threads` threads for a world of the calling thread. That thread is one of them: it does its share
/// of the work without a handover, and with warm caches.
///
/// A world never computes in a pool of several threads that a different thread also uses: the engine blocks until its
/// tasks in the pool are done, and two worlds blocking in one pool of two threads would deadlock. Single-threaded
/// worlds of a thread never compute at the same time, so they share its pool. A thread can belong to only one pool for
/// its lifetime; if it already belongs to a pool of a different size, a pool of other threads is created.
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
