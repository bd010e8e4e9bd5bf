//! `tostring`, `print` and `string.format`.

use mlua_sys::*;

use crate::{
    lua_internals::{UNITS_PER_BYTE, UNITS_PER_INSTRUCTION},
    run::budget,
    stack::{bytes, push},
    state::{self, originals::FORMAT},
    values::{address, to_text, truncate_at},
};

pub(crate) unsafe extern "C-unwind" fn tostring(l: *mut lua_State) -> i32 {
    luaL_checkany(l, 1);
    to_text(l, 1);
    1
}

/// Implements `print`: writes a log line.
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
    budget::charge_units(l, budget::LOG_LINE_COST * UNITS_PER_INSTRUCTION + lua_rawlen(l, -1) as u64 * UNITS_PER_BYTE);
    state::of(l).log_line(bytes(l, -1));
    0
}

/// Implements `string.format`: converts arguments, then calls Lua's own function.
pub(crate) unsafe extern "C-unwind" fn format(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    let format = {
        let mut len = 0;
        let ptr = luaL_checklstring(l, 1, &mut len);
        std::slice::from_raw_parts(ptr.cast::<u8>(), len)
    };
    let (top, old) = (lua_gettop(l), s.mode.old.get());
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
    s.originals.call(l, FORMAT)
}
