//! Strings and error objects of the plugin ABI.

mod error_object;

use tatu_plugin_api::abi::*;

pub use error_object::{ErrorContents, ErrorSlot, check_status, copy as copy_error, name_plugin};

/// Returns the bytes of an ABI string; a null string is empty.
///
/// # Safety
/// `s` must point to `len` bytes that are valid for `'a`, or be empty.
pub unsafe fn bytes<'a>(s: tatu_str) -> &'a [u8] {
    // SAFETY: the caller guarantees that `s` points to `len` bytes that are valid for `'a`.
    unsafe { Lent::new(s) }.bytes()
}

/// Returns an ABI string as UTF-8; invalid bytes are replaced.
///
/// # Safety
/// As for [`bytes`].
pub unsafe fn text<'a>(s: tatu_str) -> std::borrow::Cow<'a, str> {
    // SAFETY: the caller guarantees that `s` points to `len` bytes that are valid for `'a`.
    String::from_utf8_lossy(unsafe { bytes(s) })
}

/// Returns bytes as an ABI string, which points to them.
pub fn raw(s: &[u8]) -> tatu_str {
    Lent::from(s).raw()
}

/// Fills an error object of the host and returns the status.
///
/// # Safety
/// `error` must be null or point to a live error object of the host.
pub unsafe fn fill_error(error: *mut tatu_error, status: tatu_status, text: &str) -> tatu_status {
    // SAFETY: the caller guarantees that `error` is null or points to a live object during this call.
    if let Some(say) = unsafe { error.as_ref() }.and_then(|e| e.say) {
        // SAFETY: `error` points to a live object, and `say` is its own function, which copies the text.
        unsafe { say(error, status, raw(text.as_bytes())) };
    }
    status
}
