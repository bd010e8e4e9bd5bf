//! When garbage is collected: at fixed numbers of calls.
//!
//! A text that was a key of a table finds its old place again if it comes back before the collector has run, and gets
//! another one afterwards; so the order in which `pairs` visits keys depends on when that is. Lua's own clock counts
//! bytes, garbage included, and would tick otherwise in a state that was restored. Calls of the host are the same in
//! both. Lua's clock stays wound up, for scripts that make much garbage between two collections.

use mlua_sys::*;

use crate::state::State;

/// Calls of the host between two collections.
pub(crate) const EVERY: u64 = 64;
/// Garbage, KiB, at which Lua collects by itself.
const MUCH: i32 = 4 << 10;

/// Stops Lua's own clock while the library is made.
///
/// # Safety
/// A new state.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_gc(l, LUA_GCSTOP);
}

/// Collects everything, and brings what is left of the slot into order.
///
/// # Safety
/// A state of ours that runs nothing, or nothing but protected code of ours.
pub(crate) unsafe fn tidy(l: *mut lua_State, s: &State) {
    lua_gc(l, LUA_GCCOLLECT);
    s.slot.tidy();
}

/// Winds the clock up, as if everything had just been collected.
///
/// # Safety
/// A state of ours.
pub(crate) unsafe fn wind(l: *mut lua_State) {
    lua_gc(l, LUA_GCRESTART);
    // A step of a negative size is credit.
    lua_gc(l, LUA_GCSTEP, -MUCH);
}

/// Counts a call, and collects if it is time. Scripts take turns, so that not all collect in one step.
///
/// # Safety
/// Protected; the outermost call.
pub(crate) unsafe fn tick(l: *mut lua_State, s: &State) {
    s.entries.set(s.entries.get() + 1);
    if is_time(s) {
        tidy(l, s);
        wind(l);
    }
}

/// Whether the running call is one that garbage is collected before.
pub(crate) fn is_time(s: &State) -> bool {
    // By the seed, which follows from the owner's name: how many others there are must not matter.
    s.entries.get().wrapping_add(s.instance.seed).is_multiple_of(EVERY)
}
