//! The effects of property changes, and a helper that creates refusals.

use tatu_errors::Refusal;
use tatu_plugin_api::abi::tatu_status;

/// The effect of a property change on physics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changed {
    /// The change has no effect on physics.
    Value,
    /// The object and its descendants have moved.
    Moved,
    /// The drive of a joint or the friction of a surface has changed.
    Drive,
    /// Bodies must be recreated.
    Rebuild,
}

pub(crate) fn refuse<T>(status: tatu_status, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(status, text.into()))
}
