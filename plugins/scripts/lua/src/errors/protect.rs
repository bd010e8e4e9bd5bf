//! Protected mode, which is used for every access to a state from outside Lua.

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::report::{from_lua, handler};
use crate::{
    lua_internals::{NumberFormat, RunningThread},
    state::ScriptState,
};

/// Runs `f` in protected mode on the running thread; converts a Lua error to a `Fail`. `f` must not keep a value with a
/// destructor alive across Lua functions that can raise errors.
pub(crate) fn protect(s: &ScriptState, f: &mut dyn FnMut(*mut lua_State)) -> Result {
    let l = s.threads.running.get();
    let mut f = f;
    let _format = NumberFormat::begin(s.mode.old.get());
    // SAFETY: `l` is a live thread of this state, and `s` is borrowed for the whole call. `lua_checkstack` has reserved
    // the slots used, `f` lives until `lua_pcall` returns, and the stack is reset to `top`.
    unsafe {
        let _running = RunningThread::begin(l);
        let top = lua_gettop(l);
        if lua_checkstack(l, 8) == 0 {
            return Err(Fail::with_code(TATU_ERR_SCRIPT, "stack overflow"));
        }
        lua_pushcclosure(l, handler, 0);
        lua_pushcclosure(l, run, 0);
        lua_pushlightuserdata(l, (&raw mut f).cast());
        let status = lua_pcall(l, 1, 0, top + 1);
        let result = if status == LUA_OK { Ok(()) } else { Err(from_lua(s, l, status)) };
        lua_settop(l, top);
        result
    }
}

/// Runs as the body of `protect`; calls the closure that the light userdata points to.
unsafe extern "C-unwind" fn run(l: *mut lua_State) -> i32 {
    let f = &mut *lua_touserdata(l, 1).cast::<&mut dyn FnMut(*mut lua_State)>();
    lua_settop(l, 0);
    f(l);
    0
}
