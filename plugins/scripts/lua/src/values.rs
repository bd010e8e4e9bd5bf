//! Converts values to text without addresses, and to integers as in Lua 5.1.

use mlua_sys::*;

use crate::{
    errors::raise_text,
    stack::{push, reg, registry},
    state,
};

/// Pushes the text of a value. The text of a table, function or other object contains a number instead of its address;
/// objects are numbered in the order in which they are first converted.
///
/// # Safety
/// May raise a Lua error, and may call `__tostring`.
pub(crate) unsafe fn to_text(l: *mut lua_State, idx: i32) {
    let idx = lua_absindex(l, idx);
    luaL_checkstack(l, 8, std::ptr::null());
    if luaL_callmeta(l, idx, c"__tostring".as_ptr()) != 0 {
        if lua_isstring(l, -1) == 0 {
            raise_text(l, "'__tostring' must return a string");
        }
        return;
    }
    match lua_type(l, idx) {
        LUA_TSTRING => lua_pushvalue(l, idx),
        LUA_TNUMBER => {
            lua_pushvalue(l, idx);
            lua_tolstring(l, -1, std::ptr::null_mut());
        }
        LUA_TBOOLEAN if lua_toboolean(l, idx) != 0 => push(l, b"true"),
        LUA_TBOOLEAN => push(l, b"false"),
        LUA_TNIL | LUA_TNONE => push(l, b"nil"),
        kind => {
            let top = lua_gettop(l);
            if luaL_getmetafield(l, idx, c"__name".as_ptr()) != LUA_TSTRING {
                lua_settop(l, top);
                lua_pushstring(l, lua_typename(l, kind));
            }
            push(l, b": ");
            address(l, idx);
            lua_concat(l, 3);
        }
    }
}

/// Pushes the number of the object at `idx`, formatted like an address: "0x00000001".
///
/// # Safety
/// The stack must have four free slots. May raise a Lua error.
pub(crate) unsafe fn address(l: *mut lua_State, idx: i32) {
    let s = state::of(l);
    registry(l, reg::OBJECT_NUMBERS);
    lua_pushvalue(l, idx);
    if lua_rawget(l, -2) != LUA_TNUMBER {
        lua_pop(l, 1);
        let next = s.functions.numbers.get() + 1;
        s.functions.numbers.set(next);
        lua_pushvalue(l, idx);
        lua_pushinteger(l, next);
        lua_rawset(l, -3);
        lua_pushinteger(l, next);
    }
    let number = lua_tointeger(l, -1);
    lua_pop(l, 2);
    let mut text = *b"0x00000000";
    for (i, digit) in text[2..].iter_mut().enumerate() {
        let nibble = (number >> (28 - 4 * i) & 0xF) as u8;
        *digit = if nibble < 10 { b'0' + nibble } else { b'a' + nibble - 10 };
    }
    push(l, &text);
}

/// Converts a float, or a string that contains a float, to an integer as Lua 5.1 did: truncates the value, or yields
/// the smallest integer if the value is out of range.
///
/// # Safety
/// `idx` must be an absolute index.
pub(crate) unsafe fn truncate_at(l: *mut lua_State, idx: i32) {
    if lua_isinteger(l, idx) != 0 || !matches!(lua_type(l, idx), LUA_TNUMBER | LUA_TSTRING) {
        return;
    }
    let mut is_number = 0;
    let x = lua_tonumberx(l, idx, &mut is_number);
    if is_number != 0 {
        lua_pushinteger(l, if x.abs() < 9.2e18 { x as i64 } else { i64::MIN });
        lua_replace(l, idx);
    }
}
