//! Access to the error objects of calls, which are pointers to slots that the host allocated and that are valid during
//! the call.

use tatu_plugin_api::abi::*;
use tatu_plugins::{
    border::{ErrorContents, ErrorObject, ErrorSlot},
    watchdog::PluginCall,
};

/// Returns access to the error object of a call, or `None` if it is null.
pub(crate) fn error_object<'a>(error: *mut tatu_error) -> Option<ErrorObject<'a>> {
    // SAFETY: `error` is null or points to an `ErrorSlot` that the host made for this call and that outlives it. Only
    // the thread of the call uses it, and callers drop the result before they call a plugin.
    unsafe { ErrorObject::at(error) }
}

/// Fills an error object, unless it is null, and returns the status.
pub(crate) fn set_error(error: *mut tatu_error, status: tatu_status, text: &str) -> tatu_status {
    error_object(error).map_or(status, |mut error| error.set(status, text))
}

/// Returns the contents of an error object of a call.
pub(crate) fn read_error(error: *const tatu_error) -> ErrorContents {
    error_object(error.cast_mut()).map_or_else(ErrorContents::default, |error| error.contents())
}

/// Copies an error object of a call, whose slot the next call reuses.
pub(crate) fn clone_error(error: *const tatu_error) -> ErrorSlot {
    let mut kept = ErrorSlot::new();
    if let Some(error) = error_object(error.cast_mut()) {
        kept.object().copy_from(&error);
    }
    kept
}

/// Checks the status that a plugin returned against the error object it was given: see [`ErrorObject::check_status`].
pub(crate) fn check_status(error: *mut tatu_error, status: tatu_status, may_wait: bool) -> tatu_status {
    error_object(error).map_or(status, |mut error| error.check_status(status, may_wait))
}

/// Adds the name of the plugin to an error object of a call: see [`ErrorObject::name_plugin`].
pub(crate) fn name_plugin(error: *mut tatu_error, status: tatu_status, plugin: &str, call: PluginCall) {
    if let Some(mut error) = error_object(error) {
        error.name_plugin(status, plugin, call);
    }
}
