//! Replacements for functions of Lua's basic libraries.

use mlua_sys::*;
use tatu_plugin_api::abi::*;

use super::{modules, sort, strings, text};
use crate::{
    errors,
    lua_internals::{NodeKey, RawTable},
    run::budget,
    stack::{bytes, push, set},
    state::{
        self,
        originals::{CREATE, FORMAT, LOAD, WRAP},
    },
    values::truncate_at,
};

unsafe fn remove(l: *mut lua_State, name: &std::ffi::CStr) {
    lua_pushnil(l);
    lua_setfield(l, -2, name.as_ptr());
}

/// Stores the library function `name` of the table on top of the stack, for a replacement that wraps it.
unsafe fn original(l: *mut lua_State, name: &std::ffi::CStr, which: usize) {
    lua_getfield(l, -1, name.as_ptr());
    state::of(l).originals.store(which, lua_tocfunction(l, -1));
    lua_pop(l, 1);
}

/// Replaces each C function without upvalues in the table on top of the stack with a closure that has an upvalue.
pub(super) unsafe fn add_upvalues(l: *mut lua_State) {
    lua_pushnil(l);
    while lua_next(l, -2) != 0 {
        match lua_tocfunction(l, -1) {
            Some(f) if lua_getupvalue(l, -1, 1).is_null() => {
                lua_pop(l, 1);
                lua_pushvalue(l, -1);
                lua_pushinteger(l, 0);
                lua_pushcclosure(l, f, 1);
                lua_rawset(l, -4);
            }
            Some(_) => lua_pop(l, 2),
            None => lua_pop(l, 1),
        }
    }
}

pub(super) unsafe fn debug(l: *mut lua_State) {
    lua_pushcclosure(l, luaopen_debug, 0);
    lua_call(l, 0, 1);
    lua_createtable(l, 0, 2);
    for name in [c"traceback", c"getinfo"] {
        lua_getfield(l, -2, name.as_ptr());
        lua_setfield(l, -2, name.as_ptr());
    }
    add_upvalues(l);
    lua_setglobal(l, c"debug".as_ptr());
    lua_pop(l, 1);
}

pub(super) unsafe fn base(l: *mut lua_State) {
    lua_pushglobaltable(l);
    original(l, c"load", LOAD);
    set(l, c"print", text::print);
    set(l, c"tostring", text::tostring);
    set(l, c"load", load);
    set(l, c"setmetatable", setmetatable);
    set(l, c"collectgarbage", collectgarbage);
    set(l, c"xpcall", xpcall);
    remove(l, c"warn");
    lua_getfield(l, -1, c"next".as_ptr());
    let next = lua_tocfunction(l, -1).unwrap_or(do_nothing);
    lua_pop(l, 1);
    lua_pushinteger(l, 0);
    lua_pushcclosure(l, next, 1);
    lua_pushvalue(l, -1);
    lua_setfield(l, -3, c"next".as_ptr());
    lua_pushcclosure(l, pairs, 1);
    lua_setfield(l, -2, c"pairs".as_ptr());
    lua_pushinteger(l, 0);
    lua_pushcclosure(l, ipairs_next, 1);
    lua_pushcclosure(l, ipairs, 1);
    lua_setfield(l, -2, c"ipairs".as_ptr());
    lua_pop(l, 1);
}

pub(super) unsafe fn install_other_libraries(l: *mut lua_State) {
    lua_getglobal(l, c"string".as_ptr());
    original(l, c"format", FORMAT);
    set(l, c"format", text::format);
    remove(l, c"dump");
    set(l, c"find", strings::find);
    set(l, c"match", strings::match_);
    set(l, c"gmatch", strings::gmatch);
    set(l, c"gsub", strings::gsub);
    lua_getglobal(l, c"table".as_ptr());
    set(l, c"sort", sort::sort);
    lua_getglobal(l, c"coroutine".as_ptr());
    original(l, c"create", CREATE);
    original(l, c"wrap", WRAP);
    set(l, c"create", create);
    set(l, c"wrap", wrap);
    lua_getglobal(l, c"math".as_ptr());
    lua_getfield(l, -1, c"randomseed".as_ptr());
    lua_pushvalue(l, -1);
    lua_pushcclosure(l, randomseed, 1);
    lua_setfield(l, -3, c"randomseed".as_ptr());
    lua_pushinteger(l, state::of(l).border.instance.seed as i64);
    lua_call(l, 1, 0);
    lua_pop(l, 4);
}

