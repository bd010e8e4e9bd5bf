//! Instruction budget: a count hook that neither protected calls nor coroutines can bypass, and a meter in the Lua
//! state to which C code charges its loops (`lua_charges.h`).

use mlua_sys::*;

use super::time_slices;
use crate::{
    lua_internals::UNITS_PER_INSTRUCTION,
    stack::push,
    state::{self, ScriptState, account::HOOK_INTERVAL},
};

/// Instructions charged for a new coroutine, because its hook counts separately.
const COROUTINE_COST: u64 = 500;

/// Instructions charged per system call, per opened file, and per line of the log.
pub(crate) const SYSTEM_CALL_COST: u64 = 500;
pub(crate) const FILE_OPEN_COST: u64 = 5000;
pub(crate) const LOG_LINE_COST: u64 = 100;
/// Instructions charged for looking up a name in the host.
pub(crate) const LOOKUP_COST: u64 = 50;

/// Interval, in units of work, at which the host is asked whether the script must return.
const POLL_INTERVAL: u64 = (1 << 18) * UNITS_PER_INSTRUCTION;

/// Charges the instructions that a new coroutine can run before its own hook is called for the first time.
pub(crate) fn charge_coroutine(s: &ScriptState) {
    let used = &s.budget.meter().used;
    used.set(used.get() + COROUTINE_COST * UNITS_PER_INSTRUCTION);
}

/// Arms the hook of a thread; coroutines that it creates inherit the hook.
///
/// # Safety
/// `l` must be a thread of a state created by this plugin.
pub(crate) unsafe fn arm_hook(l: *mut lua_State) {
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, HOOK_INTERVAL as i32);
}

/// Returns the number of instructions that remain in the budget.
pub(crate) fn remaining(s: &ScriptState) -> u64 {
    let meter = s.budget.meter();
    meter.limit.get().saturating_sub(meter.used.get()) / UNITS_PER_INSTRUCTION
}

/// Charges the work of a library function that can run for a long time.
///
/// # Safety
/// The calling C function must keep no value with a destructor alive, since this raises a Lua error when the budget is
/// exhausted.
pub(crate) unsafe fn charge(l: *mut lua_State, instructions: u64) {
    charge_units(l, instructions.saturating_mul(UNITS_PER_INSTRUCTION));
}

/// Like [`charge`], in units.
///
/// # Safety
/// The requirements of [`charge`] apply.
pub(crate) unsafe fn charge_units(l: *mut lua_State, units: u64) {
    let meter = state::of(l).budget.meter();
    let (used, limit) = (meter.used.get(), meter.limit.get());
    // Nested calls may already have used more than the limit.
    meter.used.set(used.saturating_add(units).min(limit.max(used)));
    if meter.used.get() >= limit {
        stop_script(l);
    }
}

/// Raises the error of an exhausted budget. C code calls this function when it has exhausted the budget.
///
/// # Safety
/// The requirements of [`charge`] apply. Only this plugin sets the limit of a Lua state, so `l` is one of its states.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn tatu_lua_spent(l: *mut lua_State) {
    stop_script(l);
}

unsafe extern "C-unwind" fn hook(l: *mut lua_State, _: *mut lua_Debug) {
    let s = state::of(l);
    let b = &s.budget;
    if !b.exhausted.get() {
        let meter = b.meter();
        let used = meter.used.get() + HOOK_INTERVAL * UNITS_PER_INSTRUCTION;
        meter.used.set(used);
        if used < meter.limit.get() {
            if used / POLL_INTERVAL != (used - HOOK_INTERVAL * UNITS_PER_INSTRUCTION) / POLL_INTERVAL
                && s.world().must_return()
            {
                *b.reason.borrow_mut() =
                    Some("the script did not return within a second after a stop was requested".to_owned());
                stop_script(l);
            }
            return time_slices::count_instructions(l, s, HOOK_INTERVAL);
        }
    }
    stop_script(l);
}

/// Aborts the running call for a reason that the host gave, and disables the script.
///
/// # Safety
/// The requirements of [`charge`] apply.
pub(crate) unsafe fn stop_by_host(l: *mut lua_State, reason: String) -> i32 {
    *state::of(l).budget.reason.borrow_mut() = Some(reason);
    stop_script(l)
}

/// Aborts the running call with an error, and disables the script.
unsafe fn stop_script(l: *mut lua_State) -> ! {
    let s = state::of(l);
    let meter = s.budget.meter();
    if !s.budget.exhausted.replace(true) {
        s.budget.spent.set(meter.limit.get() / UNITS_PER_INSTRUCTION);
        // Prefer a position in a file over one in code that the script generated.
        let mut ar = std::mem::zeroed::<lua_Debug>();
        let mut level = 0;
        while lua_getstack(l, level, &mut ar) != 0 {
            lua_getinfo(l, c"Sl".as_ptr(), &mut ar);
            let file = ar.currentline > 0 && *ar.source == b'@' as _;
            if file || level == 0 {
                record_position(s, &ar);
            }
            if file {
                break;
            }
            level += 1;
        }
    }
    // From now on, the hook raises an error at every instruction, so that no protected call or coroutine continues.
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, 1);
    lua_sethook(s.threads.main, Some(hook), LUA_MASKCOUNT, 1);
    luaL_checkstack(l, 2, std::ptr::null());
    push(l, b"the script has used up its instructions");
    lua_error(l);
}

fn record_position(s: &ScriptState, ar: &lua_Debug) {
    // SAFETY: `lua_getinfo` filled `ar` just before, so `source` and `srclen` describe a string that the running
    // function keeps alive.
    let source = unsafe { std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen) };
    let text = String::from_utf8_lossy(source);
    let file = text.strip_prefix(['@', '=']).unwrap_or(&text).to_owned();
    *s.budget.place.borrow_mut() = Some((file, ar.currentline.max(0) as u64));
}
