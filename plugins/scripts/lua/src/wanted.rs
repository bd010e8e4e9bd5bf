//! How many results of a running C function its caller takes.
//!
//! Lua knows, but its interface does not tell: it stands in the record of the call. A function of V-REP's gives up to five
//! values, some of them tables, and most scripts take two; tables that nobody takes need not be made. The place of the
//! number is that of Lua 5.4 and is tried out once; where it is another, all results are made.

use std::sync::OnceLock;

use mlua::ffi::*;

/// Bytes from the beginning of a state to the address of its running call, and from that of a call to the number.
const CALL_OF_STATE: usize = 32;
const WANTED_OF_CALL: usize = 60;

static KNOWN: OnceLock<bool> = OnceLock::new();

/// How many of `n` results the caller of the running C function takes; all, where that cannot be told.
///
/// # Safety
/// `l` runs a C function.
#[inline]
pub(crate) unsafe fn wanted(l: *mut lua_State, n: u32) -> u32 {
    if KNOWN.get() != Some(&true) {
        return n;
    }
    // Negative: all, or all and one to be closed.
    u32::try_from(read(l)).map_or(n, |wanted| wanted.min(n))
}

unsafe fn read(l: *mut lua_State) -> i16 {
    let call = l.cast::<u8>().add(CALL_OF_STATE).cast::<*const u8>().read();
    call.add(WANTED_OF_CALL).cast::<i16>().read()
}

/// Tries out whether numbers are found where they should be; without that nothing is left out.
pub(crate) fn try_out() {
    KNOWN.get_or_init(|| cfg!(target_pointer_width = "64") && found() == EXPECTED);
}

/// Calls that take one to four results, none, all, and one through a metatable.
const TEXT: &[u8] = b"local f, t = ... local a = f() local a, b = f() local a, b, c, d = f() f() t(f()) local a = -t \
    local function tail() return f() end local a, b, c = tail() for i in f do break end";
const EXPECTED: [i16; 8] = [1, 2, 4, 0, -1, 1, -1, 1];

unsafe extern "C-unwind" fn note(l: *mut lua_State) -> i32 {
    let all = lua_touserdata(l, lua_upvalueindex(1)).cast::<Vec<i16>>();
    (*all).push(read(l));
    0
}

unsafe extern "C-unwind" fn nothing(_: *mut lua_State) -> i32 {
    0
}

/// What the calls of `TEXT` are found to take.
fn found() -> Vec<i16> {
    let mut found = Vec::<i16>::new();
    // SAFETY: a state of our own; a failed call finds nothing.
    unsafe {
        let l = luaL_newstate();
        if l.is_null() {
            return found;
        }
        // Elsewhere there is nothing to be read.
        let is_5_4 = lua_version(l) == 504.0;
        if is_5_4 && luaL_loadbuffer(l, TEXT.as_ptr().cast(), TEXT.len(), c"=wanted".as_ptr()) == LUA_OK {
            lua_pushlightuserdata(l, (&raw mut found).cast());
            lua_pushcclosure(l, note, 1);
            lua_newtable(l);
            lua_newtable(l);
            lua_pushvalue(l, -3);
            lua_setfield(l, -2, c"__unm".as_ptr());
            lua_pushcfunction(l, nothing);
            lua_setfield(l, -2, c"__call".as_ptr());
            lua_setmetatable(l, -2);
            lua_pcall(l, 2, 0, 0);
        }
        lua_close(l);
    }
    found
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_taken_stands_where_it_is_looked_for() {
        assert_eq!(super::found(), super::EXPECTED);
    }
}
