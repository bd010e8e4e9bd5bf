//! Time slices: a thread that does not yield is preempted after a number of instructions, and continues in the next
//! step.
//!
//! In V-REP, threads run for some milliseconds at a time; here, slices are counted in instructions, so that runs are
//! reproducible. Only the plugin's own coroutines (callback "thread") are preempted, never those of scripts.

use std::mem::MaybeUninit;

use mlua_sys::*;
use tatu_plugin_api::abi::*;

use super::frame::{MAX_RESULTS, frame};
use crate::{
    stack::{reg, registry},
    state::{self, ScriptState, slices::INSTRUCTIONS_PER_MS},
};

/// Counts instructions for the hook, and preempts the running thread at the end of its slice.
///
/// # Safety
/// The call must be the last action of the hook, since it may yield.
#[inline]
pub(crate) unsafe fn count_instructions(l: *mut lua_State, s: &ScriptState, instructions: u64) {
    let slices = &s.slices;
    let own = slices.running_coroutine.get();
    if own.is_null() {
        return;
    }
    let used = slices.used.get() + instructions;
    slices.used.set(used);
    let length = slices.length.get();
    // Do not preempt coroutines of the script inside the thread, or comparison functions of a sort.
    if length != 0 && used >= length && l == own && lua_isyieldable(l) != 0 {
        preempt(l, s);
    }
}

/// Makes the thread `l` wait for the next step by yielding from the hook.
#[cold]
unsafe fn preempt(l: *mut lua_State, s: &ScriptState) {
    let token = call_wait_command(l, s, s.slices.wait_command.get());
    if token == 0 {
        return;
    }
    luaL_checkstack(l, 4, std::ptr::null());
    registry(l, reg::WAITING_COROUTINES);
    lua_pushthread(l);
    lua_rawseti(l, -2, token as i64);
    lua_pop(l, 1);
    s.waits.waiting.set((token, l));
    lua_yield(l, 0);
}

/// Returns whether a suspended thread was preempted, rather than suspended by a command that expects results.
///
/// # Safety
/// `thread` must be suspended and belong to a state of this plugin.
pub(crate) unsafe fn was_preempted(thread: *mut lua_State) -> bool {
    let mut ar = std::mem::zeroed::<lua_Debug>();
    if lua_getstack(thread, 0, &mut ar) == 0 {
        return false;
    }
    lua_getinfo(thread, c"S".as_ptr(), &mut ar);
    *ar.what != b'C' as _
}

/// Implements `slice(ms)` for preludes: sets the slice length, if given (0: no preemption), and returns whether the
/// caller is a thread.
pub(crate) unsafe extern "C-unwind" fn slice(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    if lua_type(l, 1) == LUA_TNUMBER {
        let ms = lua_tonumber(l, 1);
        s.slices
            .length
            .set(if ms > 0.0 { (ms.min(1e6) * INSTRUCTIONS_PER_MS) as u64 } else { 0 }.max(u64::from(ms > 0.0)));
    }
    lua_pushboolean(l, i32::from(s.slices.in_thread()));
    1
}

/// Calls a waiting command without arguments for the thread `l`. Returns the wait's token, or 0 if it did not wait.
///
/// # Safety
/// `l` must be running and able to yield.
unsafe fn call_wait_command(l: *mut lua_State, s: &ScriptState, packed: u32) -> u64 {
    if packed == 0 {
        return 0;
    }
    let mut results = MaybeUninit::<[tatu_value; MAX_RESULTS]>::uninit();
    let mut frame = frame(&mut results);
    frame.wait_token = s.waits.token.get() + 1;
    s.waits.token.set(frame.wait_token);
    (frame.command, frame.alias) = (packed >> 8, packed & 0xFF);
    let outer = s.threads.running.replace(l);
    let status = (s.border.commands.call)(s.world_ref(), &mut frame);
    s.threads.running.set(outer);
    if status == TATU_WAIT { frame.wait_token } else { 0 }
}
