//! The threads that a world computes with.

use std::{cell::RefCell, sync::Arc};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, Result};

thread_local! {
    /// A pool that consists of this thread alone; made when first needed.
    static ALONE: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// A pool of `threads` threads for one world.
///
/// A world never computes in another world's pool of several threads: the engine waits there for tasks that it gave to
/// the pool, and two worlds that wait in one pool of two would wait for ever. Worlds of one thread each share a pool
/// that is the calling thread itself, so that nothing is handed from thread to thread.
pub(super) fn of(threads: usize) -> Result<Arc<ThreadPool>> {
    let failed = |e| Error::new("E401", format!("cannot start {threads} threads: {e}"));
    if threads > 1 {
        return ThreadPoolBuilder::new().num_threads(threads).build().map(Arc::new).map_err(failed);
    }
    ALONE.with_borrow_mut(|alone| {
        if let Some(pool) = alone {
            return Ok(pool.clone());
        }
        // A thread that belongs to another pool cannot become one of its own: then a thread is started.
        let own = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        let pool = own.or_else(|_| ThreadPoolBuilder::new().num_threads(1).build()).map(Arc::new).map_err(failed)?;
        *alone = Some(pool.clone());
        Ok(pool)
    })
}
