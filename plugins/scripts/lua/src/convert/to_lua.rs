//! Conversion of ABI values to Lua.

use std::ptr::null;

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::MAX_DEPTH;
use crate::{errors, run::functions, stack::push};

/// Pushes a value.
///
/// # Safety
/// The stack must have one free slot, and the value's spans must be valid for reads. May raise a Lua error.
#[inline(always)]
pub(crate) unsafe fn put(l: *mut lua_State, v: &tatu_value) {
    match v.tag {
        TATU_NIL => lua_pushnil(l),
        TATU_BOOL => lua_pushboolean(l, i32::from(v.u.i != 0)),
        TATU_I64 => lua_pushinteger(l, v.u.i),
        TATU_F64 => lua_pushnumber(l, v.u.f),
        TATU_OBJECT => lua_pushinteger(l, i64::from(tatu_slot(v.u.u))),
        _ => put_deep(l, v, 0),
    }
}

#[inline(never)]
unsafe fn put_deep(l: *mut lua_State, v: &tatu_value, depth: u32) {
    /// Pushes an array of numbers as a table.
    unsafe fn push_numbers<T: Copy>(l: *mut lua_State, v: &tatu_value, push: unsafe fn(*mut lua_State, T)) {
        let (ptr, n) = (v.u.s.ptr.cast::<T>(), v.u.s.len as usize);
        lua_createtable(l, n.min(i32::MAX as usize) as i32, 0);
        for i in 0..n {
            push(l, ptr.add(i).read_unaligned());
            lua_rawseti(l, -2, i as i64 + 1);
        }
    }
    unsafe fn push_float<T: Into<f64>>(l: *mut lua_State, x: T) {
        lua_pushnumber(l, x.into());
    }
    unsafe fn push_integer<T: Into<i64>>(l: *mut lua_State, x: T) {
        lua_pushinteger(l, x.into());
    }
    if depth > MAX_DEPTH {
        errors::raise(l, Fail::argument("a value is nested more than 32 levels deep"));
    }
    luaL_checkstack(l, 4, null());
    match v.tag {
        TATU_NIL | TATU_BOOL | TATU_I64 | TATU_F64 | TATU_OBJECT => put(l, v),
        TATU_TEXT | TATU_BYTES if v.u.s.ptr.is_null() => push(l, b""),
        TATU_TEXT | TATU_BYTES => {
            lua_pushlstring(l, v.u.s.ptr.cast(), v.u.s.len as usize);
        }
        TATU_F64S => push_numbers::<f64>(l, v, push_float),
        TATU_F32S => push_numbers::<f32>(l, v, push_float),
        TATU_I64S => push_numbers::<i64>(l, v, push_integer),
        TATU_I32S => push_numbers::<i32>(l, v, push_integer),
        TATU_U8S => push_numbers::<u8>(l, v, push_integer),
        TATU_LIST => {
            let (ptr, n) = (v.u.s.ptr.cast::<tatu_value>(), v.u.s.len as usize);
            lua_createtable(l, n.min(i32::MAX as usize) as i32, 0);
            for i in 0..n {
                put_deep(l, &*ptr.add(i), depth + 1);
                lua_rawseti(l, -2, i as i64 + 1);
            }
        }
        TATU_MAP => {
            let (ptr, n) = (v.u.s.ptr.cast::<tatu_pair>(), v.u.s.len as usize);
            lua_createtable(l, 0, n.min(i32::MAX as usize) as i32);
            for i in 0..n {
                let pair = &*ptr.add(i);
                if pair.key.tag == TATU_NIL {
                    continue;
                }
                put_deep(l, &pair.key, depth + 1);
                put_deep(l, &pair.value, depth + 1);
                lua_rawset(l, -3);
            }
        }
        TATU_FUNC => functions::put(l, v.u.u),
        tag => {
            errors::raise(l, Fail::argument(format!("a value has the unknown tag {tag}")));
        }
    }
}

/// Pushes the arguments of a call from the host and returns their number.
///
/// # Safety
/// The frame's arguments must be valid for reads. May raise a Lua error.
pub(crate) unsafe fn put_args(l: *mut lua_State, frame: *const tatu_call) -> i32 {
    let n = (*frame).n_args as i32;
    luaL_checkstack(l, n + 4, null());
    for i in 0..n as usize {
        put(l, &*(*frame).args.add(i));
    }
    n
}
