//! Lists the objects that existed before a script ran. The order of the list is the same in every state that was
//! created in the same way, so an index identifies an object.

use std::{
    collections::HashSet,
    hash::{BuildHasherDefault, Hasher},
};

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use super::roots::roots;
use crate::{errors::protect, stack::reg, state::ScriptState};

/// Set of visited addresses. It is never iterated, so a cheap hash is sufficient.
type VisitedAddresses = HashSet<usize, BuildHasherDefault<AddressHasher>>;

#[derive(Default)]
struct AddressHasher(u64);

impl Hasher for AddressHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_usize(usize::from(*b)));
    }
    fn write_usize(&mut self, n: usize) {
        self.0 = (self.0 ^ n as u64 >> 4).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
    fn finish(&self) -> u64 {
        self.0
    }
}

/// Creates the list. Must be called after the script has been loaded and before it runs.
pub(crate) fn record(s: &ScriptState) -> Result {
    let mut seen = VisitedAddresses::with_capacity_and_hasher(512, BuildHasherDefault::default());
    // SAFETY: `protect` calls the closure with a live thread in protected mode; `seen` belongs to this function, so a
    // Lua error leaks nothing.
    protect(s, &mut |l| unsafe {
        luaL_checkstack(l, 32, std::ptr::null());
        lua_createtable(l, 256, 0); // 1
        let n = roots(l);
        for i in 2..2 + n {
            add(l, i, &mut seen);
        }
        lua_settop(l, 1);
        let mut at = 0;
        while at < seen.len() {
            at += 1;
            lua_rawgeti(l, 1, at as i64);
            add_references(l, &mut seen);
            lua_settop(l, 1);
        }
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::BASELINE_OBJECTS);
    })
}

/// Adds the object at `idx` to the list in stack slot 1.
unsafe fn add(l: *mut lua_State, idx: i32, seen: &mut VisitedAddresses) {
    if matches!(lua_type(l, idx), LUA_TTABLE | LUA_TFUNCTION | LUA_TUSERDATA)
        && seen.insert(lua_topointer(l, idx) as usize)
    {
        lua_pushvalue(l, idx);
        lua_rawseti(l, 1, seen.len() as i64);
    }
}

/// Adds the objects to which the object on top of the stack refers.
unsafe fn add_references(l: *mut lua_State, seen: &mut VisitedAddresses) {
    let top = lua_gettop(l);
    match lua_type(l, top) {
        LUA_TTABLE => {
            lua_pushnil(l);
            while lua_next(l, top) != 0 {
                add(l, top + 1, seen);
                add(l, top + 2, seen);
                lua_settop(l, top + 1);
            }
        }
        LUA_TFUNCTION => {
            let mut n = 1;
            while !lua_getupvalue(l, top, n).is_null() {
                add(l, top + 1, seen);
                lua_settop(l, top);
                n += 1;
            }
        }
        _ => {}
    }
    if lua_getmetatable(l, top) != 0 {
        add(l, top + 1, seen);
    }
}
