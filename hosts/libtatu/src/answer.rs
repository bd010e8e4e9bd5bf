//! Reports errors to callers: as a status, and as a message that is stored per thread. Panics do not leave the library.

use std::{
    cell::RefCell,
    ffi::{CString, c_char},
    panic::{AssertUnwindSafe, catch_unwind},
};

use tatu_core::errors::{Error, Fault, Refusal};
use tatu_plugin_api::abi::*;

/// The reason why a function failed: a status and a message.
#[derive(Debug)]
pub struct CallError(pub tatu_status, pub String);

impl CallError {
    pub fn argument(text: impl Into<String>) -> Self {
        CallError(TATU_ERR_ARGUMENT, text.into())
    }
}

impl From<Error> for CallError {
    fn from(e: Error) -> Self {
        CallError(TATU_ERR, e.to_string())
    }
}

impl From<Refusal> for CallError {
    fn from(r: Refusal) -> Self {
        CallError(r.0, r.1)
    }
}

impl From<Box<Fault>> for CallError {
    fn from(fault: Box<Fault>) -> Self {
        let help = fault.help.as_ref().map_or(String::new(), |help| format!("\n  help: {help}"));
        CallError(fault.kind.status(), format!("[{}] {}{help}", fault.code, fault.message))
    }
}

thread_local! {
    /// Message of the last failure on this thread.
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// Runs `f`. If it fails or panics, stores the message as the last error of this thread, and returns the result of
/// `failed`, which receives the status.
pub fn guarded<T>(failed: impl FnOnce(tatu_status) -> T, f: impl FnOnce() -> Result<T, CallError>) -> T {
    let CallError(status, text) = match catch_unwind(AssertUnwindSafe(f)) {
        Ok(Ok(done)) => return done,
        Ok(Err(wrong)) => wrong,
        Err(_) => CallError(
            TATU_ERR_PANIC,
            "the simulator panicked\n  help: this is a bug in the simulator: please report it".into(),
        ),
    };
    // A C string cannot contain a zero byte, so the message ends at the first one.
    let text = text.split('\0').next().unwrap_or_default().to_owned();
    LAST_ERROR.with(|last| *last.borrow_mut() = CString::new(text).unwrap_or_default());
    failed(status)
}

/// Like [`guarded`], but returns `TATU_OK` or the status of the failure.
pub fn status(f: impl FnOnce() -> Result<(), CallError>) -> tatu_status {
    guarded(|status| status, || f().map(|()| TATU_OK))
}

/// Returns the message of the last failure on this thread, or an empty string if there was none. The string is valid
/// until the next failure on this thread.
pub fn last_error() -> *const c_char {
    LAST_ERROR.with(|last| last.borrow().as_ptr())
}
