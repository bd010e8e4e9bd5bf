//! What a change means, and refusals.

use tatu_errors::Refusal;
use tatu_plugin_api::abi::tatu_status;

/// What a change means for physics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changed {
    /// Nothing.
    Value,
    /// The object, and what hangs on it, has moved.
    Moved,
    /// What drives a joint has changed.
    Drive,
    /// Bodies must be recreated.
    Rebuild,
}

pub(crate) fn refuse<T>(status: tatu_status, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(status, text.into()))
}
