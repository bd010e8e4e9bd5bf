//! Slices: a thread that does not let go by itself is switched out after a number of instructions, and goes on in the
//! next step.
//!
//! Threads of the original ran for some milliseconds at a time; here time is counted in instructions, so that every run
//! is the same. Only the plugin's own coroutines (callback "thread") are cut in slices, never those that scripts make.

use std::cell::Cell;

use mlua_sys::*;

use crate::{
    bind,
    state::{self, State, reg, registry},
};

/// Instructions of one millisecond.
const PER_MS: f64 = 20_000.0;
/// Length of a slice that nobody has set, instructions: 2 ms.
const DEFAULT: u64 = 40_000;

/// How a script's threads are cut.
pub(crate) struct Slices {
    /// The command that lets a thread wait for the next step: id << 8 | alias; 0: threads are never cut.
    pub switch: Cell<u32>,
    /// Length of a slice, instructions; 0: threads let go by themselves.
    length: Cell<u64>,
    /// What the running thread has used of it.
    used: Cell<u64>,
    /// The own thread that runs, if one does.
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
    /// A thread of ours goes on; gives back what `leave` needs.
    pub(crate) fn enter(&self, thread: *mut lua_State) -> (*mut lua_State, u64) {
        (self.own.replace(thread), self.used.replace(0))
    }
    /// It let go.
    pub(crate) fn leave(&self, outer: (*mut lua_State, u64)) {
        self.own.set(outer.0);
        self.used.set(outer.1);
    }
    /// Whether a thread of ours runs.
    pub(crate) fn in_thread(&self) -> bool {
        !self.own.get().is_null()
    }
}

/// Called for every thousand instructions of whatever runs; switches the thread out if its slice is over.
///
/// # Safety
/// The last thing in the hook that counts.
#[inline]
pub(crate) unsafe fn tick(l: *mut lua_State, s: &State, instructions: u64) {
    let slices = &s.slices;
    let own = slices.own.get();
    if own.is_null() {
        return;
    }
    let used = slices.used.get() + instructions;
    slices.used.set(used);
    let length = slices.length.get();
    // A coroutine of the script within the thread, or a comparison within a sort, ends first.
    if length != 0 && used >= length && l == own && lua_isyieldable(l) != 0 {
        cut(l, s);
    }
}

/// Lets the thread `l` wait for the next step, and yields out of the hook.
#[cold]
unsafe fn cut(l: *mut lua_State, s: &State) {
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

/// Whether a suspended thread was cut, and not suspended by a command, which takes results.
///
/// # Safety
/// A suspended thread of a state of ours.
pub(crate) unsafe fn was_cut(thread: *mut lua_State) -> bool {
    let mut ar = std::mem::zeroed::<lua_Debug>();
    if lua_getstack(thread, 0, &mut ar) == 0 {
        return false;
    }
    lua_getinfo(thread, c"S".as_ptr(), &mut ar);
    *ar.what != b'C' as _
}

/// For preludes, `slice(ms)`: sets the length of slices, 0: no switching but by the thread itself; without an argument
/// nothing is set. Tells whether it was called in a thread.
pub(crate) unsafe extern "C-unwind" fn slice(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    if lua_type(l, 1) == LUA_TNUMBER {
        let ms = lua_tonumber(l, 1);
        s.slices.length.set(if ms > 0.0 { (ms.min(1e6) * PER_MS) as u64 } else { 0 }.max(u64::from(ms > 0.0)));
    }
    lua_pushboolean(l, i32::from(s.slices.in_thread()));
    1
}

// The hook counts so many at a time; a slice cannot be shorter.
const _: () = assert!(DEFAULT as f64 == 2.0 * PER_MS && DEFAULT >= crate::budget::STEP);
