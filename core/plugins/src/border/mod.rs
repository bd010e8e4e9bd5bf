//! Texts and error objects at the ABI.

mod error_object;

use tatu_plugin_api::abi::*;

pub use error_object::{ErrorSlot, Said, answer, copy as copy_error, name_plugin};

/// Bytes of an ABI text; empty for null.
///
/// # Safety
/// `s` points to `len` bytes that live for `'a`, or is empty.
pub unsafe fn bytes<'a>(s: tatu_str) -> &'a [u8] {
    // SAFETY: the caller promises it.
    unsafe { Lent::new(s) }.bytes()
}

/// An ABI text as UTF-8; other bytes are replaced.
///
/// # Safety
/// As for [`bytes`].
pub unsafe fn text<'a>(s: tatu_str) -> std::borrow::Cow<'a, str> {
    // SAFETY: the caller promises it.
    String::from_utf8_lossy(unsafe { bytes(s) })
}

/// A Rust text in the ABI form.
pub fn raw(s: &[u8]) -> tatu_str {
    Lent::from(s).raw()
}

/// Fills an error object of the host; returns the status.
///
/// # Safety
/// `error` is null or a live error object of the host.
pub unsafe fn say(error: *mut tatu_error, status: tatu_status, text: &str) -> tatu_status {
    // SAFETY: null or live, as the caller promises.
    if let Some(say) = unsafe { error.as_ref() }.and_then(|e| e.say) {
        // SAFETY: the object is live, and the text is copied.
        unsafe { say(error, status, raw(text.as_bytes())) };
    }
    status
}
