//! The plugin type, and short names for its commands and calls.

use tatu_plugin_api::safe::{Call, Command, SharedCall};

use super::props::Props;

/// The plugin, which stores interned property keys.
pub struct Vrep {
    pub(crate) p: Props,
}

/// A call of one of this plugin's commands.
pub(crate) type Ctx<'a> = Call<'a, Vrep>;

/// A call that may run in parallel with others.
pub(crate) type SharedCtx<'a> = SharedCall<'a, Vrep>;

/// A command of this plugin.
pub(crate) type Cmd = Command<Vrep>;
