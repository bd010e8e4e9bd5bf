//! `table.sort`. In unbalanced ranges, Lua's own implementation chooses pivots by the clock, so that the order of equal
//! elements differs between runs. This implementation uses the same algorithm with deterministic pivots.

use mlua_sys::*;

use crate::errors;

pub(crate) unsafe extern "C-unwind" fn sort(l: *mut lua_State) -> i32 {
    luaL_checktype(l, 1, LUA_TTABLE);
    let n = luaL_len(l, 1);
    if n > 1 {
        if n >= i64::from(i32::MAX) {
            return errors::raise_text(l, "bad argument #1 to 'sort' (array too big)");
        }
        if lua_type(l, 2) > LUA_TNIL {
            luaL_checktype(l, 2, LUA_TFUNCTION);
        }
        lua_settop(l, 2);
        luaL_checkstack(l, 40, std::ptr::null());
        quick(l, 1, n, 0);
    }
    0
}

/// Returns whether the value at `a` sorts before the value at `b`; both indices are relative to the top of the stack.
unsafe fn before(l: *mut lua_State, a: i32, b: i32) -> bool {
    if lua_type(l, 2) == LUA_TNIL {
        return lua_compare(l, a, b, LUA_OPLT) != 0;
    }
    lua_pushvalue(l, 2);
    lua_pushvalue(l, a - 1);
    lua_pushvalue(l, b - 2);
    lua_call(l, 2, 1);
    let result = lua_toboolean(l, -1) != 0;
    lua_pop(l, 1);
    result
}

unsafe fn set2(l: *mut lua_State, i: i64, j: i64) {
    lua_seti(l, 1, i);
    lua_seti(l, 1, j);
}

/// Partitions by the pivot on top of the stack, which is also at `up - 1`; returns the pivot's final index.
unsafe fn partition(l: *mut lua_State, lo: i64, up: i64) -> i64 {
    let (mut i, mut j) = (lo, up - 1);
    loop {
        i += 1;
        lua_geti(l, 1, i);
        while before(l, -1, -2) {
            if i == up - 1 {
                errors::raise_text(l, "invalid order function for sorting");
            }
            lua_pop(l, 1);
            i += 1;
            lua_geti(l, 1, i);
        }
        j -= 1;
        lua_geti(l, 1, j);
        while before(l, -3, -1) {
            if j < i {
                errors::raise_text(l, "invalid order function for sorting");
            }
            lua_pop(l, 1);
            j -= 1;
            lua_geti(l, 1, j);
        }
        if j < i {
            lua_pop(l, 1);
            set2(l, up - 1, i);
            return i;
        }
        set2(l, i, j);
    }
}

unsafe fn quick(l: *mut lua_State, mut lo: i64, mut up: i64, mut turn: i64) {
    luaL_checkstack(l, 40, c"too many levels".as_ptr());
    while lo < up {
        lua_geti(l, 1, lo);
        lua_geti(l, 1, up);
        if before(l, -1, -2) {
            set2(l, lo, up);
        } else {
            lua_pop(l, 2);
        }
        if up - lo == 1 {
            return;
        }
        // The pivot is the middle element or, in large unbalanced ranges, an element near the middle.
        let quarter = (up - lo) / 4;
        let mut p = if up - lo < 100 || turn == 0 { (lo + up) / 2 } else { turn % (quarter * 2) + lo + quarter };
        lua_geti(l, 1, p);
        lua_geti(l, 1, lo);
        if before(l, -2, -1) {
            set2(l, p, lo);
        } else {
            lua_pop(l, 1);
            lua_geti(l, 1, up);
            if before(l, -1, -2) {
                set2(l, p, up);
            } else {
                lua_pop(l, 2);
            }
        }
        if up - lo == 2 {
            return;
        }
        lua_geti(l, 1, p);
        lua_pushvalue(l, -1);
        lua_geti(l, 1, up - 1);
        set2(l, p, up - 1);
        p = partition(l, lo, up);
        let smaller;
        if p - lo < up - p {
            quick(l, lo, p - 1, turn);
            smaller = p - lo;
            lo = p + 1;
        } else {
            quick(l, p + 1, up, turn);
            smaller = up - p;
            up = p - 1;
        }
        if (up - lo) / 128 > smaller {
            turn = (turn.wrapping_mul(1_103_515_245).wrapping_add(12_345) & 0x7FFF_FFFF) | 1;
        }
    }
}
