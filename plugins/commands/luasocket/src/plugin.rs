//! The plugin and its state per world.

use std::cell::{Cell, RefCell};

use tatu_plugin_api::safe::Prop;

use crate::sockets::Sockets;

/// The plugin, with the properties that contain the permissions, the clock and the start date of a run.
pub struct LuaSocket {
    pub(crate) allow: Prop,
    pub(crate) clock: Prop,
    pub(crate) epoch: Prop,
}

/// The state of a world: its open sockets, and whether a denial has been reported.
#[derive(Default)]
pub struct WorldSockets {
    pub(crate) sockets: RefCell<Sockets>,
    /// Whether the denial of an access has been reported. Only the first denial in a world is reported.
    pub(crate) denial_reported: Cell<bool>,
}
