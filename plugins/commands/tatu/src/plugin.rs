//! The plugin type, and short names for its commands and calls.

use tatu_plugin_api::safe::{Call, Command, SharedCall};

/// The plugin; it has no state.
pub struct Tatu;

/// A call of one of this plugin's commands.
pub(crate) type Ctx<'a> = Call<'a, Tatu>;
/// A call that may run in parallel with others.
pub(crate) type SharedCtx<'a> = SharedCall<'a, Tatu>;
/// A command of this plugin.
pub(crate) type Cmd = Command<Tatu>;