unsafe extern "C-unwind" fn do_nothing(_: *mut lua_State) -> i32 {
    0
}

unsafe extern "C-unwind" fn pairs(l: *mut lua_State) -> i32 {
    luaL_checkany(l, 1);
    if state::of(l).restored.get() {
        watch_order(l, 1);
    }
    if luaL_getmetafield(l, 1, c"__pairs".as_ptr()) != LUA_TNIL {
        lua_pushvalue(l, 1);
        lua_callk(l, 1, 3, 0, Some(pairs_done));
        return 3;
    }
    lua_pushvalue(l, lua_upvalueindex(1));
    lua_pushvalue(l, 1);
    lua_pushnil(l);
    3
}

/// Warns once if a restored script traverses a table whose order depends on addresses. Such a table was created after
/// the restore, so its addresses can differ from those in the run that saved the snapshot.
///
/// # Safety
/// The state must have been restored, and `idx` must be a valid index.
unsafe fn watch_order(l: *mut lua_State, idx: i32) {
    if lua_type(l, idx) != LUA_TTABLE {
        return;
    }
    let t = RawTable::of(l, idx);
    let objects = (0..t.nodes()).filter(|i| t.node(*i) == (NodeKey::Object, true)).count();
    if objects > 1 {
        let s = state::of(l);
        s.restored.set(false);
        s.log(
            TATU_LOG_WARNING,
            b"a script traverses keys that are tables or functions; after a restore, their order may differ from the \
              order in the run that saved the snapshot",
        );
    }
}

unsafe extern "C-unwind" fn pairs_done(_: *mut lua_State, _: i32, _: lua_KContext) -> i32 {
    3
}

unsafe extern "C-unwind" fn ipairs(l: *mut lua_State) -> i32 {
    luaL_checkany(l, 1);
    lua_pushvalue(l, lua_upvalueindex(1));
    lua_pushvalue(l, 1);
    lua_pushinteger(l, 0);
    3
}

unsafe extern "C-unwind" fn ipairs_next(l: *mut lua_State) -> i32 {
    let i = luaL_checkinteger(l, 2).wrapping_add(1);
    lua_pushinteger(l, i);
    if lua_geti(l, 1, i) == LUA_TNIL { 1 } else { 2 }
}

/// Implements `load` for source text only: malformed bytecode can crash the process.
unsafe extern "C-unwind" fn load(l: *mut lua_State) -> i32 {
    if lua_gettop(l) < 3 {
        lua_settop(l, 3);
    }
    if lua_type(l, 1) == LUA_TSTRING {
        let name = if lua_type(l, 2) == LUA_TSTRING { 2 } else { 1 };
        modules::store_source(state::of(l), bytes(l, name), bytes(l, 1));
    }
    push(l, b"t");
    lua_replace(l, 3);
    state::of(l).originals.call(l, LOAD)
}

