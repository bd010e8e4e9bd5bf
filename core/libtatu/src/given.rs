//! What callers pass, and where results are written.

use std::ffi::{CStr, c_char};

use tatu_plugin_api::abi::tatu_str;

use crate::answer::Wrong;

/// Takes a text of the caller.
///
/// # Safety
/// `text` is null or ends with 0, and lives for `'a`.
pub unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str, Wrong> {
    if text.is_null() {
        return Err(Wrong::argument(format!("{what} is null")));
    }
    // SAFETY: the caller promises it.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Wrong::argument(format!("{what} is not UTF-8")))
}

/// Writes a result, if the caller wants it.
///
/// # Safety
/// `out` is null or a place for a `T`.
pub unsafe fn give<T>(out: *mut T, value: T) {
    if !out.is_null() {
        // SAFETY: the caller promises it; what was there may be uninitialised, so it is not dropped.
        unsafe { out.write(value) }
    }
}

/// Takes the bytes of a text.
///
/// # Safety
/// `text` is as long as it says, and lives for `'a`.
pub unsafe fn bytes<'a>(text: tatu_str) -> &'a [u8] {
    match text.ptr.is_null() || text.len == 0 {
        true => &[],
        // SAFETY: the caller promises it.
        false => unsafe { std::slice::from_raw_parts(text.ptr.cast(), text.len as usize) },
    }
}
