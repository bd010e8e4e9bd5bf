//! Time slices: a thread that does not yield by itself is preempted after a number of instructions, and continues in
//! the next step.
//!
//! Threads of the original ran for some milliseconds at a time; here slices are counted in instructions, so that every
//! run is the same. Only the plugin's own coroutines (callback "thread") are preempted, never those of scripts.

use std::cell::Cell;

use mlua_sys::*;

use crate::{
    bind,
    state::{self, State, reg, registry},
};

/// Instructions per millisecond.
const PER_MS: f64 = 20_000.0;
/// Default slice length, instructions: 2 ms.
const DEFAULT: u64 = 40_000;

/// Preemption of a script's threads.
pub(crate) struct Slices {
    /// The command that waits for the next step: id << 8 | alias; 0: no preemption.
    pub switch: Cell<u32>,
    /// Slice length, instructions; 0: no preemption.
    length: Cell<u64>,
    /// Instructions used of the current slice.
    used: Cell<u64>,
    /// The plugin's coroutine that is running, or null.
    own: Cell<*mut lua_State>,
}

impl Default for Slices {
    fn default() -> Self {
        Slices {
            switch: Cell::new(0),
            length: Cell::new(DEFAULT),
            used: Cell::new(0),
            own: Cell::new(std::ptr::null_mut()),
        }
    }
}

impl Slices {
    /// Resumes a thread; returns what `leave` needs.
    pub(crate) fn enter(&self, thread: *mut lua_State) -> (*mut lua_State, u64) {
        (self.own.replace(thread), self.used.replace(0))
    }
    /// The thread yielded or ended.
    pub(crate) fn leave(&self, outer: (*mut lua_State, u64)) {
        self.own.set(outer.0);
        self.used.set(outer.1);
    }
    /// Whether one of the plugin's coroutines is running.
    pub(crate) fn in_thread(&self) -> bool {
        !self.own.get().is_null()
    }
}

/// Called by the count hook; preempts the running thread when its slice is over.
///
/// # Safety
/// Last action of the hook.
#[inline]
pub(crate) unsafe fn count(l: *mut lua_State, s: &State, instructions: u64) {
    let slices = &s.slices;
    let own = slices.own.get();
    if own.is_null() {
        return;
    }
    let used = slices.used.get() + instructions;
    slices.used.set(used);
    let length = slices.length.get();
    // Nested coroutines of the script and comparisons of a sort finish first.
    if length != 0 && used >= length && l == own && lua_isyieldable(l) != 0 {
        preempt(l, s);
    }
}

/// Makes thread `l` wait for the next step, yielding from the hook.
#[cold]
unsafe fn preempt(l: *mut lua_State, s: &State) {
    let token = bind::wait(l, s, s.slices.switch.get());
    if token == 0 {
        return;
    }
    luaL_checkstack(l, 4, std::ptr::null());
    registry(l, reg::WAITS);
    lua_pushthread(l);
    lua_rawseti(l, -2, token as i64);
    lua_pop(l, 1);
    s.waiting.set((token, l));
    lua_yield(l, 0);
}

/// Whether a suspended thread was preempted, rather than suspended by a command that expects results.
///
/// # Safety
/// A suspended thread of a state of this plugin.
pub(crate) unsafe fn was_preempted(thread: *mut lua_State) -> bool {
    let mut ar = std::mem::zeroed::<lua_Debug>();
    if lua_getstack(thread, 0, &mut ar) == 0 {
        return false;
    }
    lua_getinfo(thread, c"S".as_ptr(), &mut ar);
    *ar.what != b'C' as _
}

/// For preludes, `slice(ms)`: sets the slice length (0: no preemption) if given, and returns whether it is called in a
/// thread.
pub(crate) unsafe extern "C-unwind" fn slice(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    if lua_type(l, 1) == LUA_TNUMBER {
        let ms = lua_tonumber(l, 1);
        s.slices.length.set(if ms > 0.0 { (ms.min(1e6) * PER_MS) as u64 } else { 0 }.max(u64::from(ms > 0.0)));
    }
    lua_pushboolean(l, i32::from(s.slices.in_thread()));
    1
}

// The hook runs at this interval; a slice cannot be shorter.
const _: () = assert!(DEFAULT as f64 == 2.0 * PER_MS && DEFAULT >= crate::budget::HOOK_INTERVAL);
