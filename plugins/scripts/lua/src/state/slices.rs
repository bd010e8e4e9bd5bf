//! Length of the time slice after which a thread of a script is preempted.

use std::cell::Cell;

use mlua_sys::lua_State;

use super::account::HOOK_INTERVAL;

/// Number of instructions that correspond to a millisecond of a time slice in V-REP.
pub(crate) const INSTRUCTIONS_PER_MS: f64 = 20_000.0;
/// Default slice length, in instructions: 2 ms.
const DEFAULT_SLICE: u64 = 40_000;

/// Preemption state of a script's threads.
pub(crate) struct TimeSlices {
    /// The command that waits for the next step, as id << 8 | alias; 0: no preemption.
    pub wait_command: Cell<u32>,
    /// Slice length, in instructions; 0: no preemption.
    pub length: Cell<u64>,
    /// Instructions used in the current slice.
    pub used: Cell<u64>,
    /// The running coroutine of the plugin, or null if no such coroutine is running.
    pub running_coroutine: Cell<*mut lua_State>,
}

impl Default for TimeSlices {
    fn default() -> Self {
        TimeSlices {
            wait_command: Cell::new(0),
            length: Cell::new(DEFAULT_SLICE),
            used: Cell::new(0),
            running_coroutine: Cell::new(std::ptr::null_mut()),
        }
    }
}

impl TimeSlices {
    /// Begins a slice of a thread; returns the argument for `leave`.
    pub(crate) fn enter(&self, thread: *mut lua_State) -> (*mut lua_State, u64) {
        (self.running_coroutine.replace(thread), self.used.replace(0))
    }
    /// Ends the slice after the thread has yielded or finished.
    pub(crate) fn leave(&self, outer: (*mut lua_State, u64)) {
        self.running_coroutine.set(outer.0);
        self.used.set(outer.1);
    }
    /// Returns whether one of the plugin's coroutines is running.
    pub(crate) fn in_thread(&self) -> bool {
        !self.running_coroutine.get().is_null()
    }
}

// A slice cannot be shorter than the interval at which the hook runs.
const _: () = assert!(DEFAULT_SLICE as f64 == 2.0 * INSTRUCTIONS_PER_MS && DEFAULT_SLICE >= HOOK_INTERVAL);
