//! Functions of Lua's library that this plugin wraps.

use std::cell::Cell;

use mlua_sys::*;

/// Library functions that this plugin wraps.
#[derive(Default)]
pub(crate) struct WrappedFunctions([Cell<Option<lua_CFunction>>; 4]);

pub(crate) const FORMAT: usize = 0;
pub(crate) const LOAD: usize = 1;
pub(crate) const CREATE: usize = 2;
pub(crate) const WRAP: usize = 3;

impl WrappedFunctions {
    /// Stores a library function at index `which`.
    pub(crate) fn store(&self, which: usize, function: Option<lua_CFunction>) {
        self.0[which].set(function);
    }
    /// Tail-calls the library function at index `which`.
    ///
    /// # Safety
    /// The call must be the last action of a C function of Lua.
    pub(crate) unsafe fn call(&self, l: *mut lua_State, which: usize) -> i32 {
        match self.0[which].get() {
            Some(f) => f(l),
            None => 0,
        }
    }
}
