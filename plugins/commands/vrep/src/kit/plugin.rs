//! The plugin as its commands see it.

use tatu_plugin_api::safe::{Call, Command, SharedCall};

use super::props::Props;

/// The plugin: its interned property keys.
pub struct Vrep {
    pub(crate) p: Props,
}

/// A running command of this plugin.
pub(crate) type Ctx<'a> = Call<'a, Vrep>;

/// One that others may run beside.
pub(crate) type Shared<'a> = SharedCall<'a, Vrep>;

/// A command of this plugin.
pub(crate) type Cmd = Command<Vrep>;
