//! The error objects of calls: pointers to slots that the host made for them, which live as long as the call.

use tatu_plugin_api::abi::*;
use tatu_plugins::{
    border::{self, ErrorSlot, Said},
    watchdog::Call,
};

/// Fills an error object; gives the status back. Those that cross the host's functions are null or the host's own.
pub(crate) fn say(error: *mut tatu_error, status: tatu_status, text: &str) -> tatu_status {
    // SAFETY: calls keep only error objects that the host made for them, which live as long as the call.
    unsafe { border::say(error, status, text) }
}

/// What an error object of a call says.
pub(crate) fn said(error: *const tatu_error) -> Said {
    // SAFETY: as above.
    unsafe { Said::of(&*error) }
}

/// Keeps what an error object of a call says: the next call uses it again.
pub(crate) fn kept(error: *const tatu_error) -> ErrorSlot {
    let mut kept = ErrorSlot::new();
    // SAFETY: as above.
    unsafe { border::copy_error(error, kept.fresh()) };
    kept
}

/// The status of a function of a plugin that got an error object of a call: see [`border::answer`].
pub(crate) fn answer(error: *mut tatu_error, status: tatu_status, may_wait: bool) -> tatu_status {
    // SAFETY: as above.
    unsafe { border::answer(status, may_wait, error) }
}

/// Names the plugin in an error object of a call: see [`border::name_plugin`].
pub(crate) fn name_plugin(error: *mut tatu_error, status: tatu_status, plugin: &str, call: Call) {
    // SAFETY: as above.
    unsafe { border::name_plugin(status, error, plugin, call) };
}
