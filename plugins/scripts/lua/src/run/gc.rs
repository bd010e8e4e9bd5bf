//! Garbage collection at fixed numbers of calls.
//!
//! A string key that was removed from a table returns to its old node if it is set again before a collection, and to
//! another one after it; so collections influence the order of `pairs`. Lua's own pacing counts allocated bytes and
//! would differ in a restored state, whereas calls from the host are the same. Lua's pacing remains only for scripts
//! that make much garbage between two collections.

use mlua_sys::*;

use crate::{lua_internals, state::State};

/// Calls from the host between two collections.
pub(crate) const INTERVAL: u64 = 64;
/// Garbage, KiB, at which Lua collects by itself.
const THRESHOLD_KIB: i32 = 4 << 10;

/// Stops the collector while the library is loaded.
///
/// # Safety
/// The state is new.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_gc(l, LUA_GCSTOP);
}

/// Runs a full collection and sorts the slot's free lists.
///
/// # Safety
/// The state runs nothing, or only protected code of this plugin.
pub(crate) unsafe fn full(l: *mut lua_State, s: &State) {
    lua_gc(l, LUA_GCCOLLECT);
    s.slot.sort_free_lists();
}

/// Restarts Lua's pacing, as after a full collection.
///
/// # Safety
/// A state of this plugin.
pub(crate) unsafe fn restart(l: *mut lua_State) {
    lua_internals::defer_gc(l, THRESHOLD_KIB);
}

/// Counts a call, and collects when due. Scripts collect in different steps.
///
/// # Safety
/// Runs in protected mode, in the outermost call.
pub(crate) unsafe fn count_call(l: *mut lua_State, s: &State) {
    s.entries.set(s.entries.get() + 1);
    if is_due(s) {
        full(l, s);
        restart(l);
    }
}

/// Whether a collection is due before the running call.
pub(crate) fn is_due(s: &State) -> bool {
    // Derived from the seed, that is, from the owner's name: the number of other scripts must not matter.
    s.entries.get().wrapping_add(s.instance.seed).is_multiple_of(INTERVAL)
}
