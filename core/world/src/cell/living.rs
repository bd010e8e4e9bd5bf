//! The worlds that live on each thread, by address.

use std::cell::{Cell, RefCell};

use tatu_plugin_api::abi::tatu_world;

thread_local! {
    /// The worlds that were made on this thread and live.
    static LIVING: RefCell<Vec<*const tatu_world>> = const { RefCell::new(Vec::new()) };
    /// The one that was found last.
    static LAST: Cell<*const tatu_world> = const { Cell::new(NONE) };
}

/// Its address stands for no world: neither null nor any number that a plugin may make up, so that one comparison is
/// enough.
static NOBODY: u8 = 0;
const NONE: *const tatu_world = (&raw const NOBODY).cast();

/// A world has got the address at which it stays.
pub(super) fn add(world: *const tatu_world) {
    LIVING.with_borrow_mut(|all| all.push(world));
}

/// A world ends.
pub(super) fn remove(world: *const tatu_world) {
    // At the end of a thread the list may be gone already.
    let _ = LIVING.try_with(|all| all.borrow_mut().retain(|w| *w != world));
    let _ = LAST.try_with(|last| last.set(NONE));
}

/// The thread enters a worker: what it found last is looked up anew.
pub(super) fn forget() {
    LAST.set(NONE);
}

/// Whether this is the world that this thread found last.
#[inline]
pub(super) fn is_last(world: *const tatu_world) -> bool {
    LAST.get() == world
}

/// Whether a world of this thread has this address.
#[cold]
pub(super) fn has(world: *const tatu_world) -> bool {
    let found = LIVING.with_borrow(|all| all.contains(&world));
    if found {
        LAST.set(world);
    }
    found
}
