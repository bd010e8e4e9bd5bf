//! The standard library of scripts: permitted functions of Lua, and replacements for the others.
//!
//! Every C function is registered with an upvalue. Without an upvalue, a function would be represented by its code
//! address, which differs between runs and would affect the order of functions that are table keys.

mod base;
pub(crate) mod compat;
mod io;
mod modules;
mod pattern;
pub(crate) mod permissions;
mod sort;
pub(crate) mod strings;
mod text;
mod time;

use mlua_sys::*;

use crate::{
    run::commands,
    stack::{push, reg, registry},
};
use base::add_upvalues;

/// Opens the library in a new state.
///
/// # Safety
/// Must run in protected mode, since it may raise an error.
pub(crate) unsafe fn open(l: *mut lua_State) {
    luaL_checkstack(l, 20, std::ptr::null());
    for place in [
        reg::BORROWED_FUNCTIONS,
        reg::KEPT_FUNCTIONS,
        reg::WAITING_COROUTINES,
        reg::WAIT_RESULTS,
        reg::OBJECT_NUMBERS,
        reg::NAMESPACES,
        reg::PLUGIN_COROUTINES,
        reg::LOADED_MODULES,
    ] {
        lua_newtable(l);
        lua_rawseti(l, LUA_REGISTRYINDEX, place);
    }
    // The keys are weak, so that the number of an object does not keep the object alive.
    registry(l, reg::OBJECT_NUMBERS);
    lua_newtable(l);
    push(l, b"k");
    lua_setfield(l, -2, c"__mode".as_ptr());
    lua_setmetatable(l, -2);
    lua_pop(l, 1);

    let libraries: [(&std::ffi::CStr, lua_CFunction); 6] = [
        (c"_G", luaopen_base),
        (c"table", luaopen_table),
        (c"string", luaopen_string),
        (c"math", luaopen_math),
        (c"coroutine", luaopen_coroutine),
        (c"utf8", luaopen_utf8),
    ];
    for (name, open) in libraries {
        luaL_requiref(l, name.as_ptr(), open, 1);
        lua_pop(l, 1);
    }
    base::debug(l);
    base::base(l);
    base::install_other_libraries(l);
    for (name, _) in libraries {
        lua_getglobal(l, name.as_ptr());
        add_upvalues(l);
        registry(l, reg::LOADED_MODULES);
        lua_pushvalue(l, -2);
        lua_setfield(l, -2, name.as_ptr());
        lua_pop(l, 2);
    }
    push(l, b"");
    if lua_getmetatable(l, -1) != 0 {
        add_upvalues(l);
        lua_pop(l, 1);
    }
    lua_pop(l, 1);
    io::open(l);
    time::open(l);
    modules::open(l);
    commands::open(l);
}
