//! Names that an API gives to fields in the maps passed to and returned by callbacks.
//!
//! The host uses neutral field names. A prelude declares the corresponding names in its API, for example
//! `arguments.dyn.step = "passCnt"` and `results.contact.ignoreContact = "ignore"`. A list of names gives a field several
//! names at once, for an API whose names changed: `arguments.joint.pos = {"pos", "currentPos"}`.

use mlua_sys::*;

use crate::stack::{bytes, push, read_strings};

/// Renamed fields: callback, original name, new name.
#[derive(Default)]
pub(crate) struct FieldNames(Vec<(Vec<u8>, Vec<u8>, Vec<u8>)>);

impl FieldNames {
    /// Reads `{callback = {original = "new", other = {"new", "newer"}}}` from the table on top.
    ///
    /// # Safety
    /// Must run in protected mode, with a table on top.
    pub(crate) unsafe fn read(&mut self, l: *mut lua_State) {
        luaL_checkstack(l, 6, std::ptr::null());
        lua_pushnil(l);
        while lua_next(l, -2) != 0 {
            if lua_type(l, -2) == LUA_TSTRING && lua_type(l, -1) == LUA_TTABLE {
                let callback = bytes(l, -2).to_vec();
                lua_pushnil(l);
                while lua_next(l, -2) != 0 {
                    if lua_type(l, -2) == LUA_TSTRING {
                        let original = bytes(l, -2).to_vec();
                        let mut names = Vec::new();
                        match lua_type(l, -1) {
                            LUA_TSTRING => names.push(bytes(l, -1).to_vec()),
                            LUA_TTABLE => read_strings(l, &mut names),
                            _ => {}
                        }
                        self.0.extend(names.into_iter().map(|name| (callback.clone(), original.clone(), name)));
                    }
                    lua_pop(l, 1);
                }
            }
            lua_pop(l, 1);
        }
        self.0.sort();
    }

    /// Returns whether a callback has renamed fields.
    pub(crate) fn has(&self, callback: &[u8]) -> bool {
        self.0.iter().any(|(of, _, _)| of == callback)
    }

    /// Replaces the table at index `at` with a copy in which fields are renamed, because the table itself may belong to
    /// the script. Any other value at `at` remains unchanged.
    ///
    /// # Safety
    /// Must run in protected mode; `at` must be a positive stack index.
    pub(crate) unsafe fn rename(&self, l: *mut lua_State, callback: &[u8], at: i32) {
        if !self.has(callback) || lua_type(l, at) != LUA_TTABLE {
            return;
        }
        luaL_checkstack(l, 6, std::ptr::null());
        lua_createtable(l, 0, 0);
        let copy = lua_gettop(l);
        lua_pushnil(l);
        while lua_next(l, at) != 0 {
            let original = if lua_type(l, -2) == LUA_TSTRING { bytes(l, -2) } else { b"" };
            let mut names = self.0.iter().filter(|(of, before, _)| of == callback && before == original).peekable();
            if names.peek().is_none() {
                lua_pushvalue(l, -2);
                lua_pushvalue(l, -2);
                lua_rawset(l, copy);
            }
            for (_, _, name) in names {
                push(l, name);
                lua_pushvalue(l, -2);
                lua_rawset(l, copy);
            }
            lua_pop(l, 1);
        }
        lua_replace(l, at);
    }
}
