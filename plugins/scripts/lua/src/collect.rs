//! When garbage is collected: at fixed numbers of calls.
//!
//! A text that was a key of a table finds its old place again if it comes back before the collector has run, and gets
//! another one afterwards; so the order in which `pairs` visits keys depends on when that is. Lua's own clock counts
//! bytes, garbage included, and would tick otherwise in a state that was restored. Calls of the host are the same in
//! both. Lua's clock stays wound up, for scripts that make much garbage between two collections.

use mlua::ffi::*;

use crate::state::State;

/// Calls of the host between two collections.
const EVERY: u64 = 256;
/// Lua collects by itself when a state has grown to so many percent of what it was after the last collection.
const PAUSE: i32 = 400;

/// Winds up Lua's own clock, and stops it while the library is made.
///
/// # Safety
/// A new state.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_gc(l, LUA_GCINC, PAUSE, 0, 0);
    lua_gc(l, LUA_GCSTOP);
}

/// Lets the clock run, as if all that is there had just been collected.
///
/// # Safety
/// The clock stands since the state was made.
pub(crate) unsafe fn begin(l: *mut lua_State) {
    lua_gc(l, LUA_GCRESTART);
    let more = lua_gc(l, LUA_GCCOUNT) * (PAUSE - 100) / 100;
    lua_gc(l, LUA_GCSTEP, -more);
}

/// Counts a call, and collects if it is time. Scripts take turns, so that not all collect in one step.
///
/// # Safety
/// Protected; the outermost call.
pub(crate) unsafe fn tick(l: *mut lua_State, s: &State) {
    let n = s.entries.get() + 1;
    s.entries.set(n);
    if (n + s.instance.id) % EVERY == 0 {
        lua_gc(l, LUA_GCCOLLECT);
    }
}
