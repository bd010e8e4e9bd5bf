//! Numbers as text: Lua 5.1 wrote the number five as `5`, Lua 5.4 writes the float five as `5.0`.
//!
//! Lua appends the ".0" to a float whose digits look like an integer's, and asks `strspn` whether they do. The build
//! gives Lua the function below in its place (`.cargo/config.toml`): while a script of an old dialect runs it answers
//! that they do not. So every way from a number to text is right at once, `..` and table keys made of text included, and
//! none costs more.

use std::{
    cell::Cell,
    ffi::{CStr, c_char},
};

thread_local! {
    /// Whether the script that runs on this thread is of a dialect that had no integers.
    static PLAIN: Cell<bool> = const { Cell::new(false) };
}

/// The question "does it look like an integer?": nothing else in Lua asks for these characters.
const LOOKS_LIKE_INTEGER: &CStr = c"-0123456789";

/// Stands for C's `strspn` in Lua: how many characters at the start of `text` are among those of `among`.
///
/// # Safety
/// Both are texts that end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tatu_lua_strspn(text: *const c_char, among: *const c_char) -> usize {
    // SAFETY: as promised.
    let (text, among) = (CStr::from_ptr(text), CStr::from_ptr(among));
    if PLAIN.get() && among == LOOKS_LIKE_INTEGER {
        return 0;
    }
    let among = among.to_bytes();
    text.to_bytes().iter().take_while(|c| among.contains(c)).count()
}

/// How numbers are written from its making to its end; then as before.
pub(crate) struct Manner(bool);

impl Manner {
    /// Begins; `plain`: without ".0".
    pub(crate) fn begin(plain: bool) -> Self {
        Manner(PLAIN.replace(plain))
    }
}

impl Drop for Manner {
    fn drop(&mut self) {
        PLAIN.set(self.0);
    }
}

/// Whether Lua was built with the function above.
pub(crate) fn installed() -> bool {
    use mlua::ffi::*;
    let _plain = Manner::begin(true);
    // SAFETY: a state of our own; the text belongs to the value on its stack.
    unsafe {
        let l = luaL_newstate();
        if l.is_null() {
            return false;
        }
        lua_pushnumber(l, 5.0);
        let text = lua_tolstring(l, -1, std::ptr::null_mut());
        let plain = !text.is_null() && CStr::from_ptr(text) == c"5";
        lua_close(l);
        plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lua_asks_us() {
        assert!(installed());
        // SAFETY: both end with a zero.
        let span = |text: &CStr, among: &CStr| unsafe { tatu_lua_strspn(text.as_ptr(), among.as_ptr()) };
        // C's `strspn`.
        assert_eq!(span(c"-12.5", LOOKS_LIKE_INTEGER), 3);
        assert_eq!(span(c"  x", c" \t"), 2);
        assert_eq!(span(c"", c"x"), 0);
        let _plain = Manner::begin(true);
        assert_eq!(span(c"-12", LOOKS_LIKE_INTEGER), 0);
        assert_eq!(span(c"05.", c"-+ #0123456789."), 3);
        {
            let _modern = Manner::begin(false);
            assert_eq!(span(c"-12", LOOKS_LIKE_INTEGER), 3);
        }
        assert_eq!(span(c"-12", LOOKS_LIKE_INTEGER), 0);
    }
}
