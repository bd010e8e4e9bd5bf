//! Cache of compiled chunks that every state loads. Loading bytecode takes a fraction of the time of compilation, and
//! creates no garbage.

use std::{
    ffi::CStr,
    sync::{Arc, Mutex, PoisonError},
};

use mlua_sys::*;

use crate::lua_internals;

/// Maximum number of entries, greater than the number of preludes. The oldest entry is evicted first.
const CAPACITY: usize = 16;

struct CachedChunk {
    name: &'static CStr,
    text: Box<[u8]>,
    code: Arc<[u8]>,
}

static CHUNKS: Mutex<Vec<CachedChunk>> = Mutex::new(Vec::new());

/// Loads source text like `luaL_loadbufferx`: pushes the compiled function or an error message.
///
/// # Safety
/// `l` must be a live thread with two free stack slots.
pub(crate) unsafe fn load(l: *mut lua_State, text: &[u8], name: &'static CStr) -> i32 {
    if let Some(code) = cached(text, name) {
        return luaL_loadbufferx(l, code.as_ptr().cast(), code.len(), name.as_ptr(), c"b".as_ptr());
    }
    let status = luaL_loadbufferx(l, text.as_ptr().cast(), text.len(), name.as_ptr(), c"t".as_ptr());
    if status == LUA_OK {
        // Debug information is included, because messages and snapshots need it.
        let mut code = Vec::new();
        lua_internals::dump(l, &mut code);
        let mut chunks = CHUNKS.lock().unwrap_or_else(PoisonError::into_inner);
        if chunks.len() == CAPACITY {
            chunks.remove(0);
        }
        chunks.push(CachedChunk { name, text: text.into(), code: code.into() });
    }
    status
}

fn cached(text: &[u8], name: &CStr) -> Option<Arc<[u8]>> {
    let chunks = CHUNKS.lock().unwrap_or_else(PoisonError::into_inner);
    chunks.iter().find(|chunk| chunk.name == name && *chunk.text == *text).map(|chunk| chunk.code.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the result of running a script in a new state, or the error message.
    fn run(text: &str) -> String {
        // SAFETY: the state is created and closed here, and a new state has LUA_MINSTACK free slots.
        unsafe {
            let l = luaL_newstate();
            luaL_requiref(l, c"_G".as_ptr(), luaopen_base, 1);
            let status = load(l, text.as_bytes(), c"=chunk");
            if status == LUA_OK {
                lua_pcall(l, 0, 1, 0);
            }
            let out = CStr::from_ptr(lua_tolstring(l, -1, std::ptr::null_mut())).to_string_lossy().into_owned();
            lua_close(l);
            out
        }
    }

    #[test]
    fn cached_chunk_returns_the_same_result() {
        let text = "local n = 40\nlocal function f() n = n + 2 return n end\nreturn f()";
        assert!(cached(text.as_bytes(), c"=chunk").is_none());
        assert_eq!(run(text), "42");
        assert!(cached(text.as_bytes(), c"=chunk").is_some());
        assert_eq!(run(text), "42");
        assert_eq!(run("return 7"), "7", "a different text with the same name");
    }

    #[test]
    fn cached_chunk_reports_the_same_names_and_lines() {
        let text = "local unset\nreturn unset.field";
        let first = run(text);
        assert_eq!(first, "chunk:2: attempt to index a nil value (local 'unset')");
        assert_eq!(run(text), first);
    }

    #[test]
    fn chunk_with_syntax_error_is_not_cached() {
        let text = "return return";
        assert!(run(text).starts_with("chunk:1:"));
        assert!(cached(text.as_bytes(), c"=chunk").is_none());
    }
}
