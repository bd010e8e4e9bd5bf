//! Reports errors to tests: as a status, and as a message that is stored per thread. Panics do not leave the library.

use std::{
    cell::RefCell,
    ffi::{CStr, c_char},
    panic::{AssertUnwindSafe, catch_unwind},
};

use tatu_core::errors::{Error, Fault};
use tatu_plugin_api::abi::*;

/// The reason why a function failed: a status, and a message that states what failed, where, and what was expected.
#[derive(Debug)]
pub struct CallError(pub tatu_status, pub String);

impl CallError {
    pub fn argument(text: impl Into<String>) -> Self {
        CallError(TATU_ERR_ARGUMENT, text.into())
    }
    pub fn missing(text: impl Into<String>) -> Self {
        CallError(TATU_ERR_MISSING, text.into())
    }
}

impl From<Error> for CallError {
    fn from(e: Error) -> Self {
        CallError(TATU_ERR, e.to_string())
    }
}

impl From<Box<Fault>> for CallError {
    fn from(fault: Box<Fault>) -> Self {
        let help = fault.help.as_ref().map_or(String::new(), |help| format!("\n  help: {help}"));
        CallError(fault.kind.status(), fault.message.clone() + &help)
    }
}

thread_local! {
    /// Message of the last failure on this thread.
    static LAST_ERROR: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs `f`. If it fails or panics, stores the message as the last error of this thread, and returns the result of
/// `refused`, which receives the status.
pub fn guarded<T>(refused: impl FnOnce(tatu_status) -> T, f: impl FnOnce() -> Result<T, CallError>) -> T {
    let CallError(status, text) = match catch_unwind(AssertUnwindSafe(f)) {
        Ok(Ok(done)) => return done,
        Ok(Err(wrong)) => wrong,
        Err(panic) => {
            let said = panic.downcast_ref::<&str>().copied();
            let said = said.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
            CallError(
                TATU_ERR_PANIC,
                format!("the host panicked: {said}\n  help: this is a bug in Tatu: please report it"),
            )
        }
    };
    LAST_ERROR.with(|last| *last.borrow_mut() = text);
    refused(status)
}

/// Like [`guarded`], but returns `TATU_OK` or the status of the failure.
pub fn status(f: impl FnOnce() -> Result<(), CallError>) -> tatu_status {
    guarded(|status| status, || f().map(|()| TATU_OK))
}

/// Returns the message of the last failure on this thread, or an empty string if there was none. The string is valid
/// until the next failure on this thread.
pub extern "C" fn last_error() -> tatu_str {
    LAST_ERROR.with(|last| {
        let last = last.borrow();
        tatu_str { ptr: last.as_ptr().cast(), len: last.len() as u64 }
    })
}

/// Borrows a C string that a test passes; returns `None` for null.
///
/// # Safety
/// `text` must be null, or a zero-terminated string that lives for `'a`.
pub unsafe fn string<'a>(text: *const c_char) -> Option<&'a CStr> {
    // SAFETY: the caller guarantees a zero-terminated string, since it is not null.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) })
}

/// Returns the text of a C string that a test passes. Fails if it is null or not UTF-8; the message refers to it as
/// `what`.
pub fn text<'a>(text: Option<&'a CStr>, what: &str) -> Result<&'a str, CallError> {
    let text = text.ok_or_else(|| CallError::argument(format!("{what} is null")))?;
    text.to_str().map_err(|_| CallError::argument(format!("{what} is not UTF-8")))
}
