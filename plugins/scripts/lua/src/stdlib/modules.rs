//! `require`, `dofile` and `loadfile`: modules of command plugins, namespaces, and files in allowed folders.

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    errors,
    lua_internals::UNITS_PER_BYTE,
    run::budget,
    stack::{bytes, push, reg, registry, set},
    state::{self, ScriptState, preludes, push_scratch},
};

/// Installs `require`, `dofile`, `loadfile` and the table `package`.
///
/// # Safety
/// Must run in protected mode, while the state is created.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_pushglobaltable(l);
    set(l, c"require", require);
    set(l, c"dofile", dofile);
    set(l, c"loadfile", loadfile);
    lua_createtable(l, 0, 4);
    registry(l, reg::LOADED_MODULES);
    lua_setfield(l, -2, c"loaded".as_ptr());
    lua_newtable(l);
    lua_setfield(l, -2, c"preload".as_ptr());
    for name in [c"path", c"cpath"] {
        push(l, b"");
        lua_setfield(l, -2, name.as_ptr());
    }
    lua_setfield(l, -2, c"package".as_ptr());
    lua_pop(l, 1);
}

/// Maximum size of a source file, in bytes.
const MAX_SOURCE_BYTES: u64 = 16 << 20;

/// Reads a file into the scratch buffer; returns false on failure, with the reason in the buffer.
fn read(s: &ScriptState, name: &[u8]) -> bool {
    let (done, content) = match s.world().read_file(name, MAX_SOURCE_BYTES) {
        Ok(content) => (true, content),
        Err(reason) => {
            let name = String::from_utf8_lossy(name);
            (false, format!("cannot open {name}: {reason}").into_bytes())
        }
    };
    *s.streams.scratch.borrow_mut() = content;
    done
}

/// Maximum number, and maximum total size in bytes, of sources that are stored for snapshots. Without limits, a script
/// that loads a new source in each step would use up the memory.
const MAX_STORED_SOURCES: usize = 64;
const MAX_STORED_BYTES: usize = 1 << 20;

/// Stores a source that is about to be loaded, so that a snapshot can refer to its functions.
pub(crate) fn store_source(s: &ScriptState, name: &[u8], text: &[u8]) {
    let mut texts = s.sources.loaded_sources.borrow_mut();
    if texts.iter().any(|(n, t)| n == name && t == text) {
        return;
    }
    let bytes: usize = texts.iter().map(|(n, t)| n.len() + t.len()).sum();
    if texts.len() < MAX_STORED_SOURCES && bytes + name.len() + text.len() <= MAX_STORED_BYTES {
        texts.push((name.to_vec(), text.to_vec()));
    }
}

/// Compiles the file whose name is at `idx`. Pushes a function, or nil and the reason for the failure.
unsafe fn compile(l: *mut lua_State, idx: i32) -> bool {
    let s = state::of(l);
    budget::charge(l, budget::FILE_OPEN_COST);
    if !read(s, bytes(l, idx)) {
        lua_pushnil(l);
        push_scratch(l, s);
        return false;
    }
    push(l, b"@");
    lua_pushvalue(l, idx);
    lua_concat(l, 2);
    let (mut ptr, mut len) = {
        let text = s.streams.scratch.borrow();
        (text.as_ptr(), text.len())
    };
    if len > 0 && *ptr == b'#' {
        while len > 0 && *ptr != b'\n' {
            (ptr, len) = (ptr.add(1), len - 1);
        }
    }
    let name = lua_tolstring(l, -1, std::ptr::null_mut());
    store_source(s, bytes(l, -1), std::slice::from_raw_parts(ptr, len));
    if luaL_loadbufferx(l, ptr.cast(), len, name, c"t".as_ptr()) != LUA_OK {
        lua_pushnil(l);
        lua_insert(l, -2);
        return false;
    }
    true
}

unsafe extern "C-unwind" fn loadfile(l: *mut lua_State) -> i32 {
    luaL_checklstring(l, 1, std::ptr::null_mut());
    if compile(l, 1) {
        if lua_type(l, 3) == LUA_TTABLE {
            lua_pushvalue(l, 3);
            lua_setupvalue(l, -2, 1);
        }
        return 1;
    }
    2
}

unsafe extern "C-unwind" fn dofile(l: *mut lua_State) -> i32 {
    luaL_checklstring(l, 1, std::ptr::null_mut());
    lua_settop(l, 1);
    if !compile(l, 1) {
        lua_error(l);
    }
    lua_replace(l, 1);
    lua_settop(l, 1);
    lua_callk(l, 0, LUA_MULTRET, 0, Some(dofile_done));
    dofile_done(l, 0, 0)
}

unsafe extern "C-unwind" fn dofile_done(l: *mut lua_State, _: i32, _: lua_KContext) -> i32 {
    lua_gettop(l)
}

