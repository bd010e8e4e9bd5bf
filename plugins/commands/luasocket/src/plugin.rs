//! The plugin and its state per world.

use std::cell::{Cell, RefCell};

use tatu_plugin_api::safe::Prop;

use crate::sockets::Sockets;

/// The plugin.
pub struct LuaSocket {
    pub(crate) allow: Prop,
    pub(crate) clock: Prop,
    pub(crate) epoch: Prop,
}

/// The sockets of one world.
#[derive(Default)]
pub struct Open {
    pub(crate) sockets: RefCell<Sockets>,
    /// Whether a refused access has been reported already; it is reported only once.
    pub(crate) told: Cell<bool>,
}
