//! A lock that lets one thread at a time start or end plugins, and create or destroy their instances.

use parking_lot::{ReentrantMutex, ReentrantMutexGuard};

static SETUP_LOCK: ReentrantMutex<()> = ReentrantMutex::new(());

/// Acquires the lock, which implements the guarantee of the tag `[setup]` in the header. The lock is reentrant, because
/// a plugin can cause instances to be created while one of its own instances is being created.
pub fn lock_setup() -> ReentrantMutexGuard<'static, ()> {
    SETUP_LOCK.lock()
}
