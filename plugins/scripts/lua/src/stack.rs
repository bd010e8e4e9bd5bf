//! Helpers for the stack and the registry of a Lua state.

use mlua_sys::*;

/// Keys in Lua's registry; 1 and 2 are reserved by Lua.
pub(crate) mod reg {
    /// The compiled source of the script, a function.
    pub const SCRIPT_CHUNK: i64 = 10;
    /// Functions passed to the host for the duration of a call: id -> function.
    pub const BORROWED_FUNCTIONS: i64 = 11;
    /// Functions kept by the host: id -> function.
    pub const KEPT_FUNCTIONS: i64 = 12;
    /// Waiting coroutines: token -> coroutine.
    pub const WAITING_COROUTINES: i64 = 13;
    /// Results of finished waits: token -> packed results.
    pub const WAIT_RESULTS: i64 = 14;
    /// Numbers that `tostring` returns in place of addresses: object -> number.
    pub const OBJECT_NUMBERS: i64 = 15;
    /// Namespace tables: prefix -> table ("" for the globals).
    pub const NAMESPACES: i64 = 16;
    /// Metatable of the userdata of files.
    pub const FILE_METATABLE: i64 = 17;
    /// Coroutines created by the plugin: coroutine -> true.
    pub const PLUGIN_COROUTINES: i64 = 18;
    /// Modules loaded by `require`: name -> value.
    pub const LOADED_MODULES: i64 = 19;
    /// Objects that existed before the script ran: index -> object.
    pub const BASELINE_OBJECTS: i64 = 20;
    /// Objects of a snapshot, while it is restored.
    pub const RESTORED_OBJECTS: i64 = 21;
    /// Constants of preludes: name -> value.
    pub const CONSTANTS: i64 = 22;
    /// Names of the globals that a script of the style `RerunRules` reads: the callback, and the script's handle.
    pub const RERUN_GLOBALS: i64 = 23;
}

/// Returns the bytes of the string or number at `idx`; converts a number in place. Returns an empty slice for other
/// types.
///
/// # Safety
/// The slice must be used only while the value is on the stack.
pub(crate) unsafe fn bytes<'a>(l: *mut lua_State, idx: i32) -> &'a [u8] {
    let mut len = 0;
    let ptr = lua_tolstring(l, idx, &mut len);
    if ptr.is_null() {
        return &[];
    }
    std::slice::from_raw_parts(ptr.cast(), len)
}

/// Pushes a string.
///
/// # Safety
/// The stack must have one free slot. May raise a Lua error.
pub(crate) unsafe fn push(l: *mut lua_State, text: &[u8]) {
    lua_pushlstring(l, text.as_ptr().cast(), text.len());
}

/// Pushes a registry value, and returns its type.
///
/// # Safety
/// The stack must have one free slot.
pub(crate) unsafe fn registry(l: *mut lua_State, place: i64) -> i32 {
    lua_rawgeti(l, LUA_REGISTRYINDEX, place)
}

/// Sets a field of the table on top of the stack to a C function.
///
/// # Safety
/// The stack must have two free slots. May raise a Lua error.
pub(crate) unsafe fn set(l: *mut lua_State, name: &std::ffi::CStr, f: lua_CFunction) {
    lua_pushinteger(l, 0);
    lua_pushcclosure(l, f, 1);
    lua_setfield(l, -2, name.as_ptr());
}

/// Reads the list of strings on top of the stack.
///
/// # Safety
/// Must run in protected mode, with a table on top and one free stack slot.
pub(crate) unsafe fn read_strings(l: *mut lua_State, out: &mut Vec<Vec<u8>>) {
    for i in 1..=lua_rawlen(l, -1) {
        lua_rawgeti(l, -1, i as i64);
        out.push(bytes(l, -1).to_vec());
        lua_pop(l, 1);
    }
}
