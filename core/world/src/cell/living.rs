//! Addresses of the worlds that are alive on each thread.

use std::cell::{Cell, RefCell};

use tatu_plugin_api::abi::tatu_world;

thread_local! {
    /// Worlds created on this thread that are still alive.
    static LIVING: RefCell<Vec<*const tatu_world>> = const { RefCell::new(Vec::new()) };
    /// The world found last, or `NONE`.
    static LAST: Cell<*const tatu_world> = const { Cell::new(NONE) };
}

/// The address of this value denotes "no world". Unlike null, a plugin cannot pass it by accident, so one comparison
/// suffices.
static NOBODY: u8 = 0;
const NONE: *const tatu_world = (&raw const NOBODY).cast();

/// Registers a world. Its address must not change afterwards.
pub(super) fn add(world: *const tatu_world) {
    LIVING.with_borrow_mut(|all| all.push(world));
}

/// Unregisters a world.
pub(super) fn remove(world: *const tatu_world) {
    // The thread-local list may already be destroyed when a thread ends.
    let _ = LIVING.try_with(|all| all.borrow_mut().retain(|w| *w != world));
    let _ = LAST.try_with(|last| last.set(NONE));
}

/// Clears the world found last, because the thread enters a worker.
pub(super) fn forget() {
    LAST.set(NONE);
}

/// Returns whether `world` is the world that this thread found last.
#[inline]
pub(super) fn is_last(world: *const tatu_world) -> bool {
    LAST.get() == world
}

/// Returns whether `world` is the address of a living world of this thread.
#[cold]
pub(super) fn has(world: *const tatu_world) -> bool {
    let found = LIVING.with_borrow(|all| all.contains(&world));
    if found {
        LAST.set(world);
    }
    found
}
