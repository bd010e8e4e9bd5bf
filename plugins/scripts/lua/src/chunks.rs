//! Cache of compiled chunks that every state loads: loading bytecode takes a fraction of the time and leaves no
//! garbage.

use std::{
    ffi::{CStr, c_void},
    sync::{Arc, Mutex, PoisonError},
};

use mlua_sys::*;

/// Capacity: more than there are preludes. The oldest entry is dropped first.
const MOST: usize = 16;

struct Chunk {
    name: &'static CStr,
    text: Box<[u8]>,
    code: Arc<[u8]>,
}

static CHUNKS: Mutex<Vec<Chunk>> = Mutex::new(Vec::new());

/// Like `luaL_loadbufferx` for text: pushes the function or a message.
///
/// # Safety
/// A live state with two free stack slots.
pub(crate) unsafe fn load(l: *mut lua_State, text: &[u8], name: &'static CStr) -> i32 {
    if let Some(code) = known(text, name) {
        return luaL_loadbufferx(l, code.as_ptr().cast(), code.len(), name.as_ptr(), c"b".as_ptr());
    }
    let status = luaL_loadbufferx(l, text.as_ptr().cast(), text.len(), name.as_ptr(), c"t".as_ptr());
    let mut code = Vec::<u8>::new();
    // With debug information, for messages and snapshots.
    if status == LUA_OK && lua_dump(l, write, (&raw mut code).cast(), 0) == 0 {
        let mut chunks = CHUNKS.lock().unwrap_or_else(PoisonError::into_inner);
        if chunks.len() == MOST {
            chunks.remove(0);
        }
        chunks.push(Chunk { name, text: text.into(), code: code.into() });
    }
    status
}

fn known(text: &[u8], name: &CStr) -> Option<Arc<[u8]>> {
    let chunks = CHUNKS.lock().unwrap_or_else(PoisonError::into_inner);
    chunks.iter().find(|chunk| chunk.name == name && *chunk.text == *text).map(|chunk| chunk.code.clone())
}

unsafe extern "C-unwind" fn write(_: *mut lua_State, part: *const c_void, size: usize, code: *mut c_void) -> i32 {
    let code: &mut Vec<u8> = &mut *code.cast();
    code.extend_from_slice(std::slice::from_raw_parts(part.cast(), size));
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Result of a text in a new state, or the message.
    fn run(text: &str) -> String {
        // SAFETY: the state belongs to this function and has enough stack.
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
    fn a_text_of_before_gives_what_it_gave() {
        let text = "local n = 40\nlocal function f() n = n + 2 return n end\nreturn f()";
        assert!(known(text.as_bytes(), c"=chunk").is_none());
        assert_eq!(run(text), "42");
        assert!(known(text.as_bytes(), c"=chunk").is_some());
        assert_eq!(run(text), "42");
        assert_eq!(run("return 7"), "7", "another text of the same name");
    }

    #[test]
    fn messages_keep_names_and_lines() {
        let text = "local unset\nreturn unset.field";
        let first = run(text);
        assert_eq!(first, "chunk:2: attempt to index a nil value (local 'unset')");
        assert_eq!(run(text), first);
    }

    #[test]
    fn what_cannot_be_compiled_is_not_kept() {
        let text = "return return";
        assert!(run(text).starts_with("chunk:1:"));
        assert!(known(text.as_bytes(), c"=chunk").is_none());
    }
}
