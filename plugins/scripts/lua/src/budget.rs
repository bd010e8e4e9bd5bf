//! Instruction budget: a count hook that neither protected calls nor coroutines can escape.

use std::cell::{Cell, RefCell};

use mlua_sys::*;
use tatu_plugin_api::{abi::TATU_ERR_BUDGET, safe::*};

use crate::{
    lua_internals,
    state::{self, push},
    time_slices,
};

/// Instructions between two runs of the hook. The cost lies in having a hook, not in how often it runs.
pub(crate) const HOOK_INTERVAL: u64 = 1000;
/// Bytes of a large allocation that count as one instruction.
const BYTES_PER_INSTRUCTION: u64 = 64;
/// Instructions charged for a new coroutine, since its hook starts a count of its own.
const COROUTINE_COST: u64 = 500;

/// Budget of the running call.
pub(crate) struct State {
    used: Cell<u64>,
    /// The part of `used` that nested calls have reported already.
    reported: Cell<u64>,
    limit: Cell<u64>,
    exhausted: Cell<bool>,
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

impl Default for State {
    fn default() -> Self {
        State {
            used: Cell::new(0),
            reported: Cell::new(0),
            limit: Cell::new(0),
            exhausted: Cell::new(false),
            countdown: Cell::new(std::ptr::null_mut()),
            place: RefCell::new(None),
        }
    }
}

impl State {
    /// Charges what the main thread executed since the last hook run and restarts the countdown, so that the usage of a
    /// call does not depend on earlier calls, and a restored state counts like the saved one.
    fn charge_main_thread(&self) {
        let countdown = self.countdown.get();
        if countdown.is_null() || self.exhausted.get() {
            return;
        }
        // SAFETY: a field of the main thread, which lives as long as this state.
        unsafe {
            self.used.set(self.used.get() + HOOK_INTERVAL.saturating_sub((*countdown).max(0) as u64));
            *countdown = HOOK_INTERVAL as i32;
        }
    }
    /// Begins a call; returns what `end` needs.
    pub(crate) fn begin(&self, limit: u64) -> Outer {
        self.charge_main_thread();
        Outer { used: self.used.replace(0), reported: self.reported.replace(0), limit: self.limit.replace(limit) }
    }
    /// Ends a call and returns its own usage. A nested call also counts against the budget of the outer one.
    pub(crate) fn end(&self, outer: Outer) -> u64 {
        self.charge_main_thread();
        let used = self.used.replace(0);
        let own = used - self.reported.replace(outer.reported + used);
        self.used.set(outer.used + used);
        self.limit.set(outer.limit);
        own
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
    /// Locates the main thread's countdown.
    ///
    /// # Safety
    /// The main thread runs nothing, and its hook is armed.
    pub(crate) unsafe fn locate_countdown(&self, main: *mut lua_State) {
        self.countdown.set(lua_internals::hook_count(main));
    }
    pub(crate) fn is_exhausted(&self) -> bool {
        self.exhausted.get()
    }
    fn message(&self) -> String {
        format!("the script used up its {} instructions of one call", self.limit.get())
    }
}

/// Charges large allocations at the begin and the end of a call, so that no call pays for another.
pub(crate) fn charge_blocks(s: &state::State) {
    s.budget.used.set(s.budget.used.get() + s.slot.take_large_bytes() / BYTES_PER_INSTRUCTION);
}

/// Charges a new coroutine for instructions before its own hook runs.
pub(crate) fn charge_coroutine(s: &state::State) {
    s.budget.used.set(s.budget.used.get() + COROUTINE_COST);
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
    match s.budget.limit.get() {
        0 => u64::MAX,
        limit => limit.saturating_sub(s.budget.used.get()),
    }
}

/// Charges the work of a library function that can take long.
///
/// # Safety
/// Raises a Lua error when the budget is exhausted.
pub(crate) unsafe fn charge(l: *mut lua_State, instructions: u64) {
    let b = &state::of(l).budget;
    let used = b.used.get().saturating_add(instructions);
    if b.limit.get() == 0 || used < b.limit.get() {
        b.used.set(used);
        return;
    }
    b.used.set(b.limit.get());
    stop_script(l);
}

unsafe extern "C-unwind" fn hook(l: *mut lua_State, _: *mut lua_Debug) {
    let s = state::of(l);
    let b = &s.budget;
    if !b.exhausted.get() {
        let used = b.used.get() + HOOK_INTERVAL + s.slot.take_large_bytes() / BYTES_PER_INSTRUCTION;
        b.used.set(used);
        if b.limit.get() == 0 || used < b.limit.get() {
            return time_slices::count(l, s, HOOK_INTERVAL);
        }
    }
    stop_script(l);
}

/// Ends the call, and disables the script.
unsafe fn stop_script(l: *mut lua_State) {
    let s = state::of(l);
    if !s.budget.exhausted.replace(true) {
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
