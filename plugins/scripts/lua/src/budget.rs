//! Instruction budget: a count hook that neither protected calls nor coroutines can escape, and a meter in the state on
//! which C code counts its loops (`lua_charges.h`).

use std::cell::{Cell, RefCell};

use mlua_sys::*;
use tatu_plugin_api::{abi::TATU_ERR_BUDGET, safe::*};

use crate::{
    lua_internals::{self, INSTRUCTION, Meter},
    state::{self, push},
    time_slices,
};

/// Instructions between two runs of the hook. The cost lies in having a hook, not in how often it runs.
pub(crate) const HOOK_INTERVAL: u64 = 1000;
/// Instructions charged for a new coroutine, since its hook starts a count of its own.
const COROUTINE_COST: u64 = 500;

/// Budget of the running call. All numbers in units.
pub(crate) struct State {
    /// What the state counts; in Lua's own memory.
    meter: Cell<*const Meter>,
    /// Used instead where the meter is not accessible.
    own: Meter,
    /// The part of what is used that nested calls have reported already.
    reported: Cell<u64>,
    exhausted: Cell<bool>,
    /// The instructions of the call that exhausted it.
    spent: Cell<u64>,
    /// Lua's countdown to the next hook run on the main thread; null: not accessible.
    countdown: Cell<*mut i32>,
    /// File and line at which the budget ran out.
    place: RefCell<Option<(String, u64)>>,
}

/// Budget of the surrounding call.
#[derive(Clone, Copy)]
pub(crate) struct Outer {
    used: u64,
    reported: u64,
    limit: u64,
}

/// No limit.
const ENDLESS: u64 = u64::MAX;

impl Default for State {
    fn default() -> Self {
        State {
            meter: Cell::new(std::ptr::null()),
            own: Meter { used: Cell::new(0), limit: Cell::new(ENDLESS) },
            reported: Cell::new(0),
            exhausted: Cell::new(false),
            spent: Cell::new(0),
            countdown: Cell::new(std::ptr::null_mut()),
            place: RefCell::new(None),
        }
    }
}

impl State {
    fn meter(&self) -> &Meter {
        // SAFETY: null, or a part of the Lua state, which lives as long as this one.
        unsafe { self.meter.get().as_ref() }.unwrap_or(&self.own)
    }
    /// Charges what the main thread executed since the last hook run and restarts the countdown, so that the usage of a
    /// call does not depend on earlier calls, and a restored state counts like the saved one.
    fn charge_main_thread(&self) {
        let countdown = self.countdown.get();
        if countdown.is_null() || self.exhausted.get() {
            return;
        }
        // SAFETY: a field of the main thread, which lives as long as this state.
        unsafe {
            let instructions = HOOK_INTERVAL.saturating_sub((*countdown).max(0) as u64);
            let used = &self.meter().used;
            used.set(used.get() + instructions * INSTRUCTION);
            *countdown = HOOK_INTERVAL as i32;
        }
    }
    /// Begins a call; returns what `end` needs. 0 instructions: no limit.
    pub(crate) fn begin(&self, instructions: u64) -> Outer {
        self.charge_main_thread();
        let limit = match instructions {
            0 => ENDLESS,
            n => n.saturating_mul(INSTRUCTION),
        };
        let meter = self.meter();
        Outer { used: meter.used.replace(0), reported: self.reported.replace(0), limit: meter.limit.replace(limit) }
    }
    /// Ends a call and returns its own instructions. A nested call also counts against the budget of the outer one.
    pub(crate) fn end(&self, outer: Outer) -> u64 {
        self.charge_main_thread();
        let meter = self.meter();
        let used = meter.used.replace(0);
        let own = used - self.reported.replace(outer.reported + used);
        meter.used.set(outer.used + used);
        meter.limit.set(outer.limit);
        own / INSTRUCTION
    }
    /// The error of a script that has exhausted its budget.
    pub(crate) fn refusal(&self) -> Option<Fail> {
        self.exhausted.get().then(|| {
            let fail = Fail::with_code(TATU_ERR_BUDGET, self.message())
                .help("look for a loop without an end, or give scripts more instructions");
            match self.place.borrow().clone() {
                Some((file, line)) => fail.at(file, line),
                None => fail,
            }
        })
    }
    /// Locates the meter and the main thread's countdown.
    ///
    /// # Safety
    /// The main thread runs nothing, and its hook is armed.
    pub(crate) unsafe fn locate(&self, main: *mut lua_State) {
        self.meter.set(lua_internals::meter(main));
        self.countdown.set(lua_internals::hook_count(main));
    }
    /// Lets what reports an exhausted budget run without one; returns what `confine` needs.
    pub(crate) fn release(&self) -> u64 {
        self.meter().limit.replace(ENDLESS)
    }
    /// Sets the limit again.
    pub(crate) fn confine(&self, limit: u64) {
        self.meter().limit.set(limit);
    }
    pub(crate) fn is_exhausted(&self) -> bool {
        self.exhausted.get()
    }
    fn message(&self) -> String {
        format!("the script used up its {} instructions of one call", self.spent.get())
    }
}

