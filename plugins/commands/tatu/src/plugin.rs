//! The plugin as its commands see it.

use tatu_plugin_api::safe::{Call, Command, SharedCall};

/// The plugin; it keeps nothing.
pub struct Tatu;

/// A running command of this plugin.
pub(crate) type Ctx<'a> = Call<'a, Tatu>;
/// One that others may run beside.
pub(crate) type Shared<'a> = SharedCall<'a, Tatu>;
/// A command of this plugin.
pub(crate) type Cmd = Command<Tatu>;
