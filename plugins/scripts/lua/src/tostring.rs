//! Conversion to text without addresses: `tostring`, `print`, `string.format`.

use mlua_sys::*;

use crate::{
    budget, errors,
    lua_internals::{BYTE, INSTRUCTION},
    state::{self, bytes, push, reg, registry},
};

/// Pushes the text of a value. Tables, functions and other objects are numbered in the order in which they are first
/// shown.
///
/// # Safety
/// May raise, and may call `__tostring`.
pub(crate) unsafe fn to_text(l: *mut lua_State, idx: i32) {
    let idx = lua_absindex(l, idx);
    luaL_checkstack(l, 8, std::ptr::null());
    if luaL_callmeta(l, idx, c"__tostring".as_ptr()) != 0 {
        if lua_isstring(l, -1) == 0 {
            errors::raise_text(l, "'__tostring' must return a string");
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

/// Pushes the number of the object at `idx` in the form of an address, "0x00000001".
unsafe fn address(l: *mut lua_State, idx: i32) {
    let s = state::of(l);
    registry(l, reg::NUMBERS);
    lua_pushvalue(l, idx);
    if lua_rawget(l, -2) != LUA_TNUMBER {
        lua_pop(l, 1);
        let next = s.numbers.get() + 1;
        s.numbers.set(next);
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

pub(crate) unsafe extern "C-unwind" fn tostring(l: *mut lua_State) -> i32 {
    luaL_checkany(l, 1);
    to_text(l, 1);
    1
}

/// `print`: writes a log line.
pub(crate) unsafe extern "C-unwind" fn print(l: *mut lua_State) -> i32 {
    let n = lua_gettop(l);
    luaL_checkstack(l, 2 * n + 8, std::ptr::null());
    for i in 1..=n {
        if i > 1 {
            push(l, b"\t");
        }
        to_text(l, i);
    }
    if n == 0 {
        push(l, b"");
    } else {
        lua_concat(l, 2 * n - 1);
    }
    budget::charge_units(l, budget::LINE * INSTRUCTION + lua_rawlen(l, -1) as u64 * BYTE);
    crate::io::print(state::of(l), bytes(l, -1));
    0
}

/// `string.format`: prepares arguments, then calls Lua's own function.
pub(crate) unsafe extern "C-unwind" fn format(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    let format = {
        let mut len = 0;
        let ptr = luaL_checklstring(l, 1, &mut len);
        std::slice::from_raw_parts(ptr.cast::<u8>(), len)
    };
    let (top, old) = (lua_gettop(l), s.old.get());
    let (mut i, mut arg, mut copy) = (0, 1, std::ptr::null_mut::<u8>());
    luaL_checkstack(l, 10, std::ptr::null());
    while i < format.len() {
        i += 1;
        if format[i - 1] != b'%' {
            continue;
        }
        if format.get(i) == Some(&b'%') {
            i += 1;
            continue;
        }
        while format.get(i).is_some_and(|b| b"-+ #0123456789.".contains(b)) {
            i += 1;
        }
        arg += 1;
        let Some(conversion) = format.get(i) else {
            break;
        };
        if arg > top {
            break;
        }
        let kind = lua_type(l, arg);
        let mut instead = 0;
        match conversion {
            b's' if kind > LUA_TSTRING || kind == LUA_TLIGHTUSERDATA => {
                to_text(l, arg);
                lua_replace(l, arg);
            }
            b'p' => {
                instead = b's';
                if kind > LUA_TSTRING {
                    address(l, arg);
                } else {
                    push(l, b"(null)");
                }
                lua_replace(l, arg);
            }
            b'd' | b'i' | b'u' | b'c' | b'o' | b'x' | b'X' if old => {
                truncate_at(l, arg);
                if *conversion == b'u' {
                    instead = b'd';
                }
            }
            _ => {}
        }
        if instead != 0 {
            if copy.is_null() {
                copy = lua_newuserdatauv(l, format.len(), 0).cast();
                std::ptr::copy_nonoverlapping(format.as_ptr(), copy, format.len());
            }
            *copy.add(i) = instead;
        }
    }
    if !copy.is_null() {
        lua_pushlstring(l, copy.cast(), format.len());
        lua_replace(l, 1);
        lua_settop(l, top);
    }
    s.originals.call(l, crate::stdlib::FORMAT)
}

/// Converts a float, or a string that is one, to an integer as Lua 5.1 did: truncated, and the least integer if out of
/// range.
///
/// # Safety
/// `idx` is absolute.
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