/// Instructions charged for a call of the operating system, for opening a file, and for a line of the log.
pub(crate) const SYSTEM_CALL: u64 = 500;
pub(crate) const OPENING: u64 = 5000;
pub(crate) const LINE: u64 = 100;
/// Instructions charged for a name that is asked for at the host.
pub(crate) const LOOKUP: u64 = 50;

/// Charges a new coroutine for instructions before its own hook runs.
pub(crate) fn charge_coroutine(s: &state::State) {
    let used = &s.budget.meter().used;
    used.set(used.get() + COROUTINE_COST * INSTRUCTION);
}

/// Arms the hook of a thread; coroutines it creates inherit the hook.
///
/// # Safety
/// A thread of a state created by this plugin.
pub(crate) unsafe fn arm(l: *mut lua_State) {
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, HOOK_INTERVAL as i32);
}

/// Remaining instructions.
pub(crate) fn remaining(s: &state::State) -> u64 {
    let meter = s.budget.meter();
    meter.limit.get().saturating_sub(meter.used.get()) / INSTRUCTION
}

/// Charges the work of a library function that can take long.
///
/// # Safety
/// Raises a Lua error when the budget is exhausted.
pub(crate) unsafe fn charge(l: *mut lua_State, instructions: u64) {
    charge_units(l, instructions.saturating_mul(INSTRUCTION));
}

/// The same in units.
///
/// # Safety
/// Raises a Lua error when the budget is exhausted.
pub(crate) unsafe fn charge_units(l: *mut lua_State, units: u64) {
    let meter = state::of(l).budget.meter();
    let (used, limit) = (meter.used.get(), meter.limit.get());
    // Nested calls may have used more than the limit.
    meter.used.set(used.saturating_add(units).min(limit.max(used)));
    if meter.used.get() >= limit {
        stop_script(l);
    }
}

/// C code has used up what was left.
///
/// # Safety
/// As `charge`. The limit of a state is set by this plugin alone, so the state is one of its own.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn tatu_lua_spent(l: *mut lua_State) {
    stop_script(l);
}

unsafe extern "C-unwind" fn hook(l: *mut lua_State, _: *mut lua_Debug) {
    let s = state::of(l);
    let b = &s.budget;
    if !b.exhausted.get() {
        let meter = b.meter();
        let used = meter.used.get() + HOOK_INTERVAL * INSTRUCTION;
        meter.used.set(used);
        if used < meter.limit.get() {
            return time_slices::count(l, s, HOOK_INTERVAL);
        }
    }
    stop_script(l);
}

/// Ends the call, and disables the script.
unsafe fn stop_script(l: *mut lua_State) {
    let s = state::of(l);
    let meter = s.budget.meter();
    if !s.budget.exhausted.replace(true) {
        s.budget.spent.set(meter.limit.get() / INSTRUCTION);
        // Prefer a position in a file over one in text that the file generated.
        let mut ar = std::mem::zeroed::<lua_Debug>();
        let mut level = 0;
        while lua_getstack(l, level, &mut ar) != 0 {
            lua_getinfo(l, c"Sl".as_ptr(), &mut ar);
            let file = ar.currentline > 0 && *ar.source == b'@' as _;
            if file || level == 0 {
                note(s, &ar);
            }
            if file {
                break;
            }
            level += 1;
        }
    }
    // From now on the hook fails at every instruction, so that no protected call and no coroutine continues.
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, 1);
    lua_sethook(s.main, Some(hook), LUA_MASKCOUNT, 1);
    luaL_checkstack(l, 2, std::ptr::null());
    push(l, b"the script used up its instructions");
    lua_error(l);
}

fn note(s: &state::State, ar: &lua_Debug) {
    // SAFETY: `ar` was filled by Lua just before.
    let source = unsafe { std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen) };
    let text = String::from_utf8_lossy(source);
    let file = text.strip_prefix(['@', '=']).unwrap_or(&text).to_owned();
    *s.budget.place.borrow_mut() = Some((file, ar.currentline.max(0) as u64));
}
