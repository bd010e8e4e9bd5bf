//! Runs the callback "thread" in coroutines of the plugin, and handles the end of waits.
//!
//! The host reports the end of a wait by the token of the wait. The plugin's own coroutines are then resumed
//! immediately.

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::{entry::enter, time_slices};
use crate::{
    convert::{put_args, take_results},
    errors,
    lua_internals::lua_closethread,
    stack::{reg, registry},
    state::ScriptState,
};

/// Starts a coroutine of the plugin with the function on top of the stack.
///
/// # Safety
/// Must run in protected mode, with a function on top of the stack; `frame` must be valid.
pub(crate) unsafe fn start(l: *mut lua_State, s: &ScriptState, frame: *mut tatu_call) -> Flow {
    let function = lua_gettop(l);
    let thread = lua_newthread(l);
    registry(l, reg::PLUGIN_COROUTINES);
    lua_pushvalue(l, -2);
    lua_pushboolean(l, 1);
    lua_rawset(l, -3);
    lua_pop(l, 1);
    lua_pushvalue(l, function);
    let n = put_args(l, frame);
    if lua_checkstack(thread, n + 4) == 0 {
        errors::raise_text(l, "too many arguments for a thread function");
    }
    lua_xmove(l, thread, n + 1);
    run_coroutine(l, s, function + 1, n, frame)
}

/// Ends the wait with this token, and resumes the waiting coroutine if it belongs to the plugin.
pub(crate) fn resume(
    s: &ScriptState,
    token: u64,
    failed: Option<Fail>,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    let (mut gone, mut failed) = (false, failed);
    // SAFETY: `enter` calls the closure with a live thread in protected mode; values with destructors belong to this
    // function or to the state, so a Lua error skips none.
    let flow = enter(s, frame, budget, used, &mut |l, frame| unsafe {
        luaL_checkstack(l, 12, std::ptr::null());
        registry(l, reg::WAITING_COROUTINES);
        let waits = lua_gettop(l);
        if lua_rawgeti(l, waits, token as i64) != LUA_TTHREAD {
            gone = true;
            return Flow::Done;
        }
        lua_pushnil(l);
        lua_rawseti(l, waits, token as i64);
        if !time_slices::was_preempted(lua_tothread(l, waits + 1)) {
            registry(l, reg::WAIT_RESULTS);
            match failed.take() {
                Some(fail) => {
                    s.waits.wait_errors.borrow_mut().insert(token, fail);
                    lua_pushboolean(l, 0);
                }
                None => pack(l, frame),
            }
            lua_rawseti(l, -2, token as i64);
        }
        registry(l, reg::PLUGIN_COROUTINES);
        lua_pushvalue(l, waits + 1);
        let own = lua_rawget(l, -2) != LUA_TNIL;
        let thread = lua_tothread(l, waits + 1);
        if !own || lua_status(thread) != LUA_YIELD {
            return Flow::Done;
        }
        run_coroutine(l, s, waits + 1, 0, frame)
    })?;
    if gone {
        return Err(Fail::with_code(TATU_ERR_GONE, "no coroutine of the script waits for this token"));
    }
    Ok(flow)
}

/// Pushes the frame's arguments as a single table.
unsafe fn pack(l: *mut lua_State, frame: *mut tatu_call) {
    let n = (*frame).n_args as i32;
    lua_createtable(l, n, 1);
    let table = lua_gettop(l);
    put_args(l, frame);
    for i in (1..=n).rev() {
        lua_rawseti(l, table, i64::from(i));
    }
    lua_pushinteger(l, i64::from(n));
    lua_setfield(l, table, c"n".as_ptr());
}

/// Runs the plugin's coroutine at index `at` until it ends or waits.
unsafe fn run_coroutine(l: *mut lua_State, s: &ScriptState, at: i32, n: i32, frame: *mut tatu_call) -> Flow {
    let thread = lua_tothread(l, at);
    s.waits.waiting.set((0, std::ptr::null_mut()));
    let mut results = 0;
    let outer = s.slices.enter(thread);
    let status = lua_resume(thread, l, n, &mut results);
    s.slices.leave(outer);
    if status == LUA_YIELD && s.waits.waiting.get().1 == thread {
        lua_pop(thread, results);
        return Flow::Waiting;
    }
    registry(l, reg::PLUGIN_COROUTINES);
    lua_pushvalue(l, at);
    lua_pushnil(l);
    lua_rawset(l, -3);
    lua_pop(l, 1);
    if status == LUA_OK {
        luaL_checkstack(l, results + 4, std::ptr::null());
        lua_xmove(thread, l, results);
        take_results(l, s, frame, results);
        return Flow::Done;
    }
    if status == LUA_YIELD {
        lua_closethread(thread, l);
        errors::raise(
            l,
            Fail::with_code(TATU_ERR_SCRIPT, "the thread function called coroutine.yield, but no code would resume it")
                .help("use a command that waits, such as one that waits for the next step"),
        );
    }
    luaL_checkstack(l, 8, std::ptr::null());
    lua_xmove(thread, l, 1);
    errors::record(l, thread, s);
    lua_closethread(thread, l);
    lua_error(l)
}
