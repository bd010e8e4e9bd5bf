//! Effects of a change, and refusals.

use tatu_errors::Refusal;
use tatu_plugin_api::abi::tatu_status;

/// The effect of a change on physics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changed {
    /// The change has no effect on physics.
    Value,
    /// The object and its descendants have moved.
    Moved,
    /// The drive of a joint has changed.
    Drive,
    /// Bodies must be recreated.
    Rebuild,
}

pub(crate) fn refuse<T>(status: tatu_status, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(status, text.into()))
}
