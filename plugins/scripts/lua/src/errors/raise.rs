//! Raises the plugin's errors in Lua.

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use crate::{
    stack::{bytes, push},
    state::{self, ScriptState},
};

/// Raises a failure as a Lua error whose message contains the position of the calling line, the text and the help, and
/// records the failure with its code.
///
/// # Safety
/// The calling C function must keep no value with a destructor alive.
pub(crate) unsafe fn raise(l: *mut lua_State, fail: Fail) -> i32 {
    luaL_checkstack(l, 4, std::ptr::null());
    luaL_where(l, 1);
    let text = record_raised(state::of(l), bytes(l, -1), fail);
    push(l, text);
    lua_error(l)
}

/// Records a failure and returns its text for the script. The text is valid until the next failure is recorded.
fn record_raised<'a>(s: &'a ScriptState, place: &[u8], fail: Fail) -> &'a [u8] {
    let mut text = place.to_vec();
    text.extend_from_slice(fail.text().as_bytes());
    if let Some(help) = fail.help_text() {
        text.extend_from_slice(b" (");
        text.extend_from_slice(help.as_bytes());
        text.push(b')');
    }
    let (ptr, len) = (text.as_ptr(), text.len());
    s.failures.errors.borrow_mut().raised = Some((fail, text));
    // SAFETY: the text was moved into `s.errors`, which does not move its heap buffer; it stays there until the next
    // failure is recorded, and callers copy it into Lua before that.
    unsafe { std::slice::from_raw_parts(ptr, len) }
}

/// Raises a plain message with the position of the calling line.
///
/// # Safety
/// The calling C function must keep no value with a destructor alive.
pub(crate) unsafe fn raise_text(l: *mut lua_State, text: &str) -> i32 {
    luaL_checkstack(l, 4, std::ptr::null());
    luaL_where(l, 1);
    push(l, text.as_bytes());
    lua_concat(l, 2);
    lua_error(l)
}
