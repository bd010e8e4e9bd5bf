//! Functions of the script that are passed to the host: borrowed for a call, or kept until the host releases them.

use mlua_sys::*;

use crate::{
    errors::protect,
    stack::{reg, registry},
    state::{self, ScriptState},
};

/// First id of a kept function; lower ids belong to borrowed functions.
const FIRST_KEPT_ID: u32 = 1 << 31;

/// Registers the function at `idx` as borrowed. The returned id is valid until `release_borrowed_since` is called with
/// a lower id, or until `release_borrowed` is called.
///
/// # Safety
/// The stack must have two free slots. May raise a Lua error.
pub(crate) unsafe fn borrow(l: *mut lua_State, s: &ScriptState, idx: i32) -> u32 {
    let id = s.functions.last_borrowed.get() % (FIRST_KEPT_ID - 1) + 1;
    s.functions.last_borrowed.set(id);
    registry(l, reg::BORROWED_FUNCTIONS);
    lua_pushvalue(l, idx);
    lua_rawseti(l, -2, i64::from(id));
    lua_pop(l, 1);
    id
}

/// Removes the functions borrowed since `before`.
///
/// # Safety
/// The stack must have two free slots. Does not raise an error, because the entries exist.
pub(crate) unsafe fn release_borrowed_since(l: *mut lua_State, s: &ScriptState, before: u32) {
    let now = s.functions.last_borrowed.get();
    if now == before {
        return;
    }
    registry(l, reg::BORROWED_FUNCTIONS);
    let mut id = before;
    while id != now {
        id = id % (FIRST_KEPT_ID - 1) + 1;
        lua_pushnil(l);
        lua_rawseti(l, -2, i64::from(id));
    }
    lua_pop(l, 1);
}

/// Removes borrowed functions that outlived their call: results, and arguments of calls that failed.
///
/// # Safety
/// May raise a Lua error.
pub(crate) unsafe fn release_borrowed(l: *mut lua_State, s: &ScriptState) {
    if s.functions.last_borrowed.get() != s.functions.released.get() {
        s.functions.released.set(s.functions.last_borrowed.get());
        lua_newtable(l);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::BORROWED_FUNCTIONS);
    }
}

/// Pushes a function value: the function itself if it belongs to this script, otherwise a closure that calls the other
/// script.
///
/// # Safety
/// The stack must have two free slots. May raise a Lua error.
pub(crate) unsafe fn put(l: *mut lua_State, func: u64) {
    let s = state::of(l);
    if func >> 32 == s.border.instance.id {
        push_by_id(l, func as u32);
    } else {
        lua_pushinteger(l, func as i64);
        lua_pushcclosure(l, s.foreign, 1);
    }
}

/// Pushes the function with the given id, or nil if there is no such function.
pub(super) unsafe fn push_by_id(l: *mut lua_State, local: u32) {
    registry(l, if local >= FIRST_KEPT_ID { reg::KEPT_FUNCTIONS } else { reg::BORROWED_FUNCTIONS });
    lua_rawgeti(l, -1, i64::from(local & !FIRST_KEPT_ID));
    lua_replace(l, -2);
}

/// Converts a borrowed function to a kept one, and returns its new id, or 0 if that is not possible.
pub(crate) fn keep(s: &ScriptState, local: u32) -> u32 {
    let mut id = 0;
    // SAFETY: `protect` calls the closure with a live thread and free stack slots, catches Lua errors, and resets the
    // stack.
    let done = protect(s, &mut |l| unsafe {
        push_by_id(l, local);
        if lua_type(l, -1) != LUA_TFUNCTION {
            return;
        }
        let next = s.functions.last_kept.get() + 1;
        if next >= FIRST_KEPT_ID {
            return;
        }
        registry(l, reg::KEPT_FUNCTIONS);
        lua_insert(l, -2);
        lua_rawseti(l, -2, i64::from(next));
        s.functions.last_kept.set(next);
        id = FIRST_KEPT_ID | next;
    });
    if done.is_err() { 0 } else { id }
}

/// Releases a kept function, so that it can be collected; borrowed functions are ignored.
pub(crate) fn drop(s: &ScriptState, local: u32) {
    if local < FIRST_KEPT_ID {
        return;
    }
    // SAFETY: `protect` calls the closure with a live thread and free stack slots, catches Lua errors, and resets the
    // stack.
    let _ = protect(s, &mut |l| unsafe {
        registry(l, reg::KEPT_FUNCTIONS);
        lua_pushnil(l);
        lua_rawseti(l, -2, i64::from(local & !FIRST_KEPT_ID));
    });
}
