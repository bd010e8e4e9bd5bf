//! The plugin, and what it keeps for a world.

use std::cell::{Cell, RefCell};

use tatu_plugin_api::safe::Prop;

use crate::sockets::Sockets;

/// The plugin.
pub struct LuaSocket {
    pub(crate) allow: Prop,
    pub(crate) clock: Prop,
    pub(crate) epoch: Prop,
}

/// What a world has open.
#[derive(Default)]
pub struct Open {
    pub(crate) sockets: RefCell<Sockets>,
    /// Whether it has been reported already what is not allowed.
    pub(crate) told: Cell<bool>,
}