unsafe extern "C-unwind" fn require(l: *mut lua_State) -> i32 {
    luaL_checklstring(l, 1, std::ptr::null_mut());
    lua_settop(l, 1);
    registry(l, reg::LOADED_MODULES); // 2
    lua_pushvalue(l, 1);
    if lua_rawget(l, 2) != LUA_TNIL {
        return 1;
    }
    lua_settop(l, 2);
    if !find(l) {
        return missing(l);
    }
    // Slot 3 contains the module's chunk (a function), or its value.
    if lua_type(l, 3) == LUA_TFUNCTION {
        lua_pushvalue(l, 1);
        lua_call(l, 1, 1);
        if lua_type(l, 3) == LUA_TNIL {
            lua_pushvalue(l, 1);
            if lua_rawget(l, 2) == LUA_TNIL {
                lua_pushboolean(l, 1);
            }
            lua_replace(l, 3);
            lua_settop(l, 3);
        }
    }
    lua_pushvalue(l, 1);
    lua_pushvalue(l, 3);
    lua_rawset(l, 2);
    1
}

/// Stores in slot 3 what a module name refers to: the chunk of a plugin's module, a namespace, or the chunk of a file.
unsafe fn find(l: *mut lua_State) -> bool {
    let s = state::of(l);
    budget::charge_units(l, lua_rawlen(l, 1) as u64 * UNITS_PER_BYTE);
    // `package.preload` takes precedence.
    lua_getglobal(l, c"package".as_ptr());
    if lua_type(l, 3) == LUA_TTABLE {
        lua_getfield(l, 3, c"preload".as_ptr());
        if lua_type(l, 4) == LUA_TTABLE {
            lua_pushvalue(l, 1);
            if lua_gettable(l, 4) == LUA_TFUNCTION {
                lua_replace(l, 3);
                lua_settop(l, 3);
                return true;
            }
        }
    }
    lua_settop(l, 2);
    if (s.border.commands.is_name_space)(s.world_ref(), bytes(l, 1).into()) != 0 {
        lua_pushglobaltable(l);
        lua_pushvalue(l, 1);
        lua_gettable(l, 3);
        lua_replace(l, 3);
        if lua_type(l, 3) == LUA_TTABLE {
            return true;
        }
    }
    // The script's own folder takes precedence, because models are distributed with their modules.
    for folder in [script_folder(s), Vec::new()] {
        lua_settop(l, 2);
        push(l, &folder);
        let path = luaL_gsub(l, lua_tolstring(l, 1, std::ptr::null_mut()), c".".as_ptr(), c"/".as_ptr());
        debug_assert!(!path.is_null());
        push(l, b".lua");
        lua_concat(l, 3);
        if compile(l, 3) {
            lua_replace(l, 3);
            lua_settop(l, 3);
            return true;
        }
        if !s.streams.scratch.borrow().starts_with(b"cannot open ") {
            lua_error(l); // the file exists, but cannot be compiled
        }
    }
    // Files take precedence, so a user's module can have the same name as a plugin's module.
    lua_settop(l, 2);
    let module = bytes(l, 1);
    let exact = preludes(s).find(|(name, _)| !name.is_empty() && *name == module);
    // On two of its three platforms, V-REP finds files regardless of case, and scripts rely on this.
    let found = exact.or_else(|| preludes(s).find(|(name, _)| !name.is_empty() && name.eq_ignore_ascii_case(module)));
    if let Some((_, text)) = found {
        push(l, b"=");
        lua_pushvalue(l, 1);
        lua_concat(l, 2);
        let name = lua_tolstring(l, 3, std::ptr::null_mut());
        store_source(s, bytes(l, 3), text);
        if luaL_loadbufferx(l, text.as_ptr().cast(), text.len(), name, c"t".as_ptr()) != LUA_OK {
            lua_error(l);
        }
        lua_replace(l, 3);
        return true;
    }
    false
}

/// Returns the folder of the script's file, with a trailing slash, or an empty path if the script is not in a folder.
fn script_folder(s: &ScriptState) -> Vec<u8> {
    let text = s.sources.text.borrow();
    text.chunk.rfind('/').map_or_else(Vec::new, |end| text.chunk.as_bytes()[..=end].to_vec())
}

unsafe fn missing(l: *mut lua_State) -> i32 {
    errors::raise(l, not_found(state::of(l), bytes(l, 1)))
}

fn not_found(s: &ScriptState, name: &[u8]) -> Fail {
    let text = s.sources.text.borrow();
    let advice = text.rules.advice(name);
    let name = String::from_utf8_lossy(name);
    if let Some(advice) = advice {
        return Fail::unsupported(format!("the module `{name}` of the original is not available")).help(advice);
    }
    Fail::with_code(
        TATU_ERR_SCRIPT,
        format!(
            "there is no module `{name}`: no plugin provides it, no command begins with `{name}.`, and no allowed \
             folder contains a file {}.lua",
            name.replace('.', "/")
        ),
    )
}
