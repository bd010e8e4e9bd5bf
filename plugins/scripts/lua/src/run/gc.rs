//! Garbage collection at fixed intervals of calls.
//!
//! If a removed string key is set again before the next collection, it returns to its old node; after a collection, it
//! may get a different one. Collections therefore affect the order of `pairs`. Lua's own pacing depends on the number
//! of bytes allocated, which differs in a restored state, whereas the number of calls from the host does not. Lua's own
//! pacing remains active only for scripts that create much garbage between two collections.

use mlua_sys::*;

use crate::{lua_internals, state::ScriptState};

/// Number of calls from the host between two collections.
pub(crate) const COLLECTION_INTERVAL: u64 = 64;
/// Garbage in KiB at which Lua's own pacing starts a collection.
const THRESHOLD_KIB: i32 = 4 << 10;

/// Stops the collector while the library is opened.
///
/// # Safety
/// `l` must be the main thread of a new state.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_gc(l, LUA_GCSTOP);
}

/// Runs a full collection and sorts the slot's free lists.
///
/// # Safety
/// The state must be idle, or run only code of this plugin in protected mode.
pub(crate) unsafe fn collect_fully(l: *mut lua_State, s: &ScriptState) {
    lua_gc(l, LUA_GCCOLLECT);
    s.slot.sort_free_lists();
}

/// Restarts Lua's own pacing, as after a full collection.
///
/// # Safety
/// `l` must belong to a state of this plugin.
pub(crate) unsafe fn restart(l: *mut lua_State) {
    lua_internals::defer_gc(l, THRESHOLD_KIB);
}

/// Counts a call, and runs a collection if one is due. The collections of different scripts fall into different steps.
///
/// # Safety
/// Must run in protected mode, in the outermost call.
pub(crate) unsafe fn count_call(l: *mut lua_State, s: &ScriptState) {
    s.call.entries.set(s.call.entries.get() + 1);
    if is_due(s) {
        collect_fully(l, s);
        restart(l);
    }
}

/// Returns whether a collection is due before the running call.
pub(crate) fn is_due(s: &ScriptState) -> bool {
    // The offset is the seed, which depends only on the name of the script's object, not on other scripts.
    s.call.entries.get().wrapping_add(s.border.instance.seed).is_multiple_of(COLLECTION_INTERVAL)
}
