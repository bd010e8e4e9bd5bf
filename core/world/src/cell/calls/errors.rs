//! Access to the error objects of calls, which are pointers to slots that the host allocated and that are valid during
//! the call.

use tatu_plugin_api::abi::*;
use tatu_plugins::{
    border::{self, ErrorContents, ErrorSlot},
    watchdog::PluginCall,
};

/// Fills an error object, unless it is null, and returns the status.
pub(crate) fn set_error(error: *mut tatu_error, status: tatu_status, text: &str) -> tatu_status {
    // SAFETY: `error` is null or points to an `ErrorSlot` that the host made for this call and that outlives it.
    unsafe { border::fill_error(error, status, text) }
}

/// Returns the contents of an error object of a call.
pub(crate) fn read_error(error: *const tatu_error) -> ErrorContents {
    // SAFETY: `error` points to an `ErrorSlot` that the host made for this call and that outlives it.
    unsafe { ErrorContents::of(&*error) }
}

/// Copies an error object of a call, whose slot the next call reuses.
pub(crate) fn clone_error(error: *const tatu_error) -> ErrorSlot {
    let mut kept = ErrorSlot::new();
    // SAFETY: `error` points to an `ErrorSlot` that the host made for this call and that outlives it; `clone_error` is
    // a separate slot that is alive.
    unsafe { border::copy_error(error, kept.reset()) };
    kept
}

/// Checks the status that a plugin returned against the error object it was given: see [`border::check_status`].
pub(crate) fn check_status(error: *mut tatu_error, status: tatu_status, may_wait: bool) -> tatu_status {
    // SAFETY: `error` is null or points to an `ErrorSlot` that the host made for this call and that outlives it.
    unsafe { border::check_status(status, may_wait, error) }
}

/// Adds the name of the plugin to an error object of a call: see [`border::name_plugin`].
pub(crate) fn name_plugin(error: *mut tatu_error, status: tatu_status, plugin: &str, call: PluginCall) {
    // SAFETY: `error` is null or points to an `ErrorSlot` that the host made for this call and that outlives it.
    unsafe { border::name_plugin(status, error, plugin, call) };
}
