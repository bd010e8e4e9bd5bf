//! Length of the time slice after which a thread of a script is preempted.

use std::cell::Cell;

use mlua_sys::lua_State;

use super::account::HOOK_INTERVAL;

/// Number of instructions that correspond to a millisecond of a time slice in V-REP.
pub(crate) const PER_MS: f64 = 20_000.0;
/// Default slice length, in instructions: 2 ms.
const DEFAULT: u64 = 40_000;

/// Preemption state of a script's threads.
pub(crate) struct Slices {
    /// The command that waits for the next step, as id << 8 | alias; 0: no preemption.
    pub switch: Cell<u32>,
    /// Slice length, in instructions; 0: no preemption.
    pub length: Cell<u64>,
    /// Instructions used in the current slice.
    pub used: Cell<u64>,
    /// The running coroutine of the plugin, or null if no such coroutine is running.
    pub own: Cell<*mut lua_State>,
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
    /// Begins a slice of a thread; returns the argument for `leave`.
    pub(crate) fn enter(&self, thread: *mut lua_State) -> (*mut lua_State, u64) {
        (self.own.replace(thread), self.used.replace(0))
    }
    /// Ends the slice after the thread has yielded or finished.
    pub(crate) fn leave(&self, outer: (*mut lua_State, u64)) {
        self.own.set(outer.0);
        self.used.set(outer.1);
    }
    /// Returns whether one of the plugin's coroutines is running.
    pub(crate) fn in_thread(&self) -> bool {
        !self.own.get().is_null()
    }
}

// A slice cannot be shorter than the interval at which the hook runs.
const _: () = assert!(DEFAULT as f64 == 2.0 * PER_MS && DEFAULT >= HOOK_INTERVAL);
