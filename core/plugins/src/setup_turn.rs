//! Whose turn it is to start or end plugins, and to make or end their instances.

use parking_lot::{ReentrantMutex, ReentrantMutexGuard};

static TURN: ReentrantMutex<()> = ReentrantMutex::new(());

/// Waits until no other thread starts or ends plugins or instances, which plugins are promised: `[setup]` in the header.
/// A plugin may have instances made while one of its own is made, so a thread that has the turn may take it again.
pub fn setup_turn() -> ReentrantMutexGuard<'static, ()> {
    TURN.lock()
}
