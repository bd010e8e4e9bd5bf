//! Reads the arguments that callers pass, and writes results through their pointers.

use std::ffi::{CStr, c_char};

use tatu_plugin_api::abi::tatu_str;

use crate::answer::CallError;

/// Borrows a C string that the caller passes. Fails if it is null or not UTF-8; the message refers to it as `what`.
///
/// # Safety
/// `text` must be null, or a zero-terminated string that lives for `'a`.
pub unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str, CallError> {
    if text.is_null() {
        return Err(CallError::argument(format!("{what} is null")));
    }
    // SAFETY: the caller guarantees a zero-terminated string.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| CallError::argument(format!("{what} is not UTF-8")))
}

/// Writes a result to `out`, unless `out` is null.
///
/// # Safety
/// `out` must be null or valid for writing a `T`.
pub unsafe fn write_out<T>(out: *mut T, value: T) {
    if !out.is_null() {
        // SAFETY: the caller guarantees that `out` is writable; its contents may be uninitialised, so they are not
        // dropped.
        unsafe { out.write(value) }
    }
}

/// Returns the bytes of a string that the caller passes.
///
/// # Safety
/// `text.ptr` must be null, or point to `text.len` bytes that live for `'a`.
pub unsafe fn bytes<'a>(text: tatu_str) -> &'a [u8] {
    match text.ptr.is_null() || text.len == 0 {
        true => &[],
        // SAFETY: the caller guarantees `len` bytes that live for `'a`.
        false => unsafe { std::slice::from_raw_parts(text.ptr.cast(), text.len as usize) },
    }
}
