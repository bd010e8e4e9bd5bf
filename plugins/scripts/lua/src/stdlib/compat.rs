//! Compatibility with older versions: a few functions for all scripts, and Lua 5.1 for old dialects.

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use crate::{
    chunk_cache,
    errors::{self, protect},
    state::ScriptState,
    values::truncate_at,
};

const COMPAT_SOURCE: &[u8] = include_bytes!("compat.lua");

/// Installs the compatibility functions.
pub(crate) fn open(s: &ScriptState, old: bool) -> Result {
    // SAFETY: `protect` calls the closure with a live thread in protected mode, and the closure keeps no value with a
    // destructor.
    protect(s, &mut |l| unsafe {
        luaL_checkstack(l, 12, std::ptr::null());
        if chunk_cache::load(l, COMPAT_SOURCE, c"=compat") != LUA_OK {
            lua_error(l);
        }
        lua_pushboolean(l, i32::from(old));
        for f in [truncating as lua_CFunction, getfenv, setfenv] {
            lua_pushinteger(l, 0);
            lua_pushcclosure(l, f, 1);
        }
        lua_call(l, 4, 0);
    })
}

/// Wraps a library function so that its arguments, starting with a given one, are truncated to integers.
unsafe extern "C-unwind" fn truncating(l: *mut lua_State) -> i32 {
    luaL_checktype(l, 1, LUA_TFUNCTION);
    lua_settop(l, 2);
    lua_pushcclosure(l, truncated, 2);
    1
}

unsafe extern "C-unwind" fn truncated(l: *mut lua_State) -> i32 {
    let n = lua_gettop(l);
    luaL_checkstack(l, 4, std::ptr::null());
    for i in lua_tointeger(l, lua_upvalueindex(2)) as i32..=n {
        truncate_at(l, i);
    }
    lua_pushvalue(l, lua_upvalueindex(1));
    lua_insert(l, 1);
    lua_call(l, n, LUA_MULTRET);
    lua_gettop(l)
}

/// Pushes the function that argument 1 specifies, either directly or by a call level.
unsafe fn function_of(l: *mut lua_State) {
    if lua_type(l, 1) == LUA_TFUNCTION {
        lua_pushvalue(l, 1);
        return;
    }
    let level = luaL_optinteger(l, 1, 1);
    let mut ar = std::mem::zeroed::<lua_Debug>();
    if !(0..1000).contains(&level) || lua_getstack(l, level as i32, &mut ar) == 0 {
        errors::raise_text(l, "invalid level");
    }
    lua_getinfo(l, c"f".as_ptr(), &mut ar);
}

/// Returns the index of the upvalue that contains the globals of the function on top of the stack, or 0 if the function
/// has no such upvalue.
unsafe fn environment(l: *mut lua_State) -> i32 {
    for n in 1..=255 {
        let name = lua_getupvalue(l, -1, n);
        if name.is_null() {
            return 0;
        }
        lua_pop(l, 1);
        if std::ffi::CStr::from_ptr(name) == c"_ENV" {
            return n;
        }
    }
    0
}

unsafe extern "C-unwind" fn getfenv(l: *mut lua_State) -> i32 {
    if lua_type(l, 1) == LUA_TNUMBER && lua_tonumber(l, 1) == 0.0 {
        lua_pushglobaltable(l);
        return 1;
    }
    function_of(l);
    match environment(l) {
        0 => {
            lua_pushglobaltable(l);
        }
        n => {
            lua_getupvalue(l, -1, n);
        }
    }
    1
}

unsafe extern "C-unwind" fn setfenv(l: *mut lua_State) -> i32 {
    luaL_checktype(l, 2, LUA_TTABLE);
    lua_settop(l, 2);
    function_of(l);
    let n = environment(l);
    if n != 0 {
        // The function gets a separate upvalue, because the old one is shared with the rest of its chunk.
        luaL_loadbufferx(l, c"".as_ptr(), 0, c"=env".as_ptr(), c"t".as_ptr());
        lua_pushvalue(l, 2);
        lua_setupvalue(l, -2, 1);
        lua_upvaluejoin(l, 3, n, -1, 1);
        lua_pop(l, 1);
    }
    lua_settop(l, 3);
    1
}
