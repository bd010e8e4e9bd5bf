//! Strings and error objects of the plugin ABI.

mod error_object;

use tatu_plugin_api::abi::*;

pub use error_object::{ErrorContents, ErrorObject, ErrorSlot};

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
