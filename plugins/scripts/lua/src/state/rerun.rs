//! Rules for scripts that are run again for each callback.

use mlua_sys::*;
use tatu_plugin_api::abi::tatu_slot;

use crate::{
    lexer,
    stack::{bytes, push, read_strings, reg, registry},
};

/// Rules for scripts that are run again for each callback.
#[derive(Default)]
pub(crate) struct RerunRules {
    /// The global that identifies the callback.
    pub variable: Vec<u8>,
    /// Value of the variable for each callback.
    pub values: Vec<(Vec<u8>, i64)>,
    /// Callbacks that run only in scripts that contain one of these names.
    needs: Vec<(Vec<u8>, Vec<Vec<u8>>)>,
    /// Globals whose value is the script's own handle.
    pub script: Vec<Vec<u8>>,
}

impl RerunRules {
    /// Reads the rules from the table on top.
    ///
    /// # Safety
    /// Must run in protected mode, with a few free stack slots.
    pub(crate) unsafe fn read_rules(&mut self, l: *mut lua_State) {
        lua_getfield(l, -1, c"variable".as_ptr());
        self.variable.extend_from_slice(bytes(l, -1));
        lua_pop(l, 1);
        if lua_getfield(l, -1, c"values".as_ptr()) == LUA_TTABLE {
            lua_pushnil(l);
            while lua_next(l, -2) != 0 {
                if lua_type(l, -2) == LUA_TSTRING {
                    let value = lua_tointeger(l, -1);
                    self.values.push((bytes(l, -2).to_vec(), value));
                }
                lua_pop(l, 1);
            }
        }
        lua_pop(l, 1);
        if lua_getfield(l, -1, c"needs".as_ptr()) == LUA_TTABLE {
            lua_pushnil(l);
            while lua_next(l, -2) != 0 {
                if lua_type(l, -2) == LUA_TSTRING && lua_type(l, -1) == LUA_TTABLE {
                    self.needs.push((bytes(l, -2).to_vec(), Vec::new()));
                    if let Some((_, words)) = self.needs.last_mut() {
                        read_strings(l, words);
                    }
                }
                lua_pop(l, 1);
            }
        }
        lua_pop(l, 1);
        if lua_getfield(l, -1, c"extra".as_ptr()) == LUA_TTABLE {
            lua_pushnil(l);
            while lua_next(l, -2) != 0 {
                if lua_type(l, -2) == LUA_TSTRING && bytes(l, -1) == b"script" {
                    self.script.push(bytes(l, -2).to_vec());
                }
                lua_pop(l, 1);
            }
        }
        lua_pop(l, 1);
    }
    /// Returns whether the script is run for a callback.
    pub(crate) fn has(&self, callback: &[u8]) -> bool {
        self.value(callback).is_some()
    }
    /// Removes the callbacks that require names which the script does not contain.
    pub(crate) fn require_words(&mut self, words: &[Vec<u8>]) {
        let needs = std::mem::take(&mut self.needs);
        let has = |w: &Vec<u8>| words.binary_search(w).is_ok();
        self.values
            .retain(|(callback, _)| needs.iter().filter(|(name, _)| name == callback).all(|(_, w)| w.iter().any(has)));
    }
    /// If the script consists only of branches on the variable, removes the callbacks without a branch; `number`
    /// returns the value of a word.
    pub(crate) fn drop_empty_branches(&mut self, text: &[u8], number: impl Fn(&[u8]) -> Option<i64>) {
        let Some(branches) = lexer::branches(text, &self.variable) else { return };
        let values: Option<Vec<i64>> = branches.iter().map(|name| number(name)).collect();
        if let Some(values) = values {
            self.values.retain(|(callback, value)| callback == b"init" || values.contains(value));
        }
    }
    /// Sets the globals for a run of the script that belongs to `owner`.
    ///
    /// # Safety
    /// Must run in protected mode, with a few free stack slots.
    pub(crate) unsafe fn set_globals(&self, l: *mut lua_State, owner: u64, value: Option<i64>) {
        if registry(l, reg::RERUN_GLOBALS) != LUA_TTABLE {
            lua_pop(l, 1);
            self.cache_names(l);
        }
        lua_pushglobaltable(l);
        lua_rawgeti(l, -2, 1);
        match value {
            Some(value) => lua_pushinteger(l, value),
            None => lua_pushnil(l),
        }
        lua_rawset(l, -3);
        for i in 2..self.script.len() as i64 + 2 {
            lua_rawgeti(l, -2, i);
            lua_pushinteger(l, i64::from(tatu_slot(owner)));
            lua_rawset(l, -3);
        }
        lua_pop(l, 2);
    }
    /// Pushes the list of the names of the globals that are set for each run (`variable` and `script`), and caches it,
    /// because creating the strings takes longer than a lookup.
    unsafe fn cache_names(&self, l: *mut lua_State) {
        lua_createtable(l, 1 + self.script.len() as i32, 0);
        push(l, &self.variable);
        lua_rawseti(l, -2, 1);
        for (name, i) in self.script.iter().zip(2..) {
            push(l, name);
            lua_rawseti(l, -2, i);
        }
        lua_pushvalue(l, -1);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::RERUN_GLOBALS);
    }
    /// Returns the value of the global for a callback.
    pub(crate) fn value(&self, callback: &[u8]) -> Option<i64> {
        self.values.iter().find(|(name, _)| name == callback).map(|v| v.1)
    }
}
