//! Functions that require a permission of the run: starting programs, and loading native libraries.

use mlua_sys::*;

use crate::{
    chunk_cache,
    stack::{reg, registry, set},
    state::ScriptState,
};

/// Lua code that implements `package.loadlib` and `require` of native libraries with two functions of Lua's `package`.
const NATIVE_LIBRARIES_SOURCE: &[u8] = b"
local loadlib, searchpath = ...
package.loadlib, package.searchpath, package.cpath = loadlib, searchpath, './?.so;./?.dll'
setmetatable(package.preload, {__index = function(_, name)
    local path = searchpath(name, package.cpath)
    return path and assert(loadlib(path, 'luaopen_' .. name:gsub('%.', '_')))
end})";

/// Installs the functions that the run allows.
///
/// # Safety
/// Must run in protected mode, after the library has been opened.
pub(crate) unsafe fn open(l: *mut lua_State, s: &ScriptState) {
    let allows = |what: &str| {
        let all = s.world().get(0, s.border.host.prop("scene.allow"));
        let all = all.ok().and_then(|v| v.as_str().map(std::borrow::Cow::into_owned)).unwrap_or_default();
        all.split(',').any(|a| a == what)
    };
    let (exec, native) = (allows("exec"), allows("native"));
    luaL_checkstack(l, 8, std::ptr::null());
    if exec {
        install(l, luaopen_os, c"execute", c"os");
        install(l, luaopen_io, c"popen", c"io");
    }
    if native {
        // Lua's library `package` replaces `require`, so restore the `require` of this plugin.
        lua_getglobal(l, c"require".as_ptr());
        lua_pushcclosure(l, luaopen_package, 0);
        lua_call(l, 0, 1);
        lua_insert(l, -2);
        lua_setglobal(l, c"require".as_ptr());
        if chunk_cache::load(l, NATIVE_LIBRARIES_SOURCE, c"=native") != LUA_OK {
            lua_error(l);
        }
        for name in [c"loadlib", c"searchpath"] {
            lua_getfield(l, -2 - i32::from(name == c"searchpath"), name.as_ptr());
        }
        lua_call(l, 2, 0);
        lua_pop(l, 1);
    }
}

/// Opens a library of Lua, and copies one of its functions to this plugin's library with the same name.
unsafe fn install(l: *mut lua_State, open: lua_CFunction, name: &std::ffi::CStr, ours: &std::ffi::CStr) {
    lua_pushcclosure(l, open, 0);
    lua_call(l, 0, 1);
    lua_getfield(l, -1, name.as_ptr());
    let function = lua_tocfunction(l, -1);
    lua_pop(l, 2);
    registry(l, reg::LOADED_MODULES);
    lua_getfield(l, -1, ours.as_ptr());
    if let Some(function) = function {
        set(l, name, function);
    }
    lua_pop(l, 2);
}
