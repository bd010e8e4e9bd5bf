//! Coroutines that wait in commands: those of the plugin, and those of scripts.
//!
//! A waiting command suspends its coroutine. If a script resumes one of its own coroutines, the command returns the
//! results if they have arrived, and otherwise continues to wait.

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use crate::{
    errors,
    stack::{reg, registry},
    state::{self, ScriptState},
};

/// Suspends the running coroutine until the host resumes `token`.
///
/// # Safety
/// The call must be the last action of a C function of Lua, in a thread that can yield.
pub(crate) unsafe fn suspend(l: *mut lua_State, s: &ScriptState, token: u64) -> i32 {
    luaL_checkstack(l, 4, std::ptr::null());
    registry(l, reg::WAITING_COROUTINES);
    lua_pushthread(l);
    lua_rawseti(l, -2, token as i64);
    lua_settop(l, 0);
    s.waits.waiting.set((token, l));
    lua_yieldk(l, 0, token as lua_KContext, Some(continue_wait))
}

/// Continuation after a resume: returns the results, raises the error, or continues to wait.
unsafe extern "C-unwind" fn continue_wait(l: *mut lua_State, _: i32, token: lua_KContext) -> i32 {
    let s = state::of(l);
    lua_settop(l, 0);
    registry(l, reg::WAIT_RESULTS);
    let kind = lua_rawgeti(l, 1, token as i64);
    if kind == LUA_TNIL {
        lua_settop(l, 0);
        s.waits.waiting.set((token as u64, l));
        return lua_yieldk(l, 0, token, Some(continue_wait));
    }
    lua_pushnil(l);
    lua_rawseti(l, 1, token as i64);
    if kind != LUA_TTABLE {
        return failed(l, s, token as u64);
    }
    lua_getfield(l, 2, c"n".as_ptr());
    let n = lua_tointeger(l, -1) as i32;
    luaL_checkstack(l, n + 2, std::ptr::null());
    for i in 1..=n {
        lua_rawgeti(l, 2, i64::from(i));
    }
    n
}

unsafe fn failed(l: *mut lua_State, s: &ScriptState, token: u64) -> i32 {
    let fail = s.waits.wait_errors.borrow_mut().remove(&token);
    errors::raise(l, fail.unwrap_or_else(|| Fail::new("the command that waited has failed")))
}
