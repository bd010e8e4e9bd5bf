//! Counts the instructions of the running call of a script.

use std::cell::{Cell, RefCell};

use mlua_sys::lua_State;
use tatu_plugin_api::{abi::TATU_ERR_BUDGET, safe::*};

use crate::lua_internals::{self, UNITS_PER_INSTRUCTION, WorkMeter};

/// Number of instructions between two runs of the hook. Most of the cost arises from the existence of a hook; running
/// it more often adds little.
pub(crate) const HOOK_INTERVAL: u64 = 1000;

/// Budget of the running call. Amounts are in units (see `lua_internals`), unless another unit is stated.
pub(crate) struct CallBudget {
    /// The counter in Lua's own memory.
    meter: Cell<*const WorkMeter>,
    /// The counter that is used if the counter in Lua's memory is not accessible.
    own: WorkMeter,
    /// The part of the used units that nested calls have already reported.
    reported: Cell<u64>,
    pub exhausted: Cell<bool>,
    /// Instructions of the call that exhausted the budget.
    pub spent: Cell<u64>,
    /// Lua's countdown to the next run of the main thread's hook, or null if it is not accessible.
    countdown: Cell<*mut i32>,
    /// File and line at which the budget ran out.
    pub place: RefCell<Option<(String, u64)>>,
    /// The reason for which the host ended the call, if it did.
    pub reason: RefCell<Option<String>>,
}

/// Budget of the surrounding call, which is restored when the nested call ends.
#[derive(Clone, Copy)]
pub(crate) struct OuterBudget {
    used: u64,
    reported: u64,
    limit: u64,
}

/// Value of a limit that is never reached.
const NO_LIMIT: u64 = u64::MAX;

impl Default for CallBudget {
    fn default() -> Self {
        CallBudget {
            meter: Cell::new(std::ptr::null()),
            own: WorkMeter { used: Cell::new(0), limit: Cell::new(NO_LIMIT) },
            reported: Cell::new(0),
            exhausted: Cell::new(false),
            spent: Cell::new(0),
            countdown: Cell::new(std::ptr::null_mut()),
            place: RefCell::new(None),
            reason: RefCell::new(None),
        }
    }
}

impl CallBudget {
    pub(crate) fn meter(&self) -> &WorkMeter {
        // SAFETY: the pointer is null, or points into the Lua state, which is closed only when this `ScriptState` is
        // dropped.
        unsafe { self.meter.get().as_ref() }.unwrap_or(&self.own)
    }
    /// Charges the instructions of the main thread since the last run of the hook, and restarts the countdown. As a
    /// result, the usage of a call does not depend on earlier calls, and is the same in a restored state.
    fn charge_main_thread(&self) {
        let countdown = self.countdown.get();
        if countdown.is_null() || self.exhausted.get() {
            return;
        }
        // SAFETY: the pointer was checked not to be null, and points to a field of the main thread, which is freed only
        // when this `ScriptState` is dropped; only the current thread accesses it.
        unsafe {
            let instructions = HOOK_INTERVAL.saturating_sub((*countdown).max(0) as u64);
            let used = &self.meter().used;
            used.set(used.get() + instructions * UNITS_PER_INSTRUCTION);
            *countdown = HOOK_INTERVAL as i32;
        }
    }
    /// Begins a call with a budget of `instructions`, or without a limit if it is 0; returns the argument for `end`.
    pub(crate) fn begin(&self, instructions: u64) -> OuterBudget {
        self.charge_main_thread();
        let limit = match instructions {
            0 => NO_LIMIT,
            n => n.saturating_mul(UNITS_PER_INSTRUCTION),
        };
        let meter = self.meter();
        OuterBudget {
            used: meter.used.replace(0),
            reported: self.reported.replace(0),
            limit: meter.limit.replace(limit),
        }
    }
    /// Ends a call and returns its own instructions. The instructions of a nested call also count against the outer
    /// budget.
    pub(crate) fn end(&self, outer: OuterBudget) -> u64 {
        self.charge_main_thread();
        let meter = self.meter();
        let used = meter.used.replace(0);
        let own = used - self.reported.replace(outer.reported + used);
        meter.used.set(outer.used + used);
        meter.limit.set(outer.limit);
        own / UNITS_PER_INSTRUCTION
    }
    /// Returns the error to report if the script has exhausted its budget.
    pub(crate) fn exhausted_error(&self) -> Option<Fail> {
        self.exhausted.get().then(|| {
            let fail = match self.reason.borrow().clone() {
                Some(reason) => Fail::with_code(TATU_ERR_BUDGET, reason),
                None => Fail::with_code(TATU_ERR_BUDGET, self.message())
                    .help("look for an endless loop, or increase the budget of scripts"),
            };
            match self.place.borrow().clone() {
                Some((file, line)) => fail.at(file, line),
                None => fail,
            }
        })
    }
    /// Locates the meter and the main thread's countdown.
    ///
    /// # Safety
    /// The main thread must be live and idle, with its hook armed.
    pub(crate) unsafe fn locate_counters(&self, main: *mut lua_State) {
        self.meter.set(lua_internals::meter(main));
        self.countdown.set(lua_internals::hook_count(main));
    }
    /// Removes the limit for code that reports an exhausted budget; returns the argument for `restore_limit`.
    pub(crate) fn lift_limit(&self) -> u64 {
        self.meter().limit.replace(NO_LIMIT)
    }
    /// Restores the limit after `lift_limit`.
    pub(crate) fn restore_limit(&self, limit: u64) {
        self.meter().limit.set(limit);
    }
    /// Returns whether the budget is exhausted.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.exhausted.get()
    }
    fn message(&self) -> String {
        format!("the script has used up its {} instructions for a single call", self.spent.get())
    }
}