/// Implements `setmetatable` without finalizers. Finalizers would run when the collector decides, outside of any
/// budget.
unsafe extern "C-unwind" fn setmetatable(l: *mut lua_State) -> i32 {
    luaL_checktype(l, 1, LUA_TTABLE);
    if lua_type(l, 2) != LUA_TNIL {
        luaL_checktype(l, 2, LUA_TTABLE);
    }
    if luaL_getmetafield(l, 1, c"__metatable".as_ptr()) != LUA_TNIL {
        return errors::raise_text(l, "cannot change a protected metatable");
    }
    lua_settop(l, 2);
    if lua_type(l, 2) == LUA_TNIL {
        lua_setmetatable(l, 1);
        return 1;
    }
    // Lua checks for `__gc` only when a metatable is set, so hide the field during this operation.
    push(l, b"__gc");
    if lua_rawget(l, 2) != LUA_TNIL {
        push(l, b"__gc");
        lua_pushnil(l);
        lua_rawset(l, 2);
    }
    lua_pushvalue(l, 2);
    lua_setmetatable(l, 1);
    if lua_type(l, 3) != LUA_TNIL {
        push(l, b"__gc");
        lua_pushvalue(l, 3);
        lua_rawset(l, 2);
    }
    lua_settop(l, 1);
    1
}

/// Instructions charged per KiB that the collector traverses.
const COLLECTION_COST_PER_KIB: u64 = 32;

unsafe extern "C-unwind" fn collectgarbage(l: *mut lua_State) -> i32 {
    let what = if lua_type(l, 1) == LUA_TSTRING { bytes(l, 1) } else { b"collect" };
    match what {
        b"count" => {
            let bytes = lua_gc(l, LUA_GCCOUNT) * 1024 + lua_gc(l, LUA_GCCOUNTB);
            lua_pushnumber(l, f64::from(bytes) / 1024.0);
        }
        b"collect" => {
            budget::charge(l, lua_gc(l, LUA_GCCOUNT) as u64 * COLLECTION_COST_PER_KIB);
            lua_gc(l, LUA_GCCOLLECT);
            lua_pushinteger(l, 0);
        }
        b"isrunning" => lua_pushboolean(l, 1),
        _ => lua_pushinteger(l, 0),
    }
    1
}

/// Implements `xpcall`. Once the budget is exhausted, the script's handler is not called, because no limit would apply
/// to it.
unsafe extern "C-unwind" fn xpcall(l: *mut lua_State) -> i32 {
    let n = lua_gettop(l);
    luaL_checktype(l, 2, LUA_TFUNCTION);
    lua_pushvalue(l, 2);
    lua_pushcclosure(l, handle, 1);
    lua_replace(l, 2);
    lua_pushboolean(l, 1);
    lua_pushvalue(l, 1);
    lua_rotate(l, 3, 2);
    let status = lua_pcallk(l, n - 2, LUA_MULTRET, 2, 2, Some(xpcall_done));
    xpcall_done(l, status, 2)
}

unsafe extern "C-unwind" fn xpcall_done(l: *mut lua_State, status: i32, extra: lua_KContext) -> i32 {
    if status != LUA_OK && status != LUA_YIELD {
        lua_pushboolean(l, 0);
        lua_pushvalue(l, -2);
        return 2;
    }
    lua_gettop(l) - extra as i32
}

unsafe extern "C-unwind" fn handle(l: *mut lua_State) -> i32 {
    lua_settop(l, 1);
    if !state::of(l).budget.is_exhausted() {
        lua_pushvalue(l, lua_upvalueindex(1));
        lua_insert(l, 1);
        lua_call(l, 1, 1);
    }
    1
}

unsafe extern "C-unwind" fn create(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge_coroutine(s);
    s.originals.call(l, CREATE)
}

unsafe extern "C-unwind" fn wrap(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge_coroutine(s);
    s.originals.call(l, WRAP)
}

/// Implements `math.randomseed`. Without arguments, it uses the script's own seed instead of the clock.
unsafe extern "C-unwind" fn randomseed(l: *mut lua_State) -> i32 {
    if lua_gettop(l) == 0 {
        lua_pushinteger(l, state::of(l).border.instance.seed as i64);
    }
    // Older versions of Lua truncated fractions.
    for i in 1..=lua_gettop(l) {
        truncate_at(l, i);
    }
    lua_pushvalue(l, lua_upvalueindex(1));
    lua_insert(l, 1);
    lua_call(l, lua_gettop(l) - 1, 0);
    0
}
