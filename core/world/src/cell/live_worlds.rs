//! Addresses of the worlds that are alive on each thread.

use std::cell::{Cell, RefCell};

use tatu_plugin_api::abi::tatu_world;

thread_local! {
    /// Worlds created on this thread that are still alive.
    static LIVE_WORLDS: RefCell<Vec<*const tatu_world>> = const { RefCell::new(Vec::new()) };
    /// The world found last, or `NO_WORLD`.
    static LAST_FOUND: Cell<*const tatu_world> = const { Cell::new(NO_WORLD) };
}

/// The address of this value denotes "no world". Unlike null, a plugin cannot pass it by accident, so one comparison
/// suffices.
static NO_WORLD_MARK: u8 = 0;
const NO_WORLD: *const tatu_world = (&raw const NO_WORLD_MARK).cast();

/// Registers a world. Its address must not change afterwards.
pub(in crate::cell) fn add(world: *const tatu_world) {
    LIVE_WORLDS.with_borrow_mut(|all| all.push(world));
}

/// Unregisters a world.
pub(in crate::cell) fn remove(world: *const tatu_world) {
    // The thread-local list may already be destroyed when a thread ends.
    let _ = LIVE_WORLDS.try_with(|all| all.borrow_mut().retain(|w| *w != world));
    let _ = LAST_FOUND.try_with(|last| last.set(NO_WORLD));
}

/// Clears the world found last, because the thread enters a worker.
pub(in crate::cell) fn clear_last_found() {
    LAST_FOUND.set(NO_WORLD);
}

/// Returns whether `world` is the world that this thread found last.
#[inline]
pub(in crate::cell) fn is_last(world: *const tatu_world) -> bool {
    LAST_FOUND.get() == world
}

/// Returns whether `world` is the address of a living world of this thread.
#[cold]
pub(in crate::cell) fn is_live(world: *const tatu_world) -> bool {
    let found = LIVE_WORLDS.with_borrow(|all| all.contains(&world));
    if found {
        LAST_FOUND.set(world);
    }
    found
}
