//! The root objects, from which the traversal of a state starts.

use mlua_sys::*;

use crate::stack::{reg, registry};

/// Pushes the root objects, all of which existed before the script ran; returns their number.
///
/// # Safety
/// The stack must have enough free slots for all of them.
pub(super) unsafe fn roots(l: *mut lua_State) -> i32 {
    lua_pushglobaltable(l);
    lua_pushlstring(l, c"".as_ptr(), 0);
    lua_getmetatable(l, -1);
    lua_replace(l, -2);
    for place in ROOT_PLACES {
        registry(l, place);
    }
    2 + ROOT_PLACES.len() as i32
}

/// Registry values that are part of the script's state.
const ROOT_PLACES: [i64; 5] =
    [reg::KEPT_FUNCTIONS, reg::NAMESPACES, reg::LOADED_MODULES, reg::FILE_METATABLE, reg::SCRIPT_CHUNK];
/// Names of the root objects in messages.
pub(super) const ROOT_NAMES: [&str; 7] = [
    "",
    "the methods of strings",
    "the functions that commands store",
    "the tables of commands",
    "the modules that `require` has loaded",
    "the methods of files",
    "the text",
];
